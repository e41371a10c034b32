"""Battery packs: cells in series and parallel, as one lumped cell (`PackModel`, goes into a vehicle plant) or cell by cell with spread (`Pack`)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..errors import VehicleError
from . import model
from .simulation import advance

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .cell import Cell

    Floats = NDArray[np.float64]

#: Passes in which the current of cells in parallel and their resistances are brought together.
_PASSES = 4
#: Secant steps after two passes by substitution; four leave less than 1e-10 of the power.
_SECANTS = 4


class PowerCurrent(NamedTuple):
    """Current that meets a power, A; and whether the power can be had (1) or is above the largest possible (0: `current` is that of the largest)."""

    current: Any
    feasible: Any


def current_from_power(cell: Cell, state: Sequence[Any], power: Any, temperature: Any, *, resistance_scale: Any = 1.0) -> PowerCurrent:
    """Current of one cell that delivers `power` (W, positive on discharge): the smaller root of `(E - R_0 i) i = P`.

    Where resistances depend on current, two passes by substitution and four secant steps bring the two together. Floats, arrays and symbols. For
    any finite power never NaN: beyond the largest power E^2 / (4 R_0) the answer is the current E / (2 R_0) of that power, with feasible 0.
    """

    def at(current: Any) -> tuple[Any, Any]:
        return model.electromotive(cell, state, current, temperature, resistance_scale=resistance_scale)

    held, ohmic = at(0.0 * power)
    current, feasible = _root(held, ohmic, power)
    if not model.varies(cell):
        return PowerCurrent(current, feasible)
    held, ohmic = at(current)
    before, missed_before = current, (held - ohmic * current) * current - power
    current, feasible = _root(held, ohmic, power)
    for _ in range(_SECANTS):
        held, ohmic = at(current)
        missed = (held - ohmic * current) * current - power
        way, change = current - before, missed - missed_before
        # a step is at most a fifth of the current, and none where both are the same already or the power cannot be had
        step = np.fmax(np.fmin(missed * way * change / (change**2 + 1e-30), 0.2 * np.fabs(current)), -0.2 * np.fabs(current)) * feasible
        before, missed_before, current = current, missed, current - step
    return PowerCurrent(current, feasible)


def _root(held: Any, ohmic: Any, power: Any) -> tuple[Any, Any]:
    """The smaller root of (E - R i) i = P, or E / (2 R) where there is none; and whether there is one."""
    root = held**2 - 4.0 * ohmic * power
    current = 2.0 * power / np.fmax(held + np.sqrt(np.fmax(root, 0.0)), 1e-6)
    # beyond the largest power the root is double: E / (2 R_0), whatever was asked
    current = current * np.fmin(1.0, np.fmax(held, 0.0) ** 2 / np.fmax(4.0 * ohmic * power, 1e-12 + np.fmax(held, 0.0) ** 2))
    return current, (root >= 0.0) * (held > 0.0) * 1.0


@dataclass(frozen=True)
class PackModel:
    """`series` times `parallel` equal cells with one temperature: terminal voltage N_s u, current I / N_p per cell.

    Attributes:
        cell: each of them.
        series: cells in a row.
        parallel: rows side by side.
        thermal_resistance: from the cells to the air, K/W, for the pack.
    """

    cell: Cell
    series: int
    parallel: int = 1
    thermal_resistance: float = float("inf")

    def __post_init__(self) -> None:
        _check_shape(self.series, self.parallel, self.thermal_resistance)

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states: those of a cell, then its temperature in K."""
        return (*model.states(self.cell), "temperature")

    @property
    def count(self) -> int:
        """Number of cells."""
        return self.series * self.parallel

    def rest(self, soc: Any, temperature: Any) -> tuple[Any, ...]:
        """State at rest."""
        return (*model.rest(self.cell, soc), temperature)

    def derivative(self, state: Sequence[Any], current: Any, ambient: Any, cooling: Any = 0.0) -> list[Any]:
        """Time derivative of the state; the thermal node is `C dT/dt = heat - (T - T_amb) / R_th - cooling`.

        Args:
            state: as `states` names it.
            current: of the pack, A, positive on discharge.
            ambient: K.
            cooling: heat that is carried away, W.
        """
        *inner, temperature = state
        each = current / self.parallel
        heat = self.count * model.heat(self.cell, inner, each, temperature)
        flow = heat - (temperature - ambient) / self.thermal_resistance - cooling
        return [*model.derivative(self.cell, inner, each, temperature), flow / (self.count * self.cell.heat_capacity_jpk)]

    def voltage(self, state: Sequence[Any], current: Any) -> Any:
        """Terminal voltage of the pack, V."""
        *inner, temperature = state
        return self.series * model.voltage(self.cell, inner, current / self.parallel, temperature)

    def powers(self, state: Sequence[Any], current: Any) -> model.Powers:
        """Where the pack's power goes, W; adds up as that of a cell."""
        *inner, temperature = state
        return model.Powers(*(self.count * p for p in model.powers(self.cell, inner, current / self.parallel, temperature)))

    def current_from_power(self, power: Any, state: Sequence[Any]) -> PowerCurrent:
        """Pack current that delivers `power` (W at the terminals), and whether it can."""
        *inner, temperature = state
        found = current_from_power(self.cell, inner, power / self.count, temperature)
        return PowerCurrent(self.parallel * found.current, found.feasible)


@dataclass(frozen=True, eq=False)
class Pack:
    """Cells that differ: arrays of shape (series, parallel). Every state of the pack has this shape.

    Attributes:
        cell: the typical cell.
        capacity: of each cell over the typical one's.
        resistance: likewise.
        soc_offset: how far each cell's charge lies from the mean at the start.
        thermal_resistance: from each cell to the air, K/W.
    """

    cell: Cell
    capacity: Floats
    resistance: Floats
    soc_offset: Floats
    thermal_resistance: float = float("inf")

    def __post_init__(self) -> None:
        shape = self.capacity.shape
        if len(shape) != 2 or self.resistance.shape != shape or self.soc_offset.shape != shape:
            found = f"{shape}, {self.resistance.shape}, {self.soc_offset.shape}"
            raise VehicleError(f"pack: capacity, resistance, soc_offset have shapes {found}, expected one (series, parallel)")
        _check_shape(*shape, self.thermal_resistance)
        for name in ("capacity", "resistance"):
            values = getattr(self, name)
            if not np.all(np.isfinite(values)) or not np.all(values > 0.0):
                raise VehicleError(f"pack: {name} factor at {np.argwhere(~(values > 0.0)).tolist()[:1]} is not positive")
        if not np.all(np.isfinite(self.soc_offset)):
            raise VehicleError("pack: soc_offset is not finite")

    @classmethod
    def spread(
        cls, cell: Cell, series: int, parallel: int, rng: np.random.Generator, *, capacity: float = 0.01, resistance: float = 0.03,
        soc: float = 0.005, thermal_resistance: float = float("inf"),
    ) -> Pack:  # fmt: skip
        """A pack whose cells deviate by these standard deviations (shares; `soc` absolute)."""
        _check_shape(series, parallel, thermal_resistance)
        draws = rng.standard_normal((3, series, parallel))
        return cls(cell, np.exp(capacity * draws[0]), np.exp(resistance * draws[1]), soc * draws[2], thermal_resistance)

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states, each (series, parallel)."""
        return (*model.states(self.cell), "temperature")

    def rest(self, soc: float, temperature: float) -> list[Floats]:
        """State at rest, cells at their own charge."""
        inner = model.rest(self.cell, np.clip(soc + self.soc_offset, 0.0, 1.0), np.zeros(self.capacity.shape))
        return [*(np.array(x) for x in inner), np.full(self.capacity.shape, temperature)]

    def split(self, state: Sequence[Floats], current: float) -> tuple[Floats, Floats]:
        """(currents (series, parallel), voltages of the groups (series,)): cells side by side have equal voltage.

        A resistance that depends on current is taken at the current of the pass before. Raises VehicleError for cells in parallel without a
        resistance that acts at once (the published MESC): their share is not defined.
        """
        *inner, temperature = state
        parallel = self.capacity.shape[1]
        each = np.full(self.capacity.shape, current / parallel)
        if parallel == 1:
            return each, np.asarray(model.voltage(self.cell, inner, each, temperature, resistance_scale=self.resistance))[:, 0]
        group = np.zeros(self.capacity.shape[0])
        for _ in range(_PASSES):
            held, ohmic = model.electromotive(self.cell, inner, each, temperature, resistance_scale=self.resistance)
            ohmic = np.broadcast_to(ohmic, self.capacity.shape)
            if not np.all(ohmic > 0.0):
                raise VehicleError(f"pack of {self.cell.name}: cells in parallel without ohmic resistance, expected ohmic_ohm above 0")
            group = (np.sum(held / ohmic, axis=1) - current) / np.sum(1.0 / ohmic, axis=1)
            each = (held - group[:, None]) / ohmic
        return each, group

    def voltage(self, state: Sequence[Floats], current: float) -> float:
        """Terminal voltage, V: the sum of the groups."""
        return float(np.sum(self.split(state, current)[1]))

    def derivative(self, state: Sequence[Floats], current: float, ambient: float, cooling: float = 0.0) -> list[Floats]:
        """Time derivative of the state; `cooling` in W for the pack, shared equally."""
        *inner, temperature = state
        each, _ = self.split(state, current)
        heat = model.heat(self.cell, inner, each, temperature, resistance_scale=self.resistance)
        flow = heat - (temperature - ambient) / self.thermal_resistance - cooling / self.capacity.size
        rates = model.derivative(self.cell, inner, each, temperature, capacity_scale=self.capacity)
        return [*(np.asarray(r) for r in rates), flow / self.cell.heat_capacity_jpk]

    def within_limits(self, state: Sequence[Floats], current: float) -> str:
        """ "" if every cell keeps its limits, else the name of the first that is broken: the weakest cell decides."""
        each, group = self.split(state, current)
        p, soc, temperature = self.cell.limits, state[0], state[-1]
        coldest, hottest = p.temperature_range
        broken = {
            "voltage": np.any(group < p.voltage_min_v) or np.any(group > p.voltage_max_v),
            "current": np.any(each > p.discharge_peak_a) or np.any(-each > p.charge_peak_a),
            "soc": (current > 0.0 and np.any(soc <= p.soc_min)) or (current < 0.0 and np.any(soc >= p.soc_max)),
            "temperature": np.any(temperature < coldest) or np.any(temperature > hottest),
        }
        return next((name for name, bad in broken.items() if bad), "")

    def usable_charge(self, soc: Floats) -> tuple[float, float]:
        """(A s to discharge, A s to charge) until the first group of cells reaches the end of its window."""
        p, capacity = self.cell.limits, self.cell.capacity * self.capacity
        down = np.sum((soc - p.soc_min) * capacity, axis=1)
        up = np.sum((p.soc_max - soc) * capacity, axis=1)
        return float(max(np.min(down), 0.0)), float(max(np.min(up), 0.0))

    def step(self, state: Sequence[Floats], current: float, ambient: float, dt: float, cooling: float = 0.0) -> list[Floats]:
        """The state after `dt` seconds of a held current; filters exact for the mean temperature, thermal node by its exponential."""
        *inner, temperature = state
        each, _ = self.split(state, current)
        mean = float(np.mean(temperature))
        ahead = advance(self.cell, inner, each, mean, dt, capacity_scale=self.capacity)
        heat = model.heat(self.cell, inner, each, temperature, resistance_scale=self.resistance) - cooling / self.capacity.size
        return [*ahead, temperature + _warming(heat, temperature - ambient, dt, self.cell.heat_capacity_jpk, self.thermal_resistance)]


def _warming(heat: Any, above: Any, dt: float, capacity: float, resistance: float) -> Any:
    if not np.isfinite(resistance):
        return heat * dt / capacity
    return -np.expm1(-dt / (capacity * resistance)) * (heat * resistance - above)


def _check_shape(series: int, parallel: int, thermal_resistance: float) -> None:
    if series < 1 or parallel < 1:
        raise VehicleError(f"pack has {series} cells in series and {parallel} in parallel, expected at least one of each")
    if not thermal_resistance > 0.0:
        raise VehicleError(f"pack: thermal resistance is {thermal_resistance} K/W, expected above 0")
