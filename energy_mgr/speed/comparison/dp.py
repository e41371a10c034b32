"""The speed of least energy by dynamic programming: no gradients, no convexity, no start to begin from. The honest check of `eco`.

At every station the speed is one of a grid's; every transition from station to station that keeps the limits costs its energy on the true loss
models plus a price times its time; Bellman's backward induction finds the cheapest way. The price is then sought for which the way arrives in time.

What is proven: on its first grid each way found is the best of all ways on that grid at its price of time, and hence the least energy among all ways
on that grid that take no longer than it does. What is not: (1) Between the prices there may be ways on the grid that arrive closer to the time
allowed than any that is best at some price (the duality gap of the time constraint); the profile then arrives early by a little, and costs at most
price times that more. (2) Speeds between the grid's are left out: one step of speed dv between stations ds apart is an acceleration of v dv/ds, so
a coarse grid drives in pulses and costs more, never less. Against that, finer grids (`refinements`) are laid about the profile found, each step a
third as wide; they hold the profile that they refine, so they only save, but they see only what is near it. (3) A circuit's first speed is chosen
from a few of the grid's at its slowest station. (4) Friction brakes only take what is beyond recuperation, also where braking less with motors pays.
"""

from __future__ import annotations

import time
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from powertrain import drive_energy

from ...errors import PlanningError
from ..checks import check_profile
from ..fastest.forward_backward import fastest_profile, friction_braking, refuse_too_early
from ..result import SpeedProfile
from .dp_grid import SpeedGrid

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..bounds.speed_limits import SpeedLimits

    Floats = NDArray[np.float64]

#: An allowed time within this fraction of the least possible one leaves no choice: the fastest profile is the only one.
_NO_CHOICE = 1e-6
#: A grid about a profile has steps smaller by this.
_FINER = 3.0
#: The search for the price ends when the time is met to the first fraction or the price known to the second: on grids that are refined, on the last.
_ROUGH, _FINE = (1e-3, 0.02), (1e-5, 1e-5)
#: Half its width over its step and `levels`: the first are wide, as a coarse grid's profile may be far off where energy is flat in speed.
_TUBES = (0.5, 0.5, 0.25)
#: Speeds tried at the first station of a circuit, on the first grid and on finer ones.
_TRIED, _TRIED_AGAIN = 9, 3
_SEARCH = 60


def dp_profile(
    limits: SpeedLimits, journey_time: float | None = None, *, levels: int = 200, price: float | None = None, refinements: int = 3
) -> SpeedProfile:
    """The profile of least energy on a grid that arrives within `journey_time` in s; or of least energy plus `price` (W) times its time.

    Cost: stations times `levels` times the band of speeds within reach; 1250 stations with 200 levels take some seconds.

    Args:
        limits: what bounds the speed.
        journey_time: allowed time, s; the profile arrives no later.
        levels: speeds per station: equal steps up to the largest speed, and the fastest possible one.
        price: of time, W, instead of `journey_time`.
        refinements: finer grids laid about the profile one after the other; 0 for the first grid alone.

    Raises:
        InfeasibleError: the time is shorter than the least possible one, which is named; or the car cannot pass a slope.
        PlanningError: jerk or windows among the limits, which this method does not know; neither a time nor a price, or both; numbers out of range.
        SolverError: the profile found breaks a limit.
    """
    started = time.perf_counter()
    _refuse(limits, journey_time, levels, price, refinements)
    fastest = fastest_profile(limits)
    allowed = np.inf if journey_time is None else journey_time
    refuse_too_early(limits.name, allowed, fastest.journey_time)
    if allowed <= fastest.journey_time * (1.0 + _NO_CHOICE):
        return replace(fastest, method="dp", solve_ms=1e3 * (time.perf_counter() - started))
    search = _Search(limits, allowed, fastest.v)
    step = float(np.max(fastest.v)) / levels
    v = fastest.v
    for finer in range(refinements + 1):
        half = np.inf if finer == 0 else _TUBES[min(finer, len(_TUBES)) - 1] * levels * step
        search.on(_grid(limits, fastest.v, v, step, half), _FINE if finer == refinements else _ROUGH, price)
        v, step = search.v, step / _FINER
    brake = friction_braking(limits, v)
    check_profile(limits, v, brake)
    status = "solved early" if price is None and search.price == 0.0 else "solved"
    milliseconds = 1e3 * (time.perf_counter() - started)
    return SpeedProfile(limits.s, v, status, search.count, milliseconds, brake=brake, method="dp", price=search.price)


def _refuse(limits: SpeedLimits, journey_time: float | None, levels: int, price: float | None, refinements: int) -> None:
    if (journey_time is None) == (price is None):
        raise PlanningError(f"{limits.name}: arrival time {journey_time}, price of time {price}; expected either an arrival time or a price of time")
    if limits.windows:
        raise PlanningError(f"{limits.name}: a window at s = {limits.windows[0].s:g} m, which method dp does not know; use eco or nlp")
    if np.isfinite(limits.jerk):
        raise PlanningError(f"{limits.name}: a jerk limit of {limits.jerk:g} m/s^3, which method dp does not know; use eco or nlp")
    if journey_time is not None and not 0.0 < journey_time < 1e7:
        raise PlanningError(f"{limits.name}: arrival time {journey_time} s, expected more than 0 and less than 1e7 s")
    if price is not None and not 0.0 <= price < 1e9:
        raise PlanningError(f"{limits.name}: price of time {price} W, expected 0 to 1e9 W")
    if not 10 <= levels <= 5000:
        raise PlanningError(f"{limits.name}: {levels} levels of speed, expected 10 to 5000")
    if not 0 <= refinements <= 5:
        raise PlanningError(f"{limits.name}: {refinements} refinements, expected 0 to 5")


def _grid(limits: SpeedLimits, fastest: Floats, centre: Floats, step: float, half: float) -> SpeedGrid:
    """Multiples of `step` up to the fastest speeds, at most `half` beside the profile `centre`, which is held itself if `half` is finite."""
    count = len(fastest) - 1
    shift = int(np.argmin(fastest[:-1])) if limits.closed else 0
    levels = []
    for k in range(count + 1):
        at = (k + shift) % count if limits.closed else k
        top, middle = float(fastest[at]), float(centre[at])
        held = [top] if np.isinf(half) else [middle, *([top] if top <= middle + half else [])]
        last = min(top, middle + half)
        multiples = step * np.arange(max(np.ceil((middle - half) / step) if np.isfinite(half) else 1.0, 1.0), np.floor(last / step) + 1.0)
        free = np.min(np.abs(multiples[:, None] - np.array(held)), axis=1) > 1e-6 * step
        fixed = not limits.closed and k in (0, count)
        levels.append(np.array([top]) if fixed or top <= 0.0 else np.unique(np.append(multiples[free & (multiples < top)], held)))
    return SpeedGrid(limits, levels, shift, _ends(limits, levels[0], float(centre[shift]), first=np.isinf(half)))


def _ends(limits: SpeedLimits, speeds: Floats, centre: float, *, first: bool) -> list[int]:
    """Numbers of the speeds tried at the first station, `centre` among them."""
    if not limits.closed:
        return [0]
    spread = np.linspace(0, len(speeds) - 1, min(_TRIED if first else _TRIED_AGAIN, len(speeds)))
    return sorted({*np.round(spread).astype(int).tolist(), int(np.argmin(np.abs(speeds - centre)))})


class _Search:
    """The search for the price at which the way through a grid takes the time allowed.

    Attributes:
        v: (n,) the best profile so far.
        price: W, at which it was found.
        count: grids passed through.
    """

    def __init__(self, limits: SpeedLimits, allowed: float, fastest: Floats) -> None:
        self._limits, self._allowed = limits, allowed
        self.v, self._energy, self.count = fastest, np.inf, 0
        ledger = drive_energy(limits.vehicle, limits.s, fastest, limits.z)
        # about what is moved against resistance per second: the order of magnitude is all that counts
        self.price = max(sum(abs(ledger.components[name]) for name in ("rolling", "drag", "copper", "inverter")) / ledger.journey_time, 1.0)
        self._widen = 4.0

    def on(self, grid: SpeedGrid, tolerances: tuple[float, float], price: float | None) -> None:
        """The best profile of a grid within the time allowed, or at a given price."""
        self._energy = np.inf
        if price is not None:
            self.price = price
            self._late(grid, price)
            return
        bracket = self._bracket(grid)
        if bracket is None:
            return
        low, late_low, high, late_high = bracket
        close, narrow = tolerances[0] * self._allowed, tolerances[1]
        side = 0
        for _ in range(_SEARCH):
            if late_high >= -close or high - low <= narrow * high:
                break
            # regula falsi; where one end stays twice, a bisection
            middle = 0.5 * (low + high) if abs(side) >= 2 else high - late_high * (high - low) / (late_high - late_low)
            middle = min(max(middle, low + 0.02 * (high - low)), high - 0.02 * (high - low))
            late = self._late(grid, middle)
            if late > 0.0:
                low, late_low, side = middle, late, max(side, 0) + 1
            else:
                high, late_high, side = middle, late, min(side, 0) - 1
        self._widen = 1.1

    def _bracket(self, grid: SpeedGrid) -> tuple[float, float, float, float] | None:
        """A price too low, by how much the way is late there, and the same of one that is high enough; None where no price at all is too low."""
        price, factor = self.price, self._widen
        late = self._late(grid, price)
        if late > 0.0:
            while True:
                low, late_low = price, late
                price, factor = max(price * factor, 1.0), factor * factor
                late = self._late(grid, price)
                if late <= 0.0:
                    return low, late_low, price, late
        while price > 0.0:
            high, late_high = price, late
            price, factor = price / factor if factor < 1e3 else 0.0, factor * factor
            late = self._late(grid, price)
            if late > 0.0:
                return price, late, high, late_high
        return None

    def _late(self, grid: SpeedGrid, price: float) -> float:
        """By how much the cheapest way at a price is late, s; it is kept if it is in time and the thriftiest so far on this grid."""
        v, limits = grid.cheapest(price), self._limits
        self.count += 1
        brake = friction_braking(limits, v)
        ledger = drive_energy(limits.vehicle, limits.s, v, limits.z, 0.0 if brake is None else brake)
        late = ledger.journey_time - self._allowed
        # what is cheapest at no price at all is the thriftiest, whatever rounding says
        if np.isinf(self._allowed) or (late <= 0.0 and (ledger.total < self._energy or price == 0.0)):
            self.v, self._energy, self.price = v, ledger.total, price
        return late
