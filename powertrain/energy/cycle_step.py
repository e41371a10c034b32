"""A battery pack under a row of constant powers, at one temperature: the step compiled once, the limits of the cell kept.

Over an interval the current is held, so that charge and filters advance exactly (`battery.simulation.advance`). It is the current that gives the
power in the middle of the interval, at the state to which the current of its beginning leads: second order, and energy adds up by construction.
"""

from __future__ import annotations

from copy import copy
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import msgspec
import numpy as np

from ..battery.availability import current_limits
from ..battery.model import model_of
from ..battery.pack import PackModel
from ..battery.simulation import advance, is_chain, transitions
from ..battery.tables import Table

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

#: Columns of what is seen of an interval: by how much a limit is passed at worst, then by how much each of `REASONS`; current, powers and voltages.
WORST, CURRENT, TERMINAL, HEAT, POLARISATION, VOLTAGE, VOLTAGE_AFTER = 0, 5, 6, 7, 8, 9, 10
COLUMNS = 11
#: Limits in the order in which they are named when several bind; "power" is more than the resistance lets through.
REASONS = ("soc", "voltage", "current", "power")
#: Inputs before the entries of the transitions: power, duration, least and largest current of a cell.
_POWER, _DT, _LOW, _HIGH, _FIXED = 0, 1, 2, 3, 4
#: The share of a power that can be had is found to 2^-30, from below; what has less than the first share has none.
_HALVINGS, _LEAST = 30, 1e-6


class Served(NamedTuple):
    """What the pack did over the intervals that were driven (k of n, fewer only if it was to stop).

    Attributes:
        states: (k+1, number of states of a cell).
        seen: (k, COLUMNS).
        share: (k,) how much of the power was given or taken.
        events: (interval, reason) where it was not all; the last one is the interval k if it stopped there.
    """

    states: Floats
    seen: Floats
    share: Floats
    events: list[tuple[int, str]]


class PowerStep:
    """`pack` at `temperature` (K), asked for powers."""

    def __init__(self, pack: PackModel, temperature: float) -> None:
        """Write and optimise the step; some 0.1 s for tables of the usual size, kept for the next of the same pack and temperature."""
        self.pack, self.temperature = pack, temperature
        self._function = _compiled(pack, temperature)

    def inputs(self, power: Floats, dt: Floats) -> Floats:
        """(n, inputs) what `drive` takes for mean powers (W) over durations (s)."""
        cell = self.pack.cell
        poles, chain = np.array([model_of(cell).poles(cell, self.temperature)]), is_chain(cell)
        # for the filters alone: time stamps carry rounding of this size
        lengths, which = np.unique(np.round(dt, 9), return_inverse=True)
        blocks = [transitions(part, poles, chain=chain)[which].reshape(len(dt), -1) for part in (0.5 * lengths, lengths)]
        return np.column_stack([power, dt, np.zeros((len(dt), 2)), *blocks])

    def drive(self, start: Floats, inputs: Floats, held: float = 0.0, *, stop: bool) -> tuple[Served, float]:
        """Follow the powers from the state `start` (one row of `Served.states`).

        The peak currents are allowed for the cell's peak duration without a pause, the steady ones after it.

        Args:
            start: state of the cells.
            inputs: as `inputs` makes them.
            held: for how long the steady currents have been passed so far, s.
            stop: whether to end where a power to be given is not met.

        Returns:
            What happened, and `held` at the end.
        """
        x, after, seen, u = np.array(start), np.zeros_like(start), np.zeros(COLUMNS), np.zeros(inputs.shape[1])
        run = _attached(self._function, (x, u), (after, seen))
        cell, count = self.pack.cell, len(inputs)
        peak_time = cell.limits.peak_duration_s + 1e-9
        peak, steady = current_limits(cell, cell.limits.peak_duration_s), current_limits(cell, np.inf)
        states, rows, share, events = np.empty((count + 1, len(x))), np.empty((count, COLUMNS)), np.ones(count), []
        states[0], k = x, 0
        for k in range(count):
            u[:] = inputs[k]
            u[_LOW : _HIGH + 1] = peak if held + u[_DT] <= peak_time else steady
            run()
            if not seen[WORST] <= 0.0:
                events.append((k, REASONS[int(np.argmax(seen[1:CURRENT] > 0.0))]))
                if stop and u[_POWER] > 0.0:
                    break
                share[k] = _largest_share(run, u, seen)
            rows[k] = seen
            states[k + 1] = x[:] = after
            held = held + u[_DT] if not steady[0] <= seen[CURRENT] / self.pack.parallel <= steady[1] else 0.0
        else:
            k = count
        return Served(states[: k + 1], rows[:k], share[:k], events), held


def _largest_share(run: Callable[[], None], u: Floats, seen: Floats) -> float:
    """The largest share of the power in `u` that keeps all limits; `u` and `seen` are left with that share."""
    power, low, high = float(u[_POWER]), 0.0, 1.0
    trial = _LEAST
    for _ in range(_HALVINGS):
        u[_POWER] = trial * power
        run()
        if seen[WORST] <= 0.0:
            low = trial
        else:
            high = trial
            if trial == _LEAST:
                break
        trial = 0.5 * (low + high)
    u[_POWER] = low * power
    run()
    return low


def _attached(function: Any, sources: tuple[Floats, ...], results: tuple[Floats, ...]) -> Callable[[], None]:
    """`function` that reads and writes these arrays, without copies in between."""
    buffer, run = function.buffer()
    for place, array in enumerate(sources):
        buffer.set_arg(place, array.data)
    for place, array in enumerate(results):
        buffer.set_res(place, array.data)

    def call() -> None:
        assert buffer is not None  # `run` alone does not keep it alive
        run()

    return call


class _Written(Table, frozen=True, dict=True):
    """A table that writes its expression once, however often symbols are looked up."""

    @cached_property
    def function(self) -> Any:
        from ..symbolic import ca

        at = [ca.SX.sym(name) for name in ("soc", "temperature", "current")]
        return ca.Function("table", at, [Table.__call__(self, *at)])

    def __call__(self, soc: Any = 0.5, temperature: Any = 298.15, current: Any = 0.0) -> Any:
        return self.function(soc, temperature, current)


def _written(value: Any) -> Any:
    """A copy of a cell with such tables. Not through its constructor, whose checks know the plain tables only."""
    if isinstance(value, tuple):
        return tuple(_written(entry) for entry in value)
    if isinstance(value, Table):
        return _Written(**{name: getattr(value, name) for name in value.__struct_fields__})
    if not isinstance(value, msgspec.Struct):
        return value
    made = copy(value)
    for name in value.__struct_fields__:
        msgspec.structs.force_setattr(made, name, _written(getattr(value, name)))
    return made


@lru_cache(maxsize=8)
def _compiled(pack: PackModel, temperature: float) -> Any:
    """(state, inputs) -> (state after the interval, what is seen of it)."""
    from ..symbolic import ca

    cell = _written(pack.cell)
    pack = PackModel(cell, pack.series, pack.parallel)
    count = len(pack.states) - 1
    filters = count - 2
    x, u = ca.SX.sym("x", count), ca.SX.sym("u", _FIXED + 2 * filters**2)
    xs, us = ca.vertsplit(x), ca.vertsplit(u)
    entries = np.array([*us[_FIXED:], None], dtype=object)[:-1].reshape(2, filters, filters)  # the None keeps NumPy from looking into symbols
    power, dt = us[_POWER], us[_DT]
    # walked through once and put in twice, as are the tables: most of the time goes into writing the expression
    solve = ca.Function("current", [x, power], ca.cse(list(pack.current_from_power(power, [*xs, temperature]))))
    first, can = solve(x, power)
    middle = advance(cell, xs, first / pack.parallel, temperature, 0.5 * dt, entries[0])
    current, still = solve(ca.vertcat(*middle), power)
    after = advance(cell, xs, current / pack.parallel, temperature, dt, entries[1])
    flow = pack.powers([*middle, temperature], current)
    volts = [pack.voltage([*state, temperature], current) for state in (xs, after)]
    past = _past(pack, us, after[0], current / pack.parallel, volts, can * still)
    seen = ca.vertcat(ca.mmax(ca.vertcat(*past)), *past, current, flow.terminal, flow.heat, flow.polarisation, *volts)
    return ca.Function("step", [x, u], ca.cse([ca.vertcat(*after), seen]))


def _past(pack: PackModel, us: list[Any], soc: Any, each: Any, volts: list[Any], feasible: Any) -> list[Any]:
    """By how much each of `REASONS` is passed on the side to which the power drives: positive where it is."""
    p, down, up = pack.cell.limits, us[_POWER] > 0.0, us[_POWER] < 0.0
    lowest, highest = np.fmin(*volts) / pack.series, np.fmax(*volts) / pack.series
    return [
        np.fmax((p.soc_min - soc) * down, (soc - p.soc_max) * up),
        np.fmax((p.voltage_min_v - lowest) * down, (highest - p.voltage_max_v) * up),
        np.fmax((each - us[_HIGH]) * down, (us[_LOW] - each) * up),
        1.0 - feasible,
    ]
