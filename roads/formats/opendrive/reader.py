"""An OpenDRIVE file as a network, and its roads with the file's own reference lines and stations."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ...borders import narrowed_at, spaced
from ...errors import RoadError
from ...findings import Findings
from ...geometry.curve import PlanarCurve, read_only
from ...geometry.plan_view import Cubic
from ...lane import Lane
from ...networks.network import Network
from ...road import Road
from ..text import garbage_later
from .geometry import Shapes
from .links import links_of
from .parse import read_records
from .records import DRIVABLE

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from .geometry import RoadShape, SectionShape
    from .records import LaneRecord, OpenDrive

    Floats = NDArray[np.float64]

#: Where the cross-section changes at once, edges and lanes do so within this stretch, on the wider side, m.
AT_ONCE = 0.01
#: A curve is not drawn through points closer than this, m.
NEAREST = 0.02
#: Changing from a lane that ends to its neighbour takes this stretch before the end, m.
CHANGE = 60.0
#: A lane narrower than this is none to drive in, m.
NARROW = 2.0
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
        partial(_road, path, drive, shapes),
        drive.geo_reference,
    )


def _road(path: Path, drive: OpenDrive, shapes: Shapes, identity: str) -> Road:
    shape = shapes[identity]
    record = shape.record
    ways = {lane.direction for section in record.sections for lane in section.lanes if lane.kind in DRIVABLE}
    if not ways:
        raise RoadError(f"{record.place}: road {identity} has no drivable lane, expected one of type {', '.join(sorted(DRIVABLE))}")
    along = 1 if ways & {0, 1} else -1
    name = f"{drive.name} {record.name}".strip() if len(drive.roads) > 1 else record.name
    try:
        s, rows, sections = _stations(shape)
        road_lanes, edges = _lanes(shape, sections, rows, along)
        closed = _is_closed(drive, shape)
        count = len(rows) - closed
        curve, along_curve = _curve(shape, closed)
        followed = _drive(s, road_lanes, edges, along, record.left_hand, closed=closed)
        driven = followed or _outermost(road_lanes, along, record.left_hand)
        right, left = (np.append(side, side[: len(s) - len(side)]) for side in (driven.right, driven.left))
        padded = Lane(along, right, left)
        limit, friction = _of_driven_lane(shape, s, sections, rows, padded, along)
        made = Road(
            name,
            curve,
            read_only(np.interp(s, shape.s, along_curve)[:count]),
            read_only(edges[0][:count]),
            read_only(edges[1][:count]),
            read_only(shape.height[rows][:count]),
            read_only(limit[:count]),
            tuple(_open_ended(lane, count) for lane in road_lanes),
            read_only(shape.bank[rows][:count]),
            read_only(friction[:count]),
            drive=followed,
            left_hand=record.left_hand,
            plan_view=tuple(element.by_arc_length() if isinstance(element, Cubic) else element for element in record.elements),
            origin=_origin(drive.geo_reference),
        )
    except RoadError as error:
        raise RoadError(f"{record.place}: {error}") from None
    return made if along > 0 else made.reversed()


def _origin(reference: str) -> tuple[float, float] | None:
    """Latitude and longitude of (0, 0) where the file's projection is a plain transverse Mercator about it."""
    found = dict(re.findall(r"\+(\w+)=(\S+)", reference))
    plain = found.get("proj") == "tmerc" and all(
        float(found.get(key, default)) == want for key, default, want in _PLAIN if _is_number(found.get(key, default))
    )
    if not plain or not all(_is_number(found.get(key, "")) for key in ("lat_0", "lon_0")):
        return None
    return float(found["lat_0"]), float(found["lon_0"])


def _is_number(word: str) -> bool:
    try:
        return bool(np.isfinite(float(word)))
    except ValueError:
        return False


def _open_ended(lane: Lane, count: int) -> Lane:
    return Lane(lane.direction, read_only(lane.right[:count]), read_only(lane.left[:count]), lane.kind, lane.name)


def _stations(shape: RoadShape) -> tuple[Floats, NDArray[np.intp], NDArray[np.intp]]:
    """Stations of the road, the row of `shape` and the section of each; at a section's start there is one station more, just inside it."""
    s, rows, sections = [], [], []
    for index, section in enumerate(shape.sections):
        inner = np.arange(section.first, section.last + (index == len(shape.sections) - 1))
        at = shape.s[inner]
        if index and len(inner) > 1 and at[1] - at[0] > 2.0 * AT_ONCE:
            inner, at = np.insert(inner, 1, inner[0]), np.insert(at, 1, at[0] + AT_ONCE)
        s.append(at)
        rows.append(inner)
        sections.append(np.full(len(inner), index))
        if index + 1 < len(shape.sections) and at[-1] < shape.s[section.last] - 2.0 * AT_ONCE:
            s.append(np.array([shape.s[section.last] - AT_ONCE]))
            rows.append(np.array([section.last]))
            sections.append(np.array([index]))
    return np.concatenate(s), np.concatenate(rows), np.concatenate(sections)


def _lanes(shape: RoadShape, sections: NDArray[np.intp], rows: NDArray[np.intp], along: int) -> tuple[list[Lane], tuple[Floats, Floats]]:
    """Lanes that are linked from section to section, and the edges of the carriageway that holds those that lead `along`."""
    count = len(rows)
    chains: list[tuple[LaneRecord, Floats, Floats]] = []
    open_chains: dict[int, int] = {}
    right_edge, left_edge = np.full(count, np.inf), np.full(count, -np.inf)
    for index, section in enumerate(shape.sections):
        here = np.flatnonzero(sections == index)
        began: dict[int, int] = {}
        borders = section.borders[:, rows[here] - section.first] * np.cos(shape.bank[rows[here]])
        group = _carriageway(section, along)
        for at in group:
            lane = section.lanes[at]
            chain = next(
                (open_chains[number] for number in lane.predecessors if number in open_chains and _same(chains[open_chains[number]][0], lane)), None
            )
            if chain is None or chain in began.values():
                chain = len(chains)
                chains.append((lane, np.full(count, np.nan), np.full(count, np.nan)))
            began[lane.id] = chain
            chains[chain][1][here], chains[chain][2][here] = borders[at], borders[at + 1]
        open_chains = began
        if group:
            right_edge[here], left_edge[here] = borders[group[0]], borders[group[-1] + 1]
    if np.isinf(right_edge).any():
        at = int(np.argmax(np.isinf(right_edge)))
        raise RoadError(f"no drivable lane that leads on at s = {shape.s[rows[at]]:.1f} m, expected one from start to end")
    edges = narrowed_at(right_edge, left_edge, np.flatnonzero(np.diff(sections)) + 1)
    right_edge, left_edge = edges
    lanes = [
        Lane(lane.direction, np.clip(right, right_edge, left_edge), np.clip(left, right_edge, left_edge), lane.kind, str(lane.id))
        for lane, right, left in chains
    ]
    return sorted(lanes, key=lambda lane: float(np.nanmean(lane.right + lane.left))), edges


def _same(before: LaneRecord, lane: LaneRecord) -> bool:
    return before.direction == lane.direction and before.id * lane.id > 0


def _carriageway(section: SectionShape, along: int) -> list[int]:
    """Indices of the drivable lanes that lie side by side with the outermost one that leads `along`, in one piece."""
    lanes = section.lanes
    drivable = [lane.kind in DRIVABLE or (lane.width is not None and not lane.width.starts) for lane in lanes]
    wanted = [k for k, lane in enumerate(lanes) if drivable[k] and lane.direction in (0, along)]
    if not wanted:
        return []
    # prefer a lane for through traffic to a ramp beside a barrier
    first = next((k for k in wanted if lanes[k].kind == "driving"), wanted[0])
    low = high = first
    while low > 0 and drivable[low - 1]:
        low -= 1
    while high + 1 < len(lanes) and drivable[high + 1]:
        high += 1
    return list(range(low, high + 1))


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


def _of_driven_lane(shape: RoadShape, s: Floats, sections: NDArray[np.intp], rows: NDArray[np.intp], lane: Lane, along: int) -> tuple[Floats, Floats]:
    """Speed limit and friction (n,) of the lane that is driven, section by section the one that it lies on."""
    record = shape.record
    limit, friction = np.full(len(s), np.inf), np.ones(len(s))
    middle = 0.5 * (lane.right + lane.left)
    for index, section in enumerate(shape.sections):
        here = np.flatnonzero(sections == index)
        at = here[len(here) // 2]
        borders = section.borders[:, rows[at] - section.first] * np.cos(shape.bank[rows[at]])
        candidates = [k for k, other in enumerate(section.lanes) if other.kind in DRIVABLE and other.direction in (0, along)]
        if not candidates:
            continue
        best = min(candidates, key=lambda k: abs(0.5 * (borders[k] + borders[k + 1]) - middle[at]))
        driven = section.lanes[best]
        part = record.sections[index]
        for start, speed in driven.limits(part.start, part.end, record.speeds):
            limit[here[s[here] >= start - 1e-9]] = speed
        for start, share in driven.frictions:
            friction[here[s[here] >= start - 1e-9]] = share
    return limit, friction


def _drive(s: Floats, lanes: list[Lane], edges: tuple[Floats, Floats], along: int, left_hand: bool, *, closed: bool) -> Lane | None:
    """The lane to follow where no lane leads on from start to end: a change to the neighbour before each one ends."""
    forward = [_wide(lane) for lane in lanes if lane.direction in (0, along)]
    if not np.all(np.any([~np.isnan(lane.right) for lane in forward], axis=0)):
        forward = [lane for lane in lanes if lane.direction in (0, along)]
    through = [lane for lane in forward if lane.kind == "driving"] or forward
    outer = through[::-1] if left_hand == (along > 0) else through
    count = len(s) - closed
    whole = next((lane for lane in outer if not np.isnan(lane.right).any()), None)
    if whole is not None:
        return None if whole.name == _outermost(lanes, along, left_hand).name else _open_ended(whole, count)
    right, left = np.empty(len(s)), np.empty(len(s))
    at = 0
    current = next(lane for lane in outer if not np.isnan(lane.right[0]))
    ends: list[tuple[int, Lane, Lane]] = []
    while at < len(s):
        gone = np.flatnonzero(np.isnan(current.right[at:]))
        stop = at + int(gone[0]) if len(gone) else len(s)
        right[at:stop], left[at:stop] = current.right[at:stop], current.left[at:stop]
        if stop == len(s):
            break
        middle = 0.5 * (current.right[stop - 1] + current.left[stop - 1])
        present = [lane for lane in outer if not np.isnan(lane.right[stop])] or [lane for lane in forward if not np.isnan(lane.right[stop])]
        if not present:
            raise RoadError(f"no lane leads on at s = {s[stop]:.1f} m, expected one from start to end")
        after = min(present, key=lambda lane: abs(0.5 * (lane.right[stop] + lane.left[stop]) - middle))
        ends.append((stop, current, after))
        current, at = after, stop
    for stop, before, after in ends:
        _blend(s, right, left, stop, before, after)
    right, left = np.clip(right, *edges), np.clip(left, *edges)
    return Lane(along, read_only(right[:count]), read_only(left[:count]), "driving", "followed")


def _wide(lane: Lane) -> Lane:
    """The lane without the stretches where it is too narrow for a car, as where it begins or ends in a taper."""
    narrow = ~(lane.left - lane.right >= NARROW)
    return replace(lane, right=np.where(narrow, np.nan, lane.right), left=np.where(narrow, np.nan, lane.left))


def _outermost(lanes: list[Lane], along: int, left_hand: bool) -> Lane:
    """The lane that `Road.driving_lane` would take."""
    order = lanes[::-1] if left_hand == (along > 0) else lanes
    return next(lane for lane in order if lane.direction in (0, along) and not np.isnan(lane.right).any())


def _blend(s: Floats, right: Floats, left: Floats, stop: int, before: Lane, after: Lane) -> None:
    """Move over smoothly while both lanes are there; where they never are, after the end, as far as the change reaches."""
    both = ~np.isnan(before.right) & ~np.isnan(after.right) & (s >= s[stop] - CHANGE) & (s < s[stop])
    if np.count_nonzero(both) > 2:
        span = np.flatnonzero(both)
        share = _smooth((s[span] - s[span[0]]) / (s[span[-1]] - s[span[0]]))
        right[span] = (1 - share) * before.right[span] + share * after.right[span]
        left[span] = (1 - share) * before.left[span] + share * after.left[span]
        return
    jump = 0.5 * (right[stop] + left[stop] - right[stop - 1] - left[stop - 1])
    if abs(jump) < 1e-3:
        return
    span = np.flatnonzero((s >= s[stop]) & (s < s[stop] + CHANGE))
    share = 1.0 - _smooth((s[span] - s[stop]) / CHANGE)
    # on the side it comes from the strip reaches back to the lane before
    if jump > 0.0:
        right[span] -= 2.0 * jump * share
    else:
        left[span] -= 2.0 * jump * share


def _smooth(share: Floats) -> Floats:
    return share**2 * (3.0 - 2.0 * share)
