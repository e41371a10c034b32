"""Makes drives on one road with one car; paths and their limits are made once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from .comparison import Comparison, Run
from .errors import InfeasibleError, PlanningError
from .path import Path, PathOptions, plan_path
from .speed import BatteryDrive, DriveRules, EcoSolver, SpeedLimits, fastest_profile, plan_speed, scaled_profile
from .speed.forward_backward import refuse_too_early
from .speed.result import energy_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from powertrain import Vehicle
    from roads import Road
    from roads.road import Extent

    from .path.planner import PathKind

SpeedKind = Literal["fast", "toppra", "eco", "socp", "dp", "nlp"]


class Planner:
    """Makes runs on one road with one car; paths and their limits are made once."""

    def __init__(
        self,
        road: Road,
        vehicle: Vehicle,
        corridor: Extent,
        margin: float,
        options: PathOptions,
        rules: DriveRules,
        report: Callable[[str], None] | None,
    ) -> None:
        self.road, self.vehicle, self.report = road, vehicle, report
        self._clearance = 0.5 * vehicle.chassis.width_m + margin
        self._corridor: Extent = corridor
        self._margin, self._options, self._rules = margin, options, rules
        self._routes: dict[PathKind, tuple[Path, SpeedLimits]] = {}

    def route(self, kind: PathKind) -> tuple[Path, SpeedLimits]:
        """The path of that kind and the limits along it."""
        if kind not in self._routes:
            path = plan_path(self.road, self._clearance, extent=self._corridor, kind=kind, options=self._options, report=self.report)
            self._routes[kind] = path, self._rules.limits(self.road, path, self.vehicle)
        return self._routes[kind]

    def run(self, kind: PathKind, speed: SpeedKind, journey_time: float | None) -> Run:
        """Drive a path by a method; without a time at its fastest."""
        path, limits = self.route(kind)
        if self.report and speed != "fast":
            self.report(f"speed: {speed} over {len(limits.s)} stations")
        if speed == "fast":  # the baseline, which knows neither jerk nor windows
            profile = fastest_profile(limits) if journey_time is None else scaled_profile(limits, journey_time)
        else:
            profile = plan_speed(limits, speed, journey_time=None if speed == "toppra" else journey_time)
        return Run(path, limits, profile, energy_of(limits, profile))

    def priced(self, kind: PathKind, speed: SpeedKind, price: float) -> Run:
        """Drive a path with least energy plus `price` (W) times time."""
        path, limits = self.route(kind)
        profile = plan_speed(limits, "dp" if speed == "dp" else "eco", price=price)
        return Run(path, limits, profile, energy_of(limits, profile))

    def joint(self, journey_time: float) -> Run:
        """Path and speed at once."""
        from .joint import joint_plan

        if self._rules != DriveRules(self._rules.start_speed, self._rules.end_speed):
            raise PlanningError(f"{self.road.name}: method joint knows no rules but the speeds at the ends")
        found = joint_plan(
            self.road,
            self.vehicle,
            corridor=self._corridor,
            margin=self._margin,
            journey_time=journey_time,
            path_options=self._options,
            start_speed=self._rules.start_speed,
            end_speed=self._rules.end_speed,
            report=self.report,
        )
        return Run(found.path, found.limits, found.profile, energy_of(found.limits, found.profile))

    def charged(self, run: Run, soc: float, price: float | None) -> tuple[Run, BatteryDrive]:
        """The drive again, within what the battery can give."""
        from .speed.battery import battery_profile

        if self.report:
            self.report("speed: power and charge of the battery")
        drive = battery_profile(run.limits, None if price is not None else run.journey_time, soc, price=price)
        return Run(run.path, drive.limits, drive.profile, energy_of(drive.limits, drive.profile)), drive

    def compare(self, journey_time: float | None) -> Comparison:
        """The four runs at `journey_time`, by default the earliest time that both paths can make."""
        earliest = {kind: _earliest(self.route(kind)[1]) for kind in ("lane", "optimal")}
        common = max(earliest.values()) if journey_time is None else journey_time

        def at_common(kind: PathKind, speed: SpeedKind) -> Run | None:
            if common < earliest[kind] * (1.0 - 1e-6):
                return None
            try:
                return self.run(kind, speed, common)
            except InfeasibleError:
                return None  # a slope that is only passed with momentum cannot be driven at scaled speeds

        return Comparison(common, at_common("lane", "fast"), at_common("optimal", "fast"), at_common("lane", "eco"), at_common("optimal", "eco"))

    def choose(self, path: PathKind, speed: SpeedKind, journey_time: float | None, comparison: Comparison) -> Run:
        """The run asked for, taken from the comparison where it is there."""
        if speed in ("fast", "toppra") and journey_time is None:
            return self.run(path, speed, None)
        made = {
            ("lane", "fast"): comparison.reference,
            ("optimal", "fast"): comparison.path_only,
            ("lane", "eco"): comparison.speed_only,
            ("optimal", "eco"): comparison.both,
        }.get((path, speed))
        if speed == "toppra":
            raise PlanningError(f"{self.road.name}: toppra with an arrival time, expected none: it finds the least")
        if made is None:
            refuse_too_early(self.road.name, comparison.journey_time, _earliest(self.route(path)[1]))
            return self.run(path, speed, comparison.journey_time)
        return made


def _earliest(limits: SpeedLimits) -> float:
    """The least possible time, s; with windows a little more, so that speeds have room."""
    least = EcoSolver(limits).least_time
    return 1.002 * least if limits.windows else least
