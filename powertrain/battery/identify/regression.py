"""Dynamic tests: all tables at once by linear least squares, poles and hysteresis rate around it.

The voltage of every model is linear in U_OCV, M and all resistances once poles, hysteresis rate and the current are known (the charge balance is
open loop). So the output error of whole tests at all temperatures is one bounded linear least-squares problem (M, R >= 0); the few poles and
gamma are found around it by `scipy.optimize.least_squares` (variable projection). Resistances and M are free at each tested temperature; U_OCV is
one curve plus temperature times an entropic slope, so that what the cold cell loses to diffusion is not taken for its open-circuit voltage.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..simulation import decay, filter_current
from .readers import REFERENCE
from .structure import Structure, hats

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .slow import Branches

    Floats = NDArray[np.float64]

#: Weights of what is known beforehand, against 1 for the RMS of the voltage error (per test, V). Slow tests: 1 mV for 1 V of distance per node.
#: Smoothness: 2.5 mV for 1 V per C-rate between nodes. Entropy: 2 mV for 0.5 mV/K, more than which |dU/dT| of common cells does not reach.
_PRIOR, _SMOOTH, _ENTROPY = 1e-3, 2.5e-3, 2e-3 / 0.5e-3
_RATES = (2.0, 400.0)


@dataclass(frozen=True, eq=False)
class Drive:
    """A dynamic test ready for regression: time s, current A, voltage V, charge by the test's own balance, and which samples are fitted."""

    temperature: float
    time: Floats
    current: Floats
    voltage: Floats
    soc: Floats
    capacity: float
    efficiency: float
    used: NDArray[np.bool_]

    @property
    def swing(self) -> Floats:
        """(n-1,) share of the capacity that each step moves, positive."""
        effective = np.where(self.current[:-1] < 0.0, self.efficiency, 1.0) * self.current[:-1]
        return np.abs(effective * np.diff(self.time)) / self.capacity

    def rows(self, stride: int) -> NDArray[np.intp]:
        """Every `stride`-th sample of those that are fitted."""
        return np.flatnonzero(self.used)[::stride]


@dataclass(frozen=True, eq=False)
class Tables:
    """Parameters over the structure's nodes: U_OCV at the reference (V), its slope (V/K); per test M (V) and the resistances (V per C-rate)."""

    time_constants: tuple[float, ...]
    rate: float
    ocv: Floats
    slope: Floats
    hysteresis: list[Floats]
    resistances: list[list[Floats]]


def columns(drive: Drive, structure: Structure, time_constants: Sequence[float], rate: float, stride: int) -> tuple[Floats, Floats]:
    """(rows, k) the voltage's dependence on U_OCV, and on M and the resistances (V per C-rate), at every `stride`-th fitted sample."""
    rows = drive.rows(stride)
    c_rate = drive.current / (drive.capacity / 3600.0)
    dt = np.diff(drive.time)
    poles = np.broadcast_to(1.0 / np.resize(time_constants, structure.filters), (len(dt), structure.filters))
    filtered = filter_current(dt, poles, c_rate, chain=structure.chain)
    flows = [c_rate] if structure.ohmic else []
    flows += list(filtered) if structure.taps else [filtered[-1]]
    over_soc = hats(drive.soc[rows], structure.resistance_nodes)
    parts = []
    if structure.hysteresis:
        swing = rate * drive.swing
        source = (np.expm1(-swing) * np.sign(drive.current[:-1]))[:, None] * hats(drive.soc[:-1], structure.hysteresis_nodes)
        parts.append(decay(swing, source)[rows])
    for branch, flow in enumerate(flows):
        shape = over_soc
        if branch == 0 and structure.current_nodes:
            over_current = hats(c_rate[rows], structure.current_nodes)
            shape = (over_soc[:, :, None] * over_current[:, None, :]).reshape(len(over_soc), -1)
        parts.append(-shape * flow[rows][:, None])
    return hats(drive.soc[rows], structure.ocv_nodes), np.hstack(parts)


class Regression:
    """The linear problem of some drives with one structure; poles and rate are its arguments."""

    def __init__(self, drives: Sequence[Drive], slow: Sequence[Branches], structure: Structure, stride: int = 1) -> None:
        self.drives, self.structure, self.stride = list(drives), structure, stride
        nodes = np.array(structure.ocv_nodes)
        self.slopes = len(drives) > 1
        self.free = len(nodes) * (2 if self.slopes else 1)
        warmest = max(slow, key=lambda branch: branch.temperature)
        self.prior_ocv = warmest.mean(nodes)[0]
        near = [min(slow, key=lambda branch, at=drive.temperature: abs(branch.temperature - at)) for drive in drives]
        self.prior_gap = [branch.mean(np.array(structure.hysteresis_nodes))[1] for branch in near]

    def solve(self, time_constants: Sequence[float], rate: float) -> tuple[Tables, Floats]:
        """The tables, and the weighted residuals (data, then what is known beforehand)."""
        from scipy.linalg import solve_triangular
        from scipy.optimize import nnls

        blocks = [self._block(k, time_constants, rate) for k in range(len(self.drives))]
        knowledge, wanted = self._knowledge()
        normal, target = knowledge.T @ knowledge, knowledge.T @ wanted
        for matrix, voltage, places, factor in blocks:
            normal[np.ix_(places, places)] += np.outer(factor, factor) * (matrix.T @ matrix)[np.ix_(self._repeat, self._repeat)]
            target[places] += factor * (matrix.T @ voltage)[self._repeat]
        root = np.linalg.cholesky(normal + 1e-13 * np.trace(normal) / len(normal) * np.eye(len(normal)))
        upper, reached, free = root.T, solve_triangular(root, target, lower=True), self.free
        bounded = nnls(upper[free:, free:], reached[free:], maxiter=30 * len(normal))[0]  # the free ones are eliminated: they come first
        x = np.concatenate([solve_triangular(upper[:free, :free], reached[:free] - upper[:free, free:] @ bounded), bounded])
        residuals = []
        for matrix, voltage, places, factor in blocks:
            mine = np.zeros(matrix.shape[1])
            np.add.at(mine, self._repeat, factor * x[places])
            residuals.append(matrix @ mine - voltage)
        return self._unpack(x, time_constants, rate), np.concatenate([*residuals, knowledge @ x - wanted])

    def search(self, time_constants: Sequence[float], rate: float, evaluations: int) -> tuple[tuple[float, ...], float]:
        """Poles and rate that leave the least voltage error, from a start."""
        from scipy.optimize import least_squares

        def residual(x: Floats) -> Floats:
            return self.solve(np.exp(x[:-1]).tolist(), float(np.exp(x[-1])))[1]

        start = np.log([*time_constants, rate])
        low, high = start - np.log(8.0), start + np.log(8.0)
        low[-1], high[-1] = np.log(_RATES[0]), np.log(_RATES[1])
        found = least_squares(residual, start, bounds=(low, high), diff_step=np.full(len(start), 0.02), max_nfev=evaluations, xtol=1e-3, ftol=1e-4).x
        return tuple(np.exp(found[:-1]).tolist()), float(np.exp(found[-1]))

    def _sizes(self) -> list[int]:
        gap = [len(self.structure.hysteresis_nodes)] if self.structure.hysteresis else []
        return gap + [self.structure.width(branch) for branch in range(self.structure.branches)]

    def _block(self, k: int, time_constants: Sequence[float], rate: float) -> tuple[Floats, Floats, NDArray[np.intp], Floats]:
        """Columns and voltage of a drive, the unknowns that they stand for and the factors of these."""
        drive, nodes = self.drives[k], len(self.prior_ocv)
        ocv, rest = columns(drive, self.structure, time_constants, rate, self.stride)
        own = self.free + k * rest.shape[1] + np.arange(rest.shape[1])
        slope = np.arange(nodes, self.free)
        places = np.concatenate([np.arange(nodes), slope, own])
        factor = np.concatenate([np.ones(nodes), np.full(len(slope), drive.temperature - REFERENCE), np.ones(len(own))])
        self._repeat = np.concatenate([np.arange(nodes), slope - nodes, nodes + np.arange(len(own))])
        weight = 1.0 / np.sqrt(len(ocv))
        return weight * np.hstack([ocv, rest]), weight * drive.voltage[drive.rows(self.stride)], places, factor

    def _knowledge(self) -> tuple[Floats, Floats]:
        nodes, sizes = len(self.prior_ocv), self._sizes()
        total = self.free + len(self.drives) * sum(sizes)
        rows, wanted = [_PRIOR * np.eye(nodes, total)], [_PRIOR * self.prior_ocv]
        if self.slopes:
            rows.append(_ENTROPY * np.eye(nodes, total, nodes))
            wanted.append(np.zeros(nodes))
        first = self.free
        for gap in self.prior_gap:
            for part, size in enumerate(sizes):
                if part == 0 and self.structure.hysteresis:
                    rows.append(_PRIOR * np.eye(size, total, first))
                    wanted.append(_PRIOR * gap)
                rows.append(_SMOOTH * np.diff(np.eye(size, total, first), axis=0))
                wanted.append(np.zeros(size - 1))
                first += size
        return np.vstack(rows), np.concatenate(wanted)

    def _unpack(self, x: Floats, time_constants: Sequence[float], rate: float) -> Tables:
        nodes, free = len(self.prior_ocv), self.free
        gaps, resistances = [], []
        pieces = np.split(np.maximum(x[free:], 0.0), np.cumsum(self._sizes() * len(self.drives))[:-1])
        per = len(self._sizes())
        for k in range(len(self.drives)):
            mine = pieces[k * per : (k + 1) * per]
            gaps.append(mine.pop(0) if self.structure.hysteresis else np.zeros(len(self.structure.hysteresis_nodes)))
            resistances.append(mine)
        slope = x[nodes:free] if self.slopes else np.zeros(nodes)
        return Tables(tuple(time_constants), rate, x[:nodes], slope, gaps, resistances)
