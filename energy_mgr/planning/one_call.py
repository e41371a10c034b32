"""The main job: from a road and a car to a thrifty drive, compared with an ordinary one at the same arrival time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from powertrain import KWH
from roads import Road, open_road

from ..request import PlanRequest, requested
from .comparison import Comparison, Plan, Run, saving_percent
from .planner import Planner

if TYPE_CHECKING:
    from collections.abc import Callable
    from os import PathLike
    from typing import Unpack

    from powertrain import Vehicle

    from ..path import Path
    from ..request import PlanWishes
    from ..speed import Front, SpeedLimits

__all__ = ["KWH", "Comparison", "Plan", "PlanRequest", "Planner", "Run", "plan", "plan_front", "saving_percent"]


def plan(
    road: Road | str | PathLike[str],
    vehicle: Vehicle | str | PathLike[str] = "romo",
    request: PlanRequest | None = None,
    *,
    closed: bool | None = None,
    report: Callable[[str], None] | None = None,
    **wishes: Unpack[PlanWishes],
) -> Plan:
    """Plan a drive and compare it with the lane centre driven as fast as the limits allow.

    Args:
        road: a road, the name of a shipped one, or a road file.
        vehicle: a car, the name of a shipped one, or a TOML file.
        request: what is asked for; by default the thriftiest drive of the own lanes at the least common arrival time.
        closed: for a road file, whether it is a circuit; None lets the file tell.
        report: called with lines of progress.
        wishes: fields of `PlanRequest` as keywords, in a short call or beside a request: `plan("rural", corridor="road", journey_time=180.0)`.

    Raises:
        RoadError, VehicleError: a file that cannot be used.
        InfeasibleError: the road is too narrow or too steep, or the time too short; the place or least time is named.
        PlanningError: wishes out of range.
    """
    asked = requested(request, wishes)
    return Planner(_road(road, closed), report=report).plan(vehicle, asked)


def plan_front(
    road: Road | str | PathLike[str],
    vehicle: Vehicle | str | PathLike[str] = "romo",
    request: PlanRequest | None = None,
    *,
    count: int = 20,
    slowest: float | None = None,
    closed: bool | None = None,
    report: Callable[[str], None] | None = None,
    **wishes: Unpack[PlanWishes],
) -> tuple[Path, SpeedLimits, Front]:
    """Time against energy on one path: what arriving earlier costs, from the fastest drive to the thriftiest.

    Args:
        road, vehicle, request, closed, report, wishes: as for `plan`; corridor, path, rules, margin and path options count.
        count: number of drives.
        slowest: time of the last of them, s; by default that of the thriftiest, or four times the least time if that is earlier.

    Raises:
        RoadError, VehicleError, InfeasibleError, PlanningError: as `plan`.
    """
    asked = requested(request, wishes)
    return Planner(_road(road, closed), report=report).front(vehicle, asked, count=count, slowest=slowest)


def _road(road: Road | str | PathLike[str], closed: bool | None) -> Road:
    return road if isinstance(road, Road) else open_road(road, closed=closed)
