"""Sequential quadratic programming with the Gauss-Newton Hessian, for problems with linear constraints.

Every iterate after the first full step keeps the constraints, so the merit function is the cost itself. Converges linearly at a rate given by the
curvature that is left at the optimum; on roads that is fast (5 to 15 iterations).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from ..errors import InfeasibleError, SolverError
from .qp import QP_SCALE, QP_SOLVERS, Constraints, QpName, QpSolver

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from .problem import CurvatureProblem

    Floats = NDArray[np.float64]

#: A control point may be missed by this much by the QP solver, m; the path is checked again on a fine grid afterwards.
ROW_TOLERANCE = 1e-5
#: Accuracy of the first and of the last QPs, relative to the cost.
_ROUGHEST_QP, _FINEST_QP = 1e-5, 1e-8


@dataclass(frozen=True, eq=False)
class Solution:
    """Where an iteration ended.

    Attributes:
        x: the point.
        cost: the cost there.
        iterations: QPs solved.
        optimality: decrease of the cost that is left, relative to the cost: what the last QP promised, or, where the QPs before shrank fast, the
            rest of their series.
        converged: the promise fell below the tolerance.
        solver: what solved the last QP; not the back end asked for if that one failed.
    """

    x: Floats
    cost: float
    iterations: int
    optimality: float
    converged: bool
    solver: str


def solve(
    problem: CurvatureProblem,
    x: Floats,
    *,
    qp: QpName = "piqp",
    tolerance: float = 1e-6,
    iterations: int = 60,
    report: Callable[[str], None] | None = None,
) -> Solution:
    """Minimise the cost of `problem` from the point `x`.

    Args:
        problem: what to minimise.
        x: (3n,) where to start; it need not keep the constraints.
        qp: the back end for the QPs.
        tolerance: stop when less than this fraction of the cost is left to gain.
        iterations: at most so many QPs.
        report: called with a line of progress per iteration.

    Raises:
        InfeasibleError: no path keeps the borders; the station of the worst conflict is named.
        SolverError: the QP back end failed on a feasible problem.
    """
    backend = QP_SOLVERS[qp](_constraints(problem))
    inside, optimality, last, accuracy = _inside(problem, x), np.inf, np.inf, _ROUGHEST_QP
    for count in range(1, iterations + 1):
        cost, gradient, hessian = problem.gauss_newton(x)
        scale = 1.0 / max(cost, 1e-12)
        model = hessian * (QP_SCALE * scale), (gradient - hessian @ x) * (QP_SCALE * scale)
        target = _checked(problem, backend.solve(*model, accuracy))
        if target is None:
            accuracy = _FINEST_QP
            target, qp, backend = _second_try(problem, model, qp, count)
        step = target - x
        promise = -float(gradient @ step) - 0.5 * float(step @ (hessian @ step))
        optimality = _left_over(abs(promise) * scale, last)
        last = abs(promise) * scale
        length = _line_search(problem, x, step, cost, float(gradient @ step), promise) if inside else 1.0
        reached = optimality < tolerance and accuracy <= 0.2 * tolerance
        if inside and (length == 0.0 or reached):
            x = x + length * step
            return Solution(x, problem.cost(x), count, optimality, reached or optimality < 100 * tolerance, qp)
        x, inside = x + length * step, True
        # as in inexact Newton methods: no QP needs solving much closer than the next step is worth
        accuracy = float(np.clip(3e-6 * last, _FINEST_QP, _ROUGHEST_QP))
        if report:
            report(f"path: iteration {count}, integral of squared curvature {problem.cost(x):.6f} 1/m")
    return Solution(x, problem.cost(x), iterations, optimality, False, qp)


def _left_over(promise: float, last: float) -> float:
    """The decrease that is left after a step that promises `promise` of the cost and follows one that promised `last`.

    Gauss-Newton steps shrink at a steady rate. Where the rate is good, what is left after this step is the rest of a geometric series.
    """
    rate = promise / last
    return promise * rate / (1.0 - rate) if rate < 0.1 else promise


def _second_try(problem: CurvatureProblem, model: tuple[sp.csc_matrix, Floats], qp: QpName, count: int) -> tuple[Floats, QpName, QpSolver]:
    """The minimiser by the other back end, which takes over; at the first QP find out first whether the borders contradict each other."""
    if count == 1:
        _explain(problem)
    other: QpName = "clarabel" if qp == "piqp" else "piqp"
    backend = QP_SOLVERS[other](_constraints(problem))
    target = _checked(problem, backend.solve(*model, _FINEST_QP))
    if target is None:
        raise SolverError(f"{problem.corridor.name}: both QP solvers failed in iteration {count} of the path")
    return target, other, backend


def _line_search(problem: CurvatureProblem, x: Floats, step: Floats, cost: float, slope: float, promise: float) -> float:
    """A step length that lowers the cost by a fair share of the promise; 0 if none does.

    Where the Gauss-Newton model overrates the curvature of the cost, full steps are too short and convergence is slow; then go on along the step, as
    far as a parabola through what is known suggests and the borders allow.
    """
    length = 1.0
    while length > 1e-4:
        found = problem.cost(x + length * step)
        if found <= cost - 1e-4 * length * promise:
            break
        length *= 0.5
    else:
        return 0.0
    if length < 1.0:
        return length
    bend = found - cost - slope
    longer = min(-slope / (2.0 * bend), 10.0) if slope < 0.0 < bend else 1.0
    if longer < 1.2:
        return 1.0
    longer = min(longer, problem.room(x, step))
    return longer if longer > 1.0 and problem.cost(x + longer * step) < found else 1.0


def _checked(problem: CurvatureProblem, x: Floats | None) -> Floats | None:
    """`x` if there is one and it keeps the control points; "solved" is not taken on trust."""
    return x if x is not None and problem.worst_row(x)[0] <= ROW_TOLERANCE else None


def _inside(problem: CurvatureProblem, x: Floats) -> bool:
    lower, upper = problem.bounds
    return problem.worst_row(x)[0] <= ROW_TOLERANCE and bool(np.all(x >= lower - 1e-9) and np.all(x <= upper + 1e-9))


def _constraints(problem: CurvatureProblem) -> Constraints:
    return Constraints(*problem.equalities, *problem.rows, *problem.bounds)


def _explain(problem: CurvatureProblem) -> None:
    """Raise InfeasibleError if the constraints contradict each other: let each control point give way and see which must, by how much."""
    k = _constraints(problem)
    n, m = k.G.shape[1], k.G.shape[0]
    slack, open_end = sp.identity(m, format="csc"), np.full(m, np.inf)
    relaxed = Constraints(
        sp.csc_matrix(sp.hstack([k.A, sp.csc_matrix((k.A.shape[0], m))])),
        k.b,
        sp.csc_matrix(sp.vstack([sp.hstack([k.G, slack]), sp.hstack([k.G, -slack])])),
        np.concatenate([k.lower, -open_end]),
        np.concatenate([open_end, k.upper]),
        np.concatenate([k.x_lower, np.zeros(m)]),
        np.concatenate([k.x_upper, open_end]),
    )
    weight = sp.diags(np.concatenate([np.full(n, 1e-8), np.ones(m)]), format="csc")
    found = QP_SOLVERS["clarabel"](relaxed).solve(sp.csc_matrix(weight), np.zeros(n + m), _FINEST_QP)
    if found is not None:
        gaps = found[n:]
        at = int(np.argmax(gaps))
        if gaps[at] > 1e-4:
            raise InfeasibleError(
                f"{problem.corridor.name}: no smooth path keeps inside the corridor near s = {problem.row_q[at]:.1f} m: "
                f"the borders there would have to give way by {gaps[at]:.2f} m"
            )
