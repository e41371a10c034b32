"""The sparse QP inside the path solvers, behind one signature.

minimise 1/2 x'Px + c'x   subject to   A x = b,  lower <= G x <= upper,  x_lower <= x <= x_upper
"""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, NamedTuple, Protocol

import clarabel
import numpy as np
import piqp
import scipy.sparse as sp

from ...errors import PlanningError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

#: Costs come scaled to this size. Bending a path over a kilometre changes its cost by so little that at order one the solvers' dual residuals
#: drown in rounding; at this scale PIQP solves every road tried with every one of its factorisations.
QP_SCALE = 1e4


#: Residual below which an answer is taken although the solver itself was not content.
_GOOD_ENOUGH = 1e-4


class Qp(NamedTuple):
    """A convex QP; P whole and symmetric, matrices in CSC."""

    P: sp.csc_matrix
    c: Floats
    A: sp.csc_matrix
    b: Floats
    G: sp.csc_matrix
    lower: Floats
    upper: Floats
    x_lower: Floats
    x_upper: Floats

    def residual(self, found: QpSolution) -> float:
        """Largest of: broken constraints, gradient of the Lagrangian, multipliers of constraints that have room; costs in units of QP_SCALE."""
        x = found.x
        rows, slope = self.G @ x, self.P @ x + self.c
        beyond = max(_worst(rows - self.upper), _worst(self.lower - rows), _worst(x - self.x_upper), _worst(self.x_lower - x))
        lagrangian = slope + self.A.T @ found.equality + self.G.T @ found.rows + found.bounds
        idle = max(_idle(found.rows, rows, self.lower, self.upper), _idle(found.bounds, x, self.x_lower, self.x_upper))
        return max(beyond, _worst(np.abs(self.A @ x - self.b)), _worst(np.abs(lagrangian)) / QP_SCALE, idle / QP_SCALE)


class QpSolution(NamedTuple):
    """A minimiser and its multipliers: of the equalities, of the rows and of the bounds; positive where the upper limit holds, negative the lower."""

    x: Floats
    equality: Floats
    rows: Floats
    bounds: Floats


class QpSolver(Protocol):
    """A QP solver; it may keep what it worked out for a QP of the same sparsity."""

    def solve(self, qp: Qp, tolerance: float) -> QpSolution | None:
        """The minimiser, to `tolerance` times QP_SCALE in dual residuals and duality gap; None where the solver found none."""
        ...


class Piqp:
    """PIQP, a proximal interior-point method; the factorisation's pattern is kept between calls."""

    def __init__(self) -> None:
        self._solver: piqp.SparseSolver | None = None
        self._last: Qp | None = None

    def solve(self, qp: Qp, tolerance: float) -> QpSolution | None:
        """See QpSolver."""
        last = self._last
        if self._solver is None or last is None or not all(_alike(new, old) for new, old in ((qp.P, last.P), (qp.A, last.A), (qp.G, last.G))):
            self._solver = piqp.SparseSolver()
            self._solver.settings.max_iter = 100
            self._solver.settings.rho_init, self._solver.settings.delta_init = 1e-8, 1e-6
            self._solver.settings.kkt_solver = piqp.KKTSolver.sparse_ldlt_cond
            self._solver.setup(*qp)
        elif last.A is qp.A and last.G is qp.G and last.lower is qp.lower and last.upper is qp.upper and last.x_lower is qp.x_lower:
            self._solver.update(P=qp.P, c=qp.c)
        else:
            self._solver.update(*qp)
        self._last = qp
        self._solver.settings.eps_abs = self._solver.settings.eps_duality_gap_abs = tolerance * QP_SCALE
        status = self._solver.solve()
        r = self._solver.result
        found = QpSolution(np.array(r.x), np.array(r.y), np.subtract(r.z_u, r.z_l), np.subtract(r.z_bu, r.z_bl))
        # on nearly straight roads the last digits of the gap cannot be had; what it found is judged by its residual, not by its status
        return found if status == piqp.PIQP_SOLVED or (np.all(np.isfinite(found.x)) and qp.residual(found) < _GOOD_ENOUGH) else None


class Clarabel:
    """Clarabel, a homogeneous interior-point method; set up anew at each call."""

    def solve(self, qp: Qp, tolerance: float) -> QpSolution | None:
        """See QpSolver."""
        low, high = np.flatnonzero(np.isfinite(qp.x_lower)), np.flatnonzero(np.isfinite(qp.x_upper))
        unit = sp.identity(len(qp.x_lower), format="csr")
        below, above = np.flatnonzero(np.isfinite(qp.upper)), np.flatnonzero(np.isfinite(qp.lower))
        rows = sp.csr_matrix(qp.G)
        matrix = sp.csc_matrix(sp.vstack([qp.A, rows[below], -rows[above], unit[high], -unit[low]]))
        rhs = np.concatenate([qp.b, qp.upper[below], -qp.lower[above], qp.x_upper[high], -qp.x_lower[low]])
        cones = [clarabel.ZeroConeT(len(qp.b)), clarabel.NonnegativeConeT(len(rhs) - len(qp.b))]
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = min(tolerance, 1e-7)
        found = clarabel.DefaultSolver(sp.csc_matrix(sp.triu(qp.P)), qp.c, matrix, rhs, cones, settings).solve()
        if found.status != clarabel.SolverStatus.Solved:
            return None
        parts = np.split(np.array(found.z), np.cumsum([len(qp.b), len(below), len(above), len(high)]))
        net, bounds = np.zeros(qp.G.shape[0]), np.zeros(len(qp.c))
        net[below] += parts[1]
        net[above] -= parts[2]
        bounds[high] += parts[3]
        bounds[low] -= parts[4]
        return QpSolution(np.array(found.x), parts[0], net, bounds)


class Other:
    """Any solver that `qpsolvers` finds installed, at tight tolerances; `osqp` comes with this package."""

    def __init__(self, name: str) -> None:
        self._name = name

    def solve(self, qp: Qp, tolerance: float) -> QpSolution | None:
        """See QpSolver."""
        import qpsolvers

        below, above = np.isfinite(qp.upper), np.isfinite(qp.lower)
        rows = sp.csr_matrix(qp.G)
        sides = sp.csc_matrix(sp.vstack([rows[np.flatnonzero(below)], -rows[np.flatnonzero(above)]]))
        rhs = np.concatenate([qp.upper[below], -qp.lower[above]])
        problem = qpsolvers.Problem(qp.P, qp.c, sides, rhs, qp.A, qp.b, qp.x_lower, qp.x_upper)
        options = {"eps_abs": 1e-7, "eps_rel": 1e-9, "max_iter": 200_000, "polishing": True} if self._name == "osqp" else {}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", PendingDeprecationWarning)  # between qpsolvers and OSQP, about a default that does not matter here
            found = qpsolvers.solve_problem(problem, solver=self._name, **options)
        if not found.found or found.x is None or found.y is None or found.z is None or found.z_box is None:
            return None
        net = np.zeros(qp.G.shape[0])
        net[below] += found.z[: np.count_nonzero(below)]
        net[above] -= found.z[np.count_nonzero(below) :]
        return QpSolution(found.x, found.y, net, found.z_box)


def qp_solver(name: str) -> QpSolver:
    """The back end `piqp`, `clarabel`, or one of those that qpsolvers finds.

    Raises:
        PlanningError: there is none of that name.
    """
    if name == "piqp":
        return Piqp()
    if name == "clarabel":
        return Clarabel()
    import qpsolvers

    if name not in qpsolvers.sparse_solvers:
        there = ", ".join(sorted({"piqp", "clarabel", *qpsolvers.sparse_solvers}))
        raise PlanningError(f"QP solver {name!r} is not installed, expected one of {there}")
    return Other(name)


def _alike(new: sp.csc_matrix, old: sp.csc_matrix) -> bool:
    """True if both have the same sparsity."""
    if new is old:
        return True
    return new.shape == old.shape and np.array_equal(new.indptr, old.indptr) and np.array_equal(new.indices, old.indices)


def _worst(values: Floats) -> float:
    return float(np.max(values, initial=0.0))


def _idle(multiplier: Floats, value: Floats, lower: Floats, upper: Floats) -> float:
    """Largest product of a multiplier and the room (at most 1) that its constraint has."""
    room = np.where(multiplier > 0.0, np.minimum(upper - value, 1.0), np.minimum(value - lower, 1.0))
    return float(np.max(np.abs(multiplier) * np.maximum(room, 0.0), initial=0.0))
