"""The main job: from a road and a car to a thrifty drive, compared with an ordinary one at the same arrival time."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Literal

from powertrain import Vehicle, load_vehicle
from roads import Road, open_road

from .comparison import KWH, Comparison, Plan, Run, saving_percent
from .errors import PlanningError
from .path import Path, PathOptions
from .planner import Planner, SpeedKind
from .speed import DriveRules, EcoSolver, Front, SpeedLimits

if TYPE_CHECKING:
    from collections.abc import Callable
    from os import PathLike

    from roads.road import Extent

    from .path.planner import PathKind

PlanMethod = Literal["sequential", "joint"]

__all__ = ["KWH", "Comparison", "Plan", "Run", "plan", "plan_front", "saving_percent"]


def plan(
    road: Road | str | PathLike[str],
    vehicle: Vehicle | str | PathLike[str] = "romo",
    *,
    corridor: Extent = "own",
    path: PathKind = "optimal",
    speed: SpeedKind = "eco",
    method: PlanMethod = "sequential",
    journey_time: float | None = None,
    price: float | None = None,
    soc: float | None = None,
    rules: DriveRules | None = None,
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
        speed: `eco` (least energy at the arrival time), `fast` (V1; with a time scaled to it, V2), or another method of `speed.plan_speed`.
        method: `sequential` (path, then speed) or `joint` (both at once, warm started by the sequential plan; `eco` on the optimal path).
        journey_time: arrival time in s; by default the least time that the lane centre and the optimal path can both make (`eco`), which nearly
            always is that of the lane centre, or the least possible (`fast`).
        price: of time, W, instead of an arrival time: the drive is the thriftiest one plus this for every second.
        soc: charge at the start, 0 to 1: the battery's power bounds the drive, and the arrival is put off until the charge lasts.
        rules: what else bounds the drive: stops, windows, jerk, grip, friction brakes, speeds at the ends.
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
    if price is not None and (journey_time is not None or speed not in ("eco", "dp") or method == "joint"):
        raise PlanningError("a price of time goes with speed eco or dp, without an arrival time and method joint")
    if method == "joint" and (path != "optimal" or speed != "eco"):
        raise PlanningError(f"method joint with path {path} and speed {speed}, expected optimal and eco")
    if speed == "fast" and rules is not None and (rules.jerk is not None or rules.windows):
        raise PlanningError("speed fast knows no limit of jerk and no windows, expected eco or nlp")
    if soc is not None and speed != "eco":
        raise PlanningError(f"a charge with speed {speed}, expected eco")
    options = _steerable(path_options or PathOptions(), vehicle)
    planner = Planner(road, vehicle, corridor, margin, options, rules or DriveRules(), report)
    priced = None if price is None else planner.priced(path, speed, price)
    comparison = planner.compare(journey_time if priced is None else priced.journey_time)
    if method == "joint":
        comparison = replace(comparison, joint=planner.joint(comparison.journey_time))
    chosen = priced or comparison.joint or planner.choose(path, speed, journey_time, comparison)
    battery = None
    if soc is not None:
        chosen, battery = planner.charged(chosen, soc, price)
    baseline = comparison.reference or planner.run("lane", "fast", None)
    return Plan(road, vehicle, corridor, margin, chosen, baseline, comparison, battery)


def _steerable(options: PathOptions, vehicle: Vehicle) -> PathOptions:
    """The options with no more curvature than the car can steer."""
    radius = vehicle.limits.turning_radius_min_m
    return options if radius is None else replace(options, curvature_max=min(options.curvature_max, 1.0 / radius))


def plan_front(
    road: Road | str | PathLike[str],
    vehicle: Vehicle | str | PathLike[str] = "romo",
    *,
    corridor: Extent = "own",
    path: PathKind = "optimal",
    rules: DriveRules | None = None,
    margin: float = 0.2,
    closed: bool | None = None,
    path_options: PathOptions | None = None,
    count: int = 20,
    slowest: float | None = None,
    report: Callable[[str], None] | None = None,
) -> tuple[Path, SpeedLimits, Front]:
    """Time against energy on one path: what arriving earlier costs, from the fastest drive to the thriftiest.

    Args:
        road, vehicle, corridor, path, rules, margin, closed, path_options, report: as for `plan`.
        count: number of drives.
        slowest: time of the last of them, s; by default that of the thriftiest, or four times the least time if that is earlier.

    Raises:
        RoadError, VehicleError, InfeasibleError, PlanningError: as `plan`.
    """
    road = road if isinstance(road, Road) else open_road(road, closed=closed)
    vehicle = vehicle if isinstance(vehicle, Vehicle) else load_vehicle(vehicle)
    if not 0.0 <= margin < 100.0:
        raise PlanningError(f"margin {margin} m, expected 0 to 100 m")
    planner = Planner(road, vehicle, corridor, margin, _steerable(path_options or PathOptions(), vehicle), rules or DriveRules(), report)
    found, limits = planner.route(path)
    if report:
        report(f"speed: {count} drives over {len(limits.s)} stations")
    return found, limits, EcoSolver(limits).front(count, slowest=slowest)
