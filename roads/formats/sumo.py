"""SUMO road networks (.net.xml): lanes by their centre line and width, connections through junctions."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ..errors import RoadError
from ..findings import Findings
from .lanelets import Lanelet, network_of, offset_polyline
from .xml import Place, parse

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from ..networks.network import Network
    from .xml import Node

    Floats = NDArray[np.float64]

#: Width of a lane that states none, m (SUMO's own default).
WIDTH = 3.2
#: Edges that are not for driving.
WALKING = {"crossing", "walkingarea", "connector"}


def read_network(path: Path) -> Network:
    """Read a SUMO network; a lane's id is SUMO's (`edge_index`), lanes side by side are those of one edge.

    Raises:
        RoadError: not a SUMO network, or no usable lane.
    """
    root = parse(path, "net")
    place, findings = Place(path), Findings()
    lanes: dict[str, Lanelet] = {}
    left_hand = root.get("lefthand", "false") in ("true", "1")
    for edge in root.findall("edge"):
        if edge.get("function") in WALKING:
            findings.note(place.at(edge), "pedestrian edges are left out")
            continue
        lanes.update(_lanes(edge, place, findings, left_hand=left_hand))
    for connection in root.findall("connection"):
        begin = f"{connection.get('from')}_{connection.get('fromLane')}"
        end = connection.get("via") or f"{connection.get('to')}_{connection.get('toLane')}"
        if begin in lanes and end in lanes:
            lanes[begin].successors.append(end)
    location = root.find("location")
    projection = "" if location is None else location.get("projParameter", "")
    return network_of(
        path, f"SUMO {root.get('version', '')}".strip(), lanes, findings, left_hand=left_hand, geographic="" if projection == "!" else projection
    )


def _lanes(edge: Node, place: Place, findings: Findings, *, left_hand: bool) -> dict[str, Lanelet]:
    made: list[tuple[int, Lanelet]] = []
    for number, node in enumerate(edge.findall("lane")):
        if not _for_cars(node):
            findings.note(place.at(node), "lanes that passenger cars may not use are left out")
            continue
        try:
            made.append((number, _lane(node, place, findings)))
        except RoadError as error:
            findings.error(error)
    # SUMO counts lanes from the outer side; one that is closed to cars lies between its neighbours
    for (first, outer), (second, inner) in pairwise(made):
        if second == first + 1:
            right, left = (inner, outer) if left_hand else (outer, inner)
            right.beside_left, left.beside_right = (left.id, True), (right.id, True)
    return {lane.id: lane for _, lane in made}


def _lane(node: Node, place: Place, findings: Findings) -> Lanelet:
    width = place.number(node, "width", WIDTH)
    if not 0.5 < width < 100.0:
        findings.warn(place.at(node), f"<lane> width is {width:g} m, expected 0.5 to 100 m; {WIDTH:g} m is taken")
        width = WIDTH
    line = _shape(node, place)
    speed = place.optional(node, "speed", np.inf, findings)
    if speed is not None and speed <= 0.0:
        findings.warn(place.at(node), f"<lane> speed is {speed:g} m/s, expected more than 0; the limit is left out")
        speed = None
    sides = offset_polyline(line, 0.5 * width), offset_polyline(line, -0.5 * width)
    return Lanelet(place.word(node, "id"), *sides, place.at(node), limit=np.inf if speed is None else speed)


def _for_cars(node: Node) -> bool:
    allow, disallow = (node.get(key, "").split() for key in ("allow", "disallow"))
    if allow:
        return "passenger" in allow or "all" in allow
    return not ("passenger" in disallow or "all" in disallow)


def _shape(node: Node, place: Place) -> Floats:
    points = []
    for word in place.word(node, "shape").split():
        values = [place.float(node, "shape", part) for part in word.split(",")]
        if len(values) not in (2, 3):
            raise place.error(node, f"shape has a point of {len(values)} numbers, expected x,y or x,y,z")
        points.append(values)
    if len({len(values) for values in points}) > 1:
        raise place.error(node, "shape has points with and without height, expected heights at all or none")
    line = np.array([[*values, 0.0][:3] for values in points])
    line = line[np.append(True, np.hypot(*np.diff(line[:, :2], axis=0).T) > 1e-3)]
    if len(line) < 2:
        raise place.error(node, "shape has fewer than 2 different points")
    return line
