"""The reduced cubic spline of problem P1: what is free, and how the curve follows from it, linearly.

Knots lie on normals of a reference curve at stations `q`. Free per knot are its offset `e` along the normal and half the second derivative `b` of the
curve there; the other spline coefficients follow from continuity, (3.3) to (3.7):

    d = reference + e n,   c = (d1 - d0) / h - h (b1 + 2 b0) / 3,   a = (b1 - b0) / (3 h).

The source's variable is the fraction `alpha = (left - e) / (left - right)` between the borders, which is the same thing with the borders inside the
matrices. With offsets, borders that move change bounds only. Second derivatives are counted along the reference's tangent and normal at the
knot, hence turning or shifting the road changes no number that a solver sees.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy.sparse as sp

from roads import PlanarCurve
from roads.geometry.cubic import PiecewiseCubic

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

#: Layouts of matrices with more entries are not kept.
_LARGE = 30_000
#: Variables per knot: second derivative along the road and across it, offset.
PER_KNOT = 3


class Basis(NamedTuple):
    """A derivative of the curve at some places as a linear map of the local variables.

    Attributes:
        segment: (k,) segment of each place.
        matrix: (k, 2, 6) by the variables of the knots before and after.
        constant: (k, 2) the part that no variable changes.
    """

    segment: Ints
    matrix: Floats
    constant: Floats


class Pattern(NamedTuple):
    """Sparsity of a matrix with one dense block per segment: where each local entry goes, row indices, column pointers."""

    place: NDArray[np.int32]
    rows: NDArray[np.int32]
    pointers: NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class ReducedSpline:
    """The spline on given knots.

    Attributes:
        reference: curve that stations and offsets refer to.
        q: (n,) stations of the knots, m; a closed road does not repeat the first.
        unit: spline parameter per metre of station; no result depends on it.
        window: an open stretch of a circuit; stations may go on beyond its end.
    """

    reference: PlanarCurve
    q: Floats
    unit: float = 1.0
    window: bool = False

    @property
    def closed(self) -> bool:
        """True on a whole circuit."""
        return self.reference.closed and not self.window

    @property
    def size(self) -> int:
        """Number of variables."""
        return PER_KNOT * len(self.q)

    @cached_property
    def breaks(self) -> Floats:
        """(segments + 1,) stations where segments meet, the end of a circuit included, m."""
        return np.append(self.q, self.q[0] + self.reference.length) if self.closed else self.q

    @cached_property
    def h(self) -> Floats:
        """(segments,) length of each segment in the spline parameter."""
        return self.unit * np.diff(self.breaks)

    @cached_property
    def ahead(self) -> Ints:
        """(segments,) index of the knot at the end of each segment."""
        return np.arange(1, len(self.h) + 1) % len(self.q)

    @cached_property
    def origin(self) -> Floats:
        """(2,) subtracted from all places, so that a road far from the origin loses no digits."""
        return self.reference.position(self.q[:1])[0]

    @cached_property
    def place(self) -> Floats:
        """(n, 2) reference at the knots, relative to `origin`, m."""
        return self.reference.position(self.q) - self.origin

    @cached_property
    def frame(self) -> tuple[Floats, Floats]:
        """Tangents (n, 2) and normals (n, 2) of the reference at the knots."""
        tangent = self.reference.tangent(self.q)
        return tangent, np.column_stack([-tangent[:, 1], tangent[:, 0]])

    @cached_property
    def kappa(self) -> Floats:
        """(n,) curvature of the reference at the knots, 1/m."""
        return self.reference.curvature(self.q)

    @cached_property
    def b_scale(self) -> Floats:
        """(n,) second derivatives enter the solver times ten local segments squared, which makes them of the size of offsets."""
        after = self.h if self.closed else np.append(self.h, self.h[-1])
        before = np.roll(self.h, 1) if self.closed else np.append(self.h[0], self.h)
        return 10.0 * (0.5 * (before + after)) ** 2

    @cached_property
    def columns(self) -> Ints:
        """(segments, 6) indices of the variables that a segment depends on."""
        knot = np.arange(len(self.h))
        three = np.arange(PER_KNOT)
        return np.column_stack([PER_KNOT * knot[:, None] + three, PER_KNOT * self.ahead[:, None] + three])

    def segment_of(self, q: Floats) -> Ints:
        """(k,) segment in which stations lie."""
        return np.clip(np.searchsorted(self.breaks, q, side="right") - 1, 0, len(self.h) - 1)

    def basis(self, q: Floats, order: int, segment: Ints | None = None) -> Basis:
        """The curve (order 0) or a derivative by the spline parameter at stations `q` (k,)."""
        k = self.segment_of(q) if segment is None else segment
        h, th = self.h[k], self.unit * (q - self.breaks[k])
        bend, line = _weights(th, h, order)
        ahead = self.ahead[k]
        tangent, normal = self.frame
        parts = []
        for knot, by_bend, by_line in ((k, bend[0], line[0]), (ahead, bend[1], line[1])):
            scaled = (by_bend / self.b_scale[knot])[:, None]
            parts += [scaled * tangent[knot], scaled * normal[knot], by_line[:, None] * normal[knot]]
        constant = line[0][:, None] * self.place[k] + line[1][:, None] * self.place[ahead]
        return Basis(k, np.stack(parts, axis=-1), constant)

    def slope_at(self, *, last: bool) -> tuple[Floats, Floats]:
        """The first derivative where an open curve begins or ends, by the variables of that segment: (2, 6), and its constant (2,)."""
        k = len(self.h) - 1 if last else 0
        h, ahead = float(self.h[k]), int(self.ahead[k])
        bends = (h / 3.0, 2.0 * h / 3.0) if last else (-2.0 * h / 3.0, -h / 3.0)
        tangent, normal = self.frame
        matrix = np.empty((2, 6))
        for at, knot, bend, line in ((0, k, bends[0], -1.0 / h), (3, ahead, bends[1], 1.0 / h)):
            scaled = bend / self.b_scale[knot]
            matrix[:, at], matrix[:, at + 1], matrix[:, at + 2] = scaled * tangent[knot], scaled * normal[knot], line * normal[knot]
        return matrix, (self.place[ahead] - self.place[k]) / h

    def values(self, basis: Basis, x: Floats) -> Floats:
        """(k, 2) what the basis gives for the variables `x`."""
        local = x[self.columns[basis.segment]]
        return np.matmul(basis.matrix, local[:, :, None])[:, :, 0] + basis.constant

    def rows(self, segment: Ints, values: Floats) -> sp.csc_matrix:
        """A sparse matrix with one row of six values (k, 6) per place."""
        return self.stacked([(self.columns[segment], values)])

    def stacked(self, parts: list[tuple[Ints, Floats]]) -> sp.csc_matrix:
        """A sparse matrix from rows of equal numbers of entries: columns (k, w) and values (k, w) of each part."""
        columns = np.concatenate([column.ravel() for column, _ in parts])
        widths = tuple(column.shape for column, _ in parts)
        values = np.concatenate([value.ravel() for _, value in parts])
        count = sum(shape[0] for shape in widths)
        make = _layout if columns.size < _LARGE else _layout.__wrapped__
        order, indices, pointers = make(columns.tobytes(), widths, self.size)
        return sp.csc_matrix((values[order], indices, pointers), shape=(count, self.size))

    def assemble(self, local: Floats) -> sp.csc_matrix:
        """Sum of the blocks (segments, 6, 6) of all segments."""
        pattern = _pattern(len(self.q), self.closed)
        values = np.bincount(pattern.place, local.ravel(), minlength=len(pattern.rows))
        return sp.csc_matrix((values, pattern.rows, pattern.pointers), shape=(self.size, self.size))

    def gather(self, local: Floats) -> Floats:
        """Sum of the vectors (segments, 6) of all segments."""
        total: Floats = np.bincount(self.columns.ravel(), local.ravel(), minlength=self.size)  # pyright: ignore[reportAssignmentType]
        return total

    def bends(self, x: Floats) -> Floats:
        """(n, 2) half second derivatives b at the knots."""
        table = x.reshape(-1, PER_KNOT)
        tangent, normal = self.frame
        return (table[:, :1] * tangent + table[:, 1:2] * normal) / self.b_scale[:, None]

    def pieces(self, x: Floats, *, relative: bool = False) -> PiecewiseCubic:
        """The curve as cubics over the station; relative to `origin` if asked for."""
        e = x[2::PER_KNOT, None]
        d, b = self.place + e * self.frame[1] + (0.0 if relative else self.origin), self.bends(x) * self.unit**2
        h = np.diff(self.breaks)[:, None]
        d0, b0, d1, b1 = d[: len(h)], b[: len(h)], d[self.ahead], b[self.ahead]
        coefficients = np.stack([(b1 - b0) / (3 * h), b0, (d1 - d0) / h - h * (b1 + 2 * b0) / 3, d0])
        return PiecewiseCubic(self.breaks, coefficients.transpose(0, 2, 1).copy())

    def curve(self, x: Floats) -> PlanarCurve:
        """The path as a curve; its parameter is the station of the reference."""
        return PlanarCurve.of_pieces(self.pieces(x), closed=self.closed)


def _weights(th: Floats, h: Floats, order: int) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """How the second derivatives and the places of the two knots enter a derivative of the curve."""
    share = th / h
    zero = np.zeros_like(th)
    if order == 0:
        return (th**2 - th**3 / (3 * h) - 2 * h * th / 3, th**3 / (3 * h) - h * th / 3), (1.0 - share, share)
    if order == 1:
        return (2 * th - th**2 / h - 2 * h / 3, th**2 / h - h / 3), (-1.0 / h, 1.0 / h)
    if order == 2:
        return (2.0 - 2.0 * share, 2.0 * share), (zero, zero)
    return (-2.0 / h, 2.0 / h), (zero, zero)


@lru_cache(maxsize=64)
def _layout(columns: bytes, widths: tuple[tuple[int, ...], ...], size: int) -> tuple[Ints, NDArray[np.int32], NDArray[np.int32]]:
    """Where the entries of rows go in column order: their order, row indices, column pointers.

    Windows of a horizon ask for the same again and again.
    """
    column = np.frombuffer(columns, dtype=np.intp)
    counts = np.concatenate([np.full(shape[0], shape[1]) for shape in widths])
    row = np.repeat(np.arange(len(counts)), counts)
    order = np.argsort(column, kind="stable")
    return order, row[order].astype(np.int32), np.searchsorted(column[order], np.arange(size + 1)).astype(np.int32)


@lru_cache(maxsize=32)
def _pattern(knots: int, closed: bool) -> Pattern:
    segments = knots if closed else knots - 1
    knot = np.arange(segments)
    three = np.arange(PER_KNOT)
    columns = np.column_stack([PER_KNOT * knot[:, None] + three, PER_KNOT * ((knot + 1) % knots)[:, None] + three])
    n = PER_KNOT * knots
    rows, across = np.broadcast_arrays(columns[:, :, None], columns[:, None, :])
    keys, place = np.unique(across.ravel() * n + rows.ravel(), return_inverse=True)
    return Pattern(place.ravel().astype(np.int32), (keys % n).astype(np.int32), np.searchsorted(keys, np.arange(n + 1) * n).astype(np.int32))
