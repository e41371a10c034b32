"""Problem P1: the gentlest path inside a corridor, over a reduced cubic spline; all terms sparse and analytic.

Equalities keep the slope continuous at the knots (3.7) and hold the ends. Rows keep the path between the borders at control points (3.9), bounds at
the knots (3.8). Both are linear. The limit of curvature, if there is one, is not: it is linearised where it is asked for.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from ...errors import PlanningError
from . import ends as ends_
from .ends import End
from .knots import equal_knots
from .objective import Model, Objective, Weights, nodes
from .spline import PER_KNOT, ReducedSpline

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from roads import Corridor, PlanarCurve

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

#: The curvature rows aim at this share of the bound, so that the path keeps it between them too.
CURVATURE_SHARE = 0.998
_FREE = np.zeros(0)


class Rows(NamedTuple):
    """`lower <= matrix x <= upper`; `q` says at which station, m."""

    matrix: sp.csc_matrix
    lower: Floats
    upper: Floats
    q: Floats


@dataclass(frozen=True, eq=False)
class CurvatureProblem:
    """P1 on given knots.

    Attributes:
        corridor: where the path may run.
        spline: the variables.
        start: (n,) offset at the knots that the initial guess follows, m.
        ends: what holds at both ends of an open road; None on a circuit.
        objective: what is minimised.
        row_q: (m,) stations between the knots at which the borders are kept, the control points (3.9).
        row_tighter: (m,) by how much the borders are drawn in there, m.
        tighter: by how much they are drawn in at the knots, m.
        curvature_max: bound on the curvature, 1/m, infinite for none.
        bend_q: (k,) stations at which it is kept.
    """

    corridor: Corridor
    spline: ReducedSpline
    start: Floats
    ends: tuple[End, End] | None
    objective: Objective
    row_q: Floats
    row_tighter: Floats
    tighter: float = 0.0
    curvature_max: float = np.inf
    bend_q: Floats = field(default_factory=lambda: _FREE)

    @classmethod
    def on(
        cls,
        corridor: Corridor,
        start: PlanarCurve,
        *,
        spacing: float = 4.0,
        knots: Floats | None = None,
        control_points: int = 3,
        weights: Weights | None = None,
        ends: tuple[End | None, End | None] = (None, None),
        curvature_max: float = np.inf,
        tighter: float = 0.0,
        unit: float = 1.0,
        window: bool = False,
    ) -> CurvatureProblem:
        """P1 with a guess along the curve `start`, on which also lie the ends that are not given.

        Args:
            corridor: where the path may run.
            start: the initial guess, and the centre that `weights.offset` counts from.
            spacing: distance of equal knots, m, if `knots` are not given.
            knots: (n,) stations of the knots, m.
            control_points: points between two knots at which the borders are kept.
            weights: what is mixed into squared curvature.
            ends: what holds at the ends of an open road; None: on `start`, along it.
            curvature_max: bound on the curvature, 1/m.
            tighter: by how much the borders are drawn in everywhere, m.
            unit: spline parameter per metre.
            window: on a circuit, an open stretch of it; `knots` may count on beyond its end.
        """
        reference = corridor.reference
        q = equal_knots(reference, spacing) if knots is None else knots
        spline = ReducedSpline(reference, q, unit, window)
        inner = spline.breaks[:-1, None] + np.diff(spline.breaks)[:, None] * np.arange(1, control_points + 1) / (control_points + 1)
        rows, weights = inner.ravel(), weights or Weights()
        right, left = corridor.offsets(q)
        offset = beside(start, reference, q)
        middle = beside(start, reference, nodes(spline).ravel()).reshape(len(spline.h), -1) if weights.offset > 0.0 else np.zeros((0, 4))
        held = None
        if not spline.closed:
            first, last = (
                ends_.along(start, reference, float(q[k]), float(np.clip(offset[k], right[k], left[k]))) if end is None else end
                for k, end in ((0, ends[0]), (-1, ends[1]))
            )
            held = first, last
            for end in held:
                if end.curvature is not None and abs(end.curvature) > curvature_max:
                    raise PlanningError(f"{corridor.name}: curvature {end.curvature:.4g} 1/m at an end, expected at most {curvature_max:.4g} 1/m")
        objective = Objective(spline, weights, middle)
        made = cls(corridor, spline, np.clip(offset, right, left), held, objective, rows, np.full(len(rows), tighter), tighter, curvature_max)
        return made if np.isinf(curvature_max) else replace(made, bend_q=made._bend_stations())

    def _bend_stations(self) -> Floats:
        """Where the curvature is watched from the start: at the knots and between them where the road bends by half the bound or more."""
        breaks = self.spline.breaks
        q = np.sort(np.concatenate([self.spline.q, 0.5 * (breaks[1:] + breaks[:-1])]))
        return q[np.abs(self.corridor.reference.curvature(q)) > 0.5 * self.curvature_max]

    # -- short names of what the spline holds ----------------------------------------------------------------------------------------

    @property
    def q(self) -> Floats:
        """(n,) stations of the knots, m."""
        return self.spline.q

    @property
    def closed(self) -> bool:
        """True on a circuit."""
        return self.spline.closed

    def curve(self, x: Floats) -> PlanarCurve:
        """The path as a curve."""
        return self.spline.curve(x)

    def cost(self, x: Floats) -> float:
        """The cost at `x`."""
        return self.objective.cost(x)

    def model(self, x: Floats) -> Model:
        """Cost, gradient and Gauss-Newton Hessian at `x`."""
        return self.objective.model(x)

    # -- borders ---------------------------------------------------------------------------------------------------------------------

    @cached_property
    def borders(self) -> tuple[Floats, Floats]:
        """(n,) least and largest offset at the knots, m."""
        right, left = self.corridor.offsets(self.q)
        return drawn_in(right, left, self.tighter)

    def fractions(self, x: Floats) -> Floats:
        """(n,) the source's variable alpha: 0 on the left border, 1 on the right one (3.6)."""
        right, left = self.borders
        return (left - x[2::PER_KNOT]) / (left - right)

    @cached_property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper bounds on x: the borders at the knots (3.8); held ends are left to their equalities."""
        right, left = (border.copy() for border in self.borders)
        if self.ends is not None:
            for at, end in zip((0, -1), self.ends, strict=True):
                if end.offset is not None:
                    right[at], left[at] = -np.inf, np.inf
        free = np.full(len(right), np.inf)
        return np.column_stack([-free, -free, right]).ravel(), np.column_stack([free, free, left]).ravel()

    @cached_property
    def offset_table(self) -> tuple[Ints, Floats, Floats]:
        """Segment (m,) of the control points, and the path's offset there by the segment's variables: rows (m, 6), constants (m,)."""
        q = self.row_q
        basis, reference = self.spline.basis(q, 0), self.spline.reference
        normal = reference.normal(q)
        values = np.matmul(normal[:, None, :], basis.matrix)[:, 0]
        return basis.segment, values, np.sum(normal * (basis.constant - (reference.position(q) - self.spline.origin)), axis=1)

    @cached_property
    def row_borders(self) -> tuple[Floats, Floats]:
        """Borders (m,) at the control points, m."""
        return self.corridor.offsets(self.row_q)

    @cached_property
    def rows(self) -> Rows:
        """Offset of the path at the control points between the borders (3.9), m."""
        segment, values, constant = self.offset_table
        right, left = drawn_in(*self.row_borders, self.row_tighter)
        return Rows(self.spline.rows(segment, values), right - constant, left - constant, self.row_q)

    def with_rows(self, q: Floats, tighter: Floats) -> CurvatureProblem:
        """The same problem with further control points at stations `q`, drawn in by `tighter` (m)."""
        if self.closed:
            first = self.spline.breaks[0]
            q = first + np.mod(q - first, self.spline.reference.length)
        every, drawn = np.concatenate([self.row_q, q]), np.concatenate([self.row_tighter, tighter])
        order = np.argsort(every, kind="stable")
        return replace(self, row_q=every[order], row_tighter=drawn[order])

    def with_bends(self, q: Floats) -> CurvatureProblem:
        """The same problem with the bound on curvature kept at further stations `q`."""
        return replace(self, bend_q=np.union1d(self.bend_q, q))

    # -- continuity and ends ---------------------------------------------------------------------------------------------------------

    @cached_property
    def equalities(self) -> tuple[sp.csc_matrix, Floats]:
        """A and b of A x = b: continuous slope at the knots (3.7), along and across the road; on open roads the ends."""
        spline = self.spline
        joint, constant = self.joint_table
        inner = self._inner
        before, after = (inner - 1) % len(spline.h), inner % len(spline.h)
        columns = np.concatenate([spline.columns[before], spline.columns[after][:, 3:]], axis=1)
        parts, rhs = [(np.repeat(columns, 2, axis=0), joint.reshape(-1, 9))], [-constant.ravel()]
        for end, last in zip(self.ends or (), (False, True), strict=False):
            segments, rows, values = ends_.conditions(spline, end, last=last)
            parts.append((spline.columns[segments], rows))
            rhs.append(values)
        return spline.stacked(parts), np.concatenate(rhs)

    @property
    def _inner(self) -> Ints:
        """Knots at which two segments join."""
        return np.arange(len(self.q)) if self.closed else np.arange(1, len(self.q) - 1)

    @cached_property
    def joint_table(self) -> tuple[Floats, Floats]:
        """Jump of the slope at the joints, along and across the road: rows (k, 2, 9) by the variables of three knots, constants (k, 2)."""
        spline, inner = self.spline, self._inner
        before, after = (inner - 1) % len(spline.h), inner % len(spline.h)
        size = 0.5 * (spline.h[before] + spline.h[after])
        left, right = spline.basis(spline.breaks[before + 1], 1, before), spline.basis(spline.breaks[after], 1, after)
        directions = np.stack(spline.frame, axis=1)[inner]
        values = [size[:, None, None] * np.matmul(directions, basis.matrix) for basis in (left, right)]
        constant = size[:, None] * np.matmul(directions, (left.constant - right.constant)[:, :, None])[:, :, 0]
        joint = np.concatenate([values[0][:, :, :3], values[0][:, :, 3:] - values[1][:, :, :3], -values[1][:, :, 3:]], axis=2)
        return joint, constant

    # -- curvature -------------------------------------------------------------------------------------------------------------------

    @cached_property
    def _bends(self) -> tuple[Any, Any]:
        return self.spline.basis(self.bend_q, 1), self.spline.basis(self.bend_q, 2)

    def curvatures(self, x: Floats) -> tuple[Floats, Floats]:
        """Curvature (k,) at `bend_q` as a multiple of what it may be, and its derivatives (k, 6) by the segment's variables."""
        first, second = self._bends
        p, q = self.spline.values(first, x), self.spline.values(second, x)
        square, cross = np.sum(p**2, axis=1), p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
        by_p = np.column_stack([q[:, 1], -q[:, 0]]) - 3.0 * (cross / square)[:, None] * p
        by_q = np.column_stack([-p[:, 1], p[:, 0]])
        jacobian = np.matmul(by_p[:, None, :], first.matrix)[:, 0] + np.matmul(by_q[:, None, :], second.matrix)[:, 0]
        scale = square**-1.5 / (CURVATURE_SHARE * self.curvature_max)
        return cross * scale, jacobian * scale[:, None]

    def bend_rows(self, values: Floats) -> sp.csc_matrix:
        """The derivatives of `curvatures` as a sparse matrix."""
        return self.spline.rows(self._bends[0].segment, values)

    def too_tight(self, x: Floats) -> float:
        """Sum of what the curvature at `bend_q` exceeds its bound by, as multiples of the bound."""
        return float(np.sum(np.maximum(np.abs(self.curvatures(x)[0]) - 1.0, 0.0))) if len(self.bend_q) else 0.0

    # -- points ----------------------------------------------------------------------------------------------------------------------

    def initial(self) -> Floats:
        """The point x that follows `start` at the knots; the second derivatives solve the equalities."""
        x = np.zeros((len(self.q), PER_KNOT))
        x[:, 2] = self.start
        matrix, rhs = self.equalities
        if self.ends is not None:
            straight = tuple(replace(end, heading=end.heading or 0.0, offset=None, curvature=None, speed=None) for end in self.ends)
            matrix, rhs = replace(self, ends=straight).equalities
        bends = np.arange(x.size) % PER_KNOT != PER_KNOT - 1
        flat = x.ravel()
        solution: Any = spsolve(matrix[:, bends], rhs - matrix @ flat)
        flat[bends] = solution
        return flat

    def room(self, x: Floats, step: Floats) -> float:
        """How many times `step` fits from `x` before a border is passed (by a micrometre)."""
        rows = self.rows
        least, most = self.bounds
        place, move = np.concatenate([rows.matrix @ x, x]), np.concatenate([rows.matrix @ step, step])
        low, high = np.concatenate([rows.lower, least]) - 1e-6, np.concatenate([rows.upper, most]) + 1e-6
        limit = np.where(move > 0.0, high - place, low - place)
        moving = np.abs(move) > 1e-12
        return float(np.min(limit[moving] / move[moving], initial=np.inf))

    def worst_row(self, x: Floats) -> tuple[float, float]:
        """Largest violation (m) of the control points and knots by `x`, and its station."""
        rows, (least, most) = self.rows, self.bounds
        value, e = rows.matrix @ x, x[2::PER_KNOT]
        beyond = np.concatenate([np.maximum(value - rows.upper, rows.lower - value), np.maximum(e - most[2::PER_KNOT], least[2::PER_KNOT] - e)])
        at = int(np.argmax(beyond))
        return float(beyond[at]), float(np.concatenate([rows.q, self.q])[at])


def beside(curve: PlanarCurve, reference: PlanarCurve, q: Floats) -> Floats:
    """(k,) offset of `curve` from the reference at stations `q`: where it crosses the reference's normals, m."""
    points, normal = reference.position(q), reference.normal(q)
    tangent = np.column_stack([normal[:, 1], -normal[:, 0]])
    s, _ = curve.project(points, q * curve.length / reference.length)
    for _ in range(20):
        gap = curve.position(s) - points
        # along the normal the crossing has no component along the tangent
        step = np.sum(gap * tangent, axis=1) / np.maximum(np.sum(curve.tangent(s) * tangent, axis=1), 0.2)
        s = s - step
        if np.max(np.abs(step), initial=0.0) < 1e-9:
            break
    return np.sum((curve.position(s) - points) * normal, axis=1)


def drawn_in(right: Floats, left: Floats, tighter: Floats | float) -> tuple[Floats, Floats]:
    """Borders (right, left) moved towards each other by `tighter`, but by no more than a quarter of what is between them."""
    least = np.minimum(tighter, 0.25 * np.maximum(left - right, 0.0))
    return right + least, left - least
