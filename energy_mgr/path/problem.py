"""Problem P1: least integral of squared curvature inside a corridor, over a reduced cubic spline.

Knots lie on normals of the corridor's reference curve at stations `q`. Free are the fraction `alpha` of each knot between the left (0) and the
right border (1) and half the second derivative `b` there; the other spline coefficients follow from continuity, (3.3) to (3.7):

    d = l + (r - l) alpha,   c = (d1 - d0) / h - h (b1 + 2 b0) / 3,   a = (b1 - b0) / (3 h)

so that the curve is linear in `x = (b_x, b_y, alpha)` per knot, and so are its constraints. The spline parameter is the station of the
reference, hence |o'| is of order one. The cost is taken over arc length, `int kappa^2 ds`, not over the parameter as in (3.10).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from roads import PlanarCurve
from roads.cubic import PiecewiseCubic

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from roads import Corridor

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True, eq=False)
class CurvatureProblem:
    """P1 on given knots.

    Attributes:
        corridor: where the path may run.
        q: (n,) stations of the knots on the reference, m; a closed road does not repeat the first.
        right: (n,) right border at the knots as offset from the reference, m.
        left: (n,) left border there, m.
        start: offset of the lane that the initial guess follows, (n,) m; on open roads the path starts and ends on it, along the road.
        row_q: (m,) stations between the knots at which the borders are kept, the control points (3.9).
        row_tighter: (m,) by how much the borders are drawn in there, m.
    """

    corridor: Corridor
    q: Floats
    right: Floats
    left: Floats
    start: Floats
    row_q: Floats
    row_tighter: Floats

    @classmethod
    def on(cls, corridor: Corridor, start: PlanarCurve, *, spacing: float, control_points: int) -> CurvatureProblem:
        """Equal knots about `spacing` (m) apart with `control_points` between two of them; the guess is the curve `start`."""
        reference = corridor.reference
        segments = max(round(reference.length / spacing), 4)
        q = np.linspace(0.0, reference.length, segments + 1)
        inner = q[:-1, None] + np.diff(q)[:, None] * np.arange(1, control_points + 1) / (control_points + 1)
        q = q[:-1] if corridor.reference.closed else q
        right, left = corridor.offsets(q)
        points = reference.position(q)
        _, offset = start.project(points, q * start.length / reference.length)
        rows = inner.ravel()
        return cls(corridor, q, right, left, np.clip(-offset, right, left), rows, np.zeros(len(rows)))

    def with_rows(self, q: Floats, tighter: Floats) -> CurvatureProblem:
        """The same problem with further control points at stations `q`, drawn in by `tighter` (m)."""
        if self.corridor.reference.closed:
            q = np.mod(q, self.corridor.reference.length)
        return replace(self, row_q=np.concatenate([self.row_q, q]), row_tighter=np.concatenate([self.row_tighter, tighter]))

    # -- geometry ------------------------------------------------------------------------------------------------------------------

    @property
    def closed(self) -> bool:
        """True on a circuit."""
        return self.corridor.reference.closed

    @cached_property
    def breaks(self) -> Floats:
        """(segments + 1,) stations where segments meet, the end of a circuit included, m."""
        return np.append(self.q, self.corridor.reference.length) if self.closed else self.q

    @cached_property
    def h(self) -> Floats:
        """(segments,) length of each segment in the parameter, m."""
        return np.diff(self.breaks)

    @cached_property
    def ahead(self) -> Ints:
        """(segments,) index of the knot at the end of each segment."""
        return np.arange(1, len(self.h) + 1) % len(self.q)

    @cached_property
    def _normal(self) -> Floats:
        return self.corridor.reference.normal(self.q)

    @cached_property
    def _left_point(self) -> Floats:
        return self.corridor.reference.position(self.q) + self.left[:, None] * self._normal

    @cached_property
    def _across(self) -> Floats:
        """(n, 2) from the left to the right border."""
        return (self.right - self.left)[:, None] * self._normal

    @property
    def borders(self) -> tuple[Floats, Floats]:
        """Left border points (n, 2) at the knots and the vectors (n, 2) from there to the right border, m."""
        return self._left_point, self._across

    @cached_property
    def b_scale(self) -> float:
        """Second derivatives enter the solver times ten mean segments squared, which makes them of the same size as the fractions."""
        return 10.0 * float(np.mean(self.h)) ** 2

    def knots_and_bends(self, x: Floats) -> tuple[Floats, Floats]:
        """Positions (n, 2) of the knots and half second derivatives b (n, 2) there."""
        table = x.reshape(-1, 3)
        return self._left_point + self._across * table[:, 2:], table[:, :2] / self.b_scale

    def curve(self, x: Floats) -> PlanarCurve:
        """The path as a curve."""
        d, b = self.knots_and_bends(x)
        d1, b1, h = d[self.ahead], b[self.ahead], self.h[:, None]
        d0, b0 = d[: len(self.h)], b[: len(self.h)]
        coefficients = np.stack([(b1 - b0) / (3 * h), b0, (d1 - d0) / h - h * (b1 + 2 * b0) / 3, d0])
        pieces = PiecewiseCubic(self.breaks, coefficients.transpose(0, 2, 1).copy())
        return PlanarCurve.of_pieces(pieces, closed=self.closed)

    # -- cost ----------------------------------------------------------------------------------------------------------------------

    @cached_property
    def _quadrature(self) -> tuple[Floats, Floats]:
        """(segments, points) parameters within the segments and weights of the Gauss-Legendre rule."""
        half = 0.5 * self.h[:, None]
        return half * (1.0 + _NODES), half * _WEIGHTS

    def _derivatives(self, x: Floats) -> tuple[Floats, Floats]:
        """First and second derivatives (2, segments, points) of the curve at the quadrature points."""
        d, b = self.knots_and_bends(x)
        th, h = self._quadrature[0], self.h[:, None]
        b0, b1 = b[: len(self.h)].T[:, :, None], b[self.ahead].T[:, :, None]
        chord = ((d[self.ahead] - d[: len(self.h)]) / h).T[:, :, None]
        first = (2 * th - th**2 / h - 2 * h / 3) * b0 + (th**2 / h - h / 3) * b1 + chord
        return first, 2.0 * (1.0 - th / h) * b0 + 2.0 * (th / h) * b1

    def residuals(self, x: Floats) -> Floats:
        """(segments, points) residuals whose squares add up to the cost, `sqrt(w |o'|) kappa`."""
        first, second = self._derivatives(x)
        cross = first[0] * second[1] - first[1] * second[0]
        return np.sqrt(self._quadrature[1]) * cross * (first[0] ** 2 + first[1] ** 2) ** -1.25

    def cost(self, x: Floats) -> float:
        """The integral of squared curvature over arc length, 1/m."""
        return float(np.sum(self.residuals(x) ** 2))

    def gauss_newton(self, x: Floats) -> tuple[float, Floats, sp.csc_matrix]:
        """Cost, gradient (3n,) and Gauss-Newton Hessian (3n, 3n) at `x`."""
        first, second = self._derivatives(x)
        th, weight = self._quadrature
        h = self.h[:, None]
        square = first[0] ** 2 + first[1] ** 2
        cross = first[0] * second[1] - first[1] * second[0]
        root = np.sqrt(weight)
        residual = root * cross * square**-1.25
        # derivatives of the residual by o' and o'' (2, segments, points)
        by_first = root * (np.stack([second[1], -second[0]]) * square**-1.25 - 2.5 * cross * first * square**-2.25)
        by_second = root * np.stack([-first[1], first[0]]) * square**-1.25
        across0, across1 = self._across[: len(self.h)].T[:, :, None], self._across[self.ahead].T[:, :, None]
        slope0, slope1 = 2 * th - th**2 / h - 2 * h / 3, th**2 / h - h / 3
        bend0 = (by_first * slope0 + by_second * 2.0 * (1.0 - th / h)) / self.b_scale
        bend1 = (by_first * slope1 + by_second * 2.0 * (th / h)) / self.b_scale
        jacobian = np.stack(
            [bend0[0], bend0[1], np.sum(-by_first * across0, axis=0) / h, bend1[0], bend1[1], np.sum(by_first * across1, axis=0) / h], axis=-1
        )
        transposed = jacobian.transpose(0, 2, 1)
        gradient = np.bincount(self._columns.ravel(), (transposed @ residual[:, :, None]).ravel(), minlength=3 * len(self.q))
        local: Floats = 2.0 * transposed @ jacobian
        # what the equalities leave free is fixed by the cost; the floor only spares the QP solvers a singular block
        local += np.eye(6) * (1e-10 * float(local.max()))
        return float(np.sum(residual**2)), np.asarray(2.0 * gradient, dtype=np.float64), self._assemble(local)

    @cached_property
    def _columns(self) -> Ints:
        """(segments, 6) indices into x of what a segment depends on."""
        knot = np.arange(len(self.h))
        return np.column_stack([3 * knot[:, None] + np.arange(3), 3 * self.ahead[:, None] + np.arange(3)])

    @cached_property
    def _pattern(self) -> tuple[Ints, Ints, Ints]:
        """Sparsity of the Hessian: where each local entry goes, row indices, column pointers."""
        n = 3 * len(self.q)
        rows, columns = np.broadcast_arrays(self._columns[:, :, None], self._columns[:, None, :])
        keys, place = np.unique(columns.ravel() * n + rows.ravel(), return_inverse=True)
        pointers = np.searchsorted(keys, np.arange(n + 1) * n)
        return place, keys % n, pointers

    def _assemble(self, local: Floats) -> sp.csc_matrix:
        place, indices, pointers = self._pattern
        n = 3 * len(self.q)
        return sp.csc_matrix((np.bincount(place, local.ravel()), indices, pointers), shape=(n, n))

    # -- constraints ---------------------------------------------------------------------------------------------------------------

    @cached_property
    def equalities(self) -> tuple[sp.csc_matrix, Floats]:
        """A and b of A x = b: continuous slope at the knots (3.7); on open roads also place and heading at both ends.

        The fourth condition per end makes the second derivative along the road zero there, which only fixes how fast the parameter runs.
        """
        entries = _Entries()
        inner = np.arange(len(self.q)) if self.closed else np.arange(1, len(self.q) - 1)
        before, after = (inner - 1) % len(self.h), inner % len(self.h)
        prior, following = before, self.ahead[after]
        h0, h1 = self.h[before], self.h[after]
        for axis in range(2):
            bends = [(prior, h0), (inner, 2 * (h0 + h1)), (following, h1)]
            lines = [(prior, -3 / h0), (inner, 3 / h0 + 3 / h1), (following, -3 / h1)]
            constant = np.sum([weight * self._left_point[knot, axis] for knot, weight in lines], axis=0)
            entries.add(
                [(3 * knot + axis, weight / self.b_scale) for knot, weight in bends]
                + [(3 * knot + 2, weight * self._across[knot, axis]) for knot, weight in lines],
                -constant,
            )
        if not self.closed:
            self._end_conditions(entries)
        return entries.matrix(3 * len(self.q))

    def _end_conditions(self, entries: _Entries) -> None:
        tangent = self.corridor.reference.tangent(self.q)
        for end, inner, h, sign in ((0, 1, self.h[0], 1.0), (len(self.q) - 1, len(self.q) - 2, self.h[-1], -1.0)):
            normal = self._normal[end]
            # o' at the end: (d1 - d0)/h -+ h (b_inner + 2 b_end)/3
            chord = sign / h * np.array([-1.0, 1.0])
            line = [(3 * end + 2, chord[0] * self._across[end] @ normal), (3 * inner + 2, chord[1] * self._across[inner] @ normal)]
            for axis in range(2):
                line += [(3 * end + axis, -sign * 2 * h / 3 * normal[axis] / self.b_scale)]
                line += [(3 * inner + axis, -sign * h / 3 * normal[axis] / self.b_scale)]
            constant = (chord[0] * self._left_point[end] + chord[1] * self._left_point[inner]) @ normal
            # the curve starts along the lane, whose heading may differ from the reference's where the lane's offset changes
            along = (self.start[inner] - self.start[end]) / (sign * h)
            entries.add([(np.array([column]), np.array([value])) for column, value in line], np.array([along - constant]))
            entries.add([(np.array([3 * end + axis]), np.array([tangent[end, axis]])) for axis in range(2)], np.zeros(1))
            entries.add([(np.array([3 * end + 2]), np.ones(1))], np.array([self._fraction(self.start)[end]]))

    @cached_property
    def rows(self) -> tuple[sp.csc_matrix, Floats, Floats]:
        """G, lower, upper: offset of the path at the control points, in m, between the borders (3.9)."""
        segment = np.clip(np.searchsorted(self.breaks, self.row_q, side="right") - 1, 0, len(self.h) - 1)
        th, h = self.row_q - self.breaks[segment], self.h[segment]
        reference = self.corridor.reference
        normal, origin = reference.normal(self.row_q), reference.position(self.row_q)
        bend0, bend1 = th**2 - th**3 / (3 * h) - 2 * h * th / 3, th**3 / (3 * h) - h * th / 3
        line0, line1 = 1.0 - th / h, th / h
        ahead = self.ahead[segment]
        entries = _Entries()
        parts: list[tuple[Ints, Floats]] = []
        for knot, bend, line in ((segment, bend0, line0), (ahead, bend1, line1)):
            parts += [(3 * knot + axis, bend * normal[:, axis] / self.b_scale) for axis in range(2)]
            parts += [(3 * knot + 2, line * np.sum(self._across[knot] * normal, axis=1))]
        entries.add(parts, np.zeros(len(th)))
        constant = np.sum((line0[:, None] * self._left_point[segment] + line1[:, None] * self._left_point[ahead] - origin) * normal, axis=1)
        right, left = self.corridor.offsets(self.row_q)
        return entries.matrix(3 * len(self.q))[0], right + self.row_tighter - constant, left - self.row_tighter - constant

    @cached_property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper bounds on x: 0 <= alpha <= 1 (3.8), b free."""
        free = np.full(len(self.q), np.inf)
        lower, upper = np.column_stack([-free, -free, 0 * self.q]).ravel(), np.column_stack([free, free, 0 * self.q + 1.0]).ravel()
        return lower, upper

    def _fraction(self, offset: Floats) -> Floats:
        return (self.left - offset) / (self.left - self.right)

    def initial(self) -> Floats:
        """The point x that follows `start` at the knots; the second derivatives solve the equalities."""
        x = np.zeros((len(self.q), 3))
        x[:, 2] = self._fraction(self.start)
        matrix, rhs = self.equalities
        bends = np.arange(x.size) % 3 != 2
        rows = np.ones(matrix.shape[0], dtype=bool)
        if not self.closed:
            rows[[-4, -1]] = False  # the places of the ends hold already
        free = sp.csc_matrix(sp.csr_matrix(matrix)[rows])
        solution: Any = spsolve(free[:, bends], (rhs[rows] - free @ x.ravel()))
        flat = x.ravel()
        flat[bends] = solution
        return flat

    def room(self, x: Floats, step: Floats) -> float:
        """How many times `step` fits from `x` before a border is passed (by a micrometre)."""
        matrix, lower, upper = self.rows
        least, most = self.bounds
        place, move = np.concatenate([matrix @ x, x]), np.concatenate([matrix @ step, step])
        low, high = np.concatenate([lower, least]) - 1e-6, np.concatenate([upper, most]) + 1e-6
        limit = np.where(move > 0.0, high - place, low - place)
        moving = np.abs(move) > 1e-12
        return float(np.min(limit[moving] / move[moving], initial=np.inf))

    def worst_row(self, x: Floats) -> tuple[float, float]:
        """Largest violation (m) of the control points by `x`, and its station."""
        matrix, lower, upper = self.rows
        value = matrix @ x
        beyond = np.maximum(value - upper, lower - value)
        at = int(np.argmax(beyond))
        return float(beyond[at]), float(self.row_q[at])


class _Entries:
    """Rows of a sparse matrix, collected in blocks."""

    def __init__(self) -> None:
        self._rows: list[Ints] = []
        self._columns: list[Ints] = []
        self._values: list[Floats] = []
        self._rhs: list[Floats] = []
        self._count = 0

    def add(self, parts: list[tuple[Any, Any]], rhs: Floats) -> None:
        """Add len(rhs) rows; each part gives one column index and value per row."""
        for columns, values in parts:
            self._rows.append(self._count + np.arange(len(rhs)))
            self._columns.append(np.asarray(columns))
            self._values.append(np.asarray(values, dtype=np.float64))
        self._rhs.append(np.asarray(rhs, dtype=np.float64))
        self._count += len(rhs)

    def matrix(self, columns: int) -> tuple[sp.csc_matrix, Floats]:
        """The matrix with `columns` columns, and the right-hand sides."""
        place = (np.concatenate(self._rows), np.concatenate(self._columns))
        return sp.csc_matrix((np.concatenate(self._values), place), shape=(self._count, columns)), np.concatenate(self._rhs)
