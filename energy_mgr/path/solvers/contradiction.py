"""Whether the borders contradict each other, and where."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from ...errors import InfeasibleError
from ..problem.spline import PER_KNOT
from .backends import Qp, qp_solver

if TYPE_CHECKING:
    from ..problem.problem import CurvatureProblem

_NOTHING = sp.csc_matrix((0, 0))


def constraints(problem: CurvatureProblem) -> Qp:
    """The QP without its objective."""
    matrix, rhs = problem.equalities
    rows = problem.rows
    return Qp(_NOTHING, np.zeros(0), matrix, rhs, rows.matrix, rows.lower, rows.upper, *problem.bounds)


def refuse_contradiction(problem: CurvatureProblem) -> None:
    """Raise InfeasibleError if the constraints contradict each other: let each border give way and see which must, by how much."""
    k = constraints(problem)
    n, m = k.G.shape[1], k.G.shape[0]
    knots = np.flatnonzero(np.isfinite(k.x_lower))
    every = sp.csc_matrix(sp.vstack([k.G, sp.identity(n, format="csr")[knots]]))
    count = m + len(knots)
    slack, infinite, zero = sp.identity(count, format="csc"), np.full(count, np.inf), np.zeros(n)
    relaxed = Qp(
        sp.csc_matrix(sp.diags_array(np.concatenate([np.full(n, 1e-8), np.ones(count)]))),
        np.zeros(n + count),
        sp.csc_matrix(sp.hstack([k.A, sp.csc_matrix((k.A.shape[0], count))])),
        k.b,
        sp.csc_matrix(sp.vstack([sp.hstack([every, slack]), sp.hstack([every, -slack])])),
        np.concatenate([k.lower, k.x_lower[knots], -infinite]),
        np.concatenate([infinite, k.upper, k.x_upper[knots]]),
        np.concatenate([zero - np.inf, np.zeros(count)]),
        np.concatenate([zero + np.inf, infinite]),
    )
    found = qp_solver("clarabel").solve(relaxed, 1e-8)
    if found is None:
        return
    gaps, stations = found.x[n:], np.concatenate([problem.row_q, problem.q[knots // PER_KNOT]])
    at = int(np.argmax(gaps))
    if gaps[at] > 1e-4:
        raise InfeasibleError(
            f"{problem.corridor.name}: no smooth path keeps inside the corridor near s = {stations[at]:.1f} m: "
            f"the borders there would have to give way by {gaps[at]:.2f} m"
        )
