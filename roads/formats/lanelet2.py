"""Lanelet2 maps (OSM XML): lanelets by their left and right ways, in metres (`local_x`, `local_y`) or in degrees."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from ..errors import RoadError
from ..findings import Findings
from .geodesy import to_plane
from .lanelets import Lanelet, network_of
from .xml import Place, parse

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from ..networks.network import Network
    from .xml import Node

    Floats = NDArray[np.float64]

#: Lanelet subtypes that a car may drive on.
DRIVABLE = {"road", "highway", "play_street", "exit", "bus_lane_shared", ""}
UNITS = {"": 1.0 / 3.6, "km/h": 1.0 / 3.6, "kmh": 1.0 / 3.6, "kph": 1.0 / 3.6, "mph": 0.44704, "m/s": 1.0, "mps": 1.0}


def read_network(path: Path) -> Network:
    """Read a Lanelet2 map. A lanelet with `one_way=no` is driven both ways: the way back is a lanelet of its own, marked `~`.

    Raises:
        RoadError: not OSM XML, no lanelets, or nodes without a position.
    """
    root = parse(path, "osm")
    place, findings = Place(path), Findings()
    nodes, geographic = _nodes(root, place, findings)
    ways = {node.get("id", ""): [nd.get("ref", "") for nd in node.findall("nd")] for node in root.findall("way")}
    rules = {node.get("id", ""): _rule(node, place, findings) for node in root.findall("relation")}
    lanelets: dict[str, Lanelet] = {}
    ends: dict[str, tuple[list[str], list[str]]] = {}
    for node in root.findall("relation"):
        tags = _tags(node)
        if tags.get("type") != "lanelet":
            continue
        if tags.get("subtype", "") not in DRIVABLE or tags.get("participant:vehicle") == "no":
            findings.note(place.at(node), f"lanelets of subtype {tags.get('subtype')} are not for cars and left out")
            continue
        try:
            left, right = _sides(node, place, ways, nodes)
            limit = min(
                (rules.get(member.get("ref", ""), np.inf) for member in node.findall("member") if member.get("role") == "regulatory_element"),
                default=np.inf,
            )
            limit = min(limit, _limit(tags.get("speed_limit", "")))
            _add(lanelets, ends, place.word(node, "id"), left, right, nodes, place.at(node), limit, both=tags.get("one_way") == "no")
        except RoadError as error:
            findings.error(error)
    if not lanelets and not findings.errors():
        raise RoadError(f"{path}: holds no lanelets (relations of type lanelet); plain OpenStreetMap ways have no borders and are not read")
    _connect(lanelets, ends)
    return network_of(path, "Lanelet2", lanelets, findings, geographic=geographic)


def _tags(node: Node) -> dict[str, str]:
    return {tag.get("k", ""): tag.get("v", "") for tag in node.findall("tag")}


def _nodes(root: Node, place: Place, findings: Findings) -> tuple[dict[str, Floats], str]:
    """Places of all nodes by their id, and the projection; a node without a sound position is left out, which its lanelets will miss."""
    found = root.findall("node")
    if not found:
        raise place.error(root, "holds no nodes")
    tags = [_tags(node) for node in found]
    some = any("ele" in tag for tag in tags)
    local = all("local_x" in tag and "local_y" in tag for tag in tags)
    names: list[str] = []
    rows: list[list[float]] = []
    for node, tag in zip(found, tags, strict=True):
        try:
            where = [place.float(node, key, tag[key]) for key in ("local_x", "local_y")] if local else place.numbers(node, ("lat", "lon"))
            names.append(place.word(node, "id"))
            rows.append([*where, _height(node, tag, place, findings, some=some)])
        except RoadError as error:
            findings.error(error)
    if not rows:
        first = findings.errors()[0]
        raise RoadError(f"{first.place}: {first.message}")
    table, origin = np.array(rows), ""
    if not local:
        try:
            table[:, :2], (latitude, longitude) = to_plane(table[:, 0], table[:, 1])
        except RoadError as error:
            raise RoadError(f"{place.path}: {error}") from None
        origin = f"+proj=tmerc +lat_0={latitude} +lon_0={longitude} +k=1 +ellps=WGS84"
    return dict(zip(names, table, strict=True)), origin


def _height(node: Node, tags: dict[str, str], place: Place, findings: Findings, *, some: bool) -> float:
    """Height, m; NaN where others have one and this node has none."""
    if "ele" not in tags:
        return np.nan if some else 0.0
    try:
        return place.float(node, "ele", tags["ele"])
    except RoadError as error:
        findings.warn(place.at(node), f"{str(error).removeprefix(place.at(node) + ': ')}; the height is left out")
        return np.nan


def _rule(node: Node, place: Place, findings: Findings) -> float:
    """The limit that a regulatory element sets, m/s: German signs 274-v in km/h, or a speed in words; inf where it sets none."""
    tags = _tags(node)
    if tags.get("type") != "regulatory_element" or tags.get("subtype") != "speed_limit":
        return np.inf
    word = tags.get("max_speed") or tags.get("limit") or tags.get("sign_type", "")
    sign = re.fullmatch(r"\s*(?:[a-z]{2})?274-([0-9]{1,3})\s*", word, re.ASCII | re.IGNORECASE)
    limit = float(sign[1]) / 3.6 if sign else _limit(word)
    if np.isinf(limit):
        findings.warn(place.at(node), f"speed limit {word[:40]!r} is not understood and not used, expected de274-50 or 50 km/h")
    return limit


def _limit(text: str) -> float:
    """m/s of `50`, `50 km/h`, `30 mph`; inf where there is none."""
    match = re.fullmatch(r"\s*([0-9]{1,4}(?:\.[0-9]{1,6})?)\s*([a-z/]*)\s*", text.lower(), re.ASCII)
    if match is None or match[2] not in UNITS:
        return np.inf
    return float(match[1]) * UNITS[match[2]] or np.inf


def _sides(node: Node, place: Place, ways: dict[str, list[str]], nodes: dict[str, Floats]) -> tuple[list[str], list[str]]:
    sides = []
    for role in ("left", "right"):
        refs = [member.get("ref", "") for member in node.findall("member") if member.get("role") == role]
        if not refs or any(ref not in ways for ref in refs):
            raise place.error(node, f"{node.get('id')} has {role} ways {', '.join(refs) or 'none'}, expected ways that the file holds")
        line = list(ways[refs[0]])
        for ref in refs[1:]:
            line = _chained(line, ways[ref])
        missing = [name for name in line if name not in nodes]
        if missing or len(line) < 2:
            raise place.error(
                node, f"{node.get('id')}: {role} way has {len(line)} nodes{', missing ' + missing[0] if missing else ''}, expected at least 2"
            )
        sides.append(line)
    return _aligned(sides[0], sides[1], nodes)


def _chained(line: list[str], after: list[str]) -> list[str]:
    """`after` put to whichever end of `line` it meets, turned round if need be."""
    if not after or not line:
        return line or after
    for first in (line, line[::-1]):
        for second in (after, after[::-1]):
            if first[-1] == second[0]:
                return first + second[1:]
    return line + after


def _aligned(left: list[str], right: list[str], nodes: dict[str, Floats]) -> tuple[list[str], list[str]]:
    """Both ways in the lanelet's direction: beside each other, the left one to the left."""
    a, b = np.array([nodes[name][:2] for name in left]), np.array([nodes[name][:2] for name in right])
    beside = np.hypot(*(a[0] - b[0])) + np.hypot(*(a[-1] - b[-1]))
    crossed = np.hypot(*(a[0] - b[-1])) + np.hypot(*(a[-1] - b[0]))
    if crossed < beside:
        right, b = right[::-1], b[::-1]
    # the strip between the ways, right one first, is run round counter-clockwise where the left one is on the left
    ring = np.vstack([b, a[::-1]])
    ring = ring - ring[0]
    after = np.roll(ring, -1, axis=0)
    area = float(np.sum(ring[:, 0] * after[:, 1] - ring[:, 1] * after[:, 0]))
    return (left, right) if area > 0.0 else (left[::-1], right[::-1])


def _add(
    lanelets: dict[str, Lanelet],
    ends: dict[str, tuple[list[str], list[str]]],
    identity: str,
    left: list[str],
    right: list[str],
    nodes: dict[str, Floats],
    place: str,
    limit: float,
    *,
    both: bool,
) -> None:
    if identity in lanelets:
        raise RoadError(f"{place}: <relation> id {identity!r} is used twice, expected each once")
    for name, sides in ((identity, (left, right)), (f"{identity}~", (right[::-1], left[::-1])))[: 1 + both]:
        lines = [np.array([nodes[node] for node in side]) for side in sides]
        lanelets[name] = Lanelet(name, lines[0], lines[1], place, limit=limit)
        ends[name] = sides


def _connect(lanelets: dict[str, Lanelet], ends: dict[str, tuple[list[str], list[str]]]) -> None:
    """Successors share their end nodes; neighbours share a way, whatever its direction."""
    starts: dict[tuple[str, str], list[str]] = {}
    by_left: dict[tuple[str, ...], str] = {}
    by_right: dict[tuple[str, ...], str] = {}
    for name, (left, right) in ends.items():
        starts.setdefault((left[0], right[0]), []).append(name)
        by_left[tuple(left)], by_right[tuple(right)] = name, name
    for name, (left, right) in ends.items():
        lanelet = lanelets[name]
        lanelet.successors = [other for other in starts.get((left[-1], right[-1]), []) if other.rstrip("~") != name.rstrip("~")]
        lanelet.beside_left = _other(name, by_right.get(tuple(left)), by_left.get(tuple(left[::-1])))
        lanelet.beside_right = _other(name, by_left.get(tuple(right)), by_right.get(tuple(right[::-1])))


def _other(name: str, same: str | None, opposite: str | None) -> tuple[str, bool] | None:
    """The neighbour that leads the same way, else the one against; the way back over the same ground is no neighbour."""
    if same is not None and same.rstrip("~") != name.rstrip("~"):
        return same, True
    if opposite is not None and opposite.rstrip("~") != name.rstrip("~"):
        return opposite, False
    return None
