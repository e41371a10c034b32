"""What a recorded drive took, and what a plan would have taken on the same road in the same time with the same stops."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from powertrain import KWH, CycleLedger, Vehicle, drive_cycle, load_vehicle

from ..errors import InfeasibleError, PlanningError
from ..request import PlanRequest
from .planner import Planner

if TYPE_CHECKING:
    from collections.abc import Callable
    from os import PathLike

    from numpy.typing import NDArray

    from roads import Recorded, Road

    from ..speed import DriveRules
    from .comparison import Plan

    Floats = NDArray[np.float64]

#: A stop closer than this to another one, or to an end of the road, is that one, m.
_APART = 10.0


@dataclass(frozen=True, eq=False)
class Score:
    """A recorded drive beside a planned one, both told at the battery's terminals with the auxiliaries, standing included.

    Attributes:
        road: the road, with what was recorded.
        vehicle: the car that both are reckoned for.
        recorded: the account of the recorded speeds over the road's heights; the friction brakes do what recuperation cannot.
        planned: the account of the plan, which stands where and as long as the recorded drive stood.
        plan: the plan.
    """

    road: Road
    vehicle: Vehicle
    recorded: CycleLedger
    planned: CycleLedger
    plan: Plan

    @property
    def late(self) -> float:
        """By how much the plan takes longer, s: more than 0 where the car's limits do not allow the recorded time; less than 0 where going as slowly
        as recorded would cost more energy.
        """
        return self.planned.duration - self.recorded.duration

    @property
    def same_ends(self) -> bool:
        """Whether the plan begins and ends with the recorded speeds, within 0.5 m/s."""
        v = self.plan.chosen.profile.v
        return bool(max(abs(v[0] - self.drive.v[0]), abs(v[-1] - self.drive.v[-1])) <= 0.5)

    @property
    def drive(self) -> Recorded:
        """What was recorded."""
        return _recorded(self.road)

    @property
    def energy_kwh(self) -> float:
        """Energy of the recorded drive, kWh."""
        return self.recorded.energy / KWH

    @property
    def planned_kwh(self) -> float:
        """Energy of the plan, kWh."""
        return self.planned.energy / KWH

    @property
    def saving_percent(self) -> float | None:
        """Energy that the plan would save, %; None where the recorded drive drew none."""
        return None if self.recorded.energy <= 0.0 else 100.0 * (1.0 - self.planned.energy / self.recorded.energy)


def score(
    road: Road,
    vehicle: Vehicle | str | PathLike[str] = "romo",
    request: PlanRequest | None = None,
    *,
    report: Callable[[str], None] | None = None,
) -> Score:
    """Score the drive that was recorded along `road`.

    Args:
        road: a road with a recorded drive (`Road.recorded`): of a GPX or GeoJSON file with times, or of a path table with times or speeds.
        vehicle: a car, the name of a shipped one, or a TOML file.
        request: how the plan is to be found; its arrival time and its stops are those of the recorded drive.
        report: called with lines of progress.

    Raises:
        PlanningError: nothing was recorded, or wishes that the recorded drive decides.
        InfeasibleError: the car cannot drive this road at all.
    """
    drive = _recorded(road)
    asked = request or PlanRequest()
    if asked.journey_time is not None or asked.price is not None or asked.soc is not None or asked.speed != "eco":
        raise PlanningError("a score with an arrival time, a price of time, a charge or a speed method, expected none: it plans in the recorded time")
    car = vehicle if isinstance(vehicle, Vehicle) else load_vehicle(vehicle)
    plan = _planned(Planner(road, report=report), car, asked, drive)
    return Score(road, car, recorded_ledger(road, car), _ledger(plan, drive), plan)


def recorded_ledger(road: Road, vehicle: Vehicle) -> CycleLedger:
    """The account of the speeds recorded along `road`, over its heights."""
    drive = _recorded(road)
    return drive_cycle(vehicle, drive.t, drive.v, _slope(drive.s, road.height_at(drive.s)))


def _recorded(road: Road) -> Recorded:
    if road.recorded is None:
        raise PlanningError(f"{road.name}: records neither times nor speeds, nothing to score")
    return road.recorded


def _slope(s: Floats, z: Floats) -> Floats:
    """(n-1,) slopes; level where nothing moves."""
    way = np.diff(s)
    return np.where(way > 1e-6, np.diff(z) / np.maximum(way, 1e-6), 0.0)


def _planned(planner: Planner, vehicle: Vehicle, asked: PlanRequest, drive: Recorded) -> Plan:
    """The plan in the recorded time, or in the least time that the car needs."""
    road = planner.road
    stops = [s for s, _ in _stops(drive, road)]
    wished = replace(asked, rules=replace(asked.rules, stops=tuple(sorted({*asked.rules.stops, *stops}))))
    if not road.closed:
        wished = replace(wished, rules=_with_ends(planner, vehicle, wished, drive))
    try:
        return planner.plan(vehicle, replace(wished, journey_time=drive.moving_time))
    except InfeasibleError:
        return _least(planner, vehicle, wished)


def _with_ends(planner: Planner, vehicle: Vehicle, asked: PlanRequest, drive: Recorded) -> DriveRules:
    """Rules with the recorded speeds at both ends, where they are within the limits, else the limits themselves."""
    fastest = [asked.rules.limits(planner.road, planner.path(vehicle, asked, kind), vehicle).v_max for kind in ("lane", "optimal")]
    start, end = (float(min(drive.v[at], *(v[at] for v in fastest))) for at in (0, -1))
    return replace(asked.rules, start_speed=start, end_speed=end)


def _least(planner: Planner, vehicle: Vehicle, asked: PlanRequest) -> Plan:
    """The plan in the least time; with these speeds at the ends if the car can, else from and to a standstill."""
    planner = Planner(replace(planner.road, recorded=None), report=planner.report)
    try:
        return planner.plan(vehicle, replace(asked, journey_time=None))
    except InfeasibleError:
        return planner.plan(vehicle, replace(asked, rules=replace(asked.rules, start_speed=0.0, end_speed=0.0)))


def _stops(drive: Recorded, road: Road) -> list[tuple[float, float]]:
    """Stations (m) and durations (s) of the stops on the way; those at the ends are no stop lines."""
    found: list[tuple[float, float]] = []
    for s, duration in drive.stops:
        if found and s - found[-1][0] < _APART:
            found[-1] = found[-1][0], found[-1][1] + duration
        elif _APART < s < road.length - _APART:
            found.append((s, duration))
    return found


def _ledger(plan: Plan, drive: Recorded) -> CycleLedger:
    """The account of the plan, which stands at its stops as long as the recorded drive did in all."""
    profile, limits = plan.chosen.profile, plan.chosen.limits
    t = np.concatenate([[0.0], np.cumsum(profile.interval_time)])
    rows = np.arange(len(t))
    standing = drive.duration - drive.moving_time
    still = np.flatnonzero(profile.v == 0.0)
    if standing > 0.0 and len(still):
        # standing costs the same wherever it is: all of it at the first stop
        at = int(still[0])
        rows = np.concatenate([rows[: at + 1], rows[at:]])
        t = np.concatenate([t[: at + 1], t[at:] + standing])
    return drive_cycle(plan.vehicle, t, profile.v[rows], _slope(profile.s[rows], limits.z[rows]))
