"""From a road and a clearance to a checked path."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from ..errors import InfeasibleError, SolverError
from . import gauss_newton
from .problem import CurvatureProblem
from .result import Path, PathReport

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from roads import Corridor, PlanarCurve, Road
    from roads.road import Extent

    from .qp import QpName

    Floats = NDArray[np.float64]

PathKind = Literal["optimal", "lane"]

#: Spacing of the re-evaluation of the borders, m.
CHECK_SPACING = 0.1
#: A path may leave the corridor by this much, m.
VIOLATION_TOLERANCE = 1e-3
#: A corridor must leave the path at least this width, m.
LEAST_WIDTH = 1e-3
#: Control points are added where it does by more than this, m.
_REPAIR_ABOVE = 3e-4
_REPAIR_ROUNDS = 8
#: Steps that promise less than this fraction of the cost end the first solve, after which control points are added, and the later ones.
_ROUGH, _FINE = 1e-4, 1e-6


def plan_path(
    road: Road,
    clearance: float,
    *,
    extent: Extent = "own",
    kind: PathKind = "optimal",
    spacing: float = 4.0,
    control_points: int = 3,
    qp: QpName = "piqp",
    report: Callable[[str], None] | None = None,
) -> Path:
    """The path of least integral of squared curvature inside the corridor, or the centre of the driving lane.

    Args:
        road: where to drive.
        clearance: distance that the path keeps from the borders, m: half the car's width plus a margin.
        extent: part of the cross-section that may be used, `lane`, `own` (all lanes that lead this way) or `road`.
        kind: `optimal` or `lane` (the lane's centre, which is checked against the corridor but not optimised).
        spacing: distance of the knots, m.
        control_points: points between two knots at which the borders are kept from the start; more are added where needed.
        qp: solver of the QPs.
        report: called with lines of progress.

    Raises:
        InfeasibleError: the road is too narrow, or no smooth path keeps the borders; the station is named.
        SolverError: no path that passes the check was found.
    """
    started = time.perf_counter()
    corridor = road.corridor(extent, clearance)
    _refuse_narrow(corridor)
    lane = road.lane_centre()
    centre_cost = lane.squared_curvature()
    if kind == "lane":
        return _follow_lane(road, corridor, lane, centre_cost, started)
    problem = CurvatureProblem.on(corridor, lane, spacing=spacing, control_points=control_points)
    found = _search(problem, qp, report)
    worst = float(np.max(found.beyond))
    if worst > VIOLATION_TOLERANCE:
        at = float(found.stations[np.argmax(found.beyond)])
        raise SolverError(f"{road.name}: the path found leaves the corridor by {worst:.4f} m at s = {at:.1f} m, allowed {VIOLATION_TOLERANCE} m")
    made = PathReport(
        status="solved" if found.solution.converged else "stalled",
        cost_centre=centre_cost,
        cost=found.curve.squared_curvature(),
        iterations=found.iterations,
        optimality=found.solution.optimality,
        max_violation_m=worst,
        solve_ms=1e3 * (time.perf_counter() - started),
        knots=len(problem.q),
        qp=found.solution.solver,
    )
    return Path(found.curve, found.curve.breaks_s, problem.breaks, made)


class _Found(NamedTuple):
    """A solved problem with its re-evaluation: road stations every 0.1 m and how far the path is outside there."""

    solution: gauss_newton.Solution
    iterations: int
    curve: PlanarCurve
    stations: Floats
    beyond: Floats


def _search(problem: CurvatureProblem, qp: QpName, report: Callable[[str], None] | None) -> _Found:
    """Solve roughly, check the borders every 0.1 m, and solve to the end, with control points added wherever the path got out."""
    x, iterations, tolerance, rounds = problem.initial(), 0, _ROUGH, 0
    while True:
        solution = gauss_newton.solve(problem, x, qp=qp, tolerance=tolerance, report=report)
        x, iterations, rounds = solution.x, iterations + solution.iterations, rounds + 1
        curve = problem.curve(x)
        stations, beyond = _violations(problem.corridor, curve)
        inside = bool(np.max(beyond) <= _REPAIR_ABOVE)
        if (inside and tolerance == _FINE) or rounds > _REPAIR_ROUNDS:
            return _Found(solution, iterations, curve, stations, beyond)
        if not inside:
            problem = _with_repairs(problem, stations, beyond)
        tolerance = _FINE


def _refuse_narrow(corridor: Corridor) -> None:
    s, width = corridor.narrowest()
    if width < LEAST_WIDTH:
        right, left = corridor.borders(s)
        oblique = " (the borders are oblique there)" if float(left - right) > 2 * corridor.margin else ""
        raise InfeasibleError(
            f"{corridor.name}: the corridor is narrower than the car with its margins at s = {s:.1f} m: "
            f"{float(left - right):.2f} m wide, needs {2 * corridor.margin + LEAST_WIDTH - min(width, 0.0) * bool(oblique):.2f} m{oblique}"
        )


def _follow_lane(road: Road, corridor: Corridor, lane: PlanarCurve, cost: float, started: float) -> Path:
    knots = np.append(road.knots, road.length) if road.closed else road.knots
    stations, beyond = _violations(corridor, lane, knots)
    worst = float(np.max(beyond))
    if worst > VIOLATION_TOLERANCE:
        at = float(stations[np.argmax(beyond)])
        lane_here = road.driving_lane()
        width = float(np.interp(at, road.s, lane_here.left - lane_here.right))
        raise InfeasibleError(
            f"{road.name}: the lane's centre leaves the corridor by {worst:.3f} m at s = {at:.1f} m: the lane is {width:.2f} m wide there, "
            f"the car with its margins {2.0 * corridor.margin:.2f} m"
        )
    milliseconds = 1e3 * (time.perf_counter() - started)
    return Path(lane, lane.breaks_s, knots, PathReport("lane centre", cost, cost, 0, 0.0, worst, milliseconds, len(knots), "none"))


def _violations(corridor: Corridor, curve: PlanarCurve, breaks_station: Floats | None = None) -> tuple[Floats, Floats]:
    """Road stations every 0.1 m along `curve` and how far it lies outside the corridor there, m.

    `breaks_station` gives the road station at the breaks of the curve where its parameter is not the road station itself.
    """
    breaks = curve.pieces.breaks
    parts = np.ceil(np.diff(curve.breaks_s) / CHECK_SPACING).astype(int)
    segment = np.repeat(np.arange(len(parts)), parts)
    part = np.arange(len(segment)) - np.repeat(np.cumsum(parts) - parts, parts)
    u = breaks[segment] + np.diff(breaks)[segment] * part / parts[segment]
    near = u if breaks_station is None else np.interp(u, breaks, breaks_station)
    return near, corridor.violation(curve.pieces(u)[0], near)


def _with_repairs(problem: CurvatureProblem, stations: Floats, beyond: Floats) -> CurvatureProblem:
    """Add a control point at each local worst place, drawn in a little further than the spot is out of line with its nearest row."""
    padded = np.concatenate([[-np.inf], beyond, [-np.inf]])
    peak = (beyond > _REPAIR_ABOVE) & (beyond >= padded[:-2]) & (beyond > padded[2:])
    at, order = stations[peak], np.argsort(problem.row_q)
    rows = problem.row_q[order]
    after = np.clip(np.searchsorted(rows, at), 1, len(rows) - 1)
    nearest = order[np.where(np.abs(rows[after] - at) < np.abs(at - rows[after - 1]), after, after - 1)]
    # a row that is there already and still let the path out sits where the strip is not exact: draw the border in further than that row did
    there = np.abs(problem.row_q[nearest] - at) < 2.0 * CHECK_SPACING
    return problem.with_rows(at, np.where(there, problem.row_tighter[nearest] + beyond[peak], 0.0) + 0.5 * _REPAIR_ABOVE)
