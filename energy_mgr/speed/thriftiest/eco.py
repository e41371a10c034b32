"""The speed that costs least energy: for a given arrival time, for a given price of time, or both traded along a front.

The unknowns are v^2/2 at the stations. In them time and losses are convex but for small parts (rolling resistance that grows with speed, eddy
currents, power limits, reversed windows); `interior` solves the programme on the true losses with exact derivatives, `proof` bounds from below what
any profile could reach, whatever was convex, and the gap between the two is part of every result.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from powertrain import drive_energy

from ...errors import PlanningError, SolverError
from ..bounds.jerk import JerkModel, jerk_of
from ..checks import TIME_TOLERANCE, arrival_times, check_profile, check_times
from ..fastest.forward_backward import fastest_profile, friction_braking, refuse_too_early
from ..result import Front, SpeedProfile, energy_of
from .interior import ChainProgramme
from .interval import IntervalModel
from .iterate import Deadline, Iterate, Solution
from .proof import lower_bound
from .windows import refuse_windows, shares_through, window_deadlines

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from ..bounds.speed_limits import SpeedLimits

    Floats = NDArray[np.float64]

#: An allowed time within this fraction of the least possible one leaves no choice: the fastest profile is the only one.
_NO_CHOICE = 1e-6
#: Residual that is accepted as `reduced accuracy` where the method stalls before its own.
_REDUCED = 1e-5
#: First guesses one after the other, should the ones before not do: share of the scaled fastest energy, first barrier.
_STARTS = (1.0, 1.0), (1.0, 1e-2), (0.3, 1e-2)
#: How a first guess changes its speed towards ends that are passed at one, m/s^2.
_GENTLY = 0.6
#: How much later than the least time a profile is sought where none is known to arrive just then.
_ROOM = 1e-3
#: A gap below which a profile is the optimum to all purposes.
_PROVEN = 1e-5
#: A front reaches from the fastest drive to this multiple of its time, unless driving slower costs more energy before that.
_SLOWEST = 4.0
#: Barrier from which a neighbouring solution is taken up again.
_WARM = 1e-4


def eco_profile(
    limits: SpeedLimits, journey_time: float | None = None, *, price: float | None = None, report: Callable[[str], None] | None = None
) -> SpeedProfile:
    """The profile of least energy that arrives within `journey_time` in s; or of least energy plus `price` (W) times its time.

    Where arriving earlier costs less energy than crawling, the profile arrives earlier and its status is `solved early`.

    Args:
        limits: what bounds the speed.
        journey_time: allowed time, s.
        price: of time, W, instead of `journey_time`.
        report: called with a line of progress.

    Raises:
        InfeasibleError: the time is shorter than the least possible one, which is named; a window that cannot be met; a slope that cannot be passed.
        SolverError: no profile that passes the checks was found.
        PlanningError: neither a time nor a price, or both; numbers out of range.
    """
    if (journey_time is None) == (price is None):
        raise PlanningError(f"{limits.name}: arrival time {journey_time}, price of time {price}; expected either an arrival time or a price of time")
    if report:
        report(f"speed: least energy over {len(limits.s)} stations")
    solver = EcoSolver(limits)
    return solver.arriving(journey_time) if journey_time is not None else solver.priced(0.0 if price is None else price)


@dataclass(frozen=True, eq=False)
class EcoSolver:
    """Least-energy profiles within the same limits; each solution is the start of the next.

    Attributes:
        limits: that all of them keep.
        every: with bounds on force that cannot bind now, for programmes that go on from here with other bounds.
    """

    limits: SpeedLimits
    every: bool = False

    @cached_property
    def fastest(self) -> SpeedProfile:
        """The fastest profile (V1); without jerk and windows."""
        return fastest_profile(self.limits)

    @cached_property
    def _model(self) -> IntervalModel:
        return IntervalModel(self.limits, every=self.every)

    @cached_property
    def _jerk(self) -> JerkModel | None:
        return JerkModel(self.limits, self._model.energy_scale) if np.isfinite(self.limits.jerk) else None

    @cached_property
    def _calm(self) -> float:
        """Share of the fastest profile's v^2/2 that keeps the limit of jerk, which grows with the cube of speed."""
        rough = float(np.max(np.abs(jerk_of(self.limits.ds, self.fastest.v)), initial=self.limits.jerk))
        return min((self.limits.jerk / rough) ** (2.0 / 3.0), 0.9)

    @cached_property
    def least_time(self) -> float:
        """The least possible journey time, jerk and windows included, s."""
        if self._jerk is None and not self.limits.windows:
            return self.fastest.journey_time
        refuse_windows(self.limits, self.fastest.v, np.inf)
        return self._least()

    def earliest(self) -> SpeedProfile:
        """The fastest profile, jerk and windows included."""
        if self._jerk is None and not self.limits.windows:
            return self.fastest
        return self.arriving(self.least_time * (1.0 + _ROOM))

    def _least(self) -> float:
        # where a window opens late there are many fastest profiles: of these, nearly the thriftiest
        limits = self.limits
        starts = [self._scaled(0.9), self._scaled(0.3)]
        if self._jerk is not None:
            starts.append(self._scaled(self._calm))
        best: Iterate | None = None
        for weight in (1.0, 1e-2, 1e-4) if limits.windows else (1e-3, 1e-6):
            programme = self._programme([], price=1.0 / self.fastest.journey_time, weight=weight)
            begun = [programme.start(start, barrier=1e-2) for start in starts]
            for start in begun if best is None else [programme.again(best, _WARM), *begun]:
                found = programme.solve(start)
                if found.solved or found.residual < _REDUCED:
                    best = found.iterate
                    break
            else:
                break
        if best is not None:
            return float(arrival_times(limits, self._speeds(best))[-1])
        where = ", ".join(f"s = {w.s:g} m from {w.earliest:g} to {w.latest:g} s" for w in limits.windows)
        words = "the limit of jerk" if not where else f"the windows at {where}" + (" and the limit of jerk" if self._jerk else "")
        raise SolverError(f"{limits.name}: no fastest profile was found within {words}")

    def arriving(self, journey_time: float) -> SpeedProfile:
        """Least energy within `journey_time` s; see `eco_profile`."""
        return self.arriving_from(journey_time, None)[0]

    def arriving_from(self, journey_time: float, warm: Iterate | None) -> tuple[SpeedProfile, Iterate | None]:
        """As `arriving`, from the solution of a neighbouring time; with the own solution to go on from."""
        started = time.perf_counter()
        limits = self.limits
        if not 0.0 < journey_time < 1e7:
            raise PlanningError(f"{limits.name}: arrival time {journey_time} s, expected more than 0 and less than 1e7 s")
        refuse_windows(limits, self.fastest.v, journey_time)
        refuse_too_early(limits.name, journey_time, self.fastest.journey_time)
        if self._jerk is not None:
            refuse_too_early(limits.name, journey_time, self.least_time)
        if self._jerk is None and journey_time <= self.fastest.journey_time * (1.0 + _NO_CHOICE):
            check_times(limits, self.fastest.v, journey_time)
            energy = energy_of(limits, self.fastest).total
            milliseconds = 1e3 * (time.perf_counter() - started)
            return replace(self.fastest, method="eco", solve_ms=milliseconds, lower_bound=energy, gap=0.0), None
        programme = self._programme([Deadline(self._model.count, journey_time, 1)])
        found = self._solved(programme, (self.fastest.journey_time / journey_time) ** 2, warm, f"of {journey_time:.2f} s")
        return self._profile(programme, found, journey_time, started), found.iterate

    def priced(self, price: float) -> SpeedProfile:
        """Least energy plus `price` (W) times time; zero drives at the thriftiest speed."""
        started = time.perf_counter()
        if not 0.0 <= price < 1e9:
            raise PlanningError(f"{self.limits.name}: price of time {price} W, expected 0 to 1e9 W")
        refuse_windows(self.limits, self.fastest.v, np.inf)
        programme = self._programme([], price=price / self._model.unit)
        found = self._solved(programme, 0.5, None, f"at {price:g} W")
        return self._profile(programme, found, np.inf, started)

    def front(self, count: int = 20, *, slowest: float | None = None) -> Front:
        """Time against energy from the fastest drive to the thriftiest, or to `slowest` s, at `count` times, denser where it is steep.

        Raises:
            PlanningError: fewer than two points.
        """
        if count < 2:
            raise PlanningError(f"{self.limits.name}: a front of {count} points, expected 2 or more")
        least = self.least_time if self._jerk is None and not self.limits.windows else self.least_time * (1.0 + _ROOM)
        if slowest is not None and not least <= slowest < 1e7:
            raise PlanningError(f"{self.limits.name}: slowest time {slowest} s, expected the least possible {least:.2f} s or more")
        last = self.priced(0.0) if slowest is None else None
        longest = min(_SLOWEST * least, last.journey_time) if last is not None else float(slowest or least)
        times = least + (longest - least) * np.linspace(0.0, 1.0, count) ** 2
        profiles: list[SpeedProfile] = []
        warm: Iterate | None = None
        for journey_time in times:
            profile, warm = self.arriving_from(float(journey_time) * (1.0 + 1e-9), warm)
            profiles.append(profile)
        return Front.of(self.limits, profiles)

    # -- inside -----------------------------------------------------------------------------------------------------------------------

    def _programme(self, deadlines: list[Deadline], *, price: float = 0.0, weight: float = 1.0) -> ChainProgramme:
        limits, model = self.limits, self._model
        bound = limits.energy_max / model.energy_scale
        fixed = bound <= 0.0
        if not limits.closed:
            fixed[[0, -1]] = True
        return ChainProgramme(model, bound, fixed, [*deadlines, *window_deadlines(limits)], price=price, weight=weight, jerk=self._jerk)

    def _scaled(self, factor: float) -> Floats:
        """v^2/2 of the fastest speeds times a factor, scaled; from window to window slower still where one opens late."""
        limits, fastest = self.limits, 0.5 * self.fastest.v**2
        slower = np.minimum(shares_through(limits, self.fastest.v, factor), 0.98) * fastest
        if not limits.closed:
            # towards ends that are passed at a speed it changes gently: a step from there to the slower speeds is beyond all limits
            way = limits.s - limits.s[0]
            ends = np.maximum(fastest[0] - _GENTLY * way, fastest[-1] - _GENTLY * (way[-1] - way))
            slower = np.maximum(slower, np.minimum(ends, 0.98 * fastest))
        return slower / self._model.energy_scale

    def _solved(self, programme: ChainProgramme, slower: float, warm: Iterate | None, words: str) -> Solution:
        best: Solution | None = None
        starts = [programme.start(self._scaled(share * slower), barrier=barrier) for share, barrier in _STARTS]
        if self._jerk is not None:
            starts.append(programme.start(self._scaled(min(slower, self._calm)), barrier=1e-2))
        for start in starts if warm is None else [programme.again(warm, _WARM), *starts]:
            found = programme.solve(start)
            if found.solved:
                best = found
                break
            best = found if best is None or found.residual < best.residual else best
            if best.residual < _REDUCED:
                break
        if best is None or not (best.solved or best.residual < _REDUCED):
            raise SolverError(f"{self.limits.name}: no speed profile {words} was found")
        return best

    def _speeds(self, found: Iterate) -> Floats:
        limits = self.limits
        e = np.clip(found.x * self._model.energy_scale, 0.0, limits.energy_max)
        if limits.closed:
            e[0] = e[-1] = min(e[0], e[-1])
        return np.sqrt(2.0 * e)

    def _profile(self, programme: ChainProgramme, found: Solution, journey_time: float, started: float) -> SpeedProfile:
        limits, iterate = self.limits, found.iterate
        v, brake = self._speeds(iterate), None
        if limits.brake > 0.0:
            brake = np.maximum(iterate.local[:, 1] * self._model.force_scale, 0.0)
            needed = friction_braking(limits, v)
            # what the barrier leaves of a brake that is not used is no braking
            brake = np.maximum(np.where(brake > 1e-5 * self._model.force_scale, brake, 0.0), 0.0 if needed is None else needed)
        check_profile(limits, v, brake)
        check_times(limits, v, journey_time)
        ledger = drive_energy(limits.vehicle, limits.s, v, limits.z, 0.0 if brake is None else brake)
        arrival = float(arrival_times(limits, v)[-1])
        bound = lower_bound(limits, programme, iterate, self.fastest.v, v, arrival if np.isinf(journey_time) else journey_time)
        moved = sum(abs(part) for part in ledger.components.values())
        prices = programme.prices(iterate.price) * self._model.unit
        early = np.isfinite(journey_time) and arrival < journey_time - TIME_TOLERANCE
        gap = max(ledger.total - bound, 0.0) / moved
        # what is proven to be the optimum is solved, whatever the last residual
        status = "reduced accuracy" if not found.solved and gap > _PROVEN else "solved early" if early else "solved"
        milliseconds = 1e3 * (time.perf_counter() - started)
        return SpeedProfile(
            limits.s, v, status, found.iterations, milliseconds, brake=brake, method="eco", lower_bound=bound, gap=gap, price=float(prices[-1])
        )
