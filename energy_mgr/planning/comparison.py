"""What planning gives: ways of driving a road, compared at one arrival time."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

from powertrain import KWH

from ..trajectory.trajectory import Trajectory

if TYPE_CHECKING:
    from collections.abc import Callable

    from powertrain import Ledger, Vehicle
    from roads import Road
    from roads.road import Extent

    from ..path import Path
    from ..path.planner import PathKind
    from ..request import PlanRequest, SpeedKind
    from ..speed import BatteryDrive, SpeedLimits, SpeedProfile


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
    """Four ways to drive the road at one arrival time; None where that way cannot arrive so early. Each is driven when it is first asked for.

    A way that no solver finds raises SolverError when it is asked for.

    Attributes:
        journey_time: the common arrival time, s.
        drive: drives a path (`lane`, `optimal`) by a method (`fast`, `eco`) at that time.
        joint: path and speed as one optimal control problem; None unless asked for.
        recorded: the drive that was recorded along the road, on the lane's centre and in its own time; None where none was.
    """

    journey_time: float
    drive: Callable[[PathKind, SpeedKind], Run | None] = field(repr=False)
    joint: Run | None = None
    recorded: Run | None = None

    @cached_property
    def reference(self) -> Run | None:
        """Lane centre, fastest profile, scaled to the time if that is later (V1, V2)."""
        return self.drive("lane", "fast")

    @cached_property
    def path_only(self) -> Run | None:
        """The optimal path, fastest profile scaled to the time (V2): what the published comparison does."""
        return self.drive("optimal", "fast")

    @cached_property
    def speed_only(self) -> Run | None:
        """Lane centre, energy-optimal speed."""
        return self.drive("lane", "eco")

    @cached_property
    def both(self) -> Run | None:
        """Optimal path, energy-optimal speed."""
        return self.drive("optimal", "eco")

    def of(self, path: PathKind, speed: SpeedKind) -> Run | None:
        """The one of the four with that path and speed; None for other speeds."""
        name = {("lane", "fast"): "reference", ("optimal", "fast"): "path_only", ("lane", "eco"): "speed_only", ("optimal", "eco"): "both"}
        return getattr(self, name[path, speed]) if (path, speed) in name else None


@dataclass(frozen=True, eq=False)
class Plan:
    """A planned drive.

    Attributes:
        road: the road.
        vehicle: the car.
        request: what was asked for.
        chosen: the drive asked for.
        baseline: lane centre driven by V1, scaled to the same arrival time if that is later than its own (V2); at its own if that is later.
        comparison: the saving at equal arrival time, by what it comes from.
        battery: the chosen drive with its battery, where a charge was given.
    """

    road: Road
    vehicle: Vehicle
    request: PlanRequest
    chosen: Run
    baseline: Run
    comparison: Comparison
    battery: BatteryDrive | None = None

    @property
    def corridor(self) -> Extent:
        """Part of the road that was used."""
        return self.request.corridor

    @property
    def margin(self) -> float:
        """Distance kept between the car's side and the borders, m."""
        return self.request.margin

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
