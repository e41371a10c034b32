"""CommonRoad XML, 2018b and 2020a: the lanelet network of a scenario; traffic, weather and planning problems are not read."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import RoadError
from ..findings import Findings
from .lanelets import Lanelet, network_of
from .xml import Place, parse

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from ..networks.network import Network
    from .xml import Node

    Floats = NDArray[np.float64]

#: Lanelet types without a car on them.
NOT_FOR_CARS = {"sidewalk", "crosswalk", "bicycleLane", "busLane", "busStop", "shoulder", "border", "parking", "restricted", "unknown_pedestrian"}
#: Traffic sign ids of a speed limit, by country; the value is in m/s.
LIMIT_SIGNS = {"274", "R2-1", "R301", "S13", "B14", "274.1", "C3", "C14"}


def read_network(path: Path) -> Network:
    """Read a CommonRoad scenario.

    Raises:
        RoadError: not a CommonRoad file of 2018b or 2020a, or no usable lanelet.
    """
    root = parse(path, "commonRoad")
    place, findings = Place(path), Findings()
    version = root.get("commonRoadVersion", "")
    if version not in ("2018b", "2020a"):
        raise place.error(root, f"commonRoadVersion is {version!r}, expected 2018b or 2020a")
    limits = _signs(root, place, findings)
    lanelets: dict[str, Lanelet] = {}
    for node in root.findall("lanelet"):
        try:
            lanelet = _lanelet(node, place, limits, findings)
            if lanelet is not None:
                if lanelet.id in lanelets:
                    raise place.error(node, f"id {lanelet.id!r} is used twice, expected each once")
                lanelets[lanelet.id] = lanelet
        except RoadError as error:
            findings.error(error)
    for tag in ("dynamicObstacle", "staticObstacle", "obstacle", "planningProblem", "trafficLight", "intersection"):
        if (first := root.find(tag)) is not None:
            findings.note(place.at(first), f"{tag} is not read")
    return network_of(path, f"CommonRoad {version}", lanelets, findings, name=root.get("benchmarkID", ""))


def _signs(root: Node, place: Place, findings: Findings) -> dict[str, float]:
    limits: dict[str, float] = {}
    for sign in root.findall("trafficSign"):
        for element in sign.findall("trafficSignElement"):
            if (element.findtext("trafficSignID") or "").strip() in LIMIT_SIGNS and element.find("additionalValue") is not None:
                value = _limit(element, "additionalValue", place, findings)
                if value is not None:
                    limits[sign.get("id", "")] = value
    return limits


def _limit(node: Node, tag: str, place: Place, findings: Findings) -> float | None:
    """The speed limit in m/s that a child says; None, with a warning, where it is none."""
    try:
        value = place.float(node, tag, node.findtext(tag))
    except RoadError as error:
        findings.warn(place.at(node), f"{str(error).removeprefix(place.at(node) + ': ')}; the limit is left out")
        return None
    if value <= 0.0:
        findings.warn(place.at(node), f"<{node.tag}> speed limit is {value:g} m/s, expected more than 0; it is left out")
        return None
    return value


def _lanelet(node: Node, place: Place, limits: dict[str, float], findings: Findings) -> Lanelet | None:
    identity = place.word(node, "id")
    kinds = {(kind.text or "").strip() for kind in node.findall("laneletType")}
    if kinds & NOT_FOR_CARS:
        findings.note(place.at(node), f"lanelets of type {', '.join(sorted(kinds & NOT_FOR_CARS))} are not for cars and left out")
        return None
    own = [limits[ref] for sign in node.findall("trafficSignRef") if (ref := sign.get("ref", "")) in limits]
    if node.find("speedLimit") is not None and (old := _limit(node, "speedLimit", place, findings)) is not None:
        own.append(old)
    return Lanelet(
        identity,
        _bound(node, "leftBound", place),
        _bound(node, "rightBound", place),
        place.at(node),
        [place.word(successor, "ref") for successor in node.findall("successor")],
        _beside(node.find("adjacentLeft"), place),
        _beside(node.find("adjacentRight"), place),
        min(own, default=np.inf),
    )


def _bound(node: Node, name: str, place: Place) -> Floats:
    bound = node.find(name)
    if bound is None:
        raise place.error(node, f"has no {name}")
    points = []
    for point in bound.findall("point"):
        z = point.findtext("z")
        values = [place.float(point, axis, point.findtext(axis)) for axis in ("x", "y")]
        points.append([*values, np.nan if z is None else place.float(point, "z", z)])
    line = np.array(points, dtype=np.float64).reshape(-1, 3)
    if np.isnan(line[:, 2]).all():
        line[:, 2] = 0.0
    return line


def _beside(node: Node | None, place: Place) -> tuple[str, bool] | None:
    if node is None:
        return None
    direction = node.get("drivingDir", "same")
    if direction not in ("same", "opposite"):
        raise place.error(node, f"drivingDir is {direction!r}, expected same or opposite")
    return place.word(node, "ref"), direction == "same"
