"""A cell under a known current, without a step of integration: the filters are linear, charge and hysteresis have closed forms.

Cost: one pass of vectorised recurrences: for 30,000 samples some 10 ms on an even clock, some 0.2 s on one that jitters.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import VehicleError
from .model import charge_rate, heat, model_of, states, voltage
from .tables import look_up

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from .cell import Cell

    Floats = NDArray[np.float64]

#: Terms of the series of a transition whose exponent is at most 1/2 (row sums at most 1): the rest is below 1e-16.
_SERIES = 14
#: Sum of exponents that one block of a recurrence may hold: exp(300) is far from overflow.
_BLOCK = 300.0


@dataclass(frozen=True, eq=False)
class CellRun:
    """What a cell did. Columns of n samples; `state` is (number of states, n) in the order of `states(cell)`.

    Attributes:
        time: s.
        current: A, positive on discharge; each holds until the next sample.
        temperature: K.
        state: all states.
        voltage: terminal voltage, V.
        heat: heat of the resistances, W.
    """

    time: Floats
    current: Floats
    temperature: Floats
    state: Floats
    voltage: Floats
    heat: Floats

    @property
    def soc(self) -> Floats:
        """State of charge."""
        return self.state[0]

    @property
    def hysteresis(self) -> Floats:
        """Hysteresis voltage, V."""
        return self.state[1]


def decay(exponent: Floats, source: Floats, start: Any = 0.0) -> Floats:
    """y of `y[n+1] = exp(-exponent[n]) y[n] + source[n]`, `y[0] = start`.

    Args:
        exponent: (n-1,) not negative.
        source: (n-1, ...) one column per recurrence.
        start: first value.

    Returns:
        (n, ...).
    """
    out = np.empty((len(source) + 1, *source.shape[1:]))
    out[0] = start
    if len(source) and np.all(exponent == exponent[0]):
        from scipy.signal import lfilter

        out[1:] = lfilter([1.0], [1.0, -np.exp(-exponent[0])], source, axis=0, zi=np.exp(-exponent[0]) * out[:1])[0]
        return out
    capped = np.minimum(exponent, _BLOCK)
    passed = np.concatenate([[0.0], np.cumsum(capped)])
    first = 0
    while first < len(source):
        last = max(int(np.searchsorted(passed, passed[first] + _BLOCK, side="right")) - 1, first + 1)
        grown = passed[first + 1 : last + 1] - passed[first]
        shape = (-1,) + (1,) * (source.ndim - 1)
        summed = np.cumsum(np.exp(grown).reshape(shape) * source[first:last], axis=0)
        out[first + 1 : last + 1] = np.exp(-grown).reshape(shape) * (out[first] + summed)
        first = last
    return out


def transition(poles: Sequence[float], *, chain: bool, dt: float) -> Floats:
    """(k, k) how filters go on over `dt` seconds with a held input: `f(t + dt) = A f(t) + (1 - sum of A's row) i`."""
    return transitions(np.atleast_1d(np.asarray(dt, dtype=np.float64)), np.asarray(poles, dtype=np.float64)[None, :], chain=chain)[0]


def transitions(dt: Floats, poles: Floats, *, chain: bool) -> Floats:
    """(n, k, k) `transition` over n steps at once.

    A chain has equal poles or nearly so, where partial fractions fail. So with the fastest pole q: `exp(-q h) exp(h (A + q I))` by its series over
    h = dt / 2^s, squared s times (uniformisation, A. Jensen 1953): every term is positive, nothing cancels.

    Args:
        dt: (n,) steps, s.
        poles: (n, k) or (1, k) during each step, rad/s.
        chain: whether each filter follows the one before it.
    """
    own = np.exp(-dt[:, None] * poles)
    count = poles.shape[1]
    diagonal = np.arange(count)
    if not chain or count == 1:
        out = np.zeros((*own.shape, count))
        out[:, diagonal, diagonal] = own
        return out
    w = poles * dt[:, None]
    fastest = np.max(w, axis=1)
    halvings = max(int(np.ceil(np.log2(max(float(np.max(fastest)), 1e-300)))) + 1, 0)
    base = np.zeros((*w.shape, count))
    base[:, diagonal, diagonal] = fastest[:, None] - w
    base[:, diagonal[1:], diagonal[:-1]] = w[:, 1:]
    base *= 0.5**halvings
    out = np.broadcast_to(np.eye(count), base.shape)
    for term in range(_SERIES, 0, -1):  # Horner
        out = np.eye(count) + base @ out / term
    out = np.exp(-fastest * 0.5**halvings)[:, None, None] * out
    for _ in range(halvings):
        out = out @ out
    out[:, diagonal, diagonal] = own
    return out


def is_chain(cell: Cell) -> bool:
    """Whether each filter follows the one before it instead of the current."""
    marks = list(range(1, len(states(cell)) - 1))
    return model_of(cell).inputs(marks, 0)[1:] == marks[:-1] and len(marks) > 1


def filter_current(dt: Floats, poles: Floats, current: Floats, *, chain: bool, start: Sequence[float] | None = None) -> Floats:
    """(k, n) filtered currents, exact for currents that hold over each step.

    Args:
        dt: (n-1,) steps, s.
        poles: (n-1, k) poles during each step, rad/s.
        current: (n,) A.
        chain: whether each filter follows the one before it, instead of the current.
        start: (k,) first values, A; zero if not given.
    """
    count = poles.shape[1]
    table = np.round(np.column_stack([dt, poles]), 9)  # time stamps carry rounding of this size
    keys = table[:1] if np.all(table == table[0]) else table
    steps = np.broadcast_to(transitions(keys[:, 0], keys[:, 1:], chain=chain), (len(dt), count, count))
    gain = 1.0 - np.sum(steps, axis=2)
    out = np.empty((count, len(current)))
    for j in range(count):
        source = gain[:, j] * current[:-1]
        for m in range(j if chain else 0):
            source = source + steps[:, j, m] * out[m, :-1]
        out[j] = decay(-np.log(np.maximum(steps[:, j, j], 1e-130)), source, start[j] if start else 0.0)
    return out


def _checked(t: ArrayLike, current: ArrayLike, temperature: ArrayLike) -> tuple[Floats, Floats, Floats]:
    t, i = np.asarray(t, dtype=np.float64), np.asarray(current, dtype=np.float64)
    if t.ndim != 1 or len(t) < 2 or i.shape != t.shape:
        raise VehicleError(f"cell run: time has shape {t.shape} and current {i.shape}, expected two equal columns of at least two samples")
    try:
        warm = np.broadcast_to(np.asarray(temperature, dtype=np.float64), t.shape)
    except ValueError:
        raise VehicleError(f"cell run: temperature has shape {np.shape(temperature)}, expected one number or {t.shape}") from None
    for name, column in (("time", t), ("current", i), ("temperature", warm)):
        if not np.all(np.isfinite(column)):
            raise VehicleError(f"cell run: {name} at sample {int(np.argmin(np.isfinite(column)))} is not finite")
    if not np.all(np.diff(t) > 0.0):
        at = int(np.argmin(np.diff(t) > 0.0)) + 1
        raise VehicleError(f"cell run: time at sample {at} is {t[at]:g} s after {t[at - 1]:g} s, expected increasing")
    if np.min(warm) < 150.0:
        raise VehicleError(f"cell run: temperature of {np.min(warm):g} K, expected kelvin above 150")
    return t, i, warm


def simulate(cell: Cell, t: ArrayLike, current: ArrayLike, temperature: ArrayLike, soc0: float, *, hysteresis0: float = 0.0) -> CellRun:
    """A cell that starts at rest and follows a current that holds from each sample to the next.

    Exact, but for M(l, T), taken in the middle of each step, and temperature, held over it.

    Args:
        cell: the cell.
        t: (n,) time, s, increasing.
        current: (n,) A, positive on discharge.
        temperature: (n,) or one number, K.
        soc0: charge at the start.
        hysteresis0: hysteresis voltage at the start, V.

    Raises:
        VehicleError: shapes that do not fit, values that are not finite, time that does not increase.
    """
    t, i, warm = _checked(t, current, temperature)
    dt = np.diff(t)
    if not np.isfinite(soc0) or not np.isfinite(hysteresis0):
        raise VehicleError(f"cell run: starts with soc {soc0} and hysteresis {hysteresis0}, expected finite numbers")
    moved = charge_rate(cell, soc0, i[:-1], warm[:-1]) * dt
    soc = soc0 - np.concatenate([[0.0], np.cumsum(moved)])
    bound = look_up(cell.hysteresis_v, soc[:-1] - 0.5 * moved, warm[:-1], i[:-1])
    swing = np.abs(cell.hysteresis_rate * moved)
    hysteresis = decay(swing, np.expm1(-swing) * np.sign(i[:-1]) * bound, hysteresis0)
    poles = np.stack([np.broadcast_to(w, dt.shape) for w in model_of(cell).poles(cell, warm[:-1])], axis=1)
    state = np.vstack([soc, hysteresis, filter_current(dt, poles, i, chain=is_chain(cell))])
    return CellRun(t, i, warm, state, np.asarray(voltage(cell, list(state), i, warm)), np.asarray(heat(cell, list(state), i, warm)))


def advance(
    cell: Cell, state: Sequence[Any], current: Any, temperature: float, dt: float, step: Floats | None = None, *, capacity_scale: Any = 1.0
) -> list[Any]:
    """The state after `dt` seconds of a held current: the step that `simulate` repeats, for batches.

    Args:
        cell: the cell.
        state: floats or arrays that broadcast.
        current: A, float or array.
        temperature: K, one number.
        dt: s.
        step: `transition` of the filters, if it is known already.
        capacity_scale: capacity of this cell over `cell`'s.
    """
    soc, hysteresis, *filters = state
    if step is None:
        step = transition(model_of(cell).poles(cell, temperature), chain=is_chain(cell), dt=dt)
    moved = charge_rate(cell, soc, current, temperature) * dt / capacity_scale
    bound = look_up(cell.hysteresis_v, soc - 0.5 * moved, temperature, current)
    stay = np.exp(-np.abs(cell.hysteresis_rate * moved))
    ahead = [sum((step[j, m] * filters[m] for m in range(len(filters))), (1.0 - np.sum(step[j])) * current) for j in range(len(filters))]
    return [soc - moved, stay * hysteresis - (1.0 - stay) * np.sign(current) * bound, *ahead]
