"""P1 through CasADi and IPOPT with exact second derivatives: slower, and the reference that the others are measured against.

The cost is written here once more, from (3.11), as symbols; nothing of the analytic derivatives in `objective` is used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from powertrain.symbolic import ca

from ...errors import SolverError
from ..problem.bends import CURVATURE_SHARE
from ..problem.spline import PER_KNOT
from .solution import Solution

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from ..problem.problem import CurvatureProblem

    Floats = NDArray[np.float64]


def build(problem: CurvatureProblem, *, tolerance: float = 1e-9) -> Any:
    """The solver for `problem`; building it takes longer than running it."""
    variables = ca.SX.sym("x", problem.spline.size)
    linear = ca.mtimes(ca.vertcat(ca.DM(problem.equalities[0]), ca.DM(problem.rows.matrix)), variables)
    constraints = ca.vertcat(linear, _bends(problem, variables)) if len(problem.bend_q) else linear
    options = {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes", "ipopt.tol": tolerance, "ipopt.max_iter": 500}
    return ca.nlpsol("path", "ipopt", {"x": variables, "f": _cost(problem, variables), "g": constraints}, options)


def solve(
    problem: CurvatureProblem,
    x: Floats,
    solver: Any = None,
    *,
    tolerance: float = 1e-9,
    report: Callable[[str], None] | None = None,
) -> Solution:
    """Minimise the cost of `problem` from the point `x`, with a solver that was built for it or a new one.

    Raises:
        SolverError: IPOPT did not converge.
    """
    solver = solver or build(problem, tolerance=min(tolerance, 1e-8))
    rhs, rows = problem.equalities[1], problem.rows
    most = np.ones(len(problem.bend_q))
    lower, upper = problem.bounds
    found = solver(x0=x, lbx=lower, ubx=upper, lbg=np.concatenate([rhs, rows.lower, -most]), ubg=np.concatenate([rhs, rows.upper, most]))
    stats: dict[str, Any] = solver.stats()
    if not stats["success"]:
        raise SolverError(f"{problem.corridor.name}: IPOPT ended with {stats['return_status']}; method gauss-newton solves the same problem")
    if report:
        report(f"path: IPOPT, {stats['iter_count']} iterations, cost {float(found['f']):.6f}")
    cost = float(found["f"])
    return Solution(np.array(found["x"]).ravel(), cost, int(stats["iter_count"]), np.nan, np.nan, True, "ipopt")


class _Segments(NamedTuple):
    """Bends and places of the knots before and after some segments, as symbols, per axis."""

    b0: list[Any]
    b1: list[Any]
    d0: list[Any]
    d1: list[Any]
    h: Any

    def derivatives(self, th: Any) -> tuple[list[Any], list[Any], list[Any], list[Any]]:
        """Place and three derivatives per axis at parameters `th` within the segments, from (3.1) and (3.3) to (3.7)."""
        place, first, second, third = [], [], [], []
        for b0, b1, d0, d1 in zip(self.b0, self.b1, self.d0, self.d1, strict=True):
            a, c = (b1 - b0) / (3 * self.h), (d1 - d0) / self.h - self.h * (b1 + 2 * b0) / 3
            place.append(a * th**3 + b0 * th**2 + c * th + d0)
            first.append(3 * a * th**2 + 2 * b0 * th + c)
            second.append(6 * a * th + 2 * b0)
            third.append(6 * a)
        return place, first, second, third


def _segments(problem: CurvatureProblem, x: Any, which: list[int]) -> _Segments:
    spline = problem.spline
    scale, (tangent, normal) = ca.DM(spline.b_scale), spline.frame
    ahead = spline.ahead[which].tolist()
    parts = []
    for axis in range(2):
        b = (x[0::PER_KNOT] * ca.DM(tangent[:, axis]) + x[1::PER_KNOT] * ca.DM(normal[:, axis])) / scale
        d = ca.DM(spline.place[:, axis]) + x[2::PER_KNOT] * ca.DM(normal[:, axis])
        parts.append((b[which], b[ahead], d[which], d[ahead]))
    b0, b1, d0, d1 = ([part[k] for part in parts] for k in range(4))
    return _Segments(b0, b1, d0, d1, ca.DM(spline.h[which]))


def _cost(problem: CurvatureProblem, x: Any) -> Any:
    """The mix of the objective as a symbol."""
    spline, weights = problem.spline, problem.objective.weights
    points, shares = np.polynomial.legendre.leggauss(4)
    segments = _segments(problem, x, list(range(len(spline.h))))
    starts = spline.breaks[:-1]
    total = 0
    for g, share in enumerate(shares):
        fraction = 0.5 * (1.0 + points[g])
        o, p, q, t = segments.derivatives(fraction * segments.h)
        square, cross = p[0] ** 2 + p[1] ** 2, p[0] * q[1] - p[1] * q[0]
        value = cross**2 / square**2.5
        if weights.length > 0.0:
            value += weights.length * ca.sqrt(square)
        if weights.curvature_rate > 0.0:
            rate = (p[0] * t[1] - p[1] * t[0]) / square**1.5 - 3 * cross * (p[0] * q[0] + p[1] * q[1]) / square**2.5
            value += weights.curvature_rate * rate**2 / ca.sqrt(square)
        if weights.offset > 0.0:
            station = starts + fraction * np.diff(spline.breaks)
            normal, place = spline.reference.normal(station), spline.reference.position(station) - spline.origin
            gap = sum(ca.DM(normal[:, axis]) * (o[axis] - ca.DM(place[:, axis])) for axis in range(2)) - ca.DM(problem.objective.centre[:, g])
            value += weights.offset / spline.unit * gap**2
        total += ca.sum1(0.5 * share * segments.h * value)
    return total


def _bends(problem: CurvatureProblem, x: Any) -> Any:
    """Curvature where it is watched, as multiples of what it may be."""
    spline = problem.spline
    which = spline.segment_of(problem.bend_q)
    segments = _segments(problem, x, which.tolist())
    _, p, q, _ = segments.derivatives(ca.DM(spline.unit * (problem.bend_q - spline.breaks[which])))
    return (p[0] * q[1] - p[1] * q[0]) / (p[0] ** 2 + p[1] ** 2) ** 1.5 / (CURVATURE_SHARE * problem.curvature_max)
