"""What lies beside the reference of a route: borders of its lanes, banks, limits, and the strip that is driven."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..borders import dense, way_along
from .middle import SAME, Middle, cut

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..geometry.curve import PlanarCurve
    from .links import Link
    from .routing import Route

    Floats = NDArray[np.float64]

#: Points of borders of polylines are looked for so far beyond the part they belong to, at places so close, m.
BEYOND, CLOSE = 5.0, 0.5
#: Bends count on so long a stretch to both sides, m.
BEND = 1.5
#: A border turns back where it is longer per metre of the reference by less than this.
FOLD = 0.15


def bend_at(curve: PlanarCurve, s: Floats) -> Floats:
    """Curvature (n,) of the stretches round the stations `s`, 1/m: that of single places may be the unevenness of the points."""
    low, high = np.maximum(s - BEND, 0.0), np.minimum(s + BEND, curve.length)
    return (curve.heading(high) - curve.heading(low)) / (high - low)


class Border(NamedTuple):
    """A border measured from the reference: stations in order, offsets and heights there, (n,) each, m."""

    s: Floats
    offset: Floats
    height: Floats


@dataclass(frozen=True, eq=False)
class Part:
    """One stretch of a route measured at its stations (n,).

    Attributes:
        links: its lanes from right to left.
        ways: the direction of each, +1 along the route and -1 against it.
        right: (k, n) offsets of their right borders, m.
        left: (k, n) of their left borders, m.
        bank: (n,) rad.
        limit: (n,) m/s.
        borders: right and left border of each link, by its id.
    """

    links: list[Link]
    ways: list[int]
    right: Floats
    left: Floats
    bank: Floats
    limit: Floats
    borders: dict[str, tuple[Border, Border]]


def measured(route: Route, k: int, curve: PlanarCurve, stations: Floats, along: Floats, way: Floats) -> Part:
    """One stretch measured at `stations` (n,) of the curve, which lie at `along` (n,) on the way; `way` (m,) is that of the curve's breaks."""
    stretch, ground, tracks = route.stretches[k], route.ground, route.tracks(k)
    main = ground.links[stretch.lanes[tracks.stop - 1]]
    row = zip(main.beside or (main.id,), main.against or (False,), strict=True)
    beside = {name: against for name, against in row if name in ground.lengths}
    # neighbours of a damaged file need not know of each other
    beside |= {name: False for track in tracks if (name := stretch.lanes[track]) not in beside}
    share = np.clip((along - route.starts[k]) / (route.starts[k + 1] - route.starts[k]), 0.0, 1.0)
    borders: dict[str, tuple[Border, Border]] = {}
    for name, against in beside.items():
        link = ground.links[name]
        lines = [cut(line, (stretch.low, stretch.high), exact=link.exact) for line in _lines(link, against=against)]
        first, last = (_beside(curve, line, link, route.starts[k : k + 2], way) for line in lines)
        borders[name] = first, last
    sides = np.array([[np.interp(stations, border.s, border.offset) for border in pair] for pair in borders.values()])
    right, left = (np.interp(stations, border.s, border.offset) for border in borders[main.id])
    low, high = (np.interp(stations, border.s, border.height) for border in borders[main.id])
    return Part(
        [ground.links[name] for name in beside],
        [-1 if against else 1 for against in beside.values()],
        sides.min(axis=1),
        sides.max(axis=1),
        np.arctan2(high - low, np.maximum(left - right, 0.5)),
        main.limit_at((stretch.low + share * (stretch.high - stretch.low)) * main.length + SAME),
        borders,
    )


def strip_driven(
    route: Route, parts: dict[int, Part], curve: PlanarCurve, stations: Floats, along: Floats, way: Floats, middle: Middle
) -> tuple[Floats, Floats]:
    """Right and left border (n,) of the strip driven: those of the lane, between two where it is changed, moved where lanes are led over.

    Lanes that meet at a corner overlap inside it and gape outside: there the strip is what both cover, and leads from the one to the other.
    """
    tracks = range(max(route.tracks(k).stop for k in parts))
    rows = np.full((2, len(tracks), len(stations)), np.nan)
    for k, part in parts.items():
        for track in route.tracks(k):
            for side, border in enumerate(part.borders[route.stretches[k].lanes[track]]):
                moved = middle.moved(np.interp(border.s, curve.breaks_s, way), float(route.starts[k]))
                offset = border.offset + np.sum(moved[:, :2] * curve.normal(border.s), axis=1)
                here = slice(*np.searchsorted(stations, [border.s[0] - 1e-9, border.s[-1] + 1e-9]))
                join = np.fmax if side else np.fmin
                rows[side, track, here] = join(rows[side, track, here], np.interp(stations[here], border.s, offset))
    for row in rows.reshape(-1, len(stations)):
        there = ~np.isnan(row)
        row[:] = np.interp(stations, stations[there], row[there]) if there.any() else 0.0
    made = np.clip(route.progress(along), 0.0, len(tracks) - 1.0)
    first = np.minimum(made.astype(np.intp), max(len(tracks) - 2, 0))
    after, every = np.minimum(first + 1, len(tracks) - 1), np.arange(len(stations))
    right, left = (row[first, every] + (made - first) * (row[after, every] - row[first, every]) for row in rows)
    return np.minimum(right, left), np.maximum(right, left)


def _lines(link: Link, *, against: bool) -> tuple[Floats, Floats]:
    """Right and left border of a lane as seen along the route."""
    left, right = link.borders
    return (left[::-1], right[::-1]) if against else (right, left)


def _beside(curve: PlanarCurve, line: Floats, link: Link, ends: Floats, way: Floats) -> Border:
    """A border of the part between the `ends` along the way."""
    fine = line if link.exact else dense(line)
    s = way_along(fine)
    near = np.interp(ends[0] + s / max(s[-1], 1e-9) * (ends[1] - ends[0]), way, curve.breaks_s)
    if not link.exact:
        near = _nearest(curve, fine, np.interp(ends, way, curve.breaks_s))
    found, offset = curve.project(fine[:, :2], near)
    # inside a bend tighter than its offset a border turns back: its places are not the nearest of what they lie beside
    at_near = np.sum((fine[:, :2] - curve.position(near)) * curve.normal(near), axis=1)
    folded = 1.0 - bend_at(curve, near) * at_near < FOLD
    found, offset = np.where(folded, near, found), np.where(folded, at_near, offset)
    order = np.argsort(found, kind="stable")
    return Border(found[order], offset[order], fine[order, 2])


def _nearest(curve: PlanarCurve, line: Floats, ends: Floats) -> Floats:
    """Stations close to the feet of a border's points: borders of corners do not keep step with the middle."""
    from scipy.spatial import cKDTree

    at = np.linspace(max(ends[0] - BEYOND, 0.0), min(ends[1] + BEYOND, curve.length), max(int((ends[1] - ends[0] + 2.0 * BEYOND) / CLOSE), 2))
    return at[cKDTree(curve.position(at)).query(line[:, :2])[1]]
