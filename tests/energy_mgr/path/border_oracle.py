"""How close a curve comes to the borders of a road, and how much it bends, without the package's own checks.

How folds are treated: where a border lies beyond the centre of curvature of a bend its offset line runs backwards. The road is the strip that
the cross-sections sweep over, its edge the envelope. So a piece of border counts only where it runs forwards and does not lie within the strip of
neighbouring cross-sections, and a point is on the road where a neighbouring cross-section goes through it. Where cross-sections reach over each
other there may be no inside edge at all. The corridor's rule that offsets end at 0.9 of the radius is no edge and is not checked here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from roads import PlanarCurve, Road
from roads.road import Extent

Floats = NDArray[np.float64]

#: A border counts for a point of the curve up to this far along the road, and up to a block further, m: in a bend of 6 m just over a right angle.
WINDOW, BLOCK = 10.0, 5.0
#: A place hides a border if it lies within the strip by more than the error of chords of 0.1 m, up to this far along the road, m.
INSIDE, REACH = 0.005, 20.0
#: Roads with ends are continued straight this far, closed ones over the seam, so that a curve need not begin and end exactly with the road, m.
RUN_OUT, ROUND = 2.0, 60.0
#: The curve is followed in steps of this much; a step leads on along the road by at most 4 m, 20 times as far inside a bend, m.
STEP, AHEAD = 0.2, 4.0
#: A curve may also cut a fold, from one leg of a bend straight to the other: up to this far on along the road, to where the reference leads the
#: same way to within 45 degrees, m.
CUT = 25.0


def worst_border_gap(road: Road, extent: Extent, curve: PlanarCurve, *, spacing: float = 0.02) -> tuple[float, float]:
    """The least distance in m from `curve` to a border of `road`, negative where the curve is off the strip, and the curve's station of it.

    The curve begins near the start of the road and leads along it; borders that are far along the road are not seen, so that a road may cross
    itself. Beyond 2 m before the start and after the end of a road there is no strip.
    """
    along = np.linspace(0.0, curve.length, max(int(np.ceil(curve.length / spacing)), 1) + 1)
    points, strip = curve.position(along), _Strip.of(road, extent)
    counts = strip.counts(0), strip.counts(1)
    s = _followed(strip, points, max(round(STEP / spacing), 1), min(REACH, 0.5 * road.length))
    gap = np.full(len(points), np.inf)
    for start in np.arange(s[0], s[-1] + BLOCK, BLOCK):
        here = slice(*np.searchsorted(s, [start, start + BLOCK]))
        low, high = start - WINDOW, start + BLOCK + WINDOW
        for side in (0, 1):
            gap[here] = np.minimum(gap[here], _distance(strip, side, counts[side], points[here], low, high))
        gap[here] *= np.where(strip.holds(points[here], low, high), 1.0, -1.0)
    at = int(np.argmin(gap))
    return float(gap[at]), float(along[at])


def curvature_extreme(curve: PlanarCurve, spacing: float = 0.1) -> float:
    """The largest curvature in 1/m, of circles through three neighbours of points a tenth of `spacing` (m) apart."""
    count = max(int(np.ceil(10.0 * curve.length / spacing)), 3)
    points = curve.position(np.linspace(0.0, curve.length, count + 1))
    if curve.closed:
        points = np.vstack([points, points[1:2]])
    before, after = points[1:-1] - points[:-2], points[2:] - points[1:-1]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return float(np.max(np.abs(2.0 * cross) / (np.hypot(*before.T) * np.hypot(*after.T) * np.hypot(*(before + after).T))))


@dataclass(frozen=True)
class _Strip:
    """A road's cross-sections every centimetre and at its data: stations (n,), places and tangents (n, 2), per border offsets and points."""

    s: Floats
    place: Floats
    tangent: Floats
    offsets: tuple[Floats, Floats]
    borders: tuple[Floats, Floats]

    @classmethod
    def of(cls, road: Road, extent: Extent) -> _Strip:
        corridor, length, closed = road.corridor(extent, 0.0), road.length, road.closed
        low, high = (-ROUND, length + ROUND) if closed else (-RUN_OUT, length + RUN_OUT)
        data = (road.s + length * np.arange(-10, 11)[:, None]).ravel() if closed else road.s
        s = np.unique(np.concatenate([np.linspace(low, high, int((high - low) / 0.01) + 1), data[(data > low) & (data < high)]]))
        s = s[np.append(True, np.diff(s) > 1e-6)]
        on = s if closed else np.clip(s, 0.0, length)
        tangent = road.reference.tangent(on)
        place = road.reference.position(on) + (s - on)[:, None] * tangent
        normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
        right, left = corridor.borders(on)
        return cls(s, place, tangent, (right, left), (place + right[:, None] * normal, place + left[:, None] * normal))

    def holds(self, points: Floats, low: float, high: float, depth: float = 0.0) -> NDArray[np.bool_]:
        """Which of `points` (k, 2) some cross-section between stations `low` and `high` goes through, `depth` inside its borders."""
        at = slice(*np.searchsorted(self.s, [low, high]), 10)
        place, tangent = self.place[at], self.tangent[at]
        ahead = points @ tangent.T - np.sum(place * tangent, axis=1)
        front = ahead >= 0.0
        k, m = np.nonzero(front[:, :-1] != front[:, 1:])
        gap, way = points[k, None] - np.stack([place[m], place[m + 1]], axis=1), np.stack([tangent[m], tangent[m + 1]], axis=1)
        aside = gap[..., 1] * way[..., 0] - gap[..., 0] * way[..., 1]
        part = ahead[k, m] / (ahead[k, m] - ahead[k, m + 1])
        right, left = ((1.0 - part) * line[at][m] + part * line[at][m + 1] for line in self.offsets)
        offset = (1.0 - part) * aside[:, 0] + part * aside[:, 1]
        held = np.zeros(len(points), dtype=bool)
        held[k[(offset >= right + depth) & (offset <= left - depth)]] = True
        return held

    def counts(self, side: int) -> NDArray[np.bool_]:
        """Which points (n,) of a border are edge of the road: those that run forwards and, near a fold, lie in no other cross-section."""
        forwards = np.sum(np.diff(self.borders[side], axis=0) * self.tangent[:-1], axis=1) > 0.0
        good = np.append(forwards, True) & np.append(True, forwards)
        folds = self.s[~good]
        for start in np.arange(self.s[0], self.s[-1], BLOCK):
            first, last = np.searchsorted(self.s, [start, start + BLOCK])
            if np.any((folds > start - REACH) & (folds < start + BLOCK + REACH)):
                good[first:last] &= ~self.holds(self.borders[side][first:last], start - REACH, start + BLOCK + REACH, INSIDE)
        return good


def _followed(strip: _Strip, points: Floats, every: int, search: float) -> Floats:
    """Stations (n,) of `points` along the road: each the nearest a little ahead of the one before, never back."""
    s, place, tangent = strip.s[::5], strip.place[::5], strip.tangent[::5]
    index = np.unique(np.append(np.arange(0, len(points), every), len(points) - 1))
    ways = np.gradient(points[index], axis=0)
    low, ahead = (int(at) for at in np.searchsorted(s, [-search, search]))
    ahead -= low
    found = []
    for point, way in zip(points[index], ways, strict=True):
        cut = slice(low, low + int(CUT / 0.05))
        reachable = tangent[cut] @ way > np.hypot(*way) / np.sqrt(2.0)
        reachable[:ahead] = True
        low += int(np.argmin(np.where(reachable, np.hypot(*(place[cut] - point).T), np.inf)))
        ahead = int(AHEAD / 0.05)
        found.append(s[low])
    return np.interp(np.arange(len(points)), index, found)


def _distance(strip: _Strip, side: int, counts: NDArray[np.bool_], points: Floats, low: float, high: float) -> Floats:
    """Distance (k,) of `points` to what counts of one border between two stations; inf where nothing does."""
    first, last = np.searchsorted(strip.s, [low, high])
    usable = first + np.flatnonzero(counts[first:last])
    if not len(points) or not len(usable):
        return np.full(len(points), np.inf)
    line = strip.borders[side]
    least, nearest = cKDTree(line[usable], balanced_tree=False, compact_nodes=False).query(points)
    at = usable[nearest]
    for other in (np.maximum(at - 1, 0), np.minimum(at + 1, len(line) - 1)):
        # the nearest place lies between two points, unless the border ends at this one
        chord = np.where(counts[other][:, None], line[other] - line[at], 0.0)
        gap = points - line[at]
        share = np.clip(np.sum(gap * chord, axis=1) / np.maximum(np.sum(chord**2, axis=1), 1e-18), 0.0, 1.0)
        least = np.minimum(least, np.hypot(*(gap - share[:, None] * chord).T))
    return least
