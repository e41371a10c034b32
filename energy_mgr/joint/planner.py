"""Path and speed planned together: what the sequential method, gentlest path first and thriftiest speed on it, leaves on the table."""

from __future__ import annotations

import time
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from powertrain import KWH, drive_energy

from ..errors import PlanningError, SolverError
from ..path import Path, PathReport, Prover, plan_path
from ..path.planner import with_repairs
from ..request import PlanRequest, requested
from ..speed import DriveRules, SpeedLimits, SpeedProfile, eco_profile, fastest_profile
from .grid import equal_parts, finer_parts
from .programme import JointProgramme, JointSolution, Point
from .start import problem_of, short_path, speeds_on, variables_of

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Unpack

    from numpy.typing import NDArray

    from powertrain import Vehicle
    from roads import Road
    from roads.road import Extent

    from ..path import Certificate, CurvatureProblem
    from ..request import PlanWishes

    Ints = NDArray[np.intp]

Start = Literal["sequential", "lane", "short"]
_STARTS = get_args(Start)

#: Rounds of solving and proving, and in how many of them intervals may be halved.
_ROUNDS, _FINER = 8, 3
#: A joint plan that does not save this fraction of the energy that moves is not worth another path.
_WORTH = 1e-6


@dataclass(frozen=True, eq=False)
class JointPlan:
    """Path and speed planned together, beside what they started from.

    Attributes:
        path: the path.
        limits: what bounds the speed on it.
        profile: the energy-optimal speed on it, by `eco_profile`.
        sequential: path and profile of the sequential method at the same arrival time.
        energy_kwh: energy of the plan by `drive_energy`, kWh.
        sequential_energy_kwh: that of the sequential one, kWh.
        extra_percent: saved over the sequential plan, %; None where that one gains energy and a percentage means nothing.
        status: `solved`, or `sequential kept` where the joint problem gave nothing better.
        note: why the sequential plan was kept; else empty.
        iterations: of IPOPT, all rounds together.
        rounds: programmes solved until the path could be proven to keep its clearance.
        solve_ms: wall time of the joint problem without the sequential plan, ms.
        programme_kwh: energy by the joint programme itself, on its own stations, kWh; NaN where it found none.
    """

    path: Path
    limits: SpeedLimits
    profile: SpeedProfile
    sequential: tuple[Path, SpeedProfile]
    energy_kwh: float
    sequential_energy_kwh: float
    extra_percent: float | None
    status: str
    note: str
    iterations: int
    rounds: int
    solve_ms: float
    programme_kwh: float


def joint_plan(
    road: Road,
    vehicle: Vehicle,
    request: PlanRequest | None = None,
    *,
    step: float = 4.0,
    start_speed: float | None = None,
    end_speed: float | None = None,
    start: Start = "sequential",
    report: Callable[[str], None] | None = None,
    **wishes: Unpack[PlanWishes],
) -> JointPlan:
    """Plan path and speed as one optimal control problem: least energy for the arrival time. Never worse than the sequential plan.

    The optimum is a local one, near the start. The speed returned is that of `eco_profile` on the path found, so that it compares with the
    sequential plan on equal terms.

    Args:
        road: where to drive.
        vehicle: the car.
        request: what is asked for: corridor, margin, arrival time (by default the least that the lane's centre and the gentlest path can both make),
            speeds at the ends, and how the sequential path is found; its knots, ends and bound on curvature hold for the joint one too.
        step: longest interval between stations of the joint problem, m.
        start_speed, end_speed: on open roads, m/s; None: those of the request's rules.
        start: path to start from: the `sequential` one, the `lane` centre or nearly the shortest path (`short`).
        report: called with lines of progress.
        wishes: fields of `PlanRequest` as keywords.

    Raises:
        InfeasibleError: the road is too narrow or too steep, or the time too short for the sequential plan.
        SolverError: the sequential plan was not found. Where the joint problem fails, the sequential plan is kept, and `note` says why.
        PlanningError: arguments out of range; rules that the joint problem does not know.
    """
    asked = requested(request, wishes)
    ends = {name: speed for name, speed in (("start_speed", start_speed), ("end_speed", end_speed)) if speed is not None}
    asked = replace(asked, rules=replace(asked.rules, **ends))
    asked.refuse_beside("a joint plan", "corridor", "method", "journey_time", "rules", "margin", "path_options")
    if not 0.5 <= step <= 50.0:
        raise PlanningError(f"step of the joint plan {step} m, expected 0.5 to 50 m")
    if start not in _STARTS:
        raise PlanningError(f"start of the joint plan {start!r}, expected one of {', '.join(_STARTS)}")
    if asked.rules != DriveRules(asked.rules.start_speed, asked.rules.end_speed):
        own = DriveRules(asked.rules.start_speed, asked.rules.end_speed)
        others = ", ".join(rule.name for rule in fields(DriveRules) if getattr(asked.rules, rule.name) != getattr(own, rule.name))
        raise PlanningError(f"{road.name}: method joint knows no rules but the speeds at the ends, expected method sequential for {others}")
    planner = _Planner(road, vehicle, asked, step, report)
    return planner.improve(planner.sequential(asked.journey_time), start)


@dataclass(frozen=True, eq=False)
class _Drive:
    """A path driven in the arrival time with least energy."""

    path: Path
    limits: SpeedLimits
    profile: SpeedProfile
    energy: float
    moved: float
    journey_time: float


class _Planner:
    """Plans on one road with one car."""

    def __init__(self, road: Road, vehicle: Vehicle, request: PlanRequest, step: float, report: Callable[[str], None] | None) -> None:
        self.road, self.vehicle, self.report = road, vehicle, report
        self._corridor: Extent = request.corridor
        self._clearance, self._options = request.clearance(vehicle), request.options_for(vehicle)
        self._step, self._speeds = step, (request.rules.start_speed, request.rules.end_speed)

    def sequential(self, journey_time: float | None) -> _Drive:
        """Gentlest path, then thriftiest speed."""
        road, clearance = self.road, self._clearance
        path = plan_path(road, clearance, extent=self._corridor, options=self._options, report=self.report)
        limits = self._limits(path)
        if journey_time is None:
            lane = self._limits(plan_path(road, clearance, extent=self._corridor, kind="lane"))
            journey_time = max(fastest_profile(one).journey_time for one in (limits, lane))
        return self._drive(path, limits, journey_time)

    def _limits(self, path: Path) -> SpeedLimits:
        return SpeedLimits.along(self.road, path, self.vehicle, start_speed=self._speeds[0], end_speed=self._speeds[1])

    def _drive(self, path: Path, limits: SpeedLimits, journey_time: float) -> _Drive:
        profile = eco_profile(limits, journey_time, report=self.report)
        ledger = drive_energy(self.vehicle, profile.s, profile.v, limits.z)
        return _Drive(path, limits, profile, ledger.total, sum(abs(part) for part in ledger.components.values()), journey_time)

    def improve(self, sequential: _Drive, start: Start) -> JointPlan:
        """The joint plan, or the sequential one where that is not better."""
        began = time.perf_counter()
        search = _Search(self.road, self.vehicle, sequential, self._step, self._speeds, self.report)
        better, note = None, ""
        try:
            path = search.path(problem_of(self.road, sequential.path, self._clearance, self._corridor, self._options), start)
            better = self._drive(path, self._limits(path), sequential.journey_time)
        except PlanningError as error:
            note = str(error)
        if better is not None and better.energy > sequential.energy - _WORTH * sequential.moved:
            note = f"the joint path takes {better.energy / KWH:.6f} kWh, the sequential one {sequential.energy / KWH:.6f} kWh"
            better = None
        best = better or sequential
        return JointPlan(
            best.path,
            best.limits,
            best.profile,
            (sequential.path, sequential.profile),
            best.energy / KWH,
            sequential.energy / KWH,
            100.0 * (1.0 - best.energy / sequential.energy) if sequential.energy > 0.0 else None,
            "sequential kept" if better is None else "solved",
            note,
            search.iterations,
            search.rounds,
            1e3 * (time.perf_counter() - began),
            search.energy / KWH,
        )


class _Search:
    """Solves the joint problem and proves the path, in turns, until the proof holds."""

    def __init__(
        self, road: Road, vehicle: Vehicle, sequential: _Drive, step: float, speeds: tuple[float, float], report: Callable[[str], None] | None
    ) -> None:
        self._road, self._vehicle, self._sequential = road, vehicle, sequential
        self._step, self._speeds, self._report = step, speeds, report
        self.iterations, self.rounds, self.energy = 0, 0, float("nan")

    def path(self, problem: CurvatureProblem, start: Start) -> Path:
        """The path of the joint optimum, proven to keep its clearance.

        Raises:
            SolverError: IPOPT did not converge, or no proof was found.
        """
        began, parts = time.perf_counter(), equal_parts(problem, self._step)
        prover, point = Prover(problem.corridor), None
        while True:
            programme = self._programme(problem, parts)
            point = self._start(programme, start) if point is None else point.on(programme.grid.q)
            found = programme.solve(point, near=self.rounds > 0, report=self._report)
            self.iterations, self.rounds, self.energy = self.iterations + found.iterations, self.rounds + 1, found.energy
            point = found.point
            certificate = prover.prove(problem.spline.pieces(point.x), problem.curvature_max)
            finer = finer_parts(problem, parts, point.x, point.v**2, self._vehicle.limits.lateral_acceleration_max_mps2)
            # peaks that remain cost optimality only: the speed is planned anew on the path
            if certificate.certified and (self.rounds > _FINER or np.array_equal(finer, parts)):
                return self._made(problem, found, certificate, 1e3 * (time.perf_counter() - began))
            if self.rounds >= _ROUNDS:
                raise SolverError(f"{self._road.name}: joint path: {certificate.fault}")
            parts = finer if self.rounds <= _FINER else parts
            problem = with_repairs(problem, point.x, certificate)

    def _programme(self, problem: CurvatureProblem, parts: Ints) -> JointProgramme:
        plan = self._sequential
        return JointProgramme(problem, self._road, self._vehicle, plan.journey_time, 0.01 * plan.moved, parts, *self._speeds)

    def _start(self, programme: JointProgramme, start: Start) -> Point:
        problem = programme.problem
        starts = {"sequential": lambda: variables_of(problem, self._sequential.path), "lane": problem.initial, "short": lambda: short_path(problem)}
        x = starts[start]()
        return Point(x, programme.grid.q, speeds_on(programme.grid, x, self._sequential.profile, self._vehicle))

    def _made(self, problem: CurvatureProblem, found: JointSolution, certificate: Certificate, solve_ms: float) -> Path:
        curve = problem.curve(found.point.x)
        bound = np.isfinite(problem.curvature_max)
        report = PathReport(
            status="solved",
            certified=certificate.certified,
            cost_centre=self._sequential.path.report.cost_centre,
            cost=curve.squared_curvature(),
            iterations=self.iterations,
            optimality=float("nan"),
            kkt_residual=found.residual,
            max_violation_m=certificate.beyond,
            max_curvature=certificate.curvature if bound else float(np.max(np.abs(curve.curvature(curve.breaks_s)))),
            solve_ms=solve_ms,
            knots=len(problem.q),
            method="joint",
            qp="ipopt",
        )
        return Path(curve, curve.breaks_s, problem.spline.breaks, report)
