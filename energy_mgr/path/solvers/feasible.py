"""The point nearest to a guess that keeps the linear constraints: where methods begin that never leave them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from ...errors import SolverError
from .backends import Qp, qp_solver
from .contradiction import refuse_contradiction

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..problem.problem import CurvatureProblem

    Floats = NDArray[np.float64]


def nearest_feasible(problem: CurvatureProblem, x: Floats) -> Floats:
    """The feasible point (3n,) nearest to `x`, bounds and rows kept by a micrometre more than asked.

    Raises:
        InfeasibleError: the borders contradict each other; the station is named.
        SolverError: the QP solver failed.
    """
    matrix, rhs = problem.equalities
    rows, (lower, upper) = problem.rows, problem.bounds
    spare = 1e-6
    identity = sp.csc_matrix(sp.identity(len(x), format="csc"))
    program = Qp(identity, -x, matrix, rhs, rows.matrix, rows.lower + spare, rows.upper - spare, lower + spare, upper - spare)
    found = qp_solver("clarabel").solve(program, 1e-10)
    if found is None:
        refuse_contradiction(problem)
        raise SolverError(f"{problem.corridor.name}: no point inside the corridor was found to start from")
    return found.x
