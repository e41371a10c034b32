"""Proof that a path keeps its distance from the borders everywhere and not only at samples.

The path is cut into pieces; a piece of a cubic lies within `h^2 / 8 max |o''|` of its chord, and `o''` is linear, so that this bound is exact
arithmetic. A border is a chain of chords with a proven sag (`roads.border_line`). Two chords whose distance exceeds the required one by both sags
prove it for what they stand for; what is not proven is halved. A path that starts between the borders, touches neither and follows the
road station by station stays between them. Only the stretch of border beside a piece counts: a road may cross or approach itself.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from roads.border_line import FINE, BorderLine, border_lines

from .curvature_proof import prove_curvature
from .pieces import Pieces, cut, dot, halves, piece_of, places

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from roads import Corridor
    from roads.geometry.cubic import PiecewiseCubic

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

#: Largest sag of a border's piece, m: coarse for what is far from the borders, fine for what is close.
_COARSE, _FINE = 6e-2, FINE
#: A piece of the path with less sag than this is not halved any more, m.
_LEAST_SAG = 3e-5
#: Length of the path's pieces to begin with, at least, and below which none is halved, m.
_FIRST_PIECE, _SHORTEST = 3.0, 1e-4
#: A place of the path may lie this far along the road from the station of its parameter, m.
_DRIFT = 0.75
#: Spacing of the looks at the road itself, m, how far they go on beyond the seam of a circuit, and how far between two of them a border may be off.
_ROAD_LOOK, _SPARE, _SIDE = 1.0, 60.0, 0.03
#: Pieces of the path, and pairs of these with pieces of borders, looked at together; keeps memory bounded on long and on winding roads.
_CHUNK, _PAIRS = 1_500, 1_000_000
_NONE = np.zeros(0)


@dataclass(frozen=True, eq=False)
class Certificate:
    """What was proven.

    Attributes:
        inside: the path keeps its distance from both borders everywhere.
        beyond: bound on how far it is beyond, m; not positive where `inside`.
        where: (k,) stations of the places that could not be proven, m.
        depth: (k,) by how much the path is too close to a border there, m.
        gentle: the bound on curvature is kept everywhere.
        curvature: bound on the path's curvature, 1/m.
        bends: (k,) stations of the places where it could not be proven, m.
    """

    inside: bool
    beyond: float
    where: Floats
    depth: Floats
    gentle: bool = True
    curvature: float = np.inf
    bends: Floats = field(default_factory=lambda: _NONE)

    @property
    def certified(self) -> bool:
        """Both proofs hold."""
        return self.inside and self.gentle

    @property
    def fault(self) -> str:
        """What could not be proven, and where; empty if all was."""
        if not self.inside:
            at = int(np.argmax(self.depth))
            return f"the path could not be proven to keep its clearance near s = {self.where[at]:.1f} m: {max(self.depth[at], 0.0):.4f} m too close"
        if not self.gentle:
            return f"the path could not be proven to keep its bound on curvature near s = {self.bends[0]:.1f} m"
        return ""


class _Both(NamedTuple):
    """Both borders: corners of the right and then of the left one, what the pieces between them keep and how far they sag; where each border's
    corners begin.

    The piece that would lead from the last corner of one to the first of the other is never asked for.
    """

    s: tuple[Floats, Floats]
    arc: tuple[Floats, Floats]
    first: tuple[int, int]
    points: Floats
    keep: Floats
    sag: Floats

    @classmethod
    def of(cls, lines: tuple[BorderLine, BorderLine]) -> _Both:
        right, left = lines
        points = np.concatenate([right.points.T, left.points.T], axis=1)
        keep, sag = (np.concatenate([a, [0.0], b]) for a, b in ((right.keep, left.keep), (right.sag, left.sag)))
        return cls((right.s, left.s), (right.arc, left.arc), (0, len(right.s)), points, keep, sag)


@dataclass(frozen=True, eq=False)
class Prover:
    """Proofs about paths in one corridor; its borders are cut up once.

    Attributes:
        corridor: the corridor.
        start: proofs are wanted from this station on, m; None: everywhere.
        end: and up to this one, m.
    """

    corridor: Corridor
    start: float | None = None
    end: float | None = None

    @cached_property
    def _coarse(self) -> _Both:
        return _Both.of(border_lines(self.corridor, _COARSE, self.start, self.end))

    @cached_property
    def _fine(self) -> _Both:
        return _Both.of(border_lines(self.corridor, _FINE, self.start, self.end))

    @cached_property
    def _road(self) -> tuple[Floats, Floats]:
        """Stations (k,), and there place, tangent, right and left border of the reference (6, k)."""
        length = self.corridor.reference.length
        wrap = self.corridor.reference.closed
        start = (-_SPARE if wrap else 0.0) if self.start is None else self.start
        end = length + (_SPARE if wrap else 0.0) if self.end is None else self.end
        # where there is no margin to tell the sides apart, look closer
        look = _ROAD_LOOK if self.corridor.margin > 2.0 * _SIDE else 0.1 * _ROAD_LOOK
        s = np.linspace(start, end, max(int(np.ceil((end - start) / look)), 1) + 1)
        reference = self.corridor.reference
        place, first = reference.pieces(reference.parameter(s), 1)
        tangent = first / np.hypot(first[:, 0], first[:, 1])[:, None]
        return s, np.column_stack([place, tangent, *self.corridor.borders(s)]).T.copy()

    def prove(self, path: PiecewiseCubic, curvature_max: float = np.inf, *, start: float | None = None, end: float | None = None) -> Certificate:
        """Prove what can be proven about a path whose parameter is the station of the corridor's reference.

        Args:
            path: the path; relative to nothing, in the plane of the road.
            curvature_max: its bound on curvature, 1/m.
            start: prove from this station on, m; by default from the path's start.
            end: prove to this station, m.
        """
        breaks = path.breaks
        broken = ~np.all(np.isfinite(path.coefficients), axis=(0, 1))
        if broken.any():
            return Certificate(False, np.inf, breaks[:-1][broken], np.full(int(broken.sum()), np.inf), False, np.inf, breaks[:-1][broken])
        first, last = breaks[0] if start is None else start, breaks[-1] if end is None else end
        cuts = np.concatenate([[first], breaks[(breaks > first) & (breaks < last)], [last]])
        pieces = Pieces(cuts[:-1], cuts[1:])
        beyond, where, depth = self._borders(path, cut(pieces, _first_length(path, pieces)))
        gentle, curvature, bends = (True, np.inf, _NONE) if np.isinf(curvature_max) else prove_curvature(path, pieces, curvature_max)
        return Certificate(len(where) == 0, beyond, where, depth, gentle, curvature, bends)

    def _borders(self, path: PiecewiseCubic, base: Pieces) -> tuple[float, Floats, Floats]:
        lost, depth_lost = self._lost(path, base)
        worst, where, depth = float(np.max(depth_lost, initial=-np.inf)), [lost], [depth_lost]
        for begin in range(0, len(base.start), _CHUNK):
            found = self._part(path, Pieces(base.start[begin : begin + _CHUNK], base.end[begin : begin + _CHUNK]))
            worst = max(worst, found[0])
            where += found[1]
            depth += found[2]
        stations = np.concatenate(where)
        order = np.argsort(stations, kind="stable")
        return worst, stations[order], np.concatenate(depth)[order]

    def _lost(self, path: PiecewiseCubic, base: Pieces) -> tuple[Floats, Floats]:
        """Places that do not follow the road, which no distance from a border can vouch for: beside the wrong station, or not between the borders."""
        s = np.append(base.start, base.end[-1:])
        bad, out = self._strays(path, s)
        return s[bad], np.fmax(out, 0.0)[bad] + self.corridor.margin

    def _strays(self, path: PiecewiseCubic, s: Floats) -> tuple[NDArray[np.bool_], Floats]:
        """Which places (k,) of the path are beside the wrong station or not between the borders, and how far outside, m."""
        stations, road = self._road
        x, y, along_x, along_y, right, left = (np.interp(s, stations, values) for values in road)
        place = places(path, piece_of(path, s), s)
        gap_x, gap_y = place[0] - x, place[1] - y
        drift = np.abs(gap_x * along_x + gap_y * along_y)
        offset = along_x * gap_y - along_y * gap_x
        out = np.maximum(offset - left, right - offset)
        return ~((drift <= _DRIFT) & (out <= min(_SIDE, 0.5 * self.corridor.margin))), out  # what is no number strays too

    def _part(self, path: PiecewiseCubic, part: Pieces) -> tuple[float, list[Floats], list[Floats]]:
        """Bound on what is beyond a border, and the pieces that could not be proven."""
        margin = self.corridor.margin
        depth, _ = _depth(path, part, self._coarse, margin)
        open_ = ~(depth <= 0.0)
        worst = float(np.max(depth[~open_], initial=-np.inf))
        part = cut(Pieces(part.start[open_], part.end[open_]), 0.25 * _FIRST_PIECE)
        where, deep = [_NONE], [_NONE]
        while len(part.start):
            depth, sag = _depth(path, part, self._fine, margin)
            # a piece that swings out between two places that follow the road shows where it is halved
            stray = self._strays(path, part.start)[0] | self._strays(path, part.end)[0]
            depth = np.where(stray, np.fmax(depth, margin + 10.0 * sag), depth)
            proven = depth <= 0.0
            worst = max(worst, float(np.max(depth[proven], initial=-np.inf)))
            # too close beyond doubt and short enough to say where, or as short as makes a difference
            length = part.end - part.start
            done = ~proven & ((sag < _LEAST_SAG) | (length < _SHORTEST) | ((depth > 2.0 * sag + 2.0 * _FINE) & (length < 0.3)))
            where.append(0.5 * (part.start + part.end)[done])
            deep.append(depth[done])
            worst = max(worst, float(np.max(depth[done], initial=-np.inf)))
            rest = ~proven & ~done
            part = halves(Pieces(part.start[rest], part.end[rest]))
        return worst, where, deep


def _first_length(path: PiecewiseCubic, pieces: Pieces) -> Floats:
    """(k,) length of the parts to begin with: as long as they sag no more than what is coarse, m."""
    piece = piece_of(path, 0.5 * (pieces.start + pieces.end))
    cubic, square = 6.0 * path.coefficients[0][:, piece], 2.0 * path.coefficients[1][:, piece]
    end = cubic * np.diff(path.breaks)[piece] + square
    bend = np.sqrt(np.maximum(dot(square, square), dot(end, end)))
    return np.minimum(np.maximum(np.sqrt(8.0 * _COARSE / np.maximum(bend, 1e-9)), _FIRST_PIECE), 10.0)


def _depth(path: PiecewiseCubic, part: Pieces, both: _Both, margin: float) -> tuple[Floats, Floats]:
    """(k,) bound on how much too close each piece comes to a border, m, and the sag of the pieces."""
    ranges = [_beside(part, s, arc, margin) for s, arc in zip(both.s, both.arc, strict=True)]
    if len(part.start) > 1 and sum(int(np.sum(high - low)) for low, high in ranges) > _PAIRS:
        middle = len(part.start) // 2
        halved = Pieces(part.start[:middle], part.end[:middle]), Pieces(part.start[middle:], part.end[middle:])
        found = [_depth(path, one, both, margin) for one in halved]
        return np.concatenate([depth for depth, _ in found]), np.concatenate([sag for _, sag in found])
    piece = piece_of(path, 0.5 * (part.start + part.end))
    a, b = places(path, piece, part.start), places(path, piece, part.end)
    cubic, square = 6.0 * path.coefficients[0][:, piece], 2.0 * path.coefficients[1][:, piece]
    bends = [cubic * (s - path.breaks[piece]) + square for s in (part.start, part.end)]
    sag = (part.end - part.start) ** 2 / 8.0 * np.sqrt(np.maximum(dot(bends[0], bends[0]), dot(bends[1], bends[1])))
    low = np.concatenate([first + found[0] for first, found in zip(both.first, ranges, strict=True)])
    count = np.concatenate([np.maximum(found[1] - found[0], 1) for found in ranges])
    starts = np.cumsum(count) - count
    which = np.repeat(np.arange(len(count)), count)
    other = (low - starts)[which] + np.arange(len(which))
    which = np.where(which < len(piece), which, which - len(piece))
    distance = _distance(a, b, which, both.points, other)
    keep, spare = both.keep[other], both.sag[other]
    # where nothing needs to be kept, touching counts as beyond
    need = np.where((keep == 0.0) & (distance > 1e-6 + spare), np.minimum(spare - distance, -1e-9), keep + spare - distance)
    most = np.maximum.reduceat(need, starts)
    return np.maximum(most[: len(piece)], most[len(piece) :]) + sag, sag


def _beside(part: Pieces, s: Floats, arc: Floats, margin: float) -> tuple[Ints, Ints]:
    """Range of the border's pieces beside each piece of the path: within reach by station, and by length of border."""
    reach = margin + 1.0
    low = np.searchsorted(s, part.start - _DRIFT) - 1
    high = np.searchsorted(s, part.end + _DRIFT)
    last = len(s) - 1
    by_arc = (
        np.searchsorted(arc, arc[np.clip(low, 0, last)] - reach) - 1,
        np.searchsorted(arc, arc[np.clip(high, 0, last)] + reach),
    )
    low = np.minimum(np.searchsorted(s, part.start - reach) - 1, by_arc[0])
    high = np.maximum(np.searchsorted(s, part.end + reach), by_arc[1])
    return np.minimum(np.maximum(low, 0), last - 1), np.minimum(np.maximum(high, 1), last)


def _distance(a: Floats, b: Floats, which: Ints, corners: Floats, other: Ints) -> Floats:
    """Distance (k,) of the segments from a to b number `which` and of those from corner to corner number `other`; points (2, n)."""
    # plain arrays, one per coordinate: most of a proof's time is spent here
    (ax, ay), (cx, cy) = (values[which] for values in a), (values[other] for values in corners)
    ab = (b - a)[:, which]
    after = other + 1
    ux, uy = ab
    vx, vy = corners[0][after] - cx, corners[1][after] - cy
    px, py = cx - ax, cy - ay  # from a to c
    qx, qy = px + vx, py + vy  # from a to d
    rx, ry = ux - px, uy - py  # from c to b
    uu, vv = np.maximum(ux * ux + uy * uy, 1e-18), np.maximum(vx * vx + vy * vy, 1e-18)
    least = np.minimum(_from_line(px, py, ux, uy, uu), _from_line(qx, qy, ux, uy, uu))
    least = np.minimum(least, np.minimum(_from_line(-px, -py, vx, vy, vv), _from_line(rx, ry, vx, vy, vv)))
    crossing = ((ux * py - uy * px) * (ux * qy - uy * qx) < 0.0) & ((vy * px - vx * py) * (vx * ry - vy * rx) < 0.0)
    return np.where(crossing, 0.0, np.sqrt(least))


def _from_line(x: Floats, y: Floats, along_x: Floats, along_y: Floats, square: Floats) -> Floats:
    """Squared distance of the points (x, y) from the segments from the origin to `along`."""
    share = np.minimum(np.maximum((x * along_x + y * along_y) / square, 0.0), 1.0)
    x, y = x - share * along_x, y - share * along_y
    return x * x + y * y
