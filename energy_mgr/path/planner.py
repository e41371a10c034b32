"""From a road and a clearance to a path that is proven to lie inside it."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np

from roads.geometry.cubic import PiecewiseCubic

from ..errors import InfeasibleError, PlanningError, SolverError
from .problem.ends import both_ends
from .problem.knots import knots_by_need
from .problem.problem import CurvatureProblem
from .proof.certificate import Certificate, Prover
from .refusals import refuse_narrow, refuse_road
from .result import Path, PathReport
from .solvers import METHODS, solve
from .solvers.backends import qp_solver

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from roads import Corridor, Narrowing, PlanarCurve, Road
    from roads.road import Extent

    from .problem.ends import End
    from .problem.objective import Weights
    from .solvers import Method, Solution

    Floats = NDArray[np.float64]

PathKind = Literal["optimal", "lane"]

#: Borders are drawn in by this much, m: what the proof of being inside needs to spare.
TIGHTER = 5e-4
#: A place beyond the border is repaired by drawing the border in by so much more than it is beyond, m.
_REPAIR_MORE = 2e-4
#: Rounds of control points per set of knots, and how much denser the knots get where these do not suffice.
_ROUNDS, _DENSER = 8, (1.0, 1.7, 3.0)
#: Methods that end where they do, above the optimum, and say they are done.
APPROXIMATE = ("linearised", "gradient")
#: Steps that promise less than this fraction of the cost end the first solve, after which control points are added.
_ROUGH = 1e-4


@dataclass(frozen=True)
class PathOptions:
    """How a path is found.

    Attributes:
        knots: `need` (closer in bends), or a distance in m for equal ones.
        control_points: points between two knots at which the borders are kept from the start; more are added where the proof needs them.
        method: solver, see `energy_mgr.path.solvers`.
        qp: back end of the QPs.
        tolerance: stop when less than this fraction of the cost is left to gain.
        weights: what is mixed into squared curvature.
        ends: what holds where an open road begins and ends; None: on the lane, along it.
        curvature_max: bound on the path's curvature, 1/m.
    """

    knots: Literal["need"] | float = "need"
    control_points: int = 3
    method: Method = "gauss-newton"
    qp: str = "piqp"
    tolerance: float = 1e-6
    weights: Weights | None = None
    ends: tuple[End | None, End | None] = (None, None)
    curvature_max: float = np.inf
    density: float = field(default=1.0, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "ends", both_ends(self.ends))
        if self.knots != "need" and not (isinstance(self.knots, int | float) and not isinstance(self.knots, bool) and 0.05 <= self.knots <= 1000.0):
            raise PlanningError(f"knots {self.knots!r}, expected 'need' or a distance of 0.05 to 1000 m")
        if not isinstance(self.control_points, int) or not 0 <= self.control_points <= 100:
            raise PlanningError(f"{self.control_points} control points between two knots, expected 0 to 100")
        if self.method not in METHODS:
            raise PlanningError(f"method {self.method!r}, expected one of {', '.join(METHODS)}")
        if self.qp not in ("piqp", "clarabel"):
            qp_solver(self.qp)  # refuses what is not installed
        if not self.curvature_max > 0.0:
            raise PlanningError(f"bound on curvature {self.curvature_max} 1/m, expected more than 0")
        if not 1e-14 <= self.tolerance <= 0.1:
            raise PlanningError(f"tolerance {self.tolerance}, expected 1e-14 to 0.1")


def plan_path(
    road: Road,
    clearance: float,
    *,
    extent: Extent = "own",
    kind: PathKind = "optimal",
    narrowings: Sequence[Narrowing] = (),
    options: PathOptions | None = None,
    report: Callable[[str], None] | None = None,
) -> Path:
    """The path of least integral of squared curvature inside the corridor, or the centre of the driving lane; proven to keep its clearance
    everywhere.

    Args:
        road: where to drive.
        clearance: distance that the path keeps from the borders, m: half the car's width plus a margin.
        extent: part of the cross-section that may be used, `lane`, `own` (all lanes that lead this way) or `road`.
        kind: `optimal` or `lane` (the lane's centre, which is checked against the corridor but not optimised).
        narrowings: obstacles and other places where the borders are closer than the road's.
        options: how the path is found.
        report: called with lines of progress.

    Raises:
        InfeasibleError: the road is too narrow, or no smooth path keeps the borders or the bound on curvature; the station is named.
        SolverError: no path that passes the proof was found; the station is named.
        PlanningError: options out of range, or a road below 1 m or above 2000 km.
        RoadError: the road's line turns back on itself; the station is named.
    """
    started = time.perf_counter()
    if not 0.0 <= clearance < 100.0:
        raise PlanningError(f"clearance {clearance} m, expected 0 to 100 m")
    corridor = road.corridor(extent, clearance).narrowed(*narrowings)
    refuse_road(corridor)
    lane = road.lane_centre()
    if kind == "lane":
        refuse_narrow(corridor)
        return _follow_lane(road, corridor, lane, started)
    return path_in(corridor, lane, options or PathOptions(), report=report)


def path_in(corridor: Corridor, centre: PlanarCurve, options: PathOptions, *, report: Callable[[str], None] | None = None) -> Path:
    """As `plan_path`, in a corridor; `centre` is the first guess and where open ends lie.

    Knots and control points are added until the proof holds. Only when much closer knots find no path either is the corridor called infeasible.
    """
    started = time.perf_counter()
    refuse_narrow(corridor)
    prover, iterations, fault, stalled = Prover(corridor), 0, None, None
    for denser in _DENSER:
        try:
            problem = _problem(corridor, centre, options, denser)
            found = _search(problem, prover, options, report)
        except (InfeasibleError, SolverError) as error:
            fault = error if fault is None or isinstance(error, InfeasibleError) else fault
            continue
        iterations += found.iterations
        if found.certificate.certified and found.solution.converged:
            return _path(found, iterations, centre, options, started)
        if found.certificate.certified:
            stalled = found if stalled is None or found.solution.cost < stalled.solution.cost else stalled
        else:
            fault = SolverError(f"{corridor.name}: {found.certificate.fault}")
    if stalled is not None:
        return _path(stalled, iterations, centre, options, started)
    if fault is not None and options.knots != "need":
        raise type(fault)(f"{fault} (knots {options.knots:g} m apart and closer; `need` puts them where the road bends)")
    raise fault or SolverError(f"{corridor.name}: no path was found")


def _problem(corridor: Corridor, centre: PlanarCurve, options: PathOptions, denser: float) -> CurvatureProblem:
    length = corridor.reference.length
    knots = knots_by_need(corridor, density=options.density * denser) if options.knots == "need" else None
    return CurvatureProblem.on(
        corridor,
        centre,
        spacing=min(length, 1000.0) if options.knots == "need" else options.knots / denser,
        knots=knots,
        control_points=options.control_points,
        weights=options.weights,
        ends=options.ends,
        curvature_max=options.curvature_max,
        tighter=TIGHTER,
    )


@dataclass(frozen=True, eq=False)
class _Found:
    """A solved problem and what is proven about it."""

    problem: CurvatureProblem
    solution: Solution
    iterations: int
    certificate: Certificate


def _search(problem: CurvatureProblem, prover: Prover, options: PathOptions, report: Callable[[str], None] | None) -> _Found:
    """Solve roughly, prove, and solve to the end, with control points added wherever the proof fails."""
    x, iterations, rough, rounds = problem.initial(), 0, options.method == "gauss-newton", 0
    while True:
        tolerance = max(_ROUGH, options.tolerance) if rough else options.tolerance
        solution = solve(problem, x, options.method, qp=options.qp, tolerance=tolerance, report=report)
        x, iterations = solution.x, iterations + solution.iterations
        certificate = prover.prove(problem.spline.pieces(x), options.curvature_max)
        if (certificate.certified and not rough) or rounds == _ROUNDS:
            return _Found(problem, solution, iterations, certificate)
        problem = with_repairs(problem, x, certificate)
        rough, rounds = False, rounds + 1


def with_repairs(problem: CurvatureProblem, x: Floats, certificate: Certificate) -> CurvatureProblem:
    """Add a control point at each local worst place, with the border drawn in so far that the path must give way by what it is too close, and a
    little more.

    What the path is off the strip's border there counts too: where the strip is not exact, the proof fails although the strip is kept. Where the
    bound on curvature could not be proven, it is watched from now on.
    """
    if not certificate.gentle:
        problem = problem.with_bends(_apart(certificate.bends, 0.5))
    if certificate.inside:
        return problem
    stations, depth = certificate.where, certificate.depth
    group = np.cumsum(np.diff(stations, prepend=stations[0]) > 0.5)
    worst = np.lexsort((depth, group))
    last = np.append(group[worst][1:] != group[worst][:-1], True)
    at, beyond = stations[worst[last]], depth[worst[last]]
    reference = problem.corridor.reference
    offset = np.sum((problem.spline.pieces(x)(at)[0] - reference.position(at)) * reference.normal(at), axis=1)
    right, left = problem.corridor.offsets(at)
    spare = np.maximum(np.minimum(left - offset, offset - right), 0.0)
    return problem.with_rows(at, spare + beyond + _REPAIR_MORE)


def _apart(stations: Floats, distance: float) -> Floats:
    """Those of the increasing stations that lie `distance` after the last one that was taken, and each first one."""
    taken = []
    for s in stations:
        if not taken or s - taken[-1] >= distance:
            taken.append(float(s))
    return np.array(taken)


def _path(found: _Found, iterations: int, centre: PlanarCurve, options: PathOptions, started: float) -> Path:
    problem, solution, certificate = found.problem, found.solution, found.certificate
    curve = problem.curve(solution.x)
    report = PathReport(
        status="approximate" if options.method in APPROXIMATE else "solved" if solution.converged else "stalled",
        certified=certificate.certified,
        cost_centre=centre.squared_curvature(),
        cost=curve.squared_curvature(),
        iterations=iterations,
        optimality=solution.optimality,
        kkt_residual=solution.kkt_residual,
        max_violation_m=certificate.beyond,
        max_curvature=certificate.curvature if np.isfinite(options.curvature_max) else float(np.max(np.abs(curve.curvature(curve.breaks_s)))),
        solve_ms=1e3 * (time.perf_counter() - started),
        knots=len(problem.q),
        method=options.method,
        qp=solution.solver,
    )
    return Path(curve, curve.breaks_s, problem.spline.breaks, report)


def _follow_lane(road: Road, corridor: Corridor, lane: PlanarCurve, started: float) -> Path:
    knots = np.append(road.knots, road.length) if road.closed else road.knots
    certificate = Prover(corridor).prove(_by_station(lane, knots))
    worst = certificate.beyond
    if not certificate.inside and worst > 1e-3:
        at = float(certificate.where[np.argmax(certificate.depth)])
        lane_here = road.driving_lane()
        width = float(np.interp(at, road.s, lane_here.left - lane_here.right))
        raise InfeasibleError(
            f"{road.name}: the lane's centre leaves the corridor by {worst:.3f} m at s = {at:.1f} m: the lane is {width:.2f} m wide there, "
            f"the car with its margins {2.0 * corridor.margin:.2f} m"
        )
    cost = lane.squared_curvature()
    report = PathReport(
        status="lane centre",
        certified=certificate.inside,
        cost_centre=cost,
        cost=cost,
        iterations=0,
        optimality=0.0,
        kkt_residual=np.nan,
        max_violation_m=worst,
        max_curvature=float(np.max(np.abs(lane.curvature(lane.breaks_s)))),
        solve_ms=1e3 * (time.perf_counter() - started),
        knots=len(knots),
        method="none",
        qp="none",
    )
    return Path(lane, lane.breaks_s, knots, report)


def _by_station(curve: PlanarCurve, knots: Floats) -> PiecewiseCubic:
    """The same curve with road stations as its parameter, linear between its breaks."""
    ratio = np.diff(curve.pieces.breaks) / np.diff(knots)
    powers = np.stack([ratio**3, ratio**2, ratio, np.ones_like(ratio)])
    return PiecewiseCubic(knots, curve.pieces.coefficients * powers[:, None, :])
