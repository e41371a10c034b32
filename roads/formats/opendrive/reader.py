"""An OpenDRIVE file as a network, and its roads with the file's own reference lines and stations."""

from __future__ import annotations

import re
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ...borders import spaced
from ...errors import RoadError
from ...findings import Findings
from ...geometry.curve import PlanarCurve, read_only
from ...geometry.plan_view import Cubic
from ...networks.network import Network
from ...road import Road
from ..text import garbage_later
from .carriageway import linked_lanes, stations_of
from .driven import followed_lane, open_ended, outermost, posted_on
from .geometry import Shapes
from .links import links_of
from .parse import read_records
from .records import DRIVABLE

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from .geometry import RoadShape
    from .records import OpenDrive

    Floats = NDArray[np.float64]

#: A curve is not drawn through points closer than this, m.
NEAREST = 0.02
#: Terms of a projection that must have these values for (0, 0) to be its origin: name, default, value.
_PLAIN = (("x_0", "0", 0.0), ("y_0", "0", 0.0), ("k", "1", 1.0), ("k_0", "1", 1.0))


def read_network(path: Path) -> Network:
    """Read an OpenDRIVE file.

    Raises:
        RoadError: not OpenDRIVE 1, or without a single usable road.
    """
    findings = Findings()
    with garbage_later():
        return _network(path, findings)


def _network(path: Path, findings: Findings) -> Network:
    drive = read_records(path, findings)
    if not drive.roads:
        errors = findings.errors()
        raise RoadError(f"{errors[0].place}: {errors[0].message}" if errors else f"{path}: holds no road, expected at least one")
    shapes = Shapes(drive.roads)
    return Network(
        drive.name or path.stem,
        str(path),
        f"OpenDRIVE {drive.version}",
        links_of(drive, shapes),
        {identity: record.length for identity, record in drive.roads.items()},
        findings.all(),
        partial(_road, drive, shapes),
        drive.geo_reference,
    )


def _road(drive: OpenDrive, shapes: Shapes, identity: str) -> Road:
    shape = shapes[identity]
    record = shape.record
    ways = {lane.direction for section in record.sections for lane in section.lanes if lane.kind in DRIVABLE}
    if not ways:
        raise RoadError(f"{record.place}: road {identity} has no drivable lane, expected one of type {', '.join(sorted(DRIVABLE))}")
    along = 1 if ways & {0, 1} else -1
    try:
        made = _built(drive, shape, along)
    except RoadError as error:
        raise RoadError(f"{record.place}: {error}") from None
    return made if along > 0 else made.reversed()


def _built(drive: OpenDrive, shape: RoadShape, along: int) -> Road:
    """The road in the direction of the file's stations; it is driven `along` them (+1) or against them (-1)."""
    record, stations = shape.record, stations_of(shape)
    s, rows, _ = stations
    lanes, (right, left) = linked_lanes(shape, stations, along)
    closed = _is_closed(drive, shape)
    count = len(s) - closed
    curve, along_curve = _curve(shape, closed)
    followed = followed_lane(s, lanes, (right, left), along, record.left_hand, closed=closed)
    limit, friction = posted_on(shape, stations, followed or outermost(lanes, along, record.left_hand), along)
    return Road(
        f"{drive.name} {record.name}".strip() if len(drive.roads) > 1 else record.name,
        curve,
        read_only(np.interp(s, shape.s, along_curve)[:count]),
        read_only(right[:count]),
        read_only(left[:count]),
        read_only(shape.height[rows][:count]),
        read_only(limit[:count]),
        tuple(open_ended(lane, count) for lane in lanes),
        read_only(shape.bank[rows][:count]),
        read_only(friction[:count]),
        drive=followed,
        left_hand=record.left_hand,
        plan_view=tuple(element.by_arc_length() if isinstance(element, Cubic) else element for element in record.elements),
        origin=_origin(drive.geo_reference),
    )


def _origin(reference: str) -> tuple[float, float] | None:
    """Latitude and longitude of (0, 0) where the file's projection is a plain transverse Mercator about it."""
    found = dict(re.findall(r"\+(\w+)=(\S+)", reference))
    terms = [(found.get(key, default), want) for key, default, want in _PLAIN]
    plain = found.get("proj") == "tmerc" and all(_is_number(word) and float(word) == want for word, want in terms)
    if not plain or not all(_is_number(found.get(key, "")) for key in ("lat_0", "lon_0")):
        return None
    return float(found["lat_0"]), float(found["lon_0"])


def _is_number(word: str) -> bool:
    try:
        return bool(np.isfinite(float(word)))
    except ValueError:
        return False


def _curve(shape: RoadShape, closed: bool) -> tuple[PlanarCurve, Floats]:
    """The reference line, and the arc length along it (n,) of the file's stations: files say lengths that are millimetres off."""
    keep = spaced(shape.s, NEAREST)
    points = shape.points[keep]
    curve = PlanarCurve.through(points[:-1] if closed else points, closed=closed)
    return curve, np.interp(shape.s, shape.s[keep], curve.breaks_s)


def _is_closed(drive: OpenDrive, shape: RoadShape) -> bool:
    """The road is its own successor, or it is alone and its end meets its start."""
    record = shape.record
    own = record.successor is not None and record.successor.kind == "road" and record.successor.id == record.id
    gap = float(np.hypot(*(shape.points[-1] - shape.points[0])))
    turn = abs((shape.heading[-1] - shape.heading[0] + np.pi) % (2 * np.pi) - np.pi)
    level = abs(shape.height[-1] - shape.height[0])
    if own and (gap > 0.05 or turn > 0.05):
        raise RoadError(f"road {record.id} is linked to itself, but its end is {gap:.3f} m and {turn:.3f} rad off its start")
    return bool(own or (len(drive.roads) == 1 and record.length > 10.0 and gap < 0.01 and turn < 0.01 and level < 0.01))
