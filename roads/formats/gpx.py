"""GPX: a track or a route of a receiver, with what it recorded of height, time and speed."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..conditioning.recording import Recording
from ..conditioning.wish import Wish
from ..errors import RoadError
from ..findings import Finding
from .geodesy import to_plane
from .recorded_line import road_about, seconds_of
from .xml import Place, parse

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from ..road import Road
    from .xml import Node

    Floats = NDArray[np.float64]


def read(path: Path, *, closed: bool | None = None, width: float | None = None, wish: Wish | None = None) -> Road:
    """The first track (all its segments in order) or route of a GPX file.

    Raises:
        RoadError: no GPX, or fewer than two places.
    """
    root = parse(path, "gpx")
    place = Place(path)
    tracks = [track for track in root.findall("trk") if track.find("trkseg/trkpt") is not None]
    routes = root.findall("rte")
    chosen = tracks[0] if tracks else routes[0] if routes else None
    nodes = [] if chosen is None else chosen.findall("trkseg/trkpt" if tracks else "rtept")
    if chosen is None or len(nodes) < 2:
        raise place.error(root, f"holds {len(nodes)} points in its first track or route, expected at least 2")
    told: list[Finding] = []
    if len(tracks) + len(routes) > 1:
        which = "track" if tracks else "route"
        told.append(Finding("note", str(path), f"holds {len(tracks)} tracks and {len(routes)} routes, the first {which} is read"))
    degrees = np.array([[place.number(node, "lat"), place.number(node, "lon")] for node in nodes])
    try:
        points, origin = to_plane(*degrees.T)
    except RoadError as error:
        raise RoadError(f"{path}: {error}") from None
    names = tuple(f"line {node.sourceline}, point {k}" for k, node in enumerate(nodes))
    recording = Recording(str(path), points, _heights(nodes, place, told), _times(nodes, path, told), _speeds(nodes, place), names)
    name = (chosen.findtext("name") or path.stem).strip()
    road = road_about(recording, name, closed=closed, width=width, origin=origin, wish=wish or Wish())
    return replace(road, findings=(*told, *road.findings))


def _heights(nodes: list[Node], place: Place, told: list[Finding]) -> Floats | None:
    """Heights (n,); where single points have none, those between their neighbours'."""
    texts = [node.findtext("ele") for node in nodes]
    known = np.array([text is not None and bool(text.strip()) for text in texts])
    if not known.any():
        told.append(Finding("note", str(place.path), "records no heights (ele): the road is taken as level"))
        return None
    heights = np.array([place.float(node, "ele", text) if text and text.strip() else np.nan for node, text in zip(nodes, texts, strict=True)])
    if not known.all():
        first, count = nodes[int(np.argmin(known))], int(np.count_nonzero(~known))
        told.append(Finding("warning", place.at(first), f"has no ele, as {count} of {len(nodes)} points: heights between those of their neighbours"))
        at = np.arange(len(nodes))
        heights = np.interp(at, at[known], heights[known])
    return heights


def _times(nodes: list[Node], path: Path, told: list[Finding]) -> Floats | None:
    words = [(node.findtext("time") or "").strip() for node in nodes]
    if not any(words):
        return None
    if not all(words):
        count = sum(not word for word in words)
        told.append(Finding("warning", str(path), f"{count} of {len(nodes)} points have no time: the file's times are not used"))
        return None
    return seconds_of(str(path), [(f"line {node.sourceline}", word) for node, word in zip(nodes, words, strict=True)])


def _speeds(nodes: list[Node], place: Place) -> Floats | None:
    """Speeds (n,) where every point has one (GPX 1.0, or an extension of 1.1), m/s."""
    words = [node.findtext(".//speed") for node in nodes]
    if not all(word is not None and word.strip() for word in words):
        return None
    return np.maximum([place.float(node, "speed", word or "") for node, word in zip(nodes, words, strict=True)], 0.0)
