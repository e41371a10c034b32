"""How much power a cell can give and take over the next seconds (B3).

Two answers. `published_power` is (5.7), corrected: charge in A s, k_i in, efficiency on charge only; it multiplies a current limit by the present
voltage and knows no voltage limit. `available_power` predicts the model's states over the horizon for a row of constant powers (and for
constant currents) and returns the largest that keeps voltage, current, charge and temperature inside at every step. `pack_power` does the same
for a pack whose cells differ.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..errors import VehicleError
from . import model
from .cell import frozen_at
from .pack import current_from_power
from .simulation import advance, is_chain, transitions
from .tables import ZERO_CELSIUS, look_up

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .cell import Cell

    Floats = NDArray[np.float64]

HORIZONS = (1.0, 10.0, 30.0)
#: Candidates per pass and passes: the answer is known to 1 / (96 * 96) of the largest conceivable power, rounded to the safe side.
_CANDIDATES, _PASSES, _STEPS = 97, 2, 20
#: The first steps are short, s: the voltage changes fastest at the beginning.
_FIRST = 0.2
#: Places inside each step at which the voltage is looked at, too: where the table of a resistance has a node, the voltage has its peaks.
_BETWEEN = np.linspace(0.0, 1.0, 13)[1:-1, None]
#: Rounding of a temperature in degC, K.
ROUNDING = 1e-3
#: Limits in the order in which they are named when several bind.
_NAMES = ("temperature", "soc", "voltage", "current", "power", "validity")


class Available(NamedTuple):
    """What can be had in one direction over one horizon.

    Attributes:
        power: largest constant power, W, a magnitude.
        power_limit: what would be broken by more: "voltage", "current", "soc", "temperature", "power" (more than the resistance lets through) or
            "validity" (more current than the cell was identified with, or, with a power of 0, a temperature at which it was not: nothing is known
            beyond).
        current: largest constant current, A, a magnitude.
        current_limit: likewise.
    """

    power: float
    power_limit: str
    current: float
    current_limit: str


@dataclass(frozen=True)
class Availability:
    """Power limits over some horizons."""

    horizons: tuple[float, ...]
    discharge: tuple[Available, ...]
    charge: tuple[Available, ...]


def published_power(cell: Cell, state: Sequence[Any], temperature: Any, horizon: float, *, current: Any = 0.0) -> tuple[Any, Any]:
    """(P_max, P_min) in W of (5.7) with C_N in A s and k_i: discharge positive, charge negative.

    Args:
        cell: the cell.
        state: its state.
        temperature: K.
        horizon: s.
        current: present current, A, for the present voltage and for k_i.
    """
    p, soc = cell.limits, state[0]
    low, high = current_limits(cell, horizon)
    u = model.voltage(cell, state, current, temperature)
    k = look_up(cell.capacity_correction, soc, temperature, current)
    eta = look_up(cell.coulombic_efficiency, soc, temperature, current)
    down = np.fmax(np.fmin((soc - p.soc_min) * cell.capacity / (k * horizon), high), 0.0)
    up = np.fmin(np.fmax((soc - p.soc_max) * cell.capacity / (eta * k * horizon), low), 0.0)
    return down * u, up * u


def available_power(
    cell: Cell, state: Sequence[float], temperature: float, *, horizons: Sequence[float] = HORIZONS, margin: float | None = None,
    capacity_scale: float = 1.0, resistance_scale: float = 1.0, extrapolate: bool = False,
) -> Availability:  # fmt: skip
    """Largest constant powers and currents of a cell that keep all its limits over each horizon.

    Tables stay at the temperature of the beginning; the temperature limit is held against warming without cooling. Nothing is promised outside
    the temperatures at which the cell was identified (`validity.temperature_degc`): its tables stop there, the cell's resistance does not. What is
    promised for longer is never more than what is promised for a shorter one of the `horizons`.

    Args:
        cell: the cell.
        state: its state, one float per name of `states(cell)`.
        temperature: K.
        horizons: s.
        margin: distance kept from the voltage limits, V; twice the RMSE that the cell's file states if not given.
        capacity_scale: capacity over the cell's.
        resistance_scale: resistance over the cell's.
        extrapolate: trust the model beyond the currents and temperatures it was identified with.

    Raises:
        VehicleError: a state or temperature that is not finite, a charge outside 0 to 1, a horizon that is not positive.
    """
    values = [float(x) for x in state]
    if len(values) != len(model.states(cell)) or not np.all(np.isfinite([*values, temperature])):
        raise VehicleError(f"available power: state {values} at {temperature} K, expected {len(model.states(cell))} finite values")
    if not 0.0 <= values[0] <= 1.0:
        raise VehicleError(f"available power: soc is {values[0]:g}, expected 0 to 1")
    if not all(np.isfinite(h) and h > 0.0 for h in horizons):
        raise VehicleError(f"available power: horizons {list(horizons)}, expected positive seconds")
    gap = 2.0 * cell.validity.voltage_rmse_v if margin is None else margin
    case = _Case(frozen_at(cell, temperature), values, temperature, gap, capacity_scale, resistance_scale, extrapolate)
    return Availability(tuple(horizons), case.over(horizons, 1.0), case.over(horizons, -1.0))


def time_steps(horizon: float) -> Floats:
    """(_STEPS,) steps that fill the horizon, the first at most 0.2 s, each longer than the one before by one factor."""
    if horizon <= _FIRST * _STEPS:
        return np.full(_STEPS, horizon / _STEPS)
    low, high = 1.0, 1.0 + horizon / _FIRST
    for _ in range(60):  # the factor by bisection: the sum rises with it
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _FIRST * np.sum(middle ** np.arange(_STEPS)) > horizon else (middle, high)
    steps = high ** np.arange(_STEPS)
    return horizon * steps / np.sum(steps)


def unknown_temperature(cell: Cell, temperature: Any) -> Any:
    """Whether the cell was not identified at `temperature` (K)."""
    coldest, warmest = (degc + ZERO_CELSIUS for degc in cell.validity.temperature_degc)
    return (temperature < coldest - ROUNDING) | (temperature > warmest + ROUNDING)


def current_limits(cell: Cell, horizon: float) -> tuple[float, float]:
    """(strongest charge current as a negative number, strongest discharge current) over a horizon, A."""
    p = cell.limits
    if horizon <= p.peak_duration_s:
        return -p.charge_peak_a, p.discharge_peak_a
    return -p.charge_max_a, p.discharge_max_a


@dataclass(frozen=True)
class _Case:
    """One cell in one state, asked for its limits."""

    cell: Cell
    state: list[float]
    temperature: float
    margin: float
    capacity_scale: float
    resistance_scale: float
    extrapolate: bool

    def over(self, horizons: Sequence[float], sign: float) -> tuple[Available, ...]:
        """The answers for every horizon; what a shorter one does not allow, a longer one does not."""
        found: dict[float, Available] = {}
        least = None
        for horizon in sorted(set(horizons)):
            here = self.limit(horizon, sign)
            if least and here.power > least.power:
                here = here._replace(power=least.power, power_limit=least.power_limit)
            if least and here.current > least.current:
                here = here._replace(current=least.current, current_limit=least.current_limit)
            found[horizon] = least = here
        return tuple(found[horizon] for horizon in horizons)

    def limit(self, horizon: float, sign: float) -> Available:
        bounds = current_limits(self.cell, horizon)
        largest = bounds[1] if sign > 0 else -bounds[0]
        top = 1.02 * largest * self.cell.limits.voltage_max_v
        power, power_limit = self._largest(horizon, sign, top, as_power=True)
        current, current_limit = self._largest(horizon, sign, 1.02 * largest, as_power=False)
        return Available(power, power_limit, current, current_limit)

    def _largest(self, horizon: float, sign: float, top: float, *, as_power: bool) -> tuple[float, str]:
        """The last of a row of candidates before the first that breaks a limit, refined."""
        low, high, name = 0.0, top, "current"
        for _ in range(_PASSES):
            row = np.linspace(low, high, _CANDIDATES)
            broken = self._broken(sign * row, horizon, as_power=as_power)
            bad = np.any(broken, axis=0)
            if not np.any(bad):
                return high, name
            first = int(np.argmax(bad))
            name = _NAMES[int(np.argmax(broken[:, first]))]
            if first == 0:
                return low, name
            low, high = float(row[first - 1]), float(row[first])
        return low, name

    def _broken(self, demand: Floats, horizon: float, *, as_power: bool) -> NDArray[np.bool_]:
        """(limits, candidates) which limits, in the order of `_NAMES`, are broken on the way."""
        cell, p = self.cell, self.cell.limits
        steps = time_steps(horizon)
        filters = transitions(steps, np.array([model.model_of(cell).poles(cell, self.temperature)]), chain=is_chain(cell))
        state: list[Any] = [np.full(demand.shape, x) for x in self.state]
        low, high = current_limits(cell, horizon)
        known = cell.validity.current_a
        down, up = demand > 0.0, demand < 0.0
        broken = np.zeros((len(_NAMES), len(demand)), dtype=np.bool_)
        joule = np.zeros(len(demand))
        i = demand
        for k in range(_STEPS + 1):  # the last one only looks: its current has not flowed
            if as_power:
                i, feasible = current_from_power(cell, state, demand, self.temperature, resistance_scale=self.resistance_scale)
                broken[4] |= feasible < 0.5
            u, _ = self._look(state, i)
            broken[2] |= self._past(u, demand)
            broken[3] |= (i > high) | (i < low)
            broken[5] |= (not self.extrapolate) & ((i > known[1]) | (i < known[0]))
            broken[1] |= (down & (state[0] < p.soc_min)) | (up & (state[0] > p.soc_max))
            if k < _STEPS:
                ahead = advance(cell, state, i, self.temperature, float(steps[k]), filters[k], capacity_scale=self.capacity_scale)
                between, warming = self._look([a + _BETWEEN * (b - a) for a, b in zip(state, ahead, strict=True)], i)
                broken[2] |= np.any(self._past(between, demand), axis=0)
                # the filters follow the current only gradually: the heat at the beginning of a step is not that of the whole
                joule += steps[k] * np.mean(np.broadcast_to(warming, between.shape), axis=0)
                state = ahead
        coldest, hottest = p.temperature_range
        start_bad = not coldest <= self.temperature <= hottest
        broken[0] |= start_bad | (self.temperature + joule / cell.heat_capacity_jpk > hottest)
        broken[0] &= (demand != 0.0) | start_bad
        broken[5] |= (not self.extrapolate) & unknown_temperature(cell, self.temperature)
        return broken

    def _past(self, u: Any, demand: Floats) -> NDArray[np.bool_]:
        """Whether a voltage is past the limit on the side to which the demand drives it."""
        p = self.cell.limits
        return ((demand > 0.0) & (u < p.voltage_min_v + self.margin)) | ((demand < 0.0) & (u > p.voltage_max_v - self.margin))

    def _look(self, state: list[Any], current: Any) -> tuple[Any, Any]:
        """Voltage and heat, tables looked up once."""
        soc, hysteresis, *filters = state
        ohmic, stages = model.model_of(self.cell).resistances(self.cell, soc, current, self.temperature)
        drop, warming = ohmic * current, ohmic * current**2
        for r, f in zip(stages, filters, strict=True):
            drop, warming = drop + r * f, warming + r * f**2
        u = self.cell.ocv_v(soc, self.temperature, current) + hysteresis - self.resistance_scale * drop
        return u, self.resistance_scale * warming
