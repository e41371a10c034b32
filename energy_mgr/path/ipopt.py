"""The path problem through CasADi and IPOPT with exact second derivatives: slower, and the reference that the others are measured against.

The cost is written here once more, from (3.11), as symbols; nothing of the analytic derivatives in `problem` is used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from ..errors import SolverError
from .gauss_newton import Solution

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .problem import CurvatureProblem

    Floats = NDArray[np.float64]


def build(problem: CurvatureProblem, *, tolerance: float = 1e-9) -> ca.Function:
    """The solver for `problem`; building it takes longer than running it."""
    variables = ca.SX.sym("x", 3 * len(problem.q))
    matrix = ca.vertcat(ca.DM(problem.equalities[0]), ca.DM(problem.rows[0]))
    options = {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes", "ipopt.tol": tolerance, "ipopt.max_iter": 500}
    return ca.nlpsol("path", "ipopt", {"x": variables, "f": _cost(problem, variables), "g": ca.mtimes(matrix, variables)}, options)


def solve(problem: CurvatureProblem, x: Floats, solver: ca.Function | None = None) -> Solution:
    """Minimise the cost of `problem` from the point `x`, with a solver that was built for it or a new one.

    Raises:
        SolverError: IPOPT did not converge.
    """
    solver = solver or build(problem)
    (_, rhs), (_, row_lower, row_upper) = problem.equalities, problem.rows
    lower, upper = problem.bounds
    found = solver(x0=x, lbx=lower, ubx=upper, lbg=np.concatenate([rhs, row_lower]), ubg=np.concatenate([rhs, row_upper]))
    stats: dict[str, Any] = solver.stats()
    if not stats["success"]:
        raise SolverError(f"{problem.corridor.name}: IPOPT ended with {stats['return_status']}")
    return Solution(np.array(found["x"]).ravel(), float(found["f"]), int(stats["iter_count"]), 0.0, True, "ipopt")


def _cost(problem: CurvatureProblem, x: Any) -> Any:
    """Integral of squared curvature over arc length, as a symbol."""
    nodes, weights = np.polynomial.legendre.leggauss(4)
    here, ahead = list(range(len(problem.h))), problem.ahead.tolist()
    alpha = x[2::3]
    h = ca.DM(problem.h)
    first, second, fraction = [], [], 0.5 * (1.0 + nodes)
    left, across = problem.borders
    for axis in range(2):
        b = x[axis::3] / problem.b_scale
        d = ca.DM(left[:, axis]) + ca.DM(across[:, axis]) * alpha
        b0, b1, d0, d1 = b[here], b[ahead], d[here], d[ahead]
        a, c = (b1 - b0) / (3 * h), (d1 - d0) / h - h * (b1 + 2 * b0) / 3
        first.append([3 * a * (f * h) ** 2 + 2 * b0 * (f * h) + c for f in fraction])
        second.append([6 * a * (f * h) + 2 * b0 for f in fraction])
    total = 0
    for g, weight in enumerate(weights):
        cross = first[0][g] * second[1][g] - first[1][g] * second[0][g]
        square = first[0][g] ** 2 + first[1][g] ** 2
        total += ca.sum1(0.5 * weight * h * cross**2 / square**2.5)
    return total
