"""The lane graph of an OpenDRIVE file."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ...errors import RoadError
from ...networks.links import Link
from .records import DRIVABLE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .geometry import Shapes
    from .records import Connection, LaneRecord, OpenDrive, RoadEnd, RoadRecord, SectionRecord

    Floats = NDArray[np.float64]


def links_of(drive: OpenDrive, shapes: Shapes) -> dict[str, Link]:
    """Every drivable lane of every section as a link; a lane for both directions becomes two links, the second one marked `~`."""
    links: dict[str, Link] = {}
    for road in drive.roads.values():
        for index, section in enumerate(road.sections):
            for group in _groups(section.lanes):
                made = [_link(road, shapes, index, lane, along) for lane in group for along in _ways(lane)]
                _set_beside(made)
                for _, _, link in made:
                    links[link.id] = link
    incoming: dict[str, list[Connection]] = {}
    for connections in drive.junctions.values():
        for connection in connections:
            incoming.setdefault(connection.incoming, []).append(connection)
    for road in drive.roads.values():
        for index, section in enumerate(road.sections):
            for lane in section.lanes:
                for along in _ways(lane) if lane.kind in DRIVABLE else ():
                    ahead = _next(drive, incoming.get(road.id, []), road, index, lane, along)
                    links[_id(road.id, road.sections[index], lane, along)].successors = [name for name in dict.fromkeys(ahead) if name in links]
    return links


def _ways(lane: LaneRecord) -> tuple[int, ...]:
    return (lane.direction,) if lane.direction else (1, -1)


def _id(road: str, section: SectionRecord, lane: LaneRecord, along: int) -> str:
    return f"{road}/{section.number}/{lane.id}" + ("~" if lane.direction == 0 and along < 0 else "")


def _groups(lanes: tuple[LaneRecord, ...]) -> list[list[LaneRecord]]:
    """Runs of drivable lanes that lie side by side, from right to left; a median or a kerb between them separates."""
    groups: list[list[LaneRecord]] = [[]]
    for lane in lanes:
        if lane.kind in DRIVABLE:
            groups[-1].append(lane)
        elif lane.width is None or lane.width.starts:
            groups.append([])
    return [group for group in groups if group]


def _link(road: RoadRecord, shapes: Shapes, index: int, lane: LaneRecord, along: int) -> tuple[int, bool, Link]:
    limits = _limits(road, index, lane, along)
    name = _id(road.id, road.sections[index], lane, along)
    made = Link(name, road.id, lane.kind, partial(_borders, shapes, road.id, index, lane, along), limits=limits, left_hand=road.left_hand, exact=True)
    made.reference = partial(_way, shapes, road.id, index, along)
    ends = index == 0, index == len(road.sections) - 1
    made.at_ends = (ends[0], ends[1]) if along > 0 else (ends[1], ends[0])
    return along, lane.direction == 0, made


def _set_beside(made: list[tuple[int, bool, Link]]) -> None:
    for along, _, link in made:
        order = made if along > 0 else made[::-1]
        # a lane for both directions counts once, as the one that leads this way
        order = [item for item in order if not item[1] or item[0] == along]
        link.beside = tuple(other.id for _, _, other in order)
        link.against = tuple(way != along for way, _, _ in order)
        at = link.beside.index(link.id)
        if at > 0 and not link.against[at - 1]:
            link.right = link.beside[at - 1]
        if at + 1 < len(order) and not link.against[at + 1]:
            link.left = link.beside[at + 1]


def _borders(shapes: Shapes, identity: str, index: int, lane: LaneRecord, along: int) -> tuple[Floats, Floats]:
    section = shapes[identity].sections[index]
    at = section.lanes.index(lane)
    right, left = section.places[at], section.places[at + 1]
    if not np.isfinite(section.places[at : at + 2]).all():
        raise RoadError(f"{lane.place}: <lane> {lane.id} of road {identity} has borders that are not finite, expected a road")
    return (left, right) if along > 0 else (right[::-1], left[::-1])


def _way(shapes: Shapes, identity: str, index: int, along: int) -> Floats:
    """Distance (n,) along the road's reference of the points of `_borders`, m."""
    shape = shapes[identity]
    section = shape.sections[index]
    s = shape.s[section.first : section.last + 1]
    return s - s[0] if along > 0 else s[-1] - s[::-1]


def _limits(road: RoadRecord, index: int, lane: LaneRecord, along: int) -> tuple[tuple[float, float], ...]:
    """Limits in the direction of travel; a lane's own limit overrides its road's."""
    section = road.sections[index]
    steps = lane.limits(section.start, section.end, road.speeds)
    if along > 0:
        return tuple((start - section.start, speed) for start, speed in steps)
    ends = [start for start, _ in steps[1:]] + [section.end]
    return tuple((section.end - end, speed) for end, (_, speed) in zip(reversed(ends), reversed(steps), strict=True))


def _next(drive: OpenDrive, incoming: list[Connection], road: RoadRecord, index: int, lane: LaneRecord, along: int) -> list[str]:
    """Ids of the links that begin where `lane` ends when it is driven `along` the stations (+1) or against them (-1)."""
    numbers = lane.successors if along > 0 else lane.predecessors
    inside = index + along
    if 0 <= inside < len(road.sections):
        return [name for number in numbers for name in _entering(road, inside, number, along)]
    end: RoadEnd | None = road.successor if along > 0 else road.predecessor
    if end is None:
        return []
    if end.kind == "road":
        other = drive.roads.get(end.id)
        return (
            []
            if other is None
            else [name for number in numbers for name in _at_contact(other, end.contact or _nearer_end(road, other, along), number)]
        )
    found: list[str] = []
    for connection in incoming:
        other = drive.roads.get(connection.connecting)
        if other is None:
            continue
        if not _meets(road, other, along, connection.contact):
            continue
        for number, to in connection.lanes:
            if lane.id in road.known_as(number, end=along > 0):
                found += _at_contact(other, connection.contact, to)
    return found


def _nearer_end(road: RoadRecord, other: RoadRecord, along: int) -> str:
    """Which end of `other` lies at the end of `road` that is left when driving `along`, for files that do not say."""
    first, last = road.elements[0], road.elements[-1]
    here = (first.x, first.y) if along < 0 else last.at(np.array([last.length]))[0][0]
    begin, end = other.elements[0], other.elements[-1]
    far = end.at(np.array([end.length]))[0][0]
    return "start" if np.hypot(begin.x - here[0], begin.y - here[1]) <= np.hypot(*(far - here)) else "end"


def _meets(road: RoadRecord, other: RoadRecord, along: int, contact: str) -> bool:
    """Whether `other` joins `road` at the end that is left when driving `along`; both its ends may be linked to one junction."""
    wanted = "end" if along > 0 else "start"
    back = other.predecessor if contact == "start" else other.successor
    if back is None or back.kind != "road" or back.id != road.id or not back.contact:
        return True
    return back.contact == wanted


def _at_contact(other: RoadRecord, contact: str, number: int) -> list[str]:
    at_end = contact != "start"
    index, along = (len(other.sections) - 1, -1) if at_end else (0, 1)
    return [name for own in other.known_as(number, end=at_end) for name in _entering(other, index, own, along)]


def _entering(road: RoadRecord, index: int, number: int, along: int) -> list[str]:
    lane = road.sections[index].lane(number) if 0 <= index < len(road.sections) else None
    if lane is None or along not in _ways(lane):
        return []
    return [_id(road.id, road.sections[index], lane, along)]
