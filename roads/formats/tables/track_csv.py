"""Track CSV: centre line and widths, the layout of the TUM race-track database, with optional columns.

    # name: commute            (optional lines `# key: value`; keys: name, closed, lanes, traffic)
    # x_m,y_m,w_tr_right_m,w_tr_left_m[,z_m][,speed_limit_mps][,bank_rad][,friction]
    0.0,0.0,3.5,3.5,12.0,13.9

Without a header line the first four columns are taken in that order. `lanes` lists the lanes from right to left, each as
`direction right_offset left_offset`, separated by `;`, with direction `forward`, `backward` or `both`, and offsets in m, positive left.
A file without `closed` is a circuit if the gap between its ends is at most one and a half of its longest steps and in line with both ends.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ...conditioning.closing import SAME_PLACE, looks_closed
from ...crossings import crossings_of, refuse_crossing_borders
from ...errors import RoadError
from ...lane import Lane
from ...road import Road
from ..text import write_whole
from .closing import closed_key
from .order import by_place
from .table import shown

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from .table import Table

    Floats = NDArray[np.float64]

WAYS = {1: "forward", -1: "backward", 0: "both"}
REQUIRED = ("x_m", "y_m", "w_tr_right_m", "w_tr_left_m")
OPTIONAL = ("z_m", "speed_limit_mps", "bank_rad", "friction")


def of_table(table: Table, *, closed: bool | None = None) -> Road:
    """A track from its table; see the module's description.

    Raises:
        RoadError: with file, line, what was found and what was expected.
    """
    columns = _columns(table)
    order = by_place(table.rows[:, [columns.index("x_m"), columns.index("y_m")]], table.at)
    table = table.only(order.keep)
    path, rows, lines, keys = table.path, table.rows, table.lines, table.keys
    named = dict(zip(columns, rows.T, strict=True))
    points = np.column_stack([named["x_m"], named["y_m"]])
    steps = np.hypot(*np.diff(points, axis=0).T)
    if closed is None:
        closed = closed_key(path, keys)
    if closed is None:
        closed = looks_closed(points)
    if closed and float(np.hypot(*(points[0] - points[-1]))) < SAME_PLACE:
        points, steps, named = points[:-1], steps[:-1], {name: values[:-1] for name, values in named.items()}
    if np.any(steps < SAME_PLACE):
        at = int(np.argmax(steps < SAME_PLACE))
        raise RoadError(f"{path}:{lines[at + 1]}: repeats the point of line {lines[at]}, expected each point once")
    if len(points) < (3 if closed else 2):
        raise RoadError(f"{path}: {len(points)} points, expected at least {3 if closed else 2}")
    width = named["w_tr_right_m"] + named["w_tr_left_m"]
    if np.any(width <= 0.0):
        at = int(np.argmax(width <= 0.0))
        raise RoadError(f"{path}:{lines[at]}: the borders cross: widths {-width[at]:z.3f} m beyond each other, expected right + left > 0")
    for name in ("speed_limit_mps", "friction"):
        if np.any(named.get(name, np.ones(1)) <= 0.0):
            at = int(np.argmax(named[name] <= 0.0))
            raise RoadError(f"{path}:{lines[at]}: {name} is {named[name][at]:g}, expected more than 0")
    road = _road(
        path,
        (keys.get("name") or path.stem)[:200],
        points,
        -named["w_tr_right_m"],
        named["w_tr_left_m"],
        closed=closed,
        height=named.get("z_m", 0.0),
        speed_limit=named.get("speed_limit_mps", np.inf),
        bank=named.get("bank_rad", 0.0),
        friction=named.get("friction", 1.0),
        lane_edges=_lanes(path, keys),
        left_hand=keys.get("traffic") == "left",
        findings=tuple(order.findings),
    )
    try:
        crossings = crossings_of(road, table.at)
        refuse_crossing_borders(road, table.at)
    except RoadError as error:
        raise error if str(error).startswith(str(path)) else RoadError(f"{path}: {error}") from None
    return replace(road, findings=(*road.findings, *crossings))


def write(road: Road, path: Path) -> None:
    """Write `road` as track CSV through a temporary file beside it.

    Raises:
        RoadError: lanes whose width changes along the road, which this format cannot hold.
    """
    road.must_lead_on(path)
    lanes = []
    for lane in road.lanes:
        if not (np.ptp(lane.right) < 1e-9 and np.ptp(lane.left) < 1e-9 and lane.right[0] < lane.left[0]):
            if len(road.lanes) == 1:
                break
            raise RoadError(
                f"{path}: track CSV holds lanes of constant width from start to end only, {road.name} has others; write .xodr or .geojson"
            )
        lanes.append(f"{WAYS[lane.direction]} {_plain(lane.right[0])} {_plain(lane.left[0])}")
    points = road.reference.position(road.s)
    if len(road.lanes) > 1 and drives_another_lane(road):
        raise RoadError(f"{path}: track CSV cannot say which lane of {road.name} is to be driven; write .geojson")
    columns = [*REQUIRED, "z_m"]
    values = [points, -road.right, road.left, road.height]
    for name, data, wanted in (
        ("speed_limit_mps", road.speed_limit, bool(np.any(np.isfinite(road.speed_limit)))),
        ("bank_rad", road.bank, bool(np.any(road.bank))),
        ("friction", road.friction, bool(np.any(road.friction != 1.0))),
    ):
        # where no limit is posted the column says inf
        if wanted:
            columns.append(name)
            values.append(data)
    table = np.column_stack(values)
    head = [f"# name: {road.name}", f"# closed: {str(road.closed).lower()}"]
    head += ["# traffic: left"] if road.left_hand else []
    head += [f"# lanes: {'; '.join(lanes)}"] if lanes else []
    write_whole(path, "\n".join([*head, "# " + ",".join(columns), *(",".join(_plain(v) for v in row) for row in table.tolist())]) + "\n")


def drives_another_lane(road: Road) -> bool:
    """Whether the lane to drive is not the one that a reader of the format would drive."""
    if road.drive is None:
        return False
    return not (np.allclose(road.drive.right, _plainest(road).right) and np.allclose(road.drive.left, _plainest(road).left))


def _plainest(road: Road) -> Lane:
    """The lane that a reader would drive."""
    return replace(road, drive=None).driving_lane()


def _plain(value: float) -> str:
    """Nanometre resolution without trailing zeros: points may lie a centimetre apart, and a spline shows what rounding does to them."""
    return f"{value:z.9f}".rstrip("0").rstrip(".")


def _columns(table: Table) -> list[str]:
    if not table.names:
        if table.rows.shape[1] != len(REQUIRED):
            raise RoadError(f"{table.at(0)}: {table.rows.shape[1]} columns, expected {len(REQUIRED)} ({','.join(REQUIRED)})")
        return list(REQUIRED)
    words = table.names
    missing = [name for name in REQUIRED if name not in words]
    unknown = [name for name in words if name not in REQUIRED + OPTIONAL]
    if missing or unknown or len(set(words)) != len(words):
        raise RoadError(
            f"{table.path}:{table.header}: columns {shown(words)}, expected {','.join(REQUIRED)} and perhaps {', '.join(OPTIONAL)}, each once"
        )
    return words


def _lanes(path: Path, keys: dict[str, str]) -> list[tuple[int, float, float]]:
    lanes: list[tuple[int, float, float]] = []
    for entry in filter(None, (part.strip() for part in keys.get("lanes", "").split(";"))):
        words = entry.split()
        try:
            direction = {word: way for way, word in WAYS.items()}[words[0]]
            right, left = float(words[1]), float(words[2])
            if len(words) != 3 or not right < left:
                raise ValueError
        except (KeyError, IndexError, ValueError):
            raise RoadError(
                f"{path}: lane {entry[:60]!r}, expected 'forward|backward|both right_offset left_offset' with right < left, in m, positive left"
            ) from None
        lanes.append((direction, right, left))
    if lanes and not any(direction >= 0 for direction, _, _ in lanes):
        raise RoadError(f"{path}: lanes {keys['lanes'][:60]!r}, expected at least one forward lane")
    return sorted(lanes, key=lambda lane: lane[1])


def _road(path: Path, name: str, *arguments: Any, **options: Any) -> Road:
    try:
        return Road.from_points(name, *arguments, **options)
    except RoadError as error:
        raise RoadError(f"{path}: {error}") from None
