"""OpenDRIVE 1.4 to 1.8: from XML to records. Facts from the ASAM OpenDRIVE standard; what is not read is noted among the findings."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...errors import RoadError
from ...geometry.plan_view import Clothoid, Cubic, PlanView
from ..xml import Place, children, only, parse
from .lanes import cubics_of, speed_of
from .records import Connection, OpenDrive, RoadEnd, RoadRecord
from .sections import sections_of

if TYPE_CHECKING:
    from pathlib import Path

    from ...findings import Findings
    from ...geometry.plan_view import Element
    from ..xml import Node

#: Content that changes where a car may drive, or how, and is not read.
UNREAD = {
    "crossfall": "lateralProfile/crossfall (deprecated) is not read",
    "shape": "lateralProfile/shape is not read: the cross-section counts as plane",
    "crossSectionSurface": "lateralProfile/crossSectionSurface is not read: the cross-section counts as plane",
    "height": "lane height is not read: lanes lie on the road's plane",
    "object": "objects are not read",
    "signal": "signals are not read; speed limits come from type and lane records",
    "railroad": "railroad is not read",
    "include": "included files are not read",
}
#: Shorter pieces than this are taken as slips of a rounding writer and skipped, m.
SHORTEST = 1e-6
#: Elements that do not meet within this are worth a warning, within `APART` usable, m.
MEET, APART = 1e-3, 0.5
#: The same for their headings, rad.
SMOOTH, SHARP = 0.01, 0.5
#: Longest single road, m.
LONGEST = 2e6


def read_records(path: Path, findings: Findings) -> OpenDrive:
    """Read the file; a road that cannot be used becomes an error among `findings` and is left out.

    Raises:
        RoadError: not an OpenDRIVE file of major version 1, or two roads of one id.
    """
    root = parse(path, "OpenDRIVE")
    place = Place(path)
    header = root.find("header")
    version = "?"
    if header is not None:
        version = f"{header.get('revMajor', '?')}.{header.get('revMinor', '?')}"
        if header.get("revMajor", "1").strip() != "1":
            raise place.error(header, f"revMajor is {header.get('revMajor')!r}, expected 1 (OpenDRIVE 1.4 to 1.8)")
    else:
        findings.warn(place.at(root), "no header, OpenDRIVE 1 assumed")
    reference = "" if header is None else (header.findtext("geoReference") or "").strip()
    made = OpenDrive((header.get("name") if header is not None else "") or path.stem, version, reference)
    for tag, message in UNREAD.items():
        nodes = list(root.iter(tag))
        if nodes:
            findings.note(place.at(nodes[0]), message, len(nodes))
    seen: set[str] = set()
    for node in root.findall("road"):
        try:
            road = _road(node, place, findings)
            if road.id in seen:
                raise place.error(node, f"id {road.id!r} is used twice, expected each once")
        except RoadError as error:
            findings.error(error)
            continue
        finally:
            seen.add(node.get("id", ""))
        made.roads[road.id] = road
    _check_joints(made.roads, findings)
    for node in root.findall("junction"):
        try:
            made.junctions[place.word(node, "id")] = _connections(node, place, findings)
        except RoadError as error:
            findings.error(error)
    return made


def _road(node: Node, place: Place, findings: Findings) -> RoadRecord:
    identity = place.word(node, "id")
    length = place.number(node, "length")
    parts = children(node)
    lanes, links = children(only(parts, "lanes")), children(only(parts, "link"))
    left_hand = node.get("rule") == "LHT"
    elements, starts = _plan_view(node, children(only(parts, "planView")).get("geometry", []), place, findings)
    drawn = float(starts[-1]) + elements[-1].length
    if abs(drawn - length) > MEET:
        findings.warn(place.at(node), f"road {identity}: length is {length:g} m, its geometries end at {drawn:g} m; the geometries count")
    speeds = []
    for kind in parts.get("type", []):
        speed = kind.find("speed")
        limit = None if speed is None else speed_of(speed, place, findings)
        at = place.optional(kind, "s", None, findings)
        if at is not None:
            speeds.append((at, np.inf if limit is None else limit))
    sections, at_start, at_end = sections_of(node, lanes.get("laneSection", []), place, findings, drawn, left_hand=left_hand)
    return RoadRecord(
        identity,
        node.get("name") or identity,
        drawn,
        node.get("junction", "-1"),
        left_hand,
        tuple(elements),
        starts,
        cubics_of(children(only(parts, "elevationProfile")).get("elevation", []), place, "s"),
        cubics_of(children(only(parts, "lateralProfile")).get("superelevation", []), place, "s"),
        cubics_of(lanes.get("laneOffset", []), place, "s"),
        sections,
        tuple(sorted(speeds)),
        _end(only(links, "predecessor"), place, findings),
        _end(only(links, "successor"), place, findings),
        place.at(node),
        at_start,
        at_end,
    )


def _end(node: Node | None, place: Place, findings: Findings) -> RoadEnd | None:
    if node is None:
        return None
    kind, other = node.get("elementType", "road"), (node.get("elementId") or "").strip()
    if kind not in ("road", "junction") or not other:
        findings.warn(place.at(node), f"<{node.tag}> leads to {kind[:20]!r} {other[:20]!r}, expected the id of a road or junction; it leads nowhere")
        return None
    return RoadEnd(kind, other, node.get("contactPoint", ""))


def _plan_view(node: Node, geometries: list[Node], place: Place, findings: Findings) -> tuple[list[Element], np.ndarray]:
    elements: list[Element] = []
    starts: list[float] = []
    for geometry in geometries:
        length = place.number(geometry, "length")
        if length < 0.0:
            raise place.error(geometry, f"length is {length:g} m, expected more than 0")
        if length < SHORTEST:
            findings.warn(place.at(geometry), f"geometry of length {length:g} m is skipped")
            continue
        element = _element(geometry, place, length)
        start = place.number(geometry, "s")
        if elements:
            slip = start - starts[-1] - elements[-1].length
            if abs(slip) > MEET:
                findings.warn(place.at(geometry), f"geometry starts at a station {slip:+.4f} m off the end of the one before; lengths count")
            start = starts[-1] + elements[-1].length
        elif abs(start) > MEET:
            findings.warn(place.at(geometry), f"first geometry starts at s = {start:g} m, expected 0; stations count from there")
            start = 0.0
        else:
            start = 0.0
        elements.append(element)
        starts.append(start)
    if not elements:
        raise place.error(node, f"id {node.get('id')!r} has no geometry, expected planView/geometry")
    if starts[-1] + elements[-1].length > LONGEST:
        raise place.error(node, f"id {node.get('id')!r} is {starts[-1] + elements[-1].length:g} m long, expected at most {LONGEST:g}")
    return elements, np.array(starts)


def _check_joints(roads: dict[str, RoadRecord], findings: Findings) -> None:
    """Roads whose elements do not meet become errors and are taken out; small gaps become warnings."""
    if not roads:
        return
    owners = [road for road in roads.values() for _ in road.elements]
    elements = [element for road in roads.values() for element in road.elements]
    follows = np.array([before is owner for before, owner in zip([None, *owners[:-1]], owners, strict=True)])
    view = PlanView(elements, follows)
    every = np.arange(len(elements))
    ends, last = view.at(every, view.length)
    first = view.at(every, np.zeros(len(elements)))[1]
    gap = np.where(follows, np.hypot(view.x - np.roll(ends[:, 0], 1), view.y - np.roll(ends[:, 1], 1)), 0.0)
    kink = np.where(follows, np.abs((first - np.roll(last, 1) + np.pi) % (2.0 * np.pi) - np.pi), 0.0)
    for k in np.flatnonzero((gap > MEET) | (kink > SMOOTH)):
        road = owners[k]
        number = k - next(j for j, owner in enumerate(owners) if owner is road)
        where = f"geometry {number} starts {gap[k]:.4f} m and {kink[k]:.4f} rad away from the end of the one before"
        if gap[k] > APART or kink[k] > SHARP:
            if roads.pop(road.id, None) is not None:
                findings.error(RoadError(f"{road.place}: road {road.id}: {where}, expected at most {APART} m and {SHARP} rad"))
        else:
            findings.warn(road.place, f"road {road.id}: {where}")


def _element(node: Node, place: Place, length: float) -> Element:
    x, y, heading = place.numbers(node, ("x", "y", "hdg"))
    frame = (x, y, heading, length)
    shape = node[0] if len(node) else None
    if shape is None:
        raise place.error(node, "holds nothing, expected line, arc, spiral, poly3 or paramPoly3")
    kind = shape.tag
    if kind == "line":
        return Clothoid(*frame)
    if kind == "arc":
        kappa = _curvature(shape, place, "curvature")
        return Clothoid(*frame, kappa, kappa)
    if kind == "spiral":
        return Clothoid(*frame, _curvature(shape, place, "curvStart"), _curvature(shape, place, "curvEnd"))
    if kind == "poly3":
        v = (place.number(shape, "a"), place.number(shape, "b"), place.number(shape, "c"), place.number(shape, "d"))
        return _poly3(node, place, frame, v)
    if kind == "paramPoly3":
        u, v = (tuple(place.number(shape, f"{letter}{axis}") for letter in "abcd") for axis in "UV")
        extent = shape.get("pRange", "normalized")
        if extent not in ("arcLength", "normalized"):
            raise place.error(shape, f"pRange is {extent!r}, expected arcLength or normalized")
        element = Cubic(*frame, u, v, *((length, "unit") if extent == "arcLength" else (1.0, "arc")))  # pyright: ignore[reportArgumentType]
        return _usable(node, place, element)
    raise place.error(node, f"holds {kind}, expected line, arc, spiral, poly3 or paramPoly3")


def _curvature(node: Node, place: Place, key: str) -> float:
    kappa = place.number(node, key)
    if abs(kappa) > 10.0:
        raise place.error(node, f"{key} is {kappa:g} 1/m, expected a radius of at least 0.1 m")
    return kappa


def _poly3(node: Node, place: Place, frame: tuple[float, float, float, float], v: tuple[float, float, float, float]) -> Element:
    """The parameter u at the end is where the curve is as long as the element says; the curve is never shorter than u."""
    length = frame[3]
    whole = _usable(node, place, Cubic(*frame, (0.0, 1.0, 0.0, 0.0), v, length, "arc"))
    end = length
    for _ in range(30):
        made = Cubic(*frame, (0.0, 1.0, 0.0, 0.0), v, end, "arc")
        slope = np.hypot(1.0, v[1] + (2.0 * v[2] + 3.0 * v[3] * end) * end)
        end = min(max(end - (made.true_length - length) / slope, 0.0), length)
    return whole if end <= 0.0 else Cubic(*frame, (0.0, 1.0, 0.0, 0.0), v, end, "arc")


def _usable(node: Node, place: Place, element: Cubic) -> Cubic:
    """A cubic that moves on everywhere and is about as long as it says. (Plain Python: files hold thousands.)"""
    slowest, sharpest, way = float("inf"), 0.0, 0.0
    (_, bu, cu, du), (_, bv, cv, dv) = element.u, element.v
    for k in range(17):
        p = element.end * k / 16.0
        ru, rv = bu + (2.0 * cu + 3.0 * du * p) * p, bv + (2.0 * cv + 3.0 * dv * p) * p
        speed = (ru * ru + rv * rv) ** 0.5
        slowest = min(slowest, speed)
        sharpest = max(sharpest, abs(ru * (2.0 * cv + 6.0 * dv * p) - rv * (2.0 * cu + 6.0 * du * p)) / max(speed, 1e-9) ** 3)
        way += speed * element.end / 16.0 * (0.5 if k in (0, 16) else 1.0)
    if not slowest * element.end > 1e-2 * element.length:
        raise place.error(node, "cubic stands still or turns back, expected a curve that moves on along the road")
    if not 0.5 < way / element.length < 2.0:
        raise place.error(node, f"cubic is about {way:.3f} m long, expected its length {element.length:.3f} m")
    if not sharpest < 10.0:
        raise place.error(node, f"cubic bends with {sharpest:.3g} 1/m, expected a radius of at least 0.1 m")
    return element


def _connections(node: Node, place: Place, findings: Findings) -> tuple[Connection, ...]:
    if node.get("type") == "virtual":
        findings.note(place.at(node), "virtual junctions are not read: the main road goes on, nobody turns off")
        return ()
    found = []
    for connection in node.findall("connection"):
        other, incoming = connection.get("connectingRoad") or connection.get("linkedRoad"), connection.get("incomingRoad")
        contact = connection.get("contactPoint", "start")
        if not other or not incoming or contact not in ("start", "end"):
            where = f"leads from road {incoming!r} to {other!r} at contactPoint {contact!r}"
            findings.warn(place.at(connection), f"<connection> {where}, expected ids of roads, at start or end; it is left out")
            continue
        numbers = [[place.optional(link, key, None, findings) for key in ("from", "to")] for link in connection.findall("laneLink")]
        lanes = tuple((int(begin), int(end)) for begin, end in numbers if begin is not None and end is not None)
        found.append(Connection(incoming, other, contact, lanes))
    return tuple(found)
