"""The sparse QP inside the path solver, behind one signature.

minimise 1/2 x'Px + c'x   subject to   A x = b,  lower <= G x <= upper,  x_lower <= x <= x_upper
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple, Protocol

import clarabel
import numpy as np
import piqp
import scipy.sparse as sp

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

QpName = Literal["piqp", "clarabel"]

#: Costs come scaled to this size. Bending a path over a kilometre changes its cost by so little that at order one the solvers' dual residuals
#: drown in rounding; at this scale PIQP solves every road tried with every one of its factorisations.
QP_SCALE = 1e4


class Constraints(NamedTuple):
    """The constraints of the QP; matrices in CSC."""

    A: sp.csc_matrix
    b: Floats
    G: sp.csc_matrix
    lower: Floats
    upper: Floats
    x_lower: Floats
    x_upper: Floats


class QpSolver(Protocol):
    """A QP solver that keeps its constraints and the sparsity of P from call to call."""

    def solve(self, P: sp.csc_matrix, c: Floats, tolerance: float) -> Floats | None:
        """The minimiser, to `tolerance` times QP_SCALE in dual residuals and duality gap; None where the solver found none."""
        ...


class Piqp:
    """PIQP, a proximal interior-point method; the factorisation's pattern is kept between calls."""

    def __init__(self, constraints: Constraints) -> None:
        self._constraints = constraints
        self._solver: piqp.SparseSolver | None = None

    def solve(self, P: sp.csc_matrix, c: Floats, tolerance: float) -> Floats | None:
        """See QpSolver."""
        k = self._constraints
        if self._solver is None:
            self._solver = piqp.SparseSolver()
            self._solver.settings.max_iter = 100
            self._solver.settings.rho_init, self._solver.settings.delta_init = 1e-8, 1e-6
            self._solver.settings.kkt_solver = piqp.KKTSolver.sparse_ldlt_cond
            self._solver.setup(P, c, k.A, k.b, k.G, k.lower, k.upper, k.x_lower, k.x_upper)
        else:
            self._solver.update(P=P, c=c)
        self._solver.settings.eps_abs = self._solver.settings.eps_duality_gap_abs = tolerance * QP_SCALE
        status = self._solver.solve()
        return np.array(self._solver.result.x) if status == piqp.PIQP_SOLVED else None


class Clarabel:
    """Clarabel, a homogeneous interior-point method; set up anew at each call."""

    def __init__(self, constraints: Constraints) -> None:
        k = constraints
        low, high = np.flatnonzero(np.isfinite(k.x_lower)), np.flatnonzero(np.isfinite(k.x_upper))
        unit = sp.identity(len(k.x_lower), format="csr")
        below, above = np.flatnonzero(np.isfinite(k.upper)), np.flatnonzero(np.isfinite(k.lower))
        rows = sp.csr_matrix(k.G)
        self._matrix = sp.csc_matrix(sp.vstack([k.A, rows[below], -rows[above], unit[high], -unit[low]]))
        self._rhs = np.concatenate([k.b, k.upper[below], -k.lower[above], k.x_upper[high], -k.x_lower[low]])
        self._cones = [clarabel.ZeroConeT(len(k.b)), clarabel.NonnegativeConeT(len(self._rhs) - len(k.b))]

    def solve(self, P: sp.csc_matrix, c: Floats, tolerance: float) -> Floats | None:
        """See QpSolver."""
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = min(tolerance, 1e-7)
        solution = clarabel.DefaultSolver(sp.csc_matrix(sp.triu(P)), c, self._matrix, self._rhs, self._cones, settings).solve()
        return np.array(solution.x) if solution.status == clarabel.SolverStatus.Solved else None


QP_SOLVERS: dict[QpName, type[Piqp] | type[Clarabel]] = {"piqp": Piqp, "clarabel": Clarabel}
