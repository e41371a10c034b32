"""One call for all solvers of P1; each is imported when it is used."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, Literal, get_args

from ...errors import PlanningError

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

    from ..problem.problem import CurvatureProblem
    from .solution import Solution

    Floats = NDArray[np.float64]

#: `gauss-newton`: sequential QPs, the default. `linearised`: one QP for thin-beam curvature (3.2). `gradient`: the source's projected gradient.
#: `slsqp`, `trust-constr`: SciPy's, dense. `ipopt`: exact Hessian, the reference.
Method = Literal["gauss-newton", "linearised", "gradient", "slsqp", "trust-constr", "ipopt"]
METHODS: tuple[Method, ...] = get_args(Method)
_MODULES = {
    "gauss-newton": "gauss_newton",
    "linearised": "linearised",
    "gradient": "gradient",
    "slsqp": "scipy_dense",
    "trust-constr": "scipy_dense",
    "ipopt": "ipopt",
}


def solve(
    problem: CurvatureProblem,
    x: Floats,
    method: Method = "gauss-newton",
    *,
    qp: str = "piqp",
    tolerance: float = 1e-6,
    report: Callable[[str], None] | None = None,
) -> Solution:
    """Minimise the cost of `problem` from the point `x`.

    Args:
        problem: what to minimise.
        x: (3n,) where to start.
        method: one of METHODS.
        qp: back end where QPs are solved.
        tolerance: relative decrease of the cost that ends the iteration.
        report: called with lines of progress.

    Raises:
        InfeasibleError: the constraints contradict each other; the station is named.
        SolverError: the method failed.
        PlanningError: no such method.
    """
    if method not in _MODULES:
        raise PlanningError(f"method {method!r}, expected one of {', '.join(METHODS)}")
    options: dict[str, Any] = {"tolerance": tolerance, "report": report}
    if method in ("gauss-newton", "linearised"):
        options["qp"] = qp
    if method in ("slsqp", "trust-constr"):
        options["method"] = method
    return import_module(f"..{_MODULES[method]}", __name__).solve(problem, x, **options)
