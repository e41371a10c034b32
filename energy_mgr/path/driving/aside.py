"""A window planned from where the car is, beside the path in force; takes a few times as long as one from a knot of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...errors import PlanningError, SolverError
from ..planner import with_repairs
from ..problem.ends import End
from ..problem.problem import CurvatureProblem
from ..problem.spline import PER_KNOT
from ..solvers import gauss_newton
from .plan import Plan, Planned
from .terms import CONTROL_POINTS, ROUNDS, SHORTEST, TIGHTER, TOLERANCE

if TYPE_CHECKING:
    from .step import PathState
    from .terms import Terms

#: The first knot is reached after this way at least, m.
_FIRST_WAY = 2.0
#: A car turned further against the road is planned for no more, rad.
_ACROSS = 1.0


def from_place(terms: Terms, s: float, state: PathState, horizon: float) -> Planned:
    """Solve and prove from where the car is at station `s`, with its curvature if that can be had.

    Raises:
        SolverError: the car is off the road or across it, nothing was proven, or the road ends too soon.
    """
    end = _end_at(terms, s, state)
    if abs(state.kappa) < terms.curvature_max:
        try:
            return _solved(terms, s, End(end.offset, end.heading, state.kappa), horizon)
        except PlanningError:
            pass  # a jump of curvature is better than no path
    return _solved(terms, s, end, horizon)


def _end_at(terms: Terms, s: float, state: PathState) -> End:
    """Place and heading of the car against the road."""
    corridor = terms.strip.corridor
    reference = corridor.reference
    place, normal = reference.position(np.array([s]))[0], reference.normal(np.array([s]))[0]
    offset = float((np.array([state.x, state.y]) - place) @ normal)
    turn = state.psi - float(reference.heading(np.array([s]))[0])
    heading = float(np.arctan2(np.sin(turn), np.cos(turn)))
    right, left = (float(border) for border in corridor.offsets(s))
    if not right <= offset <= left or abs(heading) > _ACROSS:
        raise SolverError(
            f"{terms.road.name}: the car is at {offset:.2f} m beside the reference and turned by {heading:.2f} rad at s = {s:.1f} m, "
            f"expected {right:.2f} to {left:.2f} m and less than {_ACROSS:g} rad"
        )
    return End(offset, heading)


def _solved(terms: Terms, s: float, end: End, horizon: float) -> Planned:
    strip, name = terms.strip, terms.road.name
    first = strip.knot_at(s + _FIRST_WAY) + 1
    if not strip.exists(first + SHORTEST - 1):
        raise SolverError(f"{name}: the road ends within the window, nothing can be planned from a place beside the path")
    last = strip.last_knot(first, horizon, SHORTEST - 1)
    problem = CurvatureProblem.on(
        strip.corridor,
        terms.road.lane_centre(),
        knots=np.concatenate([[s], strip.tables.station(np.arange(first, last + 1))]),
        control_points=CONTROL_POINTS,
        weights=strip.tables.problem.objective.weights,
        ends=(end, strip.far_end(last)),
        curvature_max=terms.curvature_max,
        tighter=TIGHTER,
        window=True,
    )
    x, iterations, fault = problem.initial(), 0, ""
    for _ in range(ROUNDS):
        solution = gauss_newton.solve(problem, x, tolerance=TOLERANCE)
        x, iterations = solution.x, iterations + solution.iterations
        pieces = problem.spline.pieces(x)
        stop = float(pieces.breaks[-1])
        certificate = strip.prover(s, stop).prove(pieces, terms.curvature_max)
        if certificate.certified:
            return Planned(Plan(pieces, s, stop, strip.version, first, x[PER_KNOT:], solution.converged), iterations, solution.cost)
        fault = certificate.fault
        problem = with_repairs(problem, x, certificate)
    raise SolverError(f"{name}: {fault}")
