"""How much power a pack of cells that differ can give and take over the next seconds (B3): every cell stays inside its limits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import VehicleError
from . import model
from .availability import current_limits, time_steps, unknown_temperature
from .cell import frozen_at
from .simulation import advance, is_chain, transitions

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .pack import Pack

    Floats = NDArray[np.float64]
    Flags = NDArray[np.bool_]

#: Candidates per pass and passes: the current is known to 1 / (32 * 32) of the largest conceivable one, rounded to the safe side.
_CANDIDATES, _PASSES = 33, 2
#: Passes in which the currents of cells in parallel and their resistances are brought together, as in `Pack.split`.
_SHARES = 4


def pack_power(
    pack: Pack, state: Sequence[Floats], *, horizon: float = 10.0, margin: float | None = None, extrapolate: bool = False
) -> tuple[float, float, tuple[int, int]]:
    """(discharge W, charge W, place of the cell that decides on discharge): constant powers over the horizon, magnitudes.

    Found are the largest constant pack currents with which every cell, at its own share of the current (`Pack.split`: not an equal one), keeps
    its limits at every step; the power is the current times the smallest pack voltage on the way. At this power the current never exceeds that
    one: the voltage is never below that smallest one. So the answer is safe, not sharp: low by about half the sag of the voltage over the horizon
    where charge decides (2 %; 8 % for a cell without ohmic resistance), hardly elsewhere. Tables and poles stay at the temperatures of the
    beginning. The cell that decides is, of those that break a limit first, the one with the lowest voltage (of cells in parallel the first).

    Args:
        pack: the pack.
        state: its state, one array (series, parallel) per name of `pack.states`.
        horizon: s.
        margin: distance kept from the voltage limits of each cell, V; twice the RMSE that the cell's file states if not given.
        extrapolate: trust the model beyond the currents and temperatures the cell was identified with.

    Raises:
        VehicleError: a state of the wrong shape, not finite or with a charge outside 0 to 1, a horizon that is not positive, cells in parallel
            without ohmic resistance.
    """
    shape = pack.capacity.shape
    for name, values in zip(pack.states, state, strict=True):
        if np.shape(values) != shape or not np.all(np.isfinite(values)):
            raise VehicleError(f"pack power: state {name} has shape {np.shape(values)} or is not finite, expected finite {shape}")
    if not np.all((state[0] >= 0.0) & (state[0] <= 1.0)):
        raise VehicleError(f"pack power: soc is {np.min(state[0]):g} to {np.max(state[0]):g}, expected 0 to 1")
    if not (np.isfinite(horizon) and horizon > 0.0):
        raise VehicleError(f"pack power: horizon is {horizon} s, expected positive")
    pack.split(state, 0.0)  # refuses what has no share
    gap = 2.0 * pack.cell.validity.voltage_rmse_v if margin is None else margin
    case = _Case(pack, [np.asarray(x, dtype=np.float64) for x in state], horizon, gap, extrapolate)
    down, weakest = case.largest(1.0)
    return down, case.largest(-1.0)[0], weakest


@dataclass(frozen=True)
class _Case:
    """A pack in one state, asked for its limits."""

    pack: Pack
    state: list[Floats]
    horizon: float
    margin: float
    extrapolate: bool

    def largest(self, sign: float) -> tuple[float, tuple[int, int]]:
        """Power and the first cell that breaks a limit beyond it."""
        bounds = current_limits(self.pack.cell, self.horizon)
        shape = self.pack.capacity.shape
        low, high, place, power = 0.0, 1.02 * shape[1] * (bounds[1] if sign > 0.0 else -bounds[0]), 0, 0.0
        for _ in range(_PASSES):
            row = np.linspace(low, high, _CANDIDATES)
            broken, lowest, sagged = self._predict(sign * row)
            bad = np.any(broken, axis=(1, 2))
            first = int(np.argmax(bad)) if np.any(bad) else len(row)
            if first < len(row):
                place = int(np.argmin(np.where(broken[first], sagged[first], np.inf)))
            power = max(power, float(np.max(row[:first] * np.fmax(lowest[:first], 0.0), initial=0.0)))
            if first in (0, len(row)):
                break
            low, high = float(row[first - 1]), float(row[first])
        return power, (place // shape[1], place % shape[1])

    def _predict(self, current: Floats) -> tuple[Flags, Floats, Floats]:
        """Which cells break a limit at each pack current, the lowest pack voltage, and the lowest voltage of each group."""
        pack, temperature = self.pack, self.state[-1]
        mean = float(np.mean(temperature))
        cell = frozen_at(pack.cell, mean) if np.ptp(temperature) == 0.0 else pack.cell
        steps = time_steps(self.horizon)
        filters = transitions(steps, np.array([model.model_of(cell).poles(cell, mean)]), chain=is_chain(cell))
        inner: list[Any] = [np.broadcast_to(x, (len(current), *x.shape)) for x in self.state[:-1]]
        broken = np.zeros((len(current), *temperature.shape), dtype=np.bool_)
        lowest, sagged, joule = np.full(len(current), np.inf), np.full((*broken.shape[:2], 1), np.inf), np.zeros(broken.shape)
        each = np.broadcast_to((current / temperature.shape[1])[:, None, None], broken.shape)
        for k in range(len(steps) + 1):  # the last one only looks: its current has not flowed
            each, group = self._share(cell, inner, current, each)
            broken |= self._breaks(inner, each, group, current[:, None, None])
            lowest, sagged = np.minimum(lowest, np.sum(group[:, :, 0], axis=1)), np.minimum(sagged, group)
            if k < len(steps):
                ahead = advance(cell, inner, each, mean, float(steps[k]), filters[k], capacity_scale=pack.capacity)
                # the filters follow the current only gradually: the heat of a step is the mean of that at its ends
                for state in (inner, ahead):
                    joule = joule + 0.5 * steps[k] * model.heat(cell, state, each, temperature, resistance_scale=pack.resistance)
                inner = ahead
        coldest, hottest = cell.limits.temperature_range
        outside = (temperature < coldest) | (temperature > hottest)
        outside = outside | (False if self.extrapolate else unknown_temperature(pack.cell, temperature))
        warmed = (temperature + joule / cell.heat_capacity_jpk > hottest) & (current != 0.0)[:, None, None]
        return broken | warmed | outside, lowest, sagged

    def _share(self, cell: Any, inner: list[Any], current: Floats, each: Floats) -> tuple[Floats, Floats]:
        """`Pack.split` for a row of pack currents: currents of the cells, voltage of each group."""
        pack, temperature = self.pack, self.state[-1]
        if pack.capacity.shape[1] == 1:
            return each, np.asarray(model.voltage(cell, inner, each, temperature, resistance_scale=pack.resistance))
        group = np.zeros((*each.shape[:2], 1))
        for _ in range(_SHARES):
            held, ohmic = model.electromotive(cell, inner, each, temperature, resistance_scale=pack.resistance)
            conductance = np.broadcast_to(1.0 / ohmic, each.shape)
            group = np.sum(held * conductance, axis=2, keepdims=True) - current[:, None, None]
            group = group / np.sum(conductance, axis=2, keepdims=True)
            each = (held - group) * conductance
        return each, group

    def _breaks(self, inner: list[Any], each: Floats, group: Floats, current: Floats) -> Flags:
        """Limits of every cell now; voltage and charge on the side to which the pack's current goes."""
        p, soc = self.pack.cell.limits, inner[0]
        low, high = current_limits(self.pack.cell, self.horizon)
        if not self.extrapolate:
            known = self.pack.cell.validity.current_a
            low, high = max(low, known[0]), min(high, known[1])
        down, up = current > 0.0, current < 0.0
        broken = (each > high) | (each < low)
        broken |= down & ((group < p.voltage_min_v + self.margin) | ((each > 0.0) & (soc < p.soc_min)))
        broken |= up & ((group > p.voltage_max_v - self.margin) | ((each < 0.0) & (soc > p.soc_max)))
        return broken
