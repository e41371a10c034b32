"""OpenDRIVE out of records: version 1.6, or 1.8 where a lane needs a direction of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from lxml import etree

from ...geometry.plan_view import Clothoid
from ..text import write_whole

if TYPE_CHECKING:
    from pathlib import Path

    from ...geometry.plan_view import Element
    from ..xml import Node
    from .records import Connection, Cubics, LaneRecord, OpenDrive, RoadEnd, RoadRecord


def write_records(drive: OpenDrive, path: Path) -> None:
    """Write the file, whole or not at all.

    Raises:
        RoadError: the file cannot be written.
    """
    root = etree.Element("OpenDRIVE")
    own_way = any(lane.direction != _usual(road, lane) for road in drive.roads.values() for section in road.sections for lane in section.lanes)
    header = etree.SubElement(root, "header", revMajor="1", revMinor="8" if own_way else "6", name=drive.name, version="1.00")
    if drive.geo_reference:
        etree.SubElement(header, "geoReference").text = etree.CDATA(drive.geo_reference)
    for road in drive.roads.values():
        _road(root, road)
    for identity, connections in drive.junctions.items():
        _junction(root, identity, connections)
    write_whole(path, etree.tostring(root, pretty_print=True, xml_declaration=True, encoding="UTF-8"))


def _usual(road: RoadRecord, lane: LaneRecord) -> int:
    return (1 if lane.id < 0 else -1) * (-1 if road.left_hand else 1)


def _number(value: float) -> str:
    """The shortest text that reads back as the same number; whole numbers without a point."""
    value = float(value) + 0.0
    return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)


def _add(parent: Node, tag: str, **attributes: float | str) -> Node:
    return etree.SubElement(parent, tag, {key: value if isinstance(value, str) else _number(value) for key, value in attributes.items()})


def _road(root: Node, road: RoadRecord) -> None:
    node = _add(root, "road", name=road.name, length=road.length, id=road.id, junction=road.junction, rule="LHT" if road.left_hand else "RHT")
    link = _add(node, "link")
    _end(link, "predecessor", road.predecessor)
    _end(link, "successor", road.successor)
    for start, speed in road.speeds:
        kind = _add(node, "type", s=start, type="unknown")
        _add(kind, "speed", max=_number(speed) if np.isfinite(speed) else "no limit", unit="m/s")
    plan = _add(node, "planView")
    for start, element in zip(road.starts.tolist(), road.elements, strict=True):
        _geometry(plan, start, element)
    _cubics(_add(node, "elevationProfile"), "elevation", road.elevation)
    _cubics(_add(node, "lateralProfile"), "superelevation", road.superelevation)
    lanes = _add(node, "lanes")
    _cubics(lanes, "laneOffset", road.lane_offset)
    for section in road.sections:
        at = _add(lanes, "laneSection", s=section.start)
        if section.left:
            side = _add(at, "left")
            for lane in section.left[::-1]:
                _lane(side, road, lane, section.start)
        _add(_add(at, "center"), "lane", id="0", type="none", level="false")
        if section.right:
            side = _add(at, "right")
            for lane in section.right:
                _lane(side, road, lane, section.start)


def _end(link: Node, tag: str, end: RoadEnd | None) -> None:
    if end is not None:
        contact = {"contactPoint": end.contact} if end.contact else {}
        _add(link, tag, elementType=end.kind, elementId=end.id, **contact)


def _geometry(plan: Node, start: float, element: Element) -> None:
    node = _add(plan, "geometry", s=start, x=element.x, y=element.y, hdg=element.heading, length=element.length)
    if not isinstance(element, Clothoid):
        unit = element.speed == "unit"
        # normalized parameters run from 0 to 1
        scale = 1.0 if unit else element.end
        shape = {
            f"{letter}{axis}": c * scale**k
            for axis, row in (("U", element.u), ("V", element.v))
            for k, (letter, c) in enumerate(zip("abcd", row, strict=True))
        }
        _add(node, "paramPoly3", pRange="arcLength" if unit else "normalized", **shape)
    elif element.start == element.end == 0.0:
        _add(node, "line")
    elif element.start == element.end:
        _add(node, "arc", curvature=element.start)
    else:
        _add(node, "spiral", curvStart=element.start, curvEnd=element.end)


def _cubics(parent: Node, tag: str, cubics: Cubics, key: str = "s", shift: float = 0.0) -> None:
    for start, (a, b, c, d) in zip(cubics.starts, cubics.rows, strict=True):
        _add(parent, tag, **{key: max(start - shift, 0.0)}, a=a, b=b, c=c, d=d)


def _lane(side: Node, road: RoadRecord, lane: LaneRecord, start: float) -> None:
    usual = _usual(road, lane)
    way = {} if lane.direction == usual else {"direction": "both" if lane.direction == 0 else "reversed"}
    node = _add(side, "lane", id=str(lane.id), type=lane.kind, level="false", **way)
    if lane.predecessors or lane.successors:
        link = _add(node, "link")
        for tag, numbers in (("predecessor", lane.predecessors), ("successor", lane.successors)):
            for number in numbers:
                _add(link, tag, id=str(number))
    if lane.width is not None:
        _cubics(node, "width", lane.width, "sOffset", start)
    if lane.border is not None:
        _cubics(node, "border", lane.border, "sOffset", start)
    for at, friction in lane.frictions:
        _add(node, "material", sOffset=max(at - start, 0.0), friction=friction)
    for at, speed in lane.speeds:
        _add(node, "speed", sOffset=max(at - start, 0.0), max=_number(speed) if np.isfinite(speed) else "no limit", unit="m/s")


def _junction(root: Node, identity: str, connections: tuple[Connection, ...]) -> None:
    node = _add(root, "junction", name=f"junction {identity}", id=identity)
    for k, connection in enumerate(connections):
        at = _add(
            node, "connection", id=str(k), incomingRoad=connection.incoming, connectingRoad=connection.connecting, contactPoint=connection.contact
        )
        for begin, end in connection.lanes:
            _add(at, "laneLink", **{"from": str(begin), "to": str(end)})
