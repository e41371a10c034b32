"""Borders as chains of straight pieces with a proven distance from the true border: what proofs about paths are made of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

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
    base = _base_stations(corridor, -wrap if start is None else start, reference.length + wrap if end is None else end)
    kappa, rate = _curvature_bounds(reference, base)
    right, left = corridor.borders(base)
    return _line(corridor, base, right, kappa, rate, sag, 0), _line(corridor, base, left, kappa, rate, sag, 1)


def _base_stations(corridor: Corridor, start: float, end: float) -> Floats:
    """Stations from `start` to `end` between which the reference is one cubic and the offset linear, m."""
    reference = corridor.reference
    length = reference.length
    if not reference.closed:
        start, end = max(start, 0.0), min(end, length)
    s = np.union1d(corridor.s, reference.breaks_s)
    turns = np.arange(np.floor(start / length), np.floor(end / length) + 1.0) if reference.closed else np.zeros(1)
    near = [s[np.searchsorted(s, start - turn * length) : np.searchsorted(s, end - turn * length)] + turn * length for turn in turns]
    every = np.concatenate([[start], *near, [end]])
    # two stations a rounding apart may hold a step of the border
    return np.unique(every)


def _curvature_bounds(reference: PlanarCurve, base: Floats) -> tuple[Floats, Floats]:
    """Bounds (k - 1,) on curvature and its rate between the base stations."""
    pieces = reference.pieces
    h = np.diff(pieces.breaks)
    a, b, c, _ = pieces.coefficients
    # Bernstein coefficients of the first derivative; their least component along the chord bounds the speed from below
    control = np.stack([c, c + b * h, c + 2 * b * h + 3 * a * h**2])
    chord = control.mean(axis=0)
    chord = chord / np.hypot(*chord)
    slowest = np.maximum(np.min(np.sum(control * chord, axis=1), axis=0), 1e-3)
    second = np.maximum(np.hypot(*(2 * b)), np.hypot(*(2 * b + 6 * a * h)))
    third = np.hypot(*(6 * a))
    kappa = second / slowest**2
    rate = third / slowest**3 + 3 * kappa * second / slowest**2
    middle = 0.5 * (base[1:] + base[:-1])
    if reference.closed:
        middle = np.mod(middle, reference.length)
    piece = np.clip(np.searchsorted(reference.breaks_s, middle, side="right") - 1, 0, len(h) - 1)
    return kappa[piece], rate[piece]


def _line(corridor: Corridor, base: Floats, w: Floats, kappa: Floats, rate: Floats, sag: float, which: int) -> BorderLine:
    step, wide = np.diff(base), np.maximum(np.abs(w[1:]), np.abs(w[:-1]))
    slope = np.diff(w) / np.maximum(step, 1e-12)
    second = rate * wide + 2 * kappa * np.abs(slope) + kappa * (1.0 + kappa * wide)
    count = np.maximum(np.ceil(np.maximum(step * np.sqrt(second / (8.0 * sag)), step / _LONGEST)), 1.0).astype(np.intp)
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
