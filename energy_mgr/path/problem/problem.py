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

from . import ends as ends_
from .bends import Bends, watched
from .ends import End
from .joints import joints, jumps, segments_at
from .knots import equal_knots
from .objective import Model, Objective, Weights, nodes
from .offsets import beside, drawn_in
from .spline import PER_KNOT, ReducedSpline

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from roads import Corridor, PlanarCurve

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

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
        held = None if spline.closed else ends_.held(ends, start, spline, np.clip(offset, right, left), curvature_max, corridor.name)
        objective = Objective(spline, weights, middle)
        made = cls(corridor, spline, np.clip(offset, right, left), held, objective, rows, np.full(len(rows), tighter), tighter, curvature_max)
        return made if np.isinf(curvature_max) else replace(made, bend_q=watched(spline, curvature_max))

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
        before, after = segments_at(joints(spline), spline)
        columns = np.concatenate([spline.columns[before], spline.columns[after][:, 3:]], axis=1)
        parts, rhs = [(np.repeat(columns, 2, axis=0), joint.reshape(-1, 9))], [-constant.ravel()]
        for end, last in zip(self.ends or (), (False, True), strict=False):
            segments, rows, values = ends_.conditions(spline, end, last=last)
            parts.append((spline.columns[segments], rows))
            rhs.append(values)
        return spline.stacked(parts), np.concatenate(rhs)

    @cached_property
    def joint_table(self) -> tuple[Floats, Floats]:
        """Jump of the slope at the joints, along and across the road: rows (k, 2, 9) by the variables of three knots, constants (k, 2)."""
        return jumps(self.spline)

    # -- curvature -------------------------------------------------------------------------------------------------------------------

    @cached_property
    def _bends(self) -> Bends:
        return Bends.at(self.spline, self.bend_q)

    def curvatures(self, x: Floats) -> tuple[Floats, Floats]:
        """Curvature (k,) at `bend_q` as a multiple of what it may be, and its derivatives (k, 6) by the segment's variables."""
        return self._bends.shares(x, self.curvature_max)

    def bend_rows(self, values: Floats) -> sp.csc_matrix:
        """The derivatives of `curvatures` as a sparse matrix."""
        return self.spline.rows(self._bends.first.segment, values)

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
