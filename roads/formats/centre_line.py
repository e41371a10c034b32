"""GeoJSON: lines in degrees or metres, which are taken as recorded, and roads that `write_geojson` wrote."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from ..conditioning.recording import Recording
from ..conditioning.wish import Wish
from ..errors import RoadError
from ..road import Road
from .geodesy import to_degrees, to_plane
from .recorded_line import numbered, road_about, seconds_of
from .text import read_text, write_whole
from .xml import LARGEST

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

#: Name of the coordinate system of a GeoJSON file in metres; without it the standard says degrees.
METRES = "urn:energy-mgr:plane-metres"
_ROLES = ("reference", "left_edge", "right_edge")


def read_geojson(path: Path, *, closed: bool | None = None, width: float | None = None, wish: Wish | None = None) -> Road:
    """A GeoJSON line as it was recorded, or a road that `write_geojson` wrote.

    Raises:
        RoadError: no GeoJSON, or no line.
    """
    try:
        content = json.loads(read_text(path), parse_constant=lambda word: float("nan"))
    except (ValueError, RecursionError) as error:
        where = f":{error.lineno}" if isinstance(error, json.JSONDecodeError) else ""
        raise RoadError(f"{path}{where}: not JSON: {str(error)[:100]}") from None
    if not isinstance(content, dict) or content.get("type") not in ("FeatureCollection", "Feature", "LineString"):
        kind = content.get("type") if isinstance(content, dict) else type(content).__name__
        raise RoadError(f"{path}: is {str(kind)[:40]!r}, expected a FeatureCollection, a Feature or a LineString")
    features = _features(content)
    lines = [
        (feature, geometry) for feature in features if isinstance(geometry := feature.get("geometry"), dict) and geometry.get("type") == "LineString"
    ]
    if not lines:
        raise RoadError(f"{path}: holds no LineString, expected a centre line")
    in_metres = METRES in json.dumps(content.get("crs", ""), default=str)[:500]
    by_role: dict[str, Floats] = {}
    for feature, geometry in lines:
        properties = feature.get("properties")
        role = properties.get("role") if isinstance(properties, dict) else None
        if role in _ROLES and role not in by_role:
            by_role[str(role)] = _coordinates(path, geometry)
    first = lines[0][0].get("properties")
    about: dict[str, Any] = first if isinstance(first, dict) else {}
    name = str(about.get("name") or path.stem)[:200]
    if len(by_role) == len(_ROLES):
        return _own(path, name, by_role, about, closed, in_metres=in_metres)
    table = _coordinates(path, lines[0][1])
    if in_metres:
        points, start = table[:, :2], None
    else:
        try:
            points, start = to_plane(table[:, 1], table[:, 0])
        except RoadError as error:
            raise RoadError(f"{path}: {error}") from None
    has_height = len(lines[0][1]["coordinates"][0]) > 2
    recording = Recording(str(path), points, table[:, 2] if has_height else None, _times(path, about, len(points)), None, numbered(len(points)))
    return road_about(recording, name, closed=closed, width=width, origin=start, wish=wish or Wish())


def _times(path: Path, about: dict[str, Any], count: int) -> Floats | None:
    """Times (n,) in s of the points, as converters of GPX write them: `coordTimes`, or `times` of `coordinateProperties`."""
    nested = about.get("coordinateProperties")
    found = about.get("coordTimes") or (nested.get("times") if isinstance(nested, dict) else None)
    if not isinstance(found, list) or len(found) != count:
        return None
    return seconds_of(str(path), [(f"coordinates[{k}]", str(word)) for k, word in enumerate(found)])


def _features(content: dict[str, Any]) -> list[dict[str, Any]]:
    if content["type"] == "LineString":
        return [{"type": "Feature", "geometry": content}]
    if content["type"] == "Feature":
        return [content]
    found = content.get("features")
    return [feature for feature in found if isinstance(feature, dict)] if isinstance(found, list) else []


def _coordinates(path: Path, geometry: dict[str, Any]) -> Floats:
    rows = geometry.get("coordinates")
    if not isinstance(rows, list) or len(rows) < 2:
        raise RoadError(f"{path}: LineString has {len(rows) if isinstance(rows, list) else 'no'} coordinates, expected at least 2")
    table = np.zeros((len(rows), 3))
    for k, row in enumerate(rows):
        good = isinstance(row, list) and len(row) >= 2 and all(isinstance(value, int | float) and abs(value) < LARGEST for value in row[:3])
        if not good:
            raise RoadError(f"{path}: coordinates[{k}] is {str(row)[:60]}, expected [longitude, latitude] or [longitude, latitude, height]")
        if min(len(row), 3) != min(len(rows[0]), 3):
            raise RoadError(f"{path}: coordinates[{k}] has {len(row)} numbers, coordinates[0] has {len(rows[0])}; expected a height at all or none")
        table[k, : min(len(row), 3)] = row[:3]
    return table


def _own(path: Path, name: str, lines: dict[str, Floats], properties: dict[str, Any], closed: bool | None, *, in_metres: bool) -> Road:
    from ..geometry.curve import PlanarCurve, read_only
    from ..lane import Lane

    origin: tuple[float, float] | None = None
    try:
        if not in_metres:
            given = properties.get("origin")
            fixed = given if isinstance(given, list) and len(given) == 2 and all(isinstance(v, int | float) for v in given) else None
            origin = (float(fixed[0]), float(fixed[1])) if fixed else (float(lines["reference"][0, 1]), float(lines["reference"][0, 0]))
            lines = {role: np.column_stack([to_plane(line[:, 1], line[:, 0], origin)[0], line[:, 2]]) for role, line in lines.items()}
        count = {len(line) for line in lines.values()}
        if len(count) != 1:
            raise RoadError(f"reference and edges have {sorted(count)} points, expected as many in each")
        middle = lines["reference"]
        closed = bool(properties.get("closed", False)) if closed is None else closed
        reference = PlanarCurve.through(middle[:, :2], closed=closed)
        s = reference.breaks_s[:-1] if closed else reference.breaks_s
        normal = reference.normal(s)
        right, left = (np.sum((lines[role][:, :2] - middle[:, :2]) * normal, axis=1) for role in ("right_edge", "left_edge"))
        limits = properties.get("speed_limit_mps")
        limit = np.full(len(s), np.inf)
        if isinstance(limits, list) and len(limits) == len(s) and all(v is None or (isinstance(v, int | float) and v > 0) for v in limits):
            limit = np.array([np.inf if value is None else float(value) for value in limits])
        edges = read_only(right), read_only(left)
        lanes = _lanes(properties.get("lanes"), s, edges) or (Lane(1, *edges),)
        bank, friction = (_numbers(properties.get(key), s, standard) for key, standard in (("bank_rad", 0.0), ("friction", 1.0)))
        drive = next(iter(_lanes([properties["drive"]] if isinstance(properties.get("drive"), dict) else None, s, edges)), None)
        left_hand = properties.get("left_hand") is True
        height = read_only(middle[:, 2])
        return Road(
            name, reference, read_only(s), *edges, height, read_only(limit), lanes, bank, friction, drive=drive, left_hand=left_hand, origin=origin
        )
    except RoadError as error:
        raise RoadError(f"{path}: {error}") from None


def _lanes(given: Any, s: Floats, edges: tuple[Floats, Floats]) -> tuple[Any, ...]:
    """Lanes by their offsets; what rounding puts beyond an edge goes back to it."""
    from ..geometry.curve import read_only
    from ..lane import Lane

    found = []
    for lane in given if isinstance(given, list) else []:
        if not isinstance(lane, dict) or lane.get("direction") not in (-1, 0, 1):
            raise RoadError(f"lane {str(lane)[:60]}, expected direction -1, 0 or 1 with right and left offsets")
        try:
            right, left = (np.array([np.nan if v is None else float(v) for v in lane[side]], dtype=np.float64) for side in ("right", "left"))
        except (KeyError, TypeError, ValueError):
            raise RoadError("lane without right and left offsets, expected lists of numbers") from None
        if len(right) != len(s) or len(left) != len(s):
            raise RoadError(f"lane with {len(right)} and {len(left)} offsets, expected {len(s)}")
        right, left = (np.where(_near(side, edges), np.clip(side, *edges), side) for side in (right, left))
        found.append(Lane(int(lane["direction"]), read_only(right), read_only(left), str(lane.get("kind", "driving")), str(lane.get("name", ""))))
    return tuple(found)


def _numbers(given: Any, s: Floats, standard: float) -> Floats:
    """A list of finite numbers as long as `s`, or `standard` everywhere where there is none."""
    from ..geometry.curve import read_only

    if given is None:
        return read_only(np.full(len(s), standard))
    good = isinstance(given, list) and len(given) == len(s) and all(isinstance(v, int | float) and abs(v) < LARGEST for v in given)
    if not good:
        raise RoadError(f"a property is {str(given)[:40]}, expected {len(s)} finite numbers")
    return read_only(given)


def _near(side: Floats, edges: tuple[Floats, Floats]) -> NDArray[np.bool_]:
    return (side > edges[0] - 1e-3) & (side < edges[1] + 1e-3)


def write_geojson(road: Road, path: Path) -> None:
    """Write reference and edges as lines: in degrees where the road knows its origin, else in metres with a coordinate system that says so.

    Raises:
        RoadError: the file cannot be written.
    """
    road.must_lead_on(path)
    points, normal = road.reference.position(road.s), road.reference.normal(road.s)
    lines = {"reference": points, "left_edge": points + road.left[:, None] * normal, "right_edge": points + road.right[:, None] * normal}
    features = []
    for role, line in lines.items():
        plane = line if road.origin is None else to_degrees(line, road.origin)
        digits = 9 if road.origin is None else 14
        rows = [[round(x, digits), round(y, digits), round(z, 9)] for (x, y), z in zip(plane.tolist(), road.height.tolist(), strict=True)]
        properties: dict[str, Any] = {"role": role, "name": road.name, "closed": road.closed}
        if role == "reference":
            properties |= {
                "speed_limit_mps": [v if np.isfinite(v) else None for v in road.speed_limit.tolist()],
                "lanes": [
                    {"direction": lane.direction, "kind": lane.kind, "name": lane.name, "right": _listed(lane.right), "left": _listed(lane.left)}
                    for lane in road.lanes
                ],
                "origin": None if road.origin is None else list(road.origin),
                "bank_rad": _listed(road.bank),
                "friction": _listed(road.friction),
                "left_hand": road.left_hand,
                "drive": None if road.drive is None else {"direction": 1, "right": _listed(road.drive.right), "left": _listed(road.drive.left)},
            }
        features.append({"type": "Feature", "properties": properties, "geometry": {"type": "LineString", "coordinates": rows}})
    content: dict[str, Any] = {"type": "FeatureCollection", "features": features}
    if road.origin is None:
        content["crs"] = {"type": "name", "properties": {"name": METRES}}
    write_whole(path, json.dumps(content))


def _listed(values: Floats) -> list[float | None]:
    return [round(value, 9) if np.isfinite(value) else None for value in values.tolist()]
