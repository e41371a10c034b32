"""Wounds of OpenDRIVE maps: sections, lanes, links, junctions, geometry."""

from __future__ import annotations

import copy
from xml.etree import ElementTree as ET

import numpy as np

from .chance import NUMBERS, WORDS, Node, any_of, one_of, shuffle, spoil, value

KINDS = [
    "driving",
    "entry",
    "exit",
    "onRamp",
    "bidirectional",
    "none",
    "median",
    "sidewalk",
    "parking",
    "shoulder",
    "border",
    "restricted",
    "biking",
    "xyz",
]


def sections(root: Node, rng: np.random.Generator) -> None:
    shuffle(any_of(root, rng, "road/lanes"), "laneSection", rng)


def section_stations(root: Node, rng: np.random.Generator) -> None:
    section = any_of(root, rng, "road/lanes/laneSection")
    others = [node.get("s", "0") for node in root.iterfind("road/lanes/laneSection")]
    if rng.random() < 0.5 or not others:
        spoil(section, rng, "s")
    else:
        section.set("s", one_of(rng, others))


def split_section(root: Node, rng: np.random.Generator) -> None:
    """A copy of a section a little further on, or at the same station."""
    lanes = any_of(root, rng, "road/lanes")
    found = lanes.findall("laneSection")
    if found:
        section = one_of(rng, found)
        other = copy.deepcopy(section)
        other.set("s", repr(float(section.get("s", "0")) + float(one_of(rng, [0.0, 1e-9, 1e-7, 1e-5, 1e-3, 0.02, 0.3, 5.0]))))
        lanes.insert(list(lanes).index(section) + 1, other)


def lane_numbers(root: Node, rng: np.random.Generator) -> None:
    side = any_of(root, rng, "road/lanes/laneSection/left", "road/lanes/laneSection/right")
    lanes = side.findall("lane")
    if not lanes:
        return
    one, other = one_of(rng, lanes), one_of(rng, lanes)
    if rng.random() < 0.4:
        a, b = one.get("id", ""), other.get("id", "")
        one.set("id", b)
        other.set("id", a)
    else:
        one.set("id", str(one_of(rng, [*range(-6, 7), 99, -1000000, "x", "1.5"])))


def lanes_come_and_go(root: Node, rng: np.random.Generator) -> None:
    shuffle(any_of(root, rng, "road/lanes/laneSection/left", "road/lanes/laneSection/right"), "lane", rng)


def lane_kinds(root: Node, rng: np.random.Generator) -> None:
    lane = any_of(root, rng, "road/lanes/laneSection/*/lane")
    if rng.random() < 0.8:
        lane.set("type", one_of(rng, KINDS))
    else:
        lane.set("direction", one_of(rng, ["reversed", "both", "standard", "x"]))


def widths(root: Node, rng: np.random.Generator) -> None:
    spoil(any_of(root, rng, "road/lanes/laneSection/*/lane/width"), rng, "a", "a", "a", "b", "c", "d", "sOffset")


def width_records(root: Node, rng: np.random.Generator) -> None:
    """All widths of a lane gone, doubled, opening from nothing, or borders instead."""
    lane = any_of(root, rng, "road/lanes/laneSection/*/lane")
    found = lane.findall("width")
    kind = int(rng.integers(4))
    if kind == 0:
        for node in found:
            lane.remove(node)
    elif kind == 1:
        ET.SubElement(lane, "width", sOffset="10", a="0", b="0", c=repr(0.01), d="0")
    elif kind == 2 and found:
        found[0].attrib.update(a="0", b=one_of(rng, ["0.35", "-0.1", "0", "1e-9"]))
    else:
        for node in found:
            node.tag = "border"


def lane_offsets(root: Node, rng: np.random.Generator) -> None:
    lanes = any_of(root, rng, "road/lanes")
    if rng.random() < 0.5 or lanes.find("laneOffset") is None:
        lanes.insert(0, ET.Element("laneOffset", s=value(rng), a=value(rng), b="0", c="0", d=one_of(rng, ["0", "1e-3"])))
    else:
        spoil(any_of(lanes, rng, "laneOffset"), rng, "s", "a", "b", "c", "d")


def lane_links(root: Node, rng: np.random.Generator) -> None:
    lane = any_of(root, rng, "road/lanes/laneSection/*/lane")
    link = lane.find("link")
    if link is None:
        link = ET.SubElement(lane, "link")
    kind = rng.random()
    if kind < 0.3:
        lane.remove(link)
    elif kind < 0.9:
        for node in link:
            node.set("id", str(one_of(rng, [*range(-4, 5), lane.get("id", "1"), "x"])))
    else:
        ET.SubElement(link, one_of(rng, ["predecessor", "successor"]), id=str(one_of(rng, list(range(-4, 5)))))


def road_links(root: Node, rng: np.random.Generator) -> None:
    road = any_of(root, rng, "road")
    link = any_of(road, rng, "link/predecessor", "link/successor")
    ids = [node.get("id", "") for node in (*root.iterfind("road"), *root.iterfind("junction"))]
    kind = int(rng.integers(4))
    if kind == 0:
        link.set("contactPoint", one_of(rng, ["start", "end", "", "middle"]))
    elif kind == 1:
        link.set("elementId", one_of(rng, [*ids, road.get("id", ""), "nowhere"]))
    elif kind == 2:
        link.set("elementType", one_of(rng, ["road", "junction", "x"]))
    else:
        parent = road.find("link")
        if parent is not None:
            parent.clear()
            ET.SubElement(
                parent, "successor", elementType="road", elementId=one_of(rng, [road.get("id", ""), *ids]), contactPoint=one_of(rng, ["start", "end"])
            )


def connections(root: Node, rng: np.random.Generator) -> None:
    connection = any_of(root, rng, "junction/connection")
    ids = [node.get("id", "") for node in root.iterfind("road")]
    kind = int(rng.integers(5))
    if kind < 2:
        connection.set(["incomingRoad", "connectingRoad"][kind], one_of(rng, [*ids, "nowhere"]))
    elif kind == 2:
        connection.set("contactPoint", one_of(rng, ["start", "end", "x", ""]))
    elif kind == 3:
        any_of(connection, rng, "laneLink").set(one_of(rng, ["from", "to"]), str(one_of(rng, [*range(-5, 6), "x", "1e9"])))
    else:
        shuffle(any_of(root, rng, "junction"), "connection", rng)


def whole_roads(root: Node, rng: np.random.Generator) -> None:
    road = any_of(root, rng, "road")
    kind = int(rng.integers(5))
    if kind == 0:
        shuffle(root, "road", rng)
    elif kind == 1:
        spoil(road, rng, "length")
    elif kind == 2:
        road.set("rule", one_of(rng, ["LHT", "RHT", "x"]))
    elif kind == 3:
        road.set("junction", one_of(rng, ["-1", "100", "x", ""]))
    else:
        road.set("id", one_of(rng, [node.get("id", "") for node in root.iterfind("road")]))


def geometries(root: Node, rng: np.random.Generator) -> None:
    if rng.random() < 0.3:
        shuffle(any_of(root, rng, "road/planView"), "geometry", rng)
    else:
        spoil(any_of(root, rng, "road/planView/geometry"), rng, "length", "length", "hdg", "x", "y", "s")


def shapes(root: Node, rng: np.random.Generator) -> None:
    geometry = any_of(root, rng, "road/planView/geometry")
    if rng.random() < 0.5 and len(geometry):
        shape = geometry[0]
        keys = [key for key in shape.attrib if key != "pRange"]
        if keys:
            spoil(shape, rng, *keys)
            return
    for child in list(geometry):
        geometry.remove(child)
    kind = int(rng.integers(5))
    if kind == 0:
        ET.SubElement(geometry, "arc", curvature=one_of(rng, ["0.1", "9.9", "-3", "1e-12", "0.5"]))
    elif kind == 1:
        geometry.set("length", one_of(rng, ["1e-5", "0.001", "0.05", "300"]))
        ET.SubElement(geometry, "spiral", curvStart=one_of(rng, ["0", "9", "-9"]), curvEnd=one_of(rng, ["0.1", "9", "1e-9"]))
    elif kind == 2:
        ET.SubElement(geometry, "poly3", a=one_of(rng, ["0", "5"]), b=one_of(rng, ["0", "30"]), c=value(rng), d=value(rng))
    elif kind == 3:
        row = {f"{letter}{axis}": one_of(rng, ["0", "0", "1", "10", "-3", "50"]) for letter in "abcd" for axis in "UV"}
        ET.SubElement(geometry, "paramPoly3", row, pRange=one_of(rng, ["arcLength", "normalized", "x"]))


def heights(root: Node, rng: np.random.Generator) -> None:
    road = any_of(root, rng, "road")
    profile = road.find("elevationProfile")
    if profile is None:
        profile = ET.SubElement(road, "elevationProfile")
    if profile.find("elevation") is None or rng.random() < 0.4:
        ET.SubElement(profile, "elevation", s=value(rng), a=value(rng), b=value(rng), c="0", d="0")
    else:
        spoil(any_of(profile, rng, "elevation"), rng, "s", "a", "b", "c", "d")


def banks(root: Node, rng: np.random.Generator) -> None:
    road = any_of(root, rng, "road")
    profile = ET.SubElement(road, "lateralProfile")
    ET.SubElement(
        profile, "superelevation", s=value(rng), a=one_of(rng, ["0.1", "1.57", "-3", "30", "nan"]), b=one_of(rng, ["0", "0.01", "5"]), c="0", d="0"
    )


def speeds(root: Node, rng: np.random.Generator) -> None:
    lane = any_of(root, rng, "road/lanes/laneSection/*/lane", "road/type")
    if lane.tag == "type":
        spoil(lane, rng, "s")
    words = [*NUMBERS, *WORDS]
    ET.SubElement(lane, "speed", sOffset=value(rng), max=one_of(rng, words), unit=one_of(rng, ["km/h", "m/s", "mph", "", "knots"]))


def frictions(root: Node, rng: np.random.Generator) -> None:
    ET.SubElement(any_of(root, rng, "road/lanes/laneSection/*/lane"), "material", sOffset=value(rng), friction=value(rng))
