"""Borders as chains of straight pieces with a proven distance from the true border: what proofs about paths are made of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .errors import RoadError
from .geometry.cubic import counted_from

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .corridor import Corridor
    from .geometry.curve import PlanarCurve

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

#: A border that turns back on itself, inside a bend tighter than its offset, is left out; there the strip ends at this fraction of the bend's radius.
LAST_FOLD = 0.95
#: Metres of a circuit that its border goes on beyond the seam, both ways.
_WRAP = 60.0
#: No piece is longer, m.
_LONGEST = 5.0
#: Corners worked out together, which bounds the memory on long roads.
_CHUNK = 20_000
#: A border that needs more corners per metre than this, over at least so many metres, belongs to a line that turns on the spot (3 m beside it: with a
#: radius of a centimetre), or winds all along. Roads need three to thirty. Work and memory of a proof are bounded by this and the length.
_MOST_CORNERS = ((1.0, 3_000.0), (200.0, 200.0))
#: A piece of the reference whose least speed along its chord is below this share of the largest is cut into so many parts to bound its curvature.
_CRUDE, _PARTS = 0.5, 16
#: What a proof needs at least, m: borders are asked about with this sag before anything is planned.
FINE = 2e-4


@dataclass(frozen=True, eq=False)
class BorderLine:
    """A border as straight pieces.

    Attributes:
        s: (k,) stations of the corners, m; on a circuit also some before the start and after the end.
        points: (k, 2) corners, m.
        arc: (k,) length along the border, m.
        keep: (k - 1,) distance that a path must keep from each piece, m.
        sag: (k - 1,) bound on the distance between the piece and the border, m.
    """

    s: Floats
    points: Floats
    arc: Floats
    keep: Floats
    sag: Floats


def border_lines(corridor: Corridor, sag: float, start: float | None = None, end: float | None = None) -> tuple[BorderLine, BorderLine]:
    """The right and the left border of `corridor` with at most `sag` (m) between pieces and border.

    The border is `B(s) = r(s) + w(s) n(s)` with `w` linear between the data, hence `|B''| <= |kappa' w + 2 kappa w'| + |kappa (1 - kappa w)|`, and
    a chord of `h` stations lies within `h^2 / 8 max |B''|` of it. Curvatures are bounded per piece of the reference by its Bernstein coefficients.

    Args:
        corridor: whose borders.
        sag: see above, m.
        start: station from which they are wanted, m; by default all, on a circuit with some before the start.
        end: station to which they are wanted; on a circuit it may lie beyond its end.
    """
    reference = corridor.reference
    wrap = min(_WRAP, reference.length) if reference.closed else 0.0
    bends = _Bends.of(reference)
    base = _base_stations(corridor, bends, -wrap if start is None else start, reference.length + wrap if end is None else end)
    kappa, rate = bends.between(base, closed=reference.closed)
    right, left = corridor.borders(base)
    return _line(corridor, base, right, kappa, rate, sag, 0), _line(corridor, base, left, kappa, rate, sag, 1)


class _Bends(NamedTuple):
    """Bounds on curvature (k,) and its rate (k,) along a reference, between the stations `s` (k + 1,)."""

    s: Floats
    kappa: Floats
    rate: Floats

    @classmethod
    def of(cls, reference: PlanarCurve) -> _Bends:
        """Bounds by the Bernstein coefficients of the derivative; a piece that turns far from its chord is cut up, since there they are crude."""
        pieces = reference.pieces
        control, slowest = _controls(pieces.coefficients, np.diff(pieces.breaks))
        crude = slowest < _CRUDE * np.max(np.hypot(*control.swapaxes(0, 1)), axis=0)
        parts = np.where(crude, _PARTS, 1)
        piece = np.repeat(np.arange(len(parts)), parts)
        share = (np.arange(len(piece)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[piece]
        th, h = share * np.diff(pieces.breaks)[piece], (np.diff(pieces.breaks) / parts)[piece]
        rows = counted_from(th, pieces.coefficients[:, :, piece])
        _, slowest = _controls(rows, h)
        slowest = np.maximum(slowest, 1e-3)
        second = np.maximum(np.hypot(*(2 * rows[1])), np.hypot(*(2 * rows[1] + 6 * rows[0] * h)))
        third = np.hypot(*(6 * rows[0]))
        s = reference.breaks_s[piece]
        inner = share > 0.0
        s[inner] = reference.station((pieces.breaks[piece] + th)[inner])
        return cls(np.append(s, reference.length), second / slowest**2, third / slowest**3 + 3 * second**2 / slowest**4)

    def between(self, base: Floats, *, closed: bool) -> tuple[Floats, Floats]:
        """The bounds (k - 1,) between `base` stations (k,), which hold all of `s`."""
        middle = 0.5 * (base[1:] + base[:-1])
        part = np.searchsorted(self.s, np.mod(middle, self.s[-1]) if closed else middle, side="right") - 1
        part = np.clip(part, 0, len(self.kappa) - 1)
        return self.kappa[part], self.rate[part]


def _controls(coefficients: Floats, h: Floats) -> tuple[Floats, Floats]:
    """Bernstein coefficients (3, 2, k) of the first derivative of cubics of length `h`, and the least of their components along the chord, which
    bounds the speed from below."""
    a, b, c, _ = coefficients
    control = np.stack([c, c + b * h, c + 2 * b * h + 3 * a * h**2])
    chord = control.mean(axis=0)
    chord = chord / np.maximum(np.hypot(*chord), 1e-12)
    return control, np.min(np.sum(control * chord, axis=1), axis=0)


def _base_stations(corridor: Corridor, bends: _Bends, start: float, end: float) -> Floats:
    """Stations from `start` to `end` between which the reference is one cubic and the offset linear, m."""
    reference = corridor.reference
    length = reference.length
    if not reference.closed:
        start, end = max(start, 0.0), min(end, length)
    s = np.union1d(corridor.s, bends.s)
    turns = np.arange(np.floor(start / length), np.floor(end / length) + 1.0) if reference.closed else np.zeros(1)
    near = [s[np.searchsorted(s, start - turn * length) : np.searchsorted(s, end - turn * length)] + turn * length for turn in turns]
    every = np.concatenate([[start], *near, [end]])
    # two stations a rounding apart may hold a step of the border
    return np.unique(every)


def refuse_turning_back(corridor: Corridor) -> None:
    """Refuse a corridor about a line that turns back on itself, beside which there are no borders; takes a millisecond per kilometre.

    A line that folds over its own way (points out of order, a road driven out and back, a place far off among others) turns on the spot. What is
    tight only, so that the inner border folds, is none of this: there the border is drawn in, see `LAST_FOLD`.

    Raises:
        RoadError: the station and the place where it turns, and by how much.
    """
    bends = _Bends.of(corridor.reference)
    base = _base_stations(corridor, bends, 0.0, corridor.reference.length)
    kappa, rate = bends.between(base, closed=corridor.reference.closed)
    for w in corridor.borders(base):
        step = np.diff(base)
        _refuse_too_many(corridor, base, step * np.sqrt(_second(step, w, kappa, rate) / (8.0 * FINE)))


def _second(step: Floats, w: Floats, kappa: Floats, rate: Floats) -> Floats:
    """Bound (k,) on a border's second derivative between base stations `step` apart, with offsets `w` (k + 1,)."""
    wide, slope = np.maximum(np.abs(w[1:]), np.abs(w[:-1])), np.diff(w) / np.maximum(step, 1e-12)
    return rate * wide + 2 * kappa * np.abs(slope) + kappa * (1.0 + kappa * wide)


def _refuse_too_many(corridor: Corridor, base: Floats, corners: Floats) -> None:
    """Raise RoadError where more `corners` (k,) are needed between base stations than any road needs."""
    passed = np.concatenate([[0.0], np.cumsum(corners)])
    for stretch, most in _MOST_CORNERS:
        # neighbours count together: short pieces may need many per metre, not many in all
        end = np.maximum(base[1:], np.minimum(base[:-1] + stretch, base[-1]))
        density = (np.interp(end, base, passed) - passed[:-1]) / np.maximum(end - base[:-1], stretch)
        if not np.all(density <= most):
            at = int(np.argmax(~(density <= most)))
            worst = at + int(np.argmax(corners[at : max(int(np.searchsorted(base, end[at])), at + 1)]))
            raise RoadError(_turning_words(corridor, float(base[worst]), float(base[worst + 1])))


def _turning_words(corridor: Corridor, start: float, end: float) -> str:
    reference, look = corridor.reference, np.linspace(start - 0.5, end + 0.5, 2001)
    look = look if reference.closed else np.clip(look, 0.0, reference.length)
    kappa, turn = np.abs(reference.curvature(look)), np.degrees(np.ptp(reference.heading(look)))
    at = start if start + 0.5 >= end else float(look[np.argmax(kappa)]) % reference.length
    x, y = reference.position(at)
    return (
        f"{corridor.name}: the road's line turns back on itself near s = {at:z.1f} m, at ({x:z.1f}, {y:z.1f}) m: by {turn:z.0f} degrees within "
        f"{look[-1] - look[0]:z.1f} m, with a radius down to {1.0 / max(float(np.max(kappa)), 1e-9):.2g} m; expected a line that a car can follow"
    )


def _line(corridor: Corridor, base: Floats, w: Floats, kappa: Floats, rate: Floats, sag: float, which: int) -> BorderLine:
    step = np.diff(base)
    second = _second(step, w, kappa, rate)
    corners = step * np.sqrt(second / (8.0 * sag))
    _refuse_too_many(corridor, base, corners * np.sqrt(sag / max(sag, FINE)))
    count = np.maximum(np.ceil(np.maximum(corners, step / _LONGEST)), 1.0).astype(np.intp)
    total = int(count.sum())
    s, points, folded = np.empty(total + 1), np.empty((total + 1, 2)), np.empty(total + 1, dtype=bool)
    ends = np.cumsum(count)
    for begin in range(0, total + 1, _CHUNK):
        part = slice(begin, min(begin + _CHUNK, total + 1))
        index = np.arange(part.start, part.stop)
        at = np.minimum(np.searchsorted(ends, index, side="right"), len(step) - 1)
        share = (index - (ends[at] - count[at])) / count[at]
        s[part] = np.where(share < 1.0, base[at] + step[at] * share, base[at + 1])
        points[part], folded[part] = _beside(corridor, s[part], w[at] + (w[at + 1] - w[at]) * share, 1.0 if which else -1.0)
    keep = np.where(folded[:-1] & folded[1:], 0.0, corridor.margin)
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    return BorderLine(s, points, arc, keep, np.repeat((step / count) ** 2 / 8.0 * second, count))


def _beside(corridor: Corridor, s: Floats, offset: Floats, side: float) -> tuple[Floats, NDArray[np.bool_]]:
    """Places (k, 2) beside the reference, where they fold drawn in to the last fold, and where that is."""
    reference = corridor.reference
    place, first, second = reference.pieces(reference.parameter(s), 2)
    speed = np.hypot(first[:, 0], first[:, 1])
    bend = (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / speed**3 * side
    end = np.where(bend > 0.0, LAST_FOLD / np.maximum(bend, 1e-9), np.inf)
    folded = side * offset > end
    offset = np.where(folded, side * end, offset)
    return place + (offset / speed)[:, None] * np.column_stack([-first[:, 1], first[:, 0]]), folded
