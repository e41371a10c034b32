"""A window planned on from a knot of the path in force; or, where there is none, of the lane."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...errors import SolverError
from ..problem.spline import PER_KNOT
from ..solvers import gauss_newton
from .plan import Plan, Planned
from .stitching import joined
from .terms import ROUNDS, SHORTEST, TOLERANCE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..problem.ends import End
    from ..problem.problem import CurvatureProblem
    from .terms import Clock, Terms
    from .window import Tables

    Floats = NDArray[np.float64]

#: A plan is kept this far behind the car, m.
_TAIL = 20.0
#: QPs per solve where the window has moved by at most so many knots, and otherwise.
_FEW, _MANY, _NEAR = 1, 8, 2
#: With less than this share of the budget left no further solve is started.
_LAST_SHARE = 0.3


def onward(terms: Terms, plan: Plan | None, s: float, first: int, end: End, horizon: float, clock: Clock) -> Planned:
    """Solve and prove from the knot `first`, where `end` holds, as far as `horizon` m reach.

    Raises:
        SolverError: nothing was proven, or the road ends too soon.
    """
    strip, name = terms.strip, terms.road.name
    last = strip.last_knot(first, horizon, SHORTEST)
    if last - first < SHORTEST or not strip.exists(last):
        raise SolverError(f"{name}: the road ends within the window, nothing is left to plan")
    guess = x = _guess(plan, strip.tables, first, last)
    # after a small advance one QP is enough: what it leaves, the next step takes up (real-time iteration)
    warm = plan is not None and plan.is_whole and first - plan.first_knot <= _NEAR
    count, iterations, fault = _FEW if warm else _MANY, 0, ""
    for _ in range(ROUNDS):
        # without a path in force there is nothing to fall back on, and time does not count
        left = np.inf if plan is None else clock.left_ms
        if iterations and left < _LAST_SHARE * clock.budget_ms:
            break
        problem = strip.window(first, last, end)
        if plan is not None and plan.is_whole:
            _allow(problem, plan, first, guess)
        solution = gauss_newton.solve(problem, x, qp=terms.qp, tolerance=TOLERANCE, iterations=count, seconds=1e-3 * left, residual=False)
        x, iterations = solution.x, iterations + solution.iterations
        pieces = joined(None if plan is None else plan.pieces, problem.spline.pieces(x), s - _TAIL)
        start, stop = max(s, float(pieces.breaks[0])), float(pieces.breaks[-1])
        certificate = strip.prover(start, stop).prove(pieces, terms.curvature_max, start=start, end=stop)
        if certificate.certified:
            return Planned(Plan(pieces, start, stop, strip.version, first, x, solution.converged), iterations, solution.cost)
        fault = certificate.fault
        strip.learn(problem, x, first, certificate)
    raise SolverError(f"{name}: {fault}")


def _guess(plan: Plan | None, tables: Tables, first: int, last: int) -> Floats:
    """Variables to start from: those of the path in force where it reaches, the lane's beyond."""
    x = tables.guess[np.arange(first, last + 1) % tables.count].copy()
    if plan is not None:
        low, high = max(first, plan.first_knot), min(last, plan.last_knot)
        if low <= high:
            old = plan.x.reshape(-1, PER_KNOT)
            x[low - first : high - first + 1] = old[low - plan.first_knot : high - plan.first_knot + 1]
    return x.ravel()


def _allow(window: CurvatureProblem, plan: Plan, first: int, x: Floats) -> None:
    """Widen the borders to what the path in force does: it is proven, and rows drawn in since then must not shut it out."""
    count = plan.last_knot + 1 - first  # knots of the window that the path in force has
    if count < 2 or first < plan.first_knot:
        return
    right, left = (border.copy() for border in window.borders)
    e = x[2::PER_KNOT][:count]
    right[:count], left[:count] = np.minimum(right[:count], e), np.maximum(left[:count], e)
    rows = window.rows
    covered = window.offset_table[0] < count - 1
    value = rows.matrix @ x
    lower = np.where(covered, np.minimum(rows.lower, value), rows.lower)
    upper = np.where(covered, np.maximum(rows.upper, value), rows.upper)
    vars(window).update(borders=(right, left), rows=rows._replace(lower=lower, upper=upper))
