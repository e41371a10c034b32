"""The line that is driven along a route: the middles of its lanes, changed between and led over smoothly where they do not quite meet."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..borders import spaced, way_along
from ..geometry.curve import PlanarCurve
from .routing import eased

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .routing import Route

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

#: The reference is not drawn through points closer than this, m.
NEAREST = 0.02
#: Nor that of polylines, whose ends are often jagged, closer than this, m.
JAGGED = 0.15
#: Middles of lanes that meet within this are the same place, m; heights may differ by more before they are led over.
SAME, LEVEL = 2e-3, 0.02
#: What lanes miss each other by is led over within this stretch after the joint, m.
BLEND = 30.0
#: Where the route ends before that it begins earlier, so that the stretch is at least so long: at all, and per metre missed, m.
LEAST_BLEND, PER_METRE = 6.0, 8.0
#: Places on stretches where lanes are changed or led over are so close, m.
FINE = 0.5


@dataclass(frozen=True, eq=False)
class Middle:
    """The line driven.

    Attributes:
        points: (n, 3) m.
        way: (n,) m along the way of the route.
        owner: (n,) index of the stretch that each point belongs to, a joint to the one that begins there.
        misses: (distance, from, to, (3,) gap) of every joint that is led over, m along the way.
    """

    points: Floats
    way: Floats
    owner: Ints
    misses: list[tuple[float, float, float, Floats]]

    def moved(self, way: Floats, start: float) -> Floats:
        """(n, 3) by how much the line lies beside the middles of the lanes of the stretch from `start` on at places along the way."""
        return _moved(self.misses, way, start)


def middle_of(route: Route) -> Middle:
    """The line driven along `route`; without points where it is no longer than a few centimetres."""
    kept = [k for k in range(len(route.stretches)) if route.starts[k + 1] - route.starts[k] >= NEAREST]
    lines = [_line(route, k) for k in kept]
    misses = []
    for k, ((before, _), (after, _)) in enumerate(itertools.pairwise(lines)):
        miss = before[-1] - after[0]
        far = float(np.hypot(miss[0], miss[1]))
        if far > SAME or abs(miss[2]) > LEVEL:
            at, last = float(route.starts[kept[k + 1]]), float(route.starts[-1])
            end = min(at + BLEND, last)
            begin = min(at, max(end - LEAST_BLEND - PER_METRE * far, 0.0))
            misses.append((at, begin, end, miss))
    points, ways, owner = [], [], []
    for k, (line, way) in zip(kept, lines, strict=True):
        for _, begin, end, _ in misses:
            if begin < way[-1] and end > way[0]:
                line, way = _finer(line, way, begin, end)
        points.append(line)
        ways.append(way)
        owner.append(np.full(len(line), k))
    if not points:
        return Middle(np.zeros((0, 3)), np.zeros(0), np.zeros(0, dtype=np.intp), [])
    # the ends of a stretch are counted from its own side of the joint
    line = np.concatenate([part + _moved(misses, at, k) for part, at, k in zip(points, ways, (route.starts[item] for item in kept), strict=True)])
    exact = all(route.ground.links[name].exact for stretch in route.stretches for name in stretch.lanes.values())
    keep = _apart(line, own := np.concatenate(owner), NEAREST if exact else JAGGED)
    return Middle(line[keep], np.concatenate(ways)[keep], own[keep], misses)


def _moved(misses: list[tuple[float, float, float, Floats]], way: Floats, start: float) -> Floats:
    """What joints move places along the way by, those of the stretch that begins at `start`."""
    made = np.zeros((len(way), 3))
    for at, begin, end, miss in misses:
        share = eased(np.clip((way - begin) / max(end - begin, 1e-9), 0.0, 1.0))
        made += (1.0 - share if start >= at - 1e-9 else -share)[:, None] * miss
    return made


def _line(route: Route, k: int) -> tuple[Floats, Floats]:
    """The middle driven on one stretch (n, 3), and distances along the way (n,)."""
    stretch, tracks = route.stretches[k], route.tracks(k)
    start, length = float(route.starts[k]), float(route.starts[k + 1] - route.starts[k])
    links = [route.ground.links[stretch.lanes[track]] for track in tracks]
    middles = [cut(link.centre, (stretch.low, stretch.high), exact=link.exact) for link in links]
    s = way_along(middles[0])
    way = start + s * (length / s[-1])
    if len(middles) == 1:
        return middles[0], way
    for change in route.changes[tracks.start : tracks.stop - 1]:
        low, high = max(change.begin, start), min(change.end, start + length)
        if low < high:
            way = _with_grid(way, low, high, min(2.0 * FINE, (high - low) / 50.0))
    share = (way - start) / length
    places = np.array([along(line, share) for line in middles])
    made = np.clip(route.progress(way) - tracks.start, 0.0, len(middles) - 1.0)
    first = np.minimum(made.astype(np.intp), len(middles) - 2)
    part, every = (made - first)[:, None], np.arange(len(way))
    return (1.0 - part) * places[first, every] + part * places[first + 1, every], way


def _with_grid(way: Floats, low: float, high: float, spacing: float) -> Floats:
    """`way` with an even grid from `low` to `high` instead of its own places there; its ends stay.

    Beside the grid there are places at doubling distances, without which a spline would swing out over long pieces.
    """
    grid = np.linspace(low, high, max(int(np.ceil((high - low) / spacing)), 12) + 1)
    beyond = spacing * (2.0 ** np.arange(1, 24) - 1.0)
    beyond = beyond[beyond < 2.0 * (way[-1] - way[0])]
    marks = np.concatenate([low - beyond, grid, high + beyond])
    outside = way[(way < low - 0.5 * spacing) | (way > high + 0.5 * spacing)]
    made = np.union1d(outside, marks[(marks > way[0]) & (marks < way[-1])])
    # a mark gives way to a place nearby, the ends and the grid do not
    made = made[np.append(True, np.diff(made) > 1e-6)]
    return np.union1d(made, way[[0, -1]]).astype(np.float64)


def _finer(line: Floats, way: Floats, begin: float, end: float) -> tuple[Floats, Floats]:
    made = _with_grid(way, max(begin, way[0]), min(end, way[-1]), FINE)
    return along(line, (made - way[0]) / (way[-1] - way[0])), made


def cut(line: Floats, share: tuple[float, float], *, exact: bool) -> Floats:
    """The part of `line` between two shares of its length; new ends lie on its curve (`exact`) or on the polyline."""
    if share == (0.0, 1.0):
        return line
    s = way_along(line)
    low, high = share[0] * s[-1], share[1] * s[-1]
    inner = (s > low + 1e-6) & (s < high - 1e-6)
    at = np.concatenate([[low], s[inner], [high]])
    made = np.column_stack([np.interp(at, s, line[:, axis]) for axis in range(3)])
    if exact and len(line) > 2 and s[-1] > 4.0 * NEAREST:
        made[[0, -1]] = along(line, np.array(share))
    return made


def along(line: Floats, share: Floats) -> Floats:
    """Places (n, 3) at shares of the length of `line`: on the spline through its points, heights linear."""
    s = way_along(line)
    keep = spaced(s, NEAREST)
    if np.count_nonzero(keep) < 2 or s[-1] < 2.0 * NEAREST:
        return np.column_stack([np.interp(share * s[-1], s, line[:, axis]) for axis in range(3)])
    curve = PlanarCurve.through(line[keep, :2])
    # the spline's own length runs a little ahead of the polyline's
    at = np.interp(share * s[-1], s[keep], curve.breaks_s)
    return np.column_stack([curve.position(at), np.interp(share * s[-1], s, line[:, 2])])


def _apart(line: Floats, owner: Ints, nearest: float) -> NDArray[np.bool_]:
    """Which points to keep so that none nearly repeats the one before."""
    keep = np.ones(len(line), dtype=bool)
    last = len(line) - 1
    for k in (np.flatnonzero(np.hypot(*np.diff(line[:, :2], axis=0).T) < nearest) + 1).tolist():
        here = k - 1
        while not keep[here]:
            here -= 1
        if np.hypot(line[k, 0] - line[here, 0], line[k, 1] - line[here, 1]) >= nearest:
            continue
        if k == last or owner[k] != owner[here]:
            # the end and the joints stay, the point just before them goes, unless it is the start
            keep[here] = here == 0
        else:
            keep[k] = False
    return keep
