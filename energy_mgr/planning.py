"""The main job: from a road and a car to a thrifty drive, compared with an ordinary one at the same arrival time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Literal

from powertrain import Ledger, Vehicle, drive_energy, load_vehicle
from roads import Road, open_road

from .errors import InfeasibleError, PlanningError
from .path import Path, PathOptions, plan_path
from .speed import SpeedLimits, SpeedProfile, eco_profile, fastest_profile, scaled_profile
from .speed.forward_backward import refuse_too_early
from .trajectory import Trajectory

if TYPE_CHECKING:
    from collections.abc import Callable
    from os import PathLike

    from roads.road import Extent

    from .path.planner import PathKind

SpeedKind = Literal["eco", "fast"]

#: Joules in a kilowatt-hour.
KWH = 3.6e6


@dataclass(frozen=True, eq=False)
class Run:
    """One way of driving the road: a path, the limits on it, a speed profile and the energy account."""

    path: Path
    limits: SpeedLimits
    profile: SpeedProfile
    ledger: Ledger

    @property
    def journey_time(self) -> float:
        """s"""
        return self.profile.journey_time

    @property
    def energy_kwh(self) -> float:
        """Energy drawn from the battery, kWh."""
        return self.ledger.total / KWH


@dataclass(frozen=True, eq=False)
class Comparison:
    """Four ways to drive the road at one arrival time; None where that way cannot arrive so early.

    Attributes:
        journey_time: the common arrival time, s.
        reference: lane centre, fastest profile, scaled to the time if that is later (V1, V2).
        path_only: the optimal path, fastest profile scaled to the time (V2): what the published comparison does.
        speed_only: lane centre, energy-optimal speed.
        both: optimal path, energy-optimal speed.
    """

    journey_time: float
    reference: Run | None
    path_only: Run | None
    speed_only: Run | None
    both: Run | None


@dataclass(frozen=True, eq=False)
class Plan:
    """A planned drive.

    Attributes:
        road: the road.
        vehicle: the car.
        corridor: part of the road that was used.
        margin: distance kept between the car's side and the borders, m.
        chosen: the drive asked for.
        baseline: lane centre driven by V1, scaled to the same arrival time if that is later than its own (V2); at its own if that is later.
        comparison: the saving at equal arrival time, by what it comes from.
    """

    road: Road
    vehicle: Vehicle
    corridor: Extent
    margin: float
    chosen: Run
    baseline: Run
    comparison: Comparison

    @cached_property
    def trajectory(self) -> Trajectory:
        """The planned trajectory."""
        return Trajectory.of(self.chosen.path, self.chosen.limits, self.chosen.profile, self.chosen.ledger)

    @property
    def journey_time(self) -> float:
        """Planned duration, s."""
        return self.chosen.journey_time

    @property
    def energy_kwh(self) -> float:
        """Energy that the plan draws from the battery, kWh."""
        return self.chosen.energy_kwh

    @property
    def saving_percent(self) -> float | None:
        """Energy saved against the baseline, %; None where the baseline gains energy and a percentage means nothing."""
        return saving_percent(self.chosen, self.baseline)

    @property
    def equal_time(self) -> bool:
        """True if plan and baseline arrive within 0.1 s of each other."""
        return abs(self.journey_time - self.baseline.journey_time) <= 0.1


def saving_percent(run: Run | None, reference: Run | None) -> float | None:
    """Energy that `run` saves against `reference`, %; None where either is missing or the reference draws no energy."""
    if run is None or reference is None or reference.ledger.total <= 0.0:
        return None
    return 100.0 * (1.0 - run.ledger.total / reference.ledger.total)


def plan(
    road: Road | str | PathLike[str],
    vehicle: Vehicle | str | PathLike[str] = "romo",
    *,
    corridor: Extent = "own",
    path: PathKind = "optimal",
    speed: SpeedKind = "eco",
    journey_time: float | None = None,
    margin: float = 0.2,
    closed: bool | None = None,
    path_options: PathOptions | None = None,
    report: Callable[[str], None] | None = None,
) -> Plan:
    """Plan a drive and compare it with the lane centre driven as fast as the limits allow.

    Args:
        road: a road, the name of a shipped one, or a road file.
        vehicle: a car, the name of a shipped one, or a TOML file.
        corridor: what the car may use: `lane`, `own` (all lanes that lead its way) or `road` (edge to edge).
        path: `optimal` (least curvature) or `lane` (its centre).
        speed: `eco` (least energy at the arrival time) or `fast` (V1).
        journey_time: arrival time in s; by default the least time that the lane centre and the optimal path can both make (`eco`), which nearly
            always is that of the lane centre, or the least possible (`fast`).
        margin: distance kept between the car's side and the borders, m.
        closed: for a road file, whether it is a circuit; None lets the file tell.
        path_options: how the path is found; its bound on curvature is that of the car's turning circle, if that is tighter.
        report: called with lines of progress.

    Raises:
        RoadError, VehicleError: a file that cannot be used.
        InfeasibleError: the road is too narrow or too steep, or the time too short; the place or least time is named.
        PlanningError: arguments out of range.
    """
    road = road if isinstance(road, Road) else open_road(road, closed=closed)
    vehicle = vehicle if isinstance(vehicle, Vehicle) else load_vehicle(vehicle)
    if not 0.0 <= margin < 100.0:
        raise PlanningError(f"margin {margin} m, expected 0 to 100 m")
    if journey_time is not None and not 0.0 < journey_time < 1e7:
        raise PlanningError(f"arrival time {journey_time} s, expected more than 0 and less than 1e7 s")
    planner = _Planner(road, vehicle, corridor, margin, _steerable(path_options or PathOptions(), vehicle), report)
    comparison = planner.compare(journey_time)
    chosen = planner.choose(path, speed, journey_time, comparison)
    baseline = comparison.reference or planner.run("lane", "fast", None)
    return Plan(road, vehicle, corridor, margin, chosen, baseline, comparison)


def _steerable(options: PathOptions, vehicle: Vehicle) -> PathOptions:
    """The options with no more curvature than the car can steer."""
    radius = vehicle.limits.turning_radius_min_m
    return options if radius is None else replace(options, curvature_max=min(options.curvature_max, 1.0 / radius))


class _Planner:
    """Makes runs on one road with one car; paths and their limits are made once."""

    def __init__(
        self, road: Road, vehicle: Vehicle, corridor: Extent, margin: float, options: PathOptions, report: Callable[[str], None] | None
    ) -> None:
        self.road, self.vehicle, self.report = road, vehicle, report
        self._clearance = 0.5 * vehicle.chassis.width_m + margin
        self._corridor: Extent = corridor
        self._options = options
        self._routes: dict[PathKind, tuple[Path, SpeedLimits]] = {}

    def route(self, kind: PathKind) -> tuple[Path, SpeedLimits]:
        """The path of that kind and the limits along it."""
        if kind not in self._routes:
            path = plan_path(self.road, self._clearance, extent=self._corridor, kind=kind, options=self._options, report=self.report)
            self._routes[kind] = path, SpeedLimits.along(self.road, path, self.vehicle)
        return self._routes[kind]

    def run(self, kind: PathKind, speed: SpeedKind, journey_time: float | None) -> Run:
        """Drive a path by V1 (`fast`; without a time at its fastest) or with least energy (`eco`)."""
        path, limits = self.route(kind)
        if journey_time is None:
            profile = fastest_profile(limits)
        elif speed == "fast":
            profile = scaled_profile(limits, journey_time)
        else:
            profile = eco_profile(limits, journey_time, report=self.report)
        return Run(path, limits, profile, drive_energy(self.vehicle, profile.s, profile.v, limits.z))

    def compare(self, journey_time: float | None) -> Comparison:
        """The four runs at `journey_time`, by default the earliest time that both paths can make."""
        earliest = {kind: fastest_profile(self.route(kind)[1]).journey_time for kind in ("lane", "optimal")}
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
        if speed == "fast" and journey_time is None:
            return self.run(path, "fast", None)
        made = {
            ("lane", "fast"): comparison.reference,
            ("optimal", "fast"): comparison.path_only,
            ("lane", "eco"): comparison.speed_only,
            ("optimal", "eco"): comparison.both,
        }[path, speed]
        if made is None:
            refuse_too_early(self.road.name, comparison.journey_time, fastest_profile(self.route(path)[1]).journey_time)
            return self.run(path, speed, comparison.journey_time)
        return made
