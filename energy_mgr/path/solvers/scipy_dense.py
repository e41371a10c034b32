"""P1 by SciPy's general solvers, dense: stand-ins for the source's `fmincon` and its dense SQP.

`slsqp` solves a dense least-squares subproblem per iteration, cubic in the number of knots; `trust-constr` is an interior-point method with a BFGS
Hessian. For comparison, and for problems of some dozens of knots.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from scipy import optimize

from .solution import Solution

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from ..problem.problem import CurvatureProblem

    Floats = NDArray[np.float64]

#: Its stubs know neither dictionaries of constraints nor sparse Hessians.
minimize: Any = optimize.minimize


def solve(
    problem: CurvatureProblem,
    x: Floats,
    *,
    method: Literal["slsqp", "trust-constr"] = "slsqp",
    tolerance: float = 1e-9,
    iterations: int = 1000,
    report: Callable[[str], None] | None = None,
) -> Solution:
    """Minimise from `x`; `tolerance` is the change of the scaled cost (slsqp) or of gradient and point (trust-constr) that ends it."""
    scale = 1.0 / max(problem.cost(x), 1e-12)
    start = {"slsqp": _slsqp, "trust-constr": _trust_constr}[method]
    found: Any = start(problem, x, scale, tolerance, iterations)
    if report:
        report(f"path: {method}, {found.nit} iterations, cost {found.fun / scale:.6f}")
    done = bool(found.success) or (method == "trust-constr" and found.status in (1, 2))
    return Solution(np.asarray(found.x), problem.cost(found.x), int(found.nit), np.nan, np.nan, done, method)


def _slsqp(problem: CurvatureProblem, x: Floats, scale: float, tolerance: float, iterations: int) -> Any:
    matrix, rhs = problem.equalities
    rows = problem.rows
    held, kept = matrix.toarray(), rows.matrix.toarray()
    sides = np.vstack([kept, -kept])
    limits = np.concatenate([rows.lower, -rows.upper])
    constraints: list[dict[str, Any]] = [
        {"type": "eq", "fun": lambda y: held @ y - rhs, "jac": lambda _: held},
        {"type": "ineq", "fun": lambda y: sides @ y - limits, "jac": lambda _: sides},
    ]
    if len(problem.bend_q):
        constraints += [
            {"type": "ineq", "fun": lambda y: 1.0 - problem.curvatures(y)[0], "jac": lambda y: -_bend_jacobian(problem, y)},
            {"type": "ineq", "fun": lambda y: 1.0 + problem.curvatures(y)[0], "jac": lambda y: _bend_jacobian(problem, y)},
        ]
    return minimize(
        lambda y: scale * problem.cost(y),
        x,
        jac=lambda y: scale * problem.model(y).gradient,
        bounds=list(zip(*problem.bounds, strict=True)),
        constraints=constraints,
        method="SLSQP",
        options={"ftol": tolerance, "maxiter": iterations},
    )


def _trust_constr(problem: CurvatureProblem, x: Floats, scale: float, tolerance: float, iterations: int) -> Any:
    matrix, rhs = problem.equalities
    rows = problem.rows
    constraints: list[Any] = [optimize.LinearConstraint(matrix, rhs, rhs), optimize.LinearConstraint(rows.matrix, rows.lower, rows.upper)]
    if len(problem.bend_q):
        slopes = partial(_bend_jacobian, problem, dense=False)  # sparse, as the linear rows are
        constraints.append(optimize.NonlinearConstraint(lambda y: problem.curvatures(y)[0], -1.0, 1.0, jac=slopes))
    return minimize(
        lambda y: scale * problem.cost(y),
        x,
        jac=lambda y: scale * problem.model(y).gradient,
        hess=lambda y: scale * problem.model(y).hessian,
        bounds=list(zip(*problem.bounds, strict=True)),
        constraints=constraints,
        method="trust-constr",
        options={"gtol": tolerance, "xtol": tolerance, "maxiter": iterations},
    )


def _bend_jacobian(problem: CurvatureProblem, x: Floats, *, dense: bool = True) -> Any:
    rows = problem.bend_rows(problem.curvatures(x)[1])
    return rows.toarray() if dense else rows
