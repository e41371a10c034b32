"""One road out of the lanes of a route: the middle of the lanes driven becomes the reference, borders are measured from it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..borders import narrowed_at
from ..errors import RoadError
from ..geometry.curve import PlanarCurve, read_only
from ..lane import Lane
from ..road import Road
from .measuring import bend_at, measured, strip_driven
from .middle import NEAREST, middle_of
from .rounding import rounded, with_corners

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .middle import Middle
    from .routing import Route

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

#: Where cross-sections change at once, edges do so within this stretch, m.
AT_ONCE = 0.01
#: A reference that bends with a smaller radius stands on its end, m.
CUSP = 0.5
#: Edges end inside a bend at this share of its radius.
INSIDE = 0.9


class UndrivableError(RoadError):
    """A route that cannot be drawn as a road; `stretch` counts the one of its stretches where it fails."""

    def __init__(self, message: str, stretch: int) -> None:
        """Keep where it fails beside the message."""
        super().__init__(message)
        self.stretch = stretch


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
    if _sharpest(curve)[1] > 1.0 / CUSP:
        line = rounded(line, again=True)
        curve = PlanarCurve.through(line[:, :2])
    way = np.maximum.accumulate(line[:, 3])
    _must_be_smooth(route, curve, way)
    kept = np.unique(middle.owner)
    owner = kept[np.clip(np.searchsorted(route.starts[kept], way + 1e-9, side="right") - 1, 0, len(kept) - 1)]
    return _road(name, route, curve, line[:, 2], way, owner, middle)


def _sharpest(curve: PlanarCurve) -> tuple[float, float]:
    """Station, m, and amount of the sharpest curvature, 1/m."""
    s = curve.breaks_s
    at = (s[:-1, None] + np.diff(s)[:, None] * np.array([0.02, 0.25, 0.5, 0.75, 0.98])).ravel()
    kappa = np.abs(curve.curvature(at))
    k = int(np.argmax(kappa))
    return float(at[k]), float(kappa[k])


def _must_be_smooth(route: Route, curve: PlanarCurve, way: Floats) -> None:
    at, kappa = _sharpest(curve)
    if kappa <= 1.0 / CUSP:
        return
    place = float(np.interp(at, curve.breaks_s, way))
    stretch = int(np.clip(np.searchsorted(route.starts, place, side="right") - 1, 0, len(route.stretches) - 1))
    lane = route.stretches[stretch].lanes[route.stretches[stretch].main]
    x, y = curve.position(at)
    bend = f"the way along lane {lane} turns with a radius of {1.0 / kappa:.2f} m at ({x:.1f}, {y:.1f})"
    raise UndrivableError(f"{route.ground.network.path}: {bend}, expected at least {CUSP:g} m", stretch)


def _road(name: str, route: Route, curve: PlanarCurve, height: Floats, way: Floats, owner: Ints, middle: Middle) -> Road:
    """Lanes end with their part, except those driven; edges change at once where parts meet, on the wider side."""
    s = curve.breaks_s
    joints = np.flatnonzero(np.diff(owner)) + 1
    extra = np.concatenate([s[joints] - AT_ONCE, s[joints] + AT_ONCE])
    extra = extra[(extra > 0.0) & (extra < s[-1])]
    stations = np.union1d(s, extra)
    part_at = np.append(owner[np.searchsorted(s, stations[:-1], side="right") - 1], owner[-1])
    along = np.interp(stations, s, way)
    right, left, bank, limit = (np.empty(len(stations)) for _ in range(4))
    heres = {k: part_at == k for k in np.unique(part_at).tolist()}
    parts = {k: measured(route, k, curve, stations[here], along[here], way) for k, here in heres.items()}
    drive_right, drive_left = strip_driven(route, parts, curve, stations, along, way, middle)
    lanes: list[Lane] = []
    for k, part in parts.items():
        here = heres[k]
        right[here], left[here] = part.right.min(axis=0), part.left.max(axis=0)
        bank[here], limit[here] = part.bank, part.limit
        for link, direction, *offsets in zip(part.links, part.ways, part.right, part.left, strict=True):
            bounds = np.full((2, len(here)), np.nan)
            bounds[:, here] = offsets
            lanes.append(Lane(direction, bounds[0], bounds[1], link.kind, link.id))
    right, left = _unfolded(curve, stations, right, left)
    # where lanes do not quite meet the strip driven leads from one to the other, over ground that no lane covers
    right, left = np.minimum(right, drive_right), np.maximum(left, drive_left)
    right, left = narrowed_at(right, left, np.searchsorted(stations, s[joints]))
    lanes = [Lane(lane.direction, np.clip(lane.right, right, left), np.clip(lane.left, right, left), lane.kind, lane.name) for lane in lanes]
    drive = Lane(1, np.clip(drive_right, right, left), np.clip(drive_left, right, left), "driving", "route")
    first = route.stretches[0]
    return Road(
        name,
        curve,
        read_only(stations),
        read_only(right),
        read_only(left),
        read_only(np.interp(stations, s, height)),
        read_only(limit),
        tuple(lanes),
        read_only(bank),
        drive=drive,
        left_hand=route.ground.links[first.lanes[first.main]].left_hand,
    )


def _unfolded(curve: PlanarCurve, stations: Floats, right: Floats, left: Floats) -> tuple[Floats, Floats]:
    """Edges (n,) no farther inside a bend than nearly its middle, where a road turns back on itself."""
    kappa = bend_at(curve, stations)
    middle = INSIDE / np.maximum(np.abs(kappa), 1e-9)
    return np.where(kappa < 0.0, np.maximum(right, -middle), right), np.where(kappa > 0.0, np.minimum(left, middle), left)
