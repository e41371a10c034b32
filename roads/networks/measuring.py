"""What lies beside the reference of a route: borders of its lanes, banks, limits, and the strip that is driven."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

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
#: A border turns back where it is longer per metre of the reference by less than this.
FOLD = 0.15


@dataclass(frozen=True, eq=False)
class Part:
    """One cross-section run, measured at its stations (n,): lanes (k, n) from right to left."""

    links: list[Link]
    ways: list[int]
    right: Floats
    left: Floats
    bank: Floats
    limit: Floats
    strip: tuple[Floats, Floats]


def measured(route: Route, k: int, curve: PlanarCurve, stations: Floats, along: Floats, way: Floats, middle: Middle) -> Part:
    """One stretch measured at `stations` (n,) of the curve, which lie at `along` (n,) on the way; `way` (m,) is that of the curve's breaks."""
    stretch, ground, tracks = route.stretches[k], route.ground, route.tracks(k)
    main = ground.links[stretch.lanes[tracks.stop - 1]]
    beside = dict(zip(main.beside or (main.id,), main.against or (False,), strict=True))
    # neighbours of a damaged file need not know of each other
    beside |= {name: False for track in tracks if (name := stretch.lanes[track]) not in beside}
    length = route.starts[k + 1] - route.starts[k]
    share = np.clip((along - route.starts[k]) / length, 0.0, 1.0)
    links, rows, bank = [ground.links[name] for name in beside], [], np.zeros(len(stations))
    for link, against in zip(links, beside.values(), strict=True):
        sides = [
            _beside(curve, cut(line, (stretch.low, stretch.high), exact=link.exact), link, stations, route.starts[k : k + 2], way)
            for line in _borders(link, against=against)
        ]
        rows.append([np.minimum(*(offset for offset, _ in sides)), np.maximum(*(offset for offset, _ in sides))])
        if link is main:
            (right, low), (left, high) = sides
            bank = np.arctan2(high - low, np.maximum(left - right, 0.5))
    right, left = np.array(rows).transpose(1, 0, 2)
    moved = np.sum(middle.moved(along)[:, :2] * curve.normal(stations), axis=1)
    order = {name: row for row, name in enumerate(beside)}
    driven = [order[stretch.lanes[track]] for track in tracks]
    made = np.clip(route.progress(along) - tracks.start, 0.0, len(driven) - 1.0)
    strip = tuple(_mixed(side[driven], made) + moved for side in (right, left))
    limit = main.limit_at((stretch.low + share * (stretch.high - stretch.low)) * main.length + SAME)
    return Part(links, [-1 if against else 1 for against in beside.values()], right, left, bank, limit, strip)  # pyright: ignore[reportArgumentType]


def _borders(link: Link, *, against: bool) -> tuple[Floats, Floats]:
    """Right and left border of a lane as seen along the route."""
    left, right = link.borders
    return (left[::-1], right[::-1]) if against else (right, left)


def _mixed(rows: Floats, made: Floats) -> Floats:
    """Values (n,) between the rows (k, n) by how many changes were made."""
    if len(rows) == 1:
        return rows[0]
    first = np.minimum(made.astype(np.intp), len(rows) - 2)
    every = np.arange(rows.shape[1])
    return rows[first, every] + (made - first) * (rows[first + 1, every] - rows[first, every])


def _beside(curve: PlanarCurve, line: Floats, link: Link, stations: Floats, ends: Floats, way: Floats) -> tuple[Floats, Floats]:
    """Offset and height (n,) of a border at `stations`; it belongs to the part between the `ends` along the way."""
    fine = line if link.exact else dense(line)
    s = way_along(fine)
    near = np.interp(ends[0] + s / max(s[-1], 1e-9) * (ends[1] - ends[0]), way, curve.breaks_s)
    if not link.exact:
        near = _nearest(curve, fine, np.interp(ends, way, curve.breaks_s))
    found, offset = curve.project(fine[:, :2], near)
    # inside a bend tighter than its offset a border turns back: its places are not the nearest of what they lie beside
    at_near = np.sum((fine[:, :2] - curve.position(near)) * curve.normal(near), axis=1)
    folded = 1.0 - curve.curvature(near) * at_near < FOLD
    found, offset = np.where(folded, near, found), np.where(folded, at_near, offset)
    order = np.argsort(found, kind="stable")
    return np.interp(stations, found[order], offset[order]), np.interp(stations, found[order], fine[order, 2])


def _nearest(curve: PlanarCurve, line: Floats, ends: Floats) -> Floats:
    """Stations close to the feet of a border's points: borders of corners do not keep step with the middle."""
    from scipy.spatial import cKDTree

    at = np.linspace(max(ends[0] - BEYOND, 0.0), min(ends[1] + BEYOND, curve.length), max(int((ends[1] - ends[0] + 2.0 * BEYOND) / CLOSE), 2))
    return at[cKDTree(curve.position(at)).query(line[:, :2])[1]]
