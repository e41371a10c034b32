"""One road out of the lanes of a route: the middle of the lanes driven becomes the reference, borders are measured from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..borders import dense, narrowed_at, places_beside, way_along
from ..errors import RoadError
from ..geometry.curve import PlanarCurve, read_only
from ..lane import Lane
from ..road import Road
from .middle import NEAREST, SAME, Middle, cut, middle_of
from .rounding import rounded, with_corners

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .links import Link
    from .routing import Route

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

#: Where cross-sections change at once, edges do so within this stretch, m.
AT_ONCE = 0.01
#: A reference that bends with a smaller radius stands on its end, m.
CUSP = 0.5
#: Points of borders of polylines are looked for so far beyond the part they belong to, at places so close, m.
BEYOND, CLOSE = 5.0, 0.5


class UndrivableError(RoadError):
    """A route that cannot be drawn as a road; `stretch` counts the one of its stretches where it fails."""

    def __init__(self, message: str, stretch: int) -> None:
        """Keep where it fails beside the message."""
        super().__init__(message)
        self.stretch = stretch


@dataclass(frozen=True, eq=False)
class _Part:
    """One cross-section run, measured at its stations (n,): lanes (k, n) from right to left."""

    links: list[Link]
    ways: list[int]
    right: Floats
    left: Floats
    bank: Floats
    limit: Floats
    strip: tuple[Floats, Floats]


def assemble(name: str, route: Route) -> Road:
    """The road along `route`.

    Raises:
        RoadError: a route no longer than a few centimetres.
        UndrivableError: lanes that no smooth line leads along.
    """
    path = route.ground.network.path
    middle = middle_of(route)
    if len(middle.points) < 2:
        raise RoadError(f"{path}: the route is shorter than {2 * NEAREST} m, expected a longer one")
    line = np.column_stack([middle.points, middle.way])
    if not all(route.ground.links[name].exact for stretch in route.stretches for name in stretch.lanes.values()):
        line = with_corners(line)
    line = rounded(line)
    curve = PlanarCurve.through(line[:, :2])
    way = np.maximum.accumulate(line[:, 3])
    _must_be_smooth(route, curve, way)
    kept = np.unique(middle.owner)
    owner = kept[np.clip(np.searchsorted(route.starts[kept], way + 1e-9, side="right") - 1, 0, len(kept) - 1)]
    return _road(name, route, curve, line[:, 2], way, owner, middle)


def _must_be_smooth(route: Route, curve: PlanarCurve, way: Floats) -> None:
    at = np.linspace(0.0, curve.length, max(int(10.0 * min(curve.length, 1e5)), 20))
    kappa = np.abs(curve.curvature(at))
    k = int(np.argmax(kappa))
    if kappa[k] <= 1.0 / CUSP:
        return
    place = float(np.interp(at[k], curve.breaks_s, way))
    stretch = int(np.clip(np.searchsorted(route.starts, place, side="right") - 1, 0, len(route.stretches) - 1))
    lane = route.stretches[stretch].lanes[route.stretches[stretch].main]
    x, y = curve.position(at[k])
    bend = f"the way along lane {lane} turns with a radius of {1.0 / kappa[k]:.2f} m at ({x:.1f}, {y:.1f})"
    raise UndrivableError(f"{route.ground.network.path}: {bend}, expected at least {CUSP:g} m", stretch)


def _part(route: Route, k: int, curve: PlanarCurve, stations: Floats, along: Floats, way: Floats, middle: Middle) -> _Part:
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
    return _Part(links, [-1 if against else 1 for against in beside.values()], right, left, bank, limit, strip)  # pyright: ignore[reportArgumentType]


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
    offset, height = places_beside(curve, fine, near, stations)
    return offset, height


def _nearest(curve: PlanarCurve, line: Floats, ends: Floats) -> Floats:
    """Stations close to the feet of a border's points: borders of corners do not keep step with the middle."""
    from scipy.spatial import cKDTree

    at = np.linspace(max(ends[0] - BEYOND, 0.0), min(ends[1] + BEYOND, curve.length), max(int((ends[1] - ends[0] + 2.0 * BEYOND) / CLOSE), 2))
    return at[cKDTree(curve.position(at)).query(line[:, :2])[1]]


def _road(name: str, route: Route, curve: PlanarCurve, height: Floats, way: Floats, owner: Ints, middle: Middle) -> Road:
    """Lanes end with their part, except those driven; edges change at once where parts meet, on the wider side."""
    s = curve.breaks_s
    joints = np.flatnonzero(np.diff(owner)) + 1
    extra = np.concatenate([s[joints] - AT_ONCE, s[joints] + AT_ONCE])
    extra = extra[(extra > 0.0) & (extra < s[-1])]
    stations = np.union1d(s, extra)
    part_at = np.append(owner[np.searchsorted(s, stations[:-1], side="right") - 1], owner[-1])
    along = np.interp(stations, s, way)
    right, left, bank, limit, drive_right, drive_left = (np.empty(len(stations)) for _ in range(6))
    lanes: list[Lane] = []
    for k in np.unique(part_at).tolist():
        here = part_at == k
        part = _part(route, k, curve, stations[here], along[here], way, middle)
        # where lanes do not quite meet the strip driven leads from one to the other, over ground that no lane covers
        right[here] = np.minimum(part.right.min(axis=0), part.strip[0])
        left[here] = np.maximum(part.left.max(axis=0), part.strip[1])
        bank[here], limit[here] = part.bank, part.limit
        drive_right[here], drive_left[here] = part.strip
        for link, direction, *offsets in zip(part.links, part.ways, part.right, part.left, strict=True):
            bounds = np.full((2, len(here)), np.nan)
            bounds[:, here] = offsets
            lanes.append(Lane(direction, bounds[0], bounds[1], link.kind, link.id))
    right, left = narrowed_at(right, left, np.searchsorted(stations, s[joints]))
    lanes = [Lane(lane.direction, np.clip(lane.right, right, left), np.clip(lane.left, right, left), lane.kind, lane.name) for lane in lanes]
    drive = Lane(1, np.clip(drive_right, right, left), np.clip(drive_left, right, left), "driving", "route")
    first = route.stretches[0]
    return Road(
        name,
        curve,
        *(read_only(values) for values in (stations, right, left, np.interp(stations, s, height), limit)),
        tuple(lanes),
        read_only(bank),
        drive=drive,
        left_hand=route.ground.links[first.lanes[first.main]].left_hand,
    )
