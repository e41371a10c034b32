"""The source's solver of P1, the projected nonlinear gradient (3.12) to (3.16), with its projection corrected.

The gradient is projected on the null space of the equalities, `-(g - Q1 Q1'g)` with the thin QR of A', once per problem (the source prints a
Moore-Penrose product that is no projection), then on that of the active inequalities which it would break, one by one (Gram-Schmidt). A
parabola along the direction gives the step, which is cut where the next inequality is met. Dense and slow; kept as the published baseline.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...errors import PlanningError
from ..problem.spline import PER_KNOT
from .feasible import nearest_feasible
from .solution import Solution

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from ..problem.problem import CurvatureProblem

    Floats = NDArray[np.float64]

#: Room, as a multiple of the size of its row, below which an inequality counts as active; iterations in a row that must gain little to end.
_ACTIVE, _PATIENCE = 1e-5, 3


class _Dense(NamedTuple):
    """The problem in the source's variables, dense: x = scale * y, C y <= d, null space of the equalities by its complement."""

    scale: Floats
    range_: Floats
    rows: Floats
    limits: Floats


def solve(
    problem: CurvatureProblem,
    x: Floats,
    *,
    tolerance: float = 1e-7,
    iterations: int = 2000,
    report: Callable[[str], None] | None = None,
) -> Solution:
    """Minimise from `x`, or from the nearest point that keeps the constraints.

    Args:
        problem: what to minimise; without a bound on curvature.
        x: (3n,) where to start.
        tolerance: relative decrease of the cost in an iteration; three that gain less end it.
        iterations: at most so many.
        report: called with a line of progress now and then.

    Raises:
        InfeasibleError, SolverError: there is no point to start from.
        PlanningError: the problem bounds the curvature.
    """
    if len(problem.bend_q):
        raise PlanningError("the gradient method keeps no bound on curvature, use gauss-newton, slsqp, trust-constr or ipopt")
    dense = _dense(problem)
    y = x / dense.scale
    if float(np.max(dense.rows @ y - dense.limits)) > 1e-6:
        y = nearest_feasible(problem, x) / dense.scale
    cost, count, last = problem.cost(dense.scale * y), 0, np.inf
    trial, patience = 1.0, 0
    while count < iterations:
        count += 1
        gradient = problem.model(dense.scale * y).gradient * dense.scale
        direction = _direction(dense, y, gradient)
        slope = float(gradient @ direction)
        if slope > -1e-16 * max(cost, 1e-12):
            last = 0.0
            break
        y, found, trial = _search(problem, dense, y, direction, cost, slope, trial)
        last, cost = (cost - found) / max(cost, 1e-300), found
        if report and count % 20 == 0:
            report(f"path: gradient iteration {count}, cost {cost:.6f}")
        patience = patience + 1 if last < tolerance else 0
        if patience == _PATIENCE:
            break
    return Solution(dense.scale * y, cost, count, last, np.nan, last < tolerance, "gradient")


def _dense(problem: CurvatureProblem) -> _Dense:
    spline, (right, left) = problem.spline, problem.borders
    # the source's variables: second derivatives for knots one apart, fractions between the borders
    mean = float(np.mean(spline.h))
    scale = np.column_stack([spline.b_scale / mean**2, spline.b_scale / mean**2, left - right]).ravel()
    rows, (lower, upper) = problem.rows, problem.bounds
    matrix, unit = rows.matrix.toarray() * scale, np.eye(spline.size) * scale
    above, below = np.isfinite(upper), np.isfinite(lower)
    stacked = np.vstack([matrix, -matrix, unit[above], -unit[below]])
    limits = np.concatenate([rows.upper, -rows.lower, upper[above], -lower[below]])
    norm = np.linalg.norm(stacked, axis=1)
    equalities = problem.equalities[0].toarray() * scale
    return _Dense(scale, np.linalg.qr(equalities.T)[0], stacked / norm[:, None], limits / norm)


def _direction(dense: _Dense, y: Floats, gradient: Floats) -> Floats:
    """Steepest descent that keeps the equalities and breaks no inequality that is active (3.16)."""
    direction = -(gradient - dense.range_ @ (dense.range_.T @ gradient))
    active = dense.rows[dense.limits - dense.rows @ y < _ACTIVE]
    base = np.zeros((0, len(y)))
    while len(active):
        outward = active @ direction
        worst = int(np.argmax(outward))
        if outward[worst] <= 1e-12 * np.linalg.norm(direction) or len(base) >= len(y) // PER_KNOT:
            break
        row = active[worst] - dense.range_ @ (dense.range_.T @ active[worst])
        for _ in range(2):  # twice is enough
            row = row - base.T @ (base @ row)
        size = np.linalg.norm(row)
        active = np.delete(active, worst, axis=0)
        if size < 1e-10:
            continue
        base = np.vstack([base, row / size])
        direction = direction - (base[-1] @ direction) * base[-1]
    return direction


def _search(
    problem: CurvatureProblem, dense: _Dense, y: Floats, direction: Floats, cost: float, slope: float, trial: float
) -> tuple[Floats, float, float]:
    """Quadratic line search up to the next inequality, with halving: the new point, its cost and the step to try first next time."""
    move = dense.rows @ direction
    room = dense.limits - dense.rows @ y
    towards = move > 1e-14
    most = float(np.min(np.maximum(room[towards], 0.0) / move[towards], initial=1e6))
    step = min(trial, most)
    value = problem.cost(dense.scale * (y + step * direction))
    bend = (value - cost - slope * step) / max(step, 1e-300) ** 2
    if bend > 0.0:
        step = min(-slope / (2.0 * bend), most)
        value = problem.cost(dense.scale * (y + step * direction))
    while value > cost + 1e-4 * step * slope and step > 1e-16:
        step *= 0.5
        value = problem.cost(dense.scale * (y + step * direction))
    if value >= cost:
        return y, cost, trial
    return y + step * direction, value, 2.0 * step if step < most else max(trial, step)
