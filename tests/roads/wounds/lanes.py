"""Wounds of maps that hold lanes as lines: CommonRoad, Lanelet2 (`osm_`), SUMO (`sumo_`)."""

from __future__ import annotations

import copy
from xml.etree import ElementTree as ET

import numpy as np

from .chance import Node, any_of, one_of, shuffle, spoil, value


def points(root: Node, rng: np.random.Generator) -> None:
    bound = any_of(root, rng, "lanelet/leftBound", "lanelet/rightBound")
    found = bound.findall("point")
    if not found:
        return
    kind = int(rng.integers(6))
    point = one_of(rng, found)
    if kind == 0:
        shuffle(bound, "point", rng)
    elif kind == 1:
        bound[:] = found[::-1]
    elif kind == 2:
        axis = point.find(one_of(rng, ["x", "y"]))
        if axis is not None:
            axis.text = value(rng, axis.text or "")
    elif kind == 3:
        ET.SubElement(point, "z").text = value(rng)
    elif kind == 4:
        for other in found[1:]:
            other[:] = copy.deepcopy(list(found[0]))
    else:
        bound[:] = found[: int(rng.integers(0, 3))]


def turned_ends(root: Node, rng: np.random.Generator) -> None:
    """The last segment of a border is short and leads aside or back."""
    found = any_of(root, rng, "lanelet/leftBound", "lanelet/rightBound").findall("point")
    if len(found) > 1:
        for axis in "xy":
            end, before = found[-1].find(axis), found[-2].find(axis)
            if end is not None and before is not None:
                before.text = repr(float(end.text or 0) + float(one_of(rng, [0.0, 1e-6, 1e-3, 0.05, -0.05, 0.3, -0.3])))


def references(root: Node, rng: np.random.Generator) -> None:
    ids = [node.get("id", "") for node in root.iterfind("lanelet")]
    lanelet = any_of(root, rng, "lanelet")
    kind = int(rng.integers(4))
    if kind == 0:
        ET.SubElement(lanelet, one_of(rng, ["successor", "predecessor"]), ref=one_of(rng, [*ids, "777"]))
    elif kind == 1:
        for node in (*lanelet.findall("adjacentLeft"), *lanelet.findall("adjacentRight")):
            node.set("drivingDir", one_of(rng, ["same", "opposite", "x"]))
    elif kind == 2:
        for tag in ("adjacentLeft", "adjacentRight"):
            if (node := lanelet.find(tag)) is None:
                node = ET.SubElement(lanelet, tag, drivingDir=one_of(rng, ["same", "opposite"]))
            node.set("ref", one_of(rng, [*ids, "777"]))
    else:
        for node in lanelet.findall("successor"):
            node.set("ref", one_of(rng, ids))


def whole_lanelets(root: Node, rng: np.random.Generator) -> None:
    lanelet = any_of(root, rng, "lanelet")
    kind = int(rng.integers(4))
    if kind == 0:
        shuffle(root, "lanelet", rng)
    elif kind == 1:
        one, other = lanelet.find("leftBound"), lanelet.find("rightBound")
        if one is not None and other is not None:
            one.tag, other.tag = other.tag, one.tag
    elif kind == 2:
        lanelet.set("id", one_of(rng, ["", "x", "-1", *[node.get("id", "") for node in root.iterfind("lanelet")]]))
    else:
        ET.SubElement(lanelet, "speedLimit").text = value(rng)


def osm_nodes(root: Node, rng: np.random.Generator) -> None:
    kind = int(rng.integers(4))
    if kind == 0:
        shuffle(root, "node", rng)
    elif kind == 1:
        spoil(any_of(root, rng, "node"), rng, "lat", "lon")
    elif kind == 2:
        spoil(any_of(root, rng, "node/tag"), rng, "v")
    else:
        shuffle(any_of(root, rng, "node"), "tag", rng)


def osm_ways(root: Node, rng: np.random.Generator) -> None:
    way = any_of(root, rng, "way")
    found = way.findall("nd")
    kind = int(rng.integers(4))
    if kind == 0:
        shuffle(way, "nd", rng)
    elif kind == 1:
        for one, other in zip(found, [node.get("ref", "") for node in found[::-1]], strict=True):
            one.set("ref", other)
    elif kind == 2 and found:
        one_of(rng, found).set("ref", one_of(rng, [node.get("id", "") for node in root.iterfind("node")] + ["0", "x"]))
    else:
        shuffle(root, "way", rng)


def osm_relations(root: Node, rng: np.random.Generator) -> None:
    kind = int(rng.integers(4))
    member = any_of(root, rng, "relation/member")
    if kind == 0:
        member.set("ref", one_of(rng, [node.get("id", "") for node in (*root.iterfind("way"), *root.iterfind("relation"))] + ["0"]))
    elif kind == 1:
        member.set("role", one_of(rng, ["left", "right", "regulatory_element", "x"]))
    elif kind == 2:
        spoil(any_of(root, rng, "relation/tag", "way/tag"), rng, "v")
    else:
        shuffle(one_of(rng, [root, any_of(root, rng, "relation")]), one_of(rng, ["relation", "member", "tag"]), rng)


def sumo_lanes(root: Node, rng: np.random.Generator) -> None:
    lane = any_of(root, rng, "edge/lane")
    words = lane.get("shape", "0,0 1,1").split()
    kind, k = int(rng.integers(7)), int(rng.integers(len(words)))
    if kind == 0:
        words.insert(k, words[k])
    elif kind == 1:
        words = words[::-1]
    elif kind == 2:
        words = words[:k]
    elif kind == 3:
        words[k] = ",".join([value(rng, words[k].split(",")[0]), *words[k].split(",")[1:]])
    elif kind == 4:
        words[k] += "," + value(rng)
    elif kind == 5:
        spoil(lane, rng, "width", "speed", "length", "index", "id")
    else:
        shuffle(any_of(root, rng, "edge"), "lane", rng)
    if words:
        lane.set("shape", " ".join(words))


def sumo_links(root: Node, rng: np.random.Generator) -> None:
    connection = any_of(root, rng, "connection")
    edges = [node.get("id", "") for node in root.iterfind("edge")]
    lanes = [node.get("id", "") for node in root.iterfind("edge/lane")]
    kind = int(rng.integers(4))
    if kind == 0:
        connection.set(one_of(rng, ["from", "to"]), one_of(rng, [*edges, "x"]))
    elif kind == 1:
        connection.set(one_of(rng, ["fromLane", "toLane"]), one_of(rng, ["0", "1", "2", "-1", "x", "1e9"]))
    elif kind == 2:
        connection.set("via", one_of(rng, [*lanes, "x"]))
    else:
        shuffle(root, one_of(rng, ["connection", "edge"]), rng)
