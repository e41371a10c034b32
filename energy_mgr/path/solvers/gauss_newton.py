"""Sequential quadratic programming with the Gauss-Newton Hessian, the default.

Converges linearly, at a rate given by the curvature that is left at the optimum; on roads that is fast (3 to 13 QPs). The exact Hessian, made
convex segment by segment, was tried: it takes up to six times as many, because its positive parts stay and its negative ones do not. Continuity,
ends and borders are linear, so that every iterate after the first full step keeps them. A bound on curvature is linearised; what the linearised
rows cannot keep is paid for at a price that makes the minimiser keep them where it can (an exact penalty), and the same price stands in the merit
function.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy.sparse as sp

from ...errors import InfeasibleError, SolverError
from .backends import QP_SCALE, Qp, QpSolution, QpSolver, qp_solver
from .contradiction import constraints, refuse_contradiction
from .solution import Solution

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from ..problem.objective import Model
    from ..problem.problem import CurvatureProblem

    Floats = NDArray[np.float64]

#: A control point may be missed by this much by the QP solver, m; the path is checked again afterwards.
ROW_TOLERANCE = 1e-5
#: Accuracy of the first and of the last QPs, relative to the cost.
_ROUGHEST_QP, _FINEST_QP = 1e-5, 1e-8
#: Price of curvature beyond its bound, in costs per multiple of the bound and station; raised by tens up to the last.
_FIRST_PRICE, _LAST_PRICE = 10.0, 1e5
#: Curvature beyond its bound by this multiple counts as kept; the bound itself is proven elsewhere.
BEND_TOLERANCE = 1e-4
#: Integral of squared curvature below which a path counts as straight, 1/m per m of length.
_STRAIGHT = 1e-9


def solve(
    problem: CurvatureProblem,
    x: Floats,
    *,
    qp: str | QpSolver = "piqp",
    tolerance: float = 1e-6,
    iterations: int = 60,
    seconds: float = np.inf,
    residual: bool = True,
    report: Callable[[str], None] | None = None,
) -> Solution:
    """Minimise the cost of `problem` from the point `x`.

    Args:
        problem: what to minimise.
        x: (3n,) where to start; it need not keep the constraints.
        qp: the back end for the QPs, by name or one that is kept.
        tolerance: stop when less than this fraction of the cost is left to gain.
        iterations: at most so many QPs.
        seconds: start no QP after this time, as far as the last one tells.
        residual: work out the KKT residual.
        report: called with a line of progress per iteration.

    Raises:
        InfeasibleError: no path keeps the borders, or the bound on curvature; the station of the worst conflict is named.
        SolverError: the QP back end failed on a feasible problem.
    """
    return _Run(problem, qp, report).solve(x, tolerance, iterations, seconds, residual=residual)


class _Step(NamedTuple):
    """A solved QP: the step of the variables, the decrease of the merit that it promises, the slope of the cost, and its curvature in excess."""

    step: Floats
    promise: float
    slope: float
    excess: float
    found: QpSolution
    qp: Qp


class _Run:
    """One minimisation: the back end in use, the price of curvature and the constraints that stay."""

    def __init__(self, problem: CurvatureProblem, qp: str | QpSolver, report: Callable[[str], None] | None) -> None:
        self.problem, self.report = problem, report
        self.name = qp if isinstance(qp, str) else "piqp"
        self.backend = qp_solver(qp) if isinstance(qp, str) else qp
        self.price = _FIRST_PRICE
        self.floor = _STRAIGHT * float(problem.spline.breaks[-1] - problem.spline.breaks[0])
        self.bends = len(problem.bend_q)
        self.base = constraints(problem)

    def solve(self, x: Floats, tolerance: float, iterations: int, seconds: float, *, residual: bool = True) -> Solution:
        started = last_qp = time.perf_counter()
        inside, optimality, last, accuracy, count = _inside(self.problem, x), np.inf, np.inf, _ROUGHEST_QP, 0
        if iterations == 1:
            accuracy = 0.2 * tolerance  # the only QP is the last one too
        converged, final = False, None
        while count < iterations:
            now = time.perf_counter()
            if count and (now - started) + 1.2 * (now - last_qp) > seconds:
                break
            last_qp, count = now, count + 1
            model = self.problem.model(x)
            scale = 1.0 / max(model.cost, self.floor)
            try:
                made = self._step(x, model, scale, accuracy, first=count == 1)
            except _Rough:
                accuracy = _FINEST_QP
                made = self._step(x, model, scale, accuracy, first=count == 1)
            optimality, last = _left_over(abs(made.promise), last), abs(made.promise)
            length = self._line_search(x, made, scale) if inside else 1.0
            reached = optimality < tolerance and accuracy <= 0.2 * tolerance
            final = made, model.hessian, scale
            if inside and length == 0.0 and accuracy > _FINEST_QP:
                # the point came from a rough QP and is better than the constraints allow: start over from a fine one
                accuracy, inside = _FINEST_QP, False
                continue
            x, was_inside, inside = x + length * made.step, inside, True
            if was_inside and (length == 0.0 or reached):
                if made.excess < BEND_TOLERANCE or self.price >= _LAST_PRICE:
                    converged = (reached or optimality < 100 * tolerance) and made.excess < BEND_TOLERANCE
                    break
                self.price, last = 10.0 * self.price, np.inf
                continue
            # as in inexact Newton methods: no QP needs solving much closer than the next step is worth
            accuracy = float(np.clip(3e-6 * last, min(_FINEST_QP, 0.1 * tolerance), _ROUGHEST_QP))
            if self.report:
                self.report(f"path: iteration {count}, cost {self.problem.cost(x):.6f}")
        self._refuse_too_tight(x)
        kkt = np.nan
        if final is not None and residual:
            made, hessian, scale = final
            # what the QP left, and what its model missed over its step
            kkt = made.qp.residual(made.found) + scale * float(np.max(np.abs(hessian @ made.step)))
        return Solution(x, self.problem.cost(x), count, optimality, kkt, converged, self.name)

    def _step(self, x: Floats, model: Model, scale: float, accuracy: float, *, first: bool) -> _Step:
        qp = self._qp(x, model, scale)
        found = self._checked(qp, self.backend.solve(qp, accuracy))
        if found is None:
            if accuracy > _FINEST_QP:
                raise _Rough
            found = self._second_try(qp, first=first)
        n = len(x)
        step = found.x[:n] - x
        slope = float(model.gradient @ step) * scale
        promise = -slope - 0.5 * scale * float(step @ (model.hessian @ step))
        excess = float(np.max(found.x[n:], initial=0.0))
        if self.bends:
            promise += self.price * (self.problem.too_tight(x) - float(np.sum(found.x[n:])))
        return _Step(step, promise, slope, excess, found, qp)

    def _qp(self, x: Floats, model: Model, scale: float) -> Qp:
        """The QP about `x`; with a bound on curvature a slack per station stands behind the variables."""
        base, size = self.base, QP_SCALE * scale
        P, c = model.hessian * size, (model.gradient - model.hessian @ x) * size
        if not self.bends:
            return base._replace(P=P, c=c)
        count = self.bends
        value, jacobian = self.problem.curvatures(x)
        rows = self.problem.bend_rows(jacobian)
        rest, slack, infinite = value - rows @ x, sp.identity(count, format="csr"), np.full(count, np.inf)
        return Qp(
            sp.csc_matrix(sp.block_diag([P, sp.csc_matrix((count, count))])),
            np.concatenate([c, np.full(count, self.price * QP_SCALE)]),
            sp.csc_matrix(sp.hstack([base.A, sp.csc_matrix((base.A.shape[0], count))])),
            base.b,
            sp.csc_matrix(sp.bmat([[base.G, None], [rows, -slack], [rows, slack]])),
            np.concatenate([base.lower, -infinite, -1.0 - rest]),
            np.concatenate([base.upper, 1.0 - rest, infinite]),
            np.concatenate([base.x_lower, np.zeros(count)]),
            np.concatenate([base.x_upper, infinite]),
        )

    def _checked(self, qp: Qp, found: QpSolution | None) -> QpSolution | None:
        """The solution if there is one that keeps borders and continuity; "solved" is not taken on trust."""
        if found is None or not np.all(np.isfinite(found.x)):
            return None
        x = found.x[: self.problem.spline.size]
        kept = self.problem.worst_row(x)[0] <= ROW_TOLERANCE and float(np.max(np.abs(qp.A @ found.x - qp.b), initial=0.0)) <= ROW_TOLERANCE
        return found if kept else None

    def _second_try(self, qp: Qp, *, first: bool) -> QpSolution:
        """The minimiser by the other back end, which takes over; at the first QP find out first whether the borders contradict each other."""
        if first:
            refuse_contradiction(self.problem)
        before, self.name = self.name, "clarabel" if self.name == "piqp" else "piqp"
        self.backend = qp_solver(self.name)
        found = self._checked(qp, self.backend.solve(qp, _FINEST_QP))
        if found is None:
            raise SolverError(f"{self.problem.corridor.name}: the QP solvers {before} and {self.name} both failed on the path")
        return found

    def _merit(self, x: Floats, scale: float) -> float:
        return self.problem.cost(x) * scale + (self.price * self.problem.too_tight(x) if self.bends else 0.0)

    def _line_search(self, x: Floats, made: _Step, scale: float) -> float:
        """A step length that lowers the merit by a fair share of the promise; 0 if none does.

        Where the model overrates the curvature of the cost, full steps are too short; then go on along the step, as far as a parabola through what is
        known suggests and the borders allow.
        """
        here, length = self._merit(x, scale), 1.0
        while length > 1e-4:
            found = self._merit(x + length * made.step, scale)
            if found <= here - 1e-4 * length * made.promise:
                break
            length *= 0.5
        else:
            return 0.0
        if length < 1.0 or self.bends:
            return length
        bend = found - here - made.slope
        longer = min(-made.slope / (2.0 * bend), 10.0) if made.slope < 0.0 < bend else 1.0
        if longer < 1.2:
            return 1.0
        longer = min(longer, self.problem.room(x, made.step))
        return longer if longer > 1.0 and self._merit(x + longer * made.step, scale) < found else 1.0

    def _refuse_too_tight(self, x: Floats) -> None:
        if not self.bends or self.price < _LAST_PRICE:
            return
        value = np.abs(self.problem.curvatures(x)[0])
        at = int(np.argmax(value))
        if value[at] > 1.0 + 10 * BEND_TOLERANCE:
            bound = self.problem.curvature_max
            raise InfeasibleError(
                f"{self.problem.corridor.name}: no path was found inside the corridor that keeps the curvature below {bound:.4g} 1/m, "
                f"radius {1 / bound:.2f} m; it breaks it near s = {self.problem.bend_q[at]:.1f} m"
            )


class _Rough(Exception):  # noqa: N818 - never leaves this module
    """A rough QP came back unusable."""


def _left_over(promise: float, last: float) -> float:
    """The decrease that is left after a step that promises `promise` of the cost and follows one that promised `last`.

    Steps shrink at a steady rate. Where the rate is good, what is left after this step is the rest of a geometric series.
    """
    if np.isinf(last) or last == 0.0:  # nothing to gain on a straight
        return promise
    rate = promise / last
    return promise * rate / (1.0 - rate) if rate < 0.1 else promise


def _inside(problem: CurvatureProblem, x: Floats) -> bool:
    matrix, rhs = problem.equalities
    return problem.worst_row(x)[0] <= ROW_TOLERANCE and float(np.max(np.abs(matrix @ x - rhs), initial=0.0)) <= ROW_TOLERANCE
