"""The speed while driving: the next kilometres are planned again and again from where the car is, so that it arrives on time all the same.

The journey is planned once; that gives the speed and the time of passing at every station. A step plans a stretch of it: from the measured speed to
the plan's speed at the end of the stretch, in the time that is left until the plan passes there. What the car is late (or early) by now is made up
evenly over the rest of the journey, which is nearly what it costs least to do, since a second then has the same price everywhere.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from ...errors import InfeasibleError, PlanningError, SolverError
from ..battery import instant_powers
from ..bounds.forces import ElectricPower
from ..bounds.jerk import JerkModel
from ..bounds.parts import BatteryPower
from ..checks import arrival_times, check_profile, station_number
from ..fastest.forward_backward import fastest_energy
from ..thriftiest.eco import EcoSolver
from ..thriftiest.interior import ChainProgramme
from ..thriftiest.interval import IntervalModel
from ..thriftiest.iterate import Deadline, Iterate

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..bounds.speed_limits import SpeedLimits

    Floats = NDArray[np.float64]

#: A speed above the fastest profile by more than this cannot be planned from, only braked from, m/s.
_TOO_FAST = 0.05
#: No car is faster, m/s.
_CONCEIVABLE = 200.0
#: A car slower than this is planned as one at this speed, m/s: between two stations at rest no time would pass.
_CREEP = 0.3
#: Barrier from which the last solution is taken up, tolerances of a step: complementarity over the energy that moves.
_WARM, _GAP, _TOLERANCE = 1e-4, 1e-5, 1e-7
#: A search with this residual (scaled, of stationarity) is on its way to nowhere.
_RUN_AWAY = 1e3
#: Acceleration between the ends of a stretch and the profile that a search starts from, m/s^2.
_GENTLE = 1.0
#: Shortest stretch that is planned, intervals.
_LEAST = 4


@dataclass(frozen=True, eq=False)
class HorizonSpeed:
    """What to drive next.

    Attributes:
        s: (n,) stations, m, from where the car is.
        v: (n,) speeds, m/s; speed squared is linear in between.
        status: `planned`; `late` (as fast as the limits allow and still behind the plan); `braking` (too fast for what lies ahead); `kept` (nothing
            new was found, or the measurement was not used: the last profile); `arrived`.
        lateness: behind the plan, s; negative when early.
        solve_ms: wall time of the step, ms.
    """

    s: Floats
    v: Floats
    status: str
    lateness: float
    solve_ms: float

    def speed_at(self, s: float) -> float:
        """Speed at `s` m, m/s."""
        return float(np.sqrt(np.interp(s, self.s, self.v**2)))


class SpeedPlanner:
    """Plans the next stretch, step by step.

    Windows still open and jerk are kept in what is `planned`; `late` and `braking` profiles know neither, and `braking` counts on the deceleration of
    the limits, whatever the motors can do.

    Args:
        limits: of the whole journey, on an open road.
        journey_time: s from the start.
        soc: charge at the start, 0 to 1; given, the battery's power bounds the drive and follows the charge that steps are told (5.7).
        horizon: way that a step looks ahead, m.
        budget: wall time that a step may take, s; when it is over the last profile is kept.
    """

    def __init__(self, limits: SpeedLimits, journey_time: float, *, soc: float | None = None, horizon: float = 1000.0, budget: float = 0.25) -> None:
        if limits.closed:
            raise PlanningError(f"{limits.name}: planning while driving needs an open road, this is a circuit")
        if not horizon > 0.0 or not budget > 0.0:
            raise PlanningError(f"{limits.name}: horizon {horizon} m, budget {budget} s, expected more than 0")
        if soc is not None:
            if not 0.0 <= soc <= 1.0:
                raise PlanningError(f"{limits.name}: state of charge {soc}, expected 0 to 1")
            powers = instant_powers(limits.vehicle, soc)
            if powers[0] <= 0.0:
                raise InfeasibleError(f"{limits.name}: the battery of {limits.vehicle.name} gives no power at a state of charge of {soc:g}")
            limits = BatteryPower(*powers).added(limits)
        self.limits, self.journey_time, self._horizon, self._budget = limits, journey_time, horizon, budget
        # the steps' model has all bounds on force, since the battery's change; the journey's solution is where the first step starts
        solver = EcoSolver(limits, every=soc is not None)
        self.plan, solution = solver.arriving_from(journey_time, None)
        self.rejected = 0
        self._fastest = np.sqrt(2.0 * fastest_energy(limits))
        self._fastest_t = arrival_times(limits, self._fastest)
        self._times = arrival_times(limits, self.plan.v)
        self._model = IntervalModel(limits, every=soc is not None)
        self._last = HorizonSpeed(limits.s, self.plan.v, "planned", 0.0, self.plan.solve_ms)
        self._warm = None if solution is None else (limits.s, solution)

    def step(self, s: float, v: float, t: float, soc: float | None = None) -> HorizonSpeed:
        """The profile from station `s` (m) at speed `v` (m/s), time `t` (s) and charge `soc` (0 to 1) on.

        Never raises on a measurement: what is not finite or not on the road is rejected and counted (`rejected`), and the last profile goes on.
        """
        started = perf_counter()
        found = self._stepped(s, v, t, soc, started)
        self._last = replace(found, solve_ms=1e3 * (perf_counter() - started))
        return self._last

    def _stepped(self, s: float, v: float, t: float, soc: float | None, started: float) -> HorizonSpeed:
        limits = self.limits
        length = float(limits.s[-1])
        try:
            s, v, t, soc = float(s), float(v), float(t), None if soc is None else float(soc)
        except (TypeError, ValueError):
            s = np.nan
        good = -1.0 <= s <= length + 1.0 and -0.5 <= v <= _CONCEIVABLE and 0.0 <= t <= _CONCEIVABLE**4
        if not good or (soc is not None and not 0.0 <= soc <= 1.0):
            self.rejected += 1
            return replace(self._last, status="kept")
        s, v = min(max(s, 0.0), length), max(v, 0.0)
        lateness = t - self._time_at(s)
        if s >= length - float(limits.ds[-1]):
            return HorizonSpeed(np.array([s, length + 1e-9]), np.array([max(v, _CREEP), self.plan.v[-1]]), "arrived", lateness, 0.0)
        if v > self._fastest_at(s) + _TOO_FAST:
            return self._braking(s, v, lateness)
        try:
            return self._planned(s, v, t, lateness, soc, started + self._budget)
        except PlanningError:
            return replace(self._last, status="kept", lateness=lateness)

    def _time_at(self, s: float) -> float:
        """When the plan passes `s`, s."""
        limits = self.limits
        at = int(np.clip(np.searchsorted(limits.s, s, side="right") - 1, 0, len(limits.s) - 2))
        here = float(np.sqrt(np.interp(s, limits.s, self.plan.v**2)))
        way = s - float(limits.s[at])
        return float(self._times[at]) + (2.0 * way / (float(self.plan.v[at]) + here) if way > 0.0 else 0.0)

    def _fastest_at(self, s: float) -> float:
        return float(np.sqrt(np.interp(s, self.limits.s, self._fastest**2)))

    def _planned(self, s: float, v: float, t: float, lateness: float, soc: float | None, until: float) -> HorizonSpeed:
        limits = self.limits
        length = float(limits.s[-1])
        first = int(np.searchsorted(limits.s, s, side="right")) - 1
        last = int(np.clip(np.searchsorted(limits.s, s + self._horizon), first + _LEAST, len(limits.s) - 1))
        last = max(last, min(first + _LEAST, len(limits.s) - 1))
        entry = min(max(v, _CREEP), max(self._fastest_at(s), _CREEP)) if s > 0.0 or v > 0.0 else 0.0
        cut = _charged(limits.stretch(s, last, entry, float(self.plan.v[last]), t), soc)
        fastest = self._reachable(cut)
        cut = replace(cut, end_speed=min(cut.end_speed, float(fastest[-1])))
        least = float(arrival_times(cut, fastest)[-1])
        rest = max(length - float(limits.s[last]), 0.0) / max(length - s, 1e-9)
        allowed = self._times[last] + lateness * rest - t
        if allowed <= least * (1.0 + 1e-6):
            return self._onward(cut.s, fastest, last, "late", lateness)
        v_found = self._solved(cut, fastest, least, float(allowed), until)
        check_profile(cut, v_found)
        return self._onward(cut.s, v_found, last, "planned", lateness)

    def _onward(self, s: Floats, v: Floats, last: int, status: str, lateness: float) -> HorizonSpeed:
        """A stretch up to station number `last` and the journey's plan behind it, lest a profile that is kept for long should ever end."""
        limits = self.limits
        return HorizonSpeed(np.append(s, limits.s[last + 1 :]), np.append(v, self.plan.v[last + 1 :]), status, lateness, 0.0)

    def _reachable(self, cut: SpeedLimits) -> Floats:
        """The fastest speeds on a stretch; its end may be slower than asked for."""
        free = replace(cut, end_speed=float(cut.v_max[-1]))
        bound = np.minimum(free.energy_max, 0.5 * np.interp(cut.s, self.limits.s, self._fastest**2) + 1e-9)
        bound[0] = 0.5 * cut.start_speed**2
        tighter = replace(free, speeds={"fastest": np.sqrt(2.0 * bound)}, end_speed=float(np.sqrt(2.0 * bound[-1])))
        return np.sqrt(2.0 * fastest_energy(tighter, ends=False))

    def _solved(self, cut: SpeedLimits, fastest: Floats, least: float, allowed: float, until: float) -> Floats:
        model = self._model.on(cut)
        bound = cut.energy_max / model.energy_scale
        fixed = bound <= 0.0
        fixed[[0, -1]] = True
        jerk = JerkModel(cut, model.energy_scale) if np.isfinite(cut.jerk) else None
        programme = ChainProgramme(model, bound, fixed, [Deadline(model.count, allowed, 1), *_open_windows(cut, fastest)], jerk=jerk)
        start = programme.start(_slower(cut, fastest, min((least / allowed) ** 2, 0.98)) / model.energy_scale)
        if self._warm is not None:
            start = programme.again(_moved(self._warm, cut.s), _WARM)
        found = programme.solve(start, tolerance=_TOLERANCE, gap=_GAP, until=until)
        if not found.solved and self._warm is not None and perf_counter() < until:
            start = programme.start(_slower(cut, fastest, (least / allowed) ** 2) / model.energy_scale)
            found = programme.solve(start, tolerance=_TOLERANCE, gap=_GAP, until=until)
        # what was reached within the budget is where the next step goes on, unless it ran away
        if found.solved or found.residual < _RUN_AWAY:
            self._warm = cut.s, found.iterate
        if not found.solved:
            raise SolverError(f"{cut.name}: no speed profile within the budget")
        return np.sqrt(2.0 * np.clip(found.iterate.x * model.energy_scale, 0.0, cut.energy_max))

    def _braking(self, s: float, v: float, lateness: float) -> HorizonSpeed:
        """Brake as the limits allow until the fastest profile is met, then follow it."""
        limits = self.limits
        first = int(np.searchsorted(limits.s, s, side="right"))
        stations = np.append(s, limits.s[first:])
        bound = np.append(self._fastest_at(s), self._fastest[first:])
        down = limits.deceleration[max(first - 1, 0) :][: len(stations) - 1]
        fall = np.append(0.0, np.cumsum(2.0 * down * np.diff(stations)))
        return HorizonSpeed(stations, np.maximum(bound, np.sqrt(np.maximum(v**2 - fall, 0.0))), "braking", lateness, 0.0)


def _slower(cut: SpeedLimits, fastest: Floats, share: float) -> Floats:
    """A share of the fastest v^2/2, joined to both ends gently: a jump there would brake beyond where a battery takes the most, and a search that
    begins there is caught on the wrong side.
    """
    most, energy = cut.energy_max, share * 0.5 * fastest**2
    for end, way in ((most[0], cut.s - cut.s[0]), (most[-1], cut.s[-1] - cut.s)):
        energy = np.clip(energy, end - _GENTLE * way, end + _GENTLE * way)
    return np.minimum(energy, most)


def _open_windows(cut: SpeedLimits, fastest: Floats) -> list[Deadline]:
    """The windows of a stretch as deadlines; one that is missed already asks for nothing."""
    arrival, rows = arrival_times(cut, fastest), []
    for window in cut.windows:
        number = station_number(cut, window.s)
        if number > 0 and np.isfinite(window.latest) and arrival[number] < window.latest:
            rows.append(Deadline(number, window.latest, 1))
        if number > 0 and arrival[number] < window.earliest <= window.latest:
            rows.append(Deadline(number, window.earliest, -1))
    return rows


def _charged(cut: SpeedLimits, soc: float | None) -> SpeedLimits:
    """The limits with the battery's power at its present charge, where that is among them."""
    if soc is None or not any(isinstance(limit, ElectricPower) for limit in cut.forces):
        return cut
    give, take = instant_powers(cut.vehicle, soc)
    forces = [replace(x, power=np.full_like(x.power, give if x.sign > 0 else take)) if isinstance(x, ElectricPower) else x for x in cut.forces]
    return replace(cut, forces=tuple(forces))


def _moved(warm: tuple[Floats, Iterate], s: Floats) -> Iterate:
    """A solution on other stations: unknowns interpolated, those of intervals from the nearest one."""
    old, found = warm
    middle = 0.5 * (old[1:] + old[:-1])
    near = np.clip(np.searchsorted(middle, 0.5 * (s[1:] + s[:-1])), 0, len(middle) - 1)

    def at(values: Floats) -> Floats:
        return np.interp(s, old, values)

    jerk = np.clip(np.searchsorted(old[1:-1], s[1:-1]), 0, max(len(old) - 3, 0))
    has_jerk = len(found.jerk_dual) > 0
    return Iterate(
        at(found.x), found.local[near], found.slack[near], found.dual[near], at(found.low), at(found.high), found.late, found.price, 0.0,
        found.jerk_slack[jerk] if has_jerk else found.jerk_slack, found.jerk_dual[jerk] if has_jerk else found.jerk_dual,
    )  # fmt: skip
