"""One QP for the thin-beam linearisation of curvature (3.2): what the source's baseline minimises, in the reduced variables of P1.

The integral of the squared second derivative by the spline parameter is a quadratic, hence one convex QP; it is the integral of squared curvature
only where the parameter runs at an even speed. Quick, and up to tens of per cent above the optimum where the road turns sharply.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...errors import PlanningError, SolverError
from ..problem.objective import thin_beam
from .backends import QP_SCALE, Qp, qp_solver
from .contradiction import refuse_contradiction
from .solution import Solution

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from ..problem.problem import CurvatureProblem

    Floats = NDArray[np.float64]


def solve(
    problem: CurvatureProblem,
    x: Floats,
    *,
    qp: str = "piqp",
    tolerance: float = 1e-9,
    report: Callable[[str], None] | None = None,
) -> Solution:
    """The minimiser of (3.2); `x` is not used but to scale the cost. The cost returned is the true one.

    Raises:
        InfeasibleError: the borders contradict each other.
        SolverError: the QP solver failed.
        PlanningError: the problem bounds the curvature, which this method cannot.
    """
    if len(problem.bend_q):
        raise PlanningError("the linearised method keeps no bound on curvature, use gauss-newton, slsqp, trust-constr or ipopt")
    matrix, rhs = problem.equalities
    rows = problem.rows
    hessian = thin_beam(problem.spline)
    scale = QP_SCALE / max(0.5 * float(x @ (hessian @ x)), 1e-12)
    program = Qp(hessian * scale, np.zeros(len(x)), matrix, rhs, rows.matrix, rows.lower, rows.upper, *problem.bounds)
    found = qp_solver(qp).solve(program, min(tolerance, 1e-8))
    if found is None:
        refuse_contradiction(problem)
        raise SolverError(f"{problem.corridor.name}: {qp} failed on the linearised problem")
    cost = problem.cost(found.x)
    if report:
        report(f"path: linearised curvature, one QP, true cost {cost:.6f}")
    return Solution(found.x, cost, 1, np.nan, program.residual(found), True, qp)
