"""Lanes of an OpenDRIVE or CommonRoad file as strips in the plane, read here independently of the package: what tests hold routes against."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np

from .plan_geometry import Line, cubic

#: Lane types with cars on them, ASAM OpenDRIVE 1.8.
FOR_CARS = {"driving", "entry", "exit", "onRamp", "offRamp", "connectingRamp", "slipLane", "mwyEntry", "mwyExit", "bidirectional", "roadWorks"}
#: Distance of the cells that a lane is divided into, m, and length below which a section counts as nothing.
CELL, NOTHING = 0.5, 0.05


@dataclass(eq=False)
class Strip:
    """One lane of one section as it is driven: borders (n, 2) in its direction; neighbours of one cross-section have theirs side by side.

    `ahead` holds what the file says to follow; `hinted` what only the other side says, or what another link contradicts.
    """

    name: str
    road: str
    left: np.ndarray
    right: np.ndarray
    heading: tuple[float, float]
    tiny: bool = False
    ahead: list[str] = field(default_factory=list)
    hinted: list[str] = field(default_factory=list)
    on_left: str | None = None
    on_right: str | None = None

    @property
    def centre(self) -> np.ndarray:
        return 0.5 * (self.left + self.right)

    @property
    def width(self) -> np.ndarray:
        return np.hypot(*(self.left - self.right).T)

    @property
    def way(self) -> np.ndarray:
        return np.append(0.0, np.cumsum(np.hypot(*np.diff(self.centre, axis=0).T)))


class _Road:
    def __init__(self, node: ET.Element) -> None:
        self.id, self.left_hand = node.get("id", ""), node.get("rule") == "LHT"
        self.line = Line(node.findall("planView/geometry"))
        self.offsets = node.findall("lanes/laneOffset")
        self.sections = node.findall("lanes/laneSection")
        self.starts = [float(one.get("s", "nan")) for one in self.sections]
        self.ends = [*self.starts[1:], self.line.length]
        self.links = {side: node.find(f"link/{side}") for side in ("predecessor", "successor")}

    def lanes(self, k: int) -> dict[int, ET.Element]:
        """By number, from right to left."""
        nodes = self.sections[k].findall("left/lane") + self.sections[k].findall("right/lane")
        return dict(sorted((int(node.get("id", "0")), node) for node in nodes))

    def ways(self, node: ET.Element) -> tuple[int, ...]:
        if node.get("type") == "bidirectional" or node.get("direction") == "both":
            return (1, -1)
        way = (1 if int(node.get("id", "0")) < 0 else -1) * (-1 if self.left_hand else 1)
        return (-way if node.get("direction") == "reversed" else way,)

    def strips(self, k: int) -> dict[str, Strip]:
        start, end = self.starts[k], self.ends[k]
        tiny = end - start < NOTHING
        s = np.linspace(start, max(end, start), max(int(np.ceil((end - start) / CELL)), 4) + 1)
        inner, found = s.copy(), {}
        # a cross-section ends with what ruled before its end
        inner[-1] = max(s[-1] - 1e-7, s[0])
        rows: list[tuple[int, ET.Element, np.ndarray, np.ndarray]] = []
        lanes = self.lanes(k)
        for sign in (1, -1):
            edge = cubic(self.offsets, "s", 0.0, inner)
            for number in sorted((n for n in lanes if n * sign > 0), key=abs):
                outer = edge + sign * np.maximum(cubic(lanes[number].findall("width"), "sOffset", start, inner), 0.0)
                rows.append((number, lanes[number], np.minimum(edge, outer), np.maximum(edge, outer)))
                edge = outer
        for _, node, right, left in rows:
            if node.get("type") in FOR_CARS:
                for way in self.ways(node):
                    name = self.name(k, node, way)
                    found[name] = self._strip(name, s, left, right, way, tiny)
        order = sorted(rows, key=lambda row: row[0])
        for (_, a, _, _), (_, b, _, _) in itertools.pairwise(order):
            for way in set(self.ways(a)) & set(self.ways(b)) if {a.get("type"), b.get("type")} <= FOR_CARS else ():
                right, left = (self.name(k, one, way) for one in ((a, b) if way > 0 else (b, a)))
                found[right].on_left, found[left].on_right = left, right
        return found

    def _strip(self, name: str, s: np.ndarray, left: np.ndarray, right: np.ndarray, way: int, tiny: bool) -> Strip:
        place, heading = self.line.at(s)
        normal = np.column_stack([-np.sin(heading), np.cos(heading)])
        a, b = place + left[:, None] * normal, place + right[:, None] * normal
        if way < 0:
            a, b = b[::-1], a[::-1]
        middle = 0.5 * (a + b)
        return Strip(name, self.id, a, b, (_direction(middle), _direction(middle[::-1] * -1.0)), tiny)

    def name(self, k: int, node: ET.Element, way: int) -> str:
        return f"{self.id}/{k}/{node.get('id')}" + ("~" if len(self.ways(node)) == 2 and way < 0 else "")


def _direction(line: np.ndarray) -> float:
    """At the beginning of `line`: that of the parabola through its first three points."""
    d = np.hypot(*np.diff(line[:3], axis=0).T)
    if d.min() < 1e-9:
        return float(np.arctan2(*(line[-1] - line[0])[::-1]))
    first, second = (line[1] - line[0]) / d[0], (line[2] - line[1]) / d[1]
    return float(np.arctan2(*(first - (second - first) * d[0] / (d[0] + d[1]))[::-1]))


def numbers(lane: ET.Element, way: int) -> list[int]:
    tag = "successor" if way > 0 else "predecessor"
    return [int(node.get("id", "0")) for node in lane.findall(f"link/{tag}")]


def opendrive(path: Path) -> dict[str, Strip]:
    """All strips of an OpenDRIVE file; sections are counted in the order of the file."""
    root = ET.parse(path).getroot()
    made = {road.id: road for road in map(_Road, root.findall("road"))}
    strips = {name: strip for road in made.values() for k in range(len(road.sections)) for name, strip in road.strips(k).items()}
    junctions = {node.get("id", ""): node.findall("connection") for node in root.findall("junction")}
    for road in made.values():
        for k in range(len(road.sections)):
            for lane in road.lanes(k).values():
                for way in road.ways(lane) if lane.get("type") in FOR_CARS else ():
                    strip = strips[road.name(k, lane, way)]
                    strip.ahead, strip.hinted = _ahead(made, junctions, road, k, lane, way)
    for strip in strips.values():
        strip.ahead = [name for name in strip.ahead if name in strips]
        strip.hinted = [name for name in strip.hinted if name in strips]
    return strips


def _ahead(
    made: dict[str, _Road], junctions: dict[str, list[ET.Element]], road: _Road, k: int, lane: ET.Element, way: int
) -> tuple[list[str], list[str]]:
    own = int(lane.get("id", "0"))
    if 0 <= k + way < len(road.sections):
        return _entering(road, k + way, way, numbers(lane, way), own)
    link = road.links["successor" if way > 0 else "predecessor"]
    if link is None:
        return [], []
    if link.get("elementType") == "road":
        other = made.get(link.get("elementId", ""))
        if other is None:
            return [], []
        at_start = link.get("contactPoint") == "start"
        return _entering(other, 0 if at_start else len(other.sections) - 1, 1 if at_start else -1, numbers(lane, way), own)
    sure, hinted = [], []
    for connection in junctions.get(link.get("elementId", ""), []):
        other = made.get(connection.get("connectingRoad", ""))
        if connection.get("incomingRoad") != road.id or other is None:
            continue
        at_start = connection.get("contactPoint") == "start"
        wanted = [int(one.get("to", "0")) for one in connection.findall("laneLink") if int(one.get("from", "0")) == own]
        names, _ = _entering(other, 0 if at_start else len(other.sections) - 1, 1 if at_start else -1, wanted, own)
        back = other.links["predecessor" if at_start else "successor"]
        agrees = back is not None and back.get("elementId") == road.id and back.get("contactPoint") == ("end" if way > 0 else "start")
        (sure if agrees else hinted).extend(names)
    return sure, hinted


def _entering(road: _Road, k: int, way: int, wanted: list[int], own: int) -> tuple[list[str], list[str]]:
    """Names of the lanes `wanted` that lead on that way, and of those that name `own` as the one before without being wanted."""
    lanes = road.lanes(k)
    sure = [road.name(k, lanes[n], way) for n in wanted if n in lanes and way in road.ways(lanes[n])]
    hinted = [road.name(k, lane, way) for lane in lanes.values() if way in road.ways(lane) and own in numbers(lane, -way)]
    return sure, [name for name in hinted if name not in sure]


def commonroad(path: Path) -> dict[str, Strip]:
    """All strips of a CommonRoad file."""
    root = ET.parse(path).getroot()
    nodes = {node.get("id", ""): node for node in root.findall("lanelet")}
    raw = {name: [_bound(node, side) for side in ("leftBound", "rightBound")] for name, node in nodes.items()}
    beside = {name: [_same_way(node, side) for side in ("adjacentLeft", "adjacentRight")] for name, node in nodes.items()}
    strips: dict[str, Strip] = {}
    for name, (left, right) in raw.items():
        group, todo = {name}, [name]
        while todo:
            for other in beside[todo.pop()]:
                if other is not None and other in raw and other not in group:
                    group.add(other)
                    todo.append(other)
        count = max(int(_way(line)[-1] / CELL) for one in group for line in raw[one]) + 5
        left, right = (_resampled(line, count) for line in (left, right))
        middle = 0.5 * (left + right)
        # the last segment of a border may turn aside: the direction is that of a metre
        reach = [max(int(np.searchsorted(_way(line), 1.0)), 1) for line in (middle, middle[::-1])]
        reach = [min(k, count - 1) for k in reach]
        heading = tuple(
            float(np.arctan2(*(sign * (line[k] - line[0]))[::-1])) for line, k, sign in ((middle, reach[0], 1), (middle[::-1], reach[1], -1))
        )
        made = Strip(name, name, left, right, heading)  # type: ignore[arg-type]
        made.ahead = [one.get("ref", "") for one in nodes[name].findall("successor") if one.get("ref") in raw]
        made.on_left, made.on_right = beside[name]
        strips[name] = made
    return strips


def _bound(node: ET.Element, side: str) -> np.ndarray:
    return np.array([[float(point.findtext(axis, "nan")) for axis in "xy"] for point in node.findall(f"{side}/point")])


def _same_way(node: ET.Element, side: str) -> str | None:
    other = node.find(side)
    return None if other is None or other.get("drivingDir") != "same" else other.get("ref")


def _way(line: np.ndarray) -> np.ndarray:
    return np.append(0.0, np.cumsum(np.hypot(*np.diff(line, axis=0).T)))


def _resampled(line: np.ndarray, count: int) -> np.ndarray:
    way = _way(line)
    at = np.linspace(0.0, way[-1], count)
    return np.column_stack([np.interp(at, way, line[:, k]) for k in (0, 1)])
