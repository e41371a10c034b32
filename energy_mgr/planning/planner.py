"""Plans drives on one road, for one car or many: what depends on the road alone is made once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from powertrain import Vehicle, load_vehicle

from ..errors import InfeasibleError, PlanningError
from ..path import Path, plan_path
from ..request import PlanRequest
from ..speed import BatteryDrive, EcoSolver, Front, SpeedLimits, fastest_profile, plan_speed, scaled_profile
from ..speed.fastest.forward_backward import refuse_too_early
from ..speed.result import energy_of
from .comparison import Comparison, Plan, Run
from .recorded import recorded_run

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable
    from os import PathLike

    from roads import Road

    from ..path.planner import PathKind
    from ..request import SpeedKind


class Planner:
    """Plans drives on one road, for one car or many.

    Cars of the same width and turning circle share their paths, whatever else they are asked for:

        planner = Planner(roads.open_road("rural"))
        plans = [planner.plan(car, request) for car in cars for request in requests]

    Attributes:
        road: the road.
        report: called with lines of progress.
    """

    def __init__(self, road: Road, *, report: Callable[[str], None] | None = None) -> None:
        self.road, self.report = road, report
        self._paths: dict[Hashable, Path] = {}

    def plan(self, vehicle: Vehicle | str | PathLike[str] = "romo", request: PlanRequest | None = None) -> Plan:
        """Plan one drive; see `energy_mgr.plan`."""
        return _Drives(self, _loaded(vehicle), request or PlanRequest()).plan()

    def front(
        self, vehicle: Vehicle | str | PathLike[str], request: PlanRequest | None = None, *, count: int = 20, slowest: float | None = None
    ) -> tuple[Path, SpeedLimits, Front]:
        """Time against energy; see `energy_mgr.plan_front`."""
        asked = request or PlanRequest()
        asked.refuse_beside("a front", "corridor", "path", "rules", "margin", "path_options")
        path, limits = _Drives(self, _loaded(vehicle), asked).route(asked.path)
        if self.report:
            self.report(f"speed: {count} drives over {len(limits.s)} stations")
        return path, limits, EcoSolver(limits).front(count, slowest=slowest)

    def path(self, vehicle: Vehicle, request: PlanRequest, kind: PathKind) -> Path:
        """The path of that kind for a car; found once for all cars and requests that ask for the same."""
        clearance, options = request.clearance(vehicle), request.options_for(vehicle)
        key = clearance, request.corridor, kind, options
        if key not in self._paths:
            self._paths[key] = plan_path(self.road, clearance, extent=request.corridor, kind=kind, options=options, report=self.report)
        return self._paths[key]


def _loaded(vehicle: Vehicle | str | PathLike[str]) -> Vehicle:
    return vehicle if isinstance(vehicle, Vehicle) else load_vehicle(vehicle)


def driven(path: Path, limits: SpeedLimits, speed: SpeedKind, journey_time: float | None) -> Run:
    """Drive a path by a method; without a time at its fastest."""
    if speed == "fast":  # the baseline, which knows neither jerk nor windows
        profile = fastest_profile(limits) if journey_time is None else scaled_profile(limits, journey_time)
    else:
        profile = plan_speed(limits, speed, journey_time=None if speed == "toppra" else journey_time)
    return Run(path, limits, profile, energy_of(limits, profile))


@dataclass(frozen=True, eq=False)
class AtOneTime:
    """Drives the paths of a plan at its arrival time, by any method; it holds these paths and no more, so that a plan can be kept and sent about.

    Attributes:
        journey_time: s.
        earliest: least time on each path, s.
        routes: the paths and the limits along them.
    """

    journey_time: float
    earliest: dict[PathKind, float]
    routes: dict[PathKind, tuple[Path, SpeedLimits]]

    def __call__(self, kind: PathKind, speed: SpeedKind) -> Run | None:
        """The run; None where it cannot arrive so early, or a slope that is only passed with momentum cannot be driven at scaled speeds."""
        if self.journey_time < self.earliest[kind] * (1.0 - 1e-6):
            return None
        try:
            return driven(*self.routes[kind], speed, self.journey_time)
        except InfeasibleError:
            return None


class _Drives:
    """Makes runs with one car; limits along its paths are made once."""

    def __init__(self, planner: Planner, vehicle: Vehicle, request: PlanRequest) -> None:
        self.planner, self.vehicle, self.request = planner, vehicle, request
        self.road, self.report = planner.road, planner.report
        self._routes: dict[PathKind, tuple[Path, SpeedLimits]] = {}

    def plan(self) -> Plan:
        """The drive asked for, beside the others."""
        asked = self.request
        priced = None if asked.price is None else self.priced(asked.price)
        comparison = self.compare(asked.journey_time if priced is None else priced.journey_time)
        chosen = priced or comparison.joint or self.choose(comparison)
        battery = None
        if asked.soc is not None:
            chosen, battery = self.charged(chosen, asked.soc)
        baseline = comparison.reference or self.run("lane", "fast", None)
        return Plan(self.road, self.vehicle, asked, chosen, baseline, comparison, battery)

    def route(self, kind: PathKind) -> tuple[Path, SpeedLimits]:
        """The path of that kind and the limits along it."""
        if kind not in self._routes:
            path = self.planner.path(self.vehicle, self.request, kind)
            self._routes[kind] = path, self.request.rules.limits(self.road, path, self.vehicle)
        return self._routes[kind]

    def run(self, kind: PathKind, speed: SpeedKind, journey_time: float | None) -> Run:
        """Drive a path by a method; without a time at its fastest."""
        path, limits = self.route(kind)
        return driven(path, limits, speed, journey_time)

    def priced(self, price: float) -> Run:
        """Drive with least energy plus `price` (W) times time."""
        path, limits = self.route(self.request.path)
        profile = plan_speed(limits, "dp" if self.request.speed == "dp" else "eco", price=price)
        return Run(path, limits, profile, energy_of(limits, profile))

    def joint(self, journey_time: float) -> Run:
        """Path and speed at once."""
        from ..joint import joint_plan

        asked = replace(self.request, journey_time=journey_time, soc=None)  # the charge is looked at afterwards
        found = joint_plan(self.road, self.vehicle, asked, report=self.report)
        return Run(found.path, found.limits, found.profile, energy_of(found.limits, found.profile))

    def charged(self, run: Run, soc: float) -> tuple[Run, BatteryDrive]:
        """The drive again, within what the battery can give."""
        from ..speed.battery import battery_profile

        if self.report:
            self.report("speed: power and charge of the battery")
        price = self.request.price
        drive = battery_profile(run.limits, None if price is not None else run.journey_time, soc, price=price)
        return Run(run.path, drive.limits, drive.profile, energy_of(drive.limits, drive.profile)), drive

    def compare(self, journey_time: float | None) -> Comparison:
        """The ways to drive at `journey_time`, by default the recorded time, or the earliest that both paths can make if that is later."""
        earliest: dict[PathKind, float] = {kind: _earliest(self.route(kind)[1]) for kind in ("lane", "optimal")}
        recorded = recorded_run(self.road, *self.route("lane"))
        common = max(*earliest.values(), 0.0 if recorded is None else recorded.journey_time) if journey_time is None else journey_time
        joint = self.joint(common) if self.request.method == "joint" else None
        return Comparison(common, AtOneTime(common, earliest, dict(self._routes)), joint, recorded)

    def choose(self, comparison: Comparison) -> Run:
        """The run asked for, taken from the comparison where it is there."""
        path, speed = self.request.path, self.request.speed
        if speed in ("fast", "toppra") and self.request.journey_time is None:
            return self.run(path, speed, None)
        if speed == "toppra":
            raise PlanningError(f"{self.road.name}: speed toppra with an arrival time, expected none: it finds the least; speed eco keeps one")
        if self.report and speed != "fast":
            self.report(f"speed: {speed} over {len(self.route(path)[1].s)} stations")
        made = comparison.of(path, speed)
        if made is None:
            refuse_too_early(self.road.name, comparison.journey_time, _earliest(self.route(path)[1]))
            return self.run(path, speed, comparison.journey_time)
        return made


def _earliest(limits: SpeedLimits) -> float:
    """The least possible time, s; with windows a little more, so that speeds have room."""
    least = EcoSolver(limits).least_time
    return 1.002 * least if limits.windows else least
