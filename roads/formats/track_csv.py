"""Track CSV: centre line and widths, the layout of the TUM race-track database, with optional columns.

    # name: commute            (optional lines `# key: value`; keys: name, closed, lanes)
    # x_m,y_m,w_tr_right_m,w_tr_left_m[,z_m][,speed_limit_mps]
    0.0,0.0,3.5,3.5,12.0,13.9

Without a header line the first four columns are taken in that order. `lanes` lists the lanes from right to left, each as
`direction right_offset left_offset`, separated by `;`, with direction `forward` or `backward` and offsets in m, positive left.
A file without `closed` is a circuit if the gap between its ends is no more than three times its longest step and lies in line with both ends.
"""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..crossing import mutual_crossings, self_crossings
from ..errors import RoadError
from ..road import Road

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

REQUIRED = ("x_m", "y_m", "w_tr_right_m", "w_tr_left_m")
OPTIONAL = ("z_m", "speed_limit_mps")
KEYS = ("name", "closed", "lanes")

#: Points of the reference closer than this are the same place, m.
SAME_PLACE = 1e-6
#: No coordinate, width, height or limit on Earth is larger in m or m/s.
LARGEST = 1e9
#: A road may pass over itself where the levels are at least this far apart, m.
BRIDGE_CLEARANCE = 3.0
#: Borders that meet again further along than this belong to different parts of the road, m.
LOCAL = 60.0


def read(path: Path, *, closed: bool | None = None) -> Road:
    """Read a track CSV; see the module's description.

    Raises:
        RoadError: with file, line, what was found and what was expected.
    """
    keys, columns, rows, lines = _parse(path)
    table = dict(zip(columns, rows.T, strict=True))
    points = np.column_stack([table["x_m"], table["y_m"]])
    steps = np.hypot(*np.diff(points, axis=0).T)
    if closed is None:
        closed = _closed_key(path, keys)
    gap = float(np.hypot(*(points[0] - points[-1])))
    if closed is None:
        closed = _looks_closed(points, float(np.max(steps, initial=0.0)))
    if closed and gap < SAME_PLACE:
        points, steps, table = points[:-1], steps[:-1], {name: values[:-1] for name, values in table.items()}
    if np.any(steps < SAME_PLACE):
        at = int(np.argmax(steps < SAME_PLACE))
        raise RoadError(f"{path}:{lines[at + 1]}: repeats the point of line {lines[at]}, expected each point once")
    if len(points) < (3 if closed else 2):
        raise RoadError(f"{path}: {len(points)} points, expected at least {3 if closed else 2}")
    width = table["w_tr_right_m"] + table["w_tr_left_m"]
    if np.any(width <= 0.0):
        at = int(np.argmax(width <= 0.0))
        raise RoadError(f"{path}:{lines[at]}: the borders cross: widths {-width[at]:.3f} m beyond each other, expected right + left > 0")
    if np.any(table.get("speed_limit_mps", np.ones(1)) <= 0.0):
        at = int(np.argmax(table["speed_limit_mps"] <= 0.0))
        raise RoadError(f"{path}:{lines[at]}: speed_limit_mps is {table['speed_limit_mps'][at]:g}, expected more than 0")
    road = _road(
        path,
        keys.get("name", path.stem),
        points,
        -table["w_tr_right_m"],
        table["w_tr_left_m"],
        closed=closed,
        height=table.get("z_m", 0.0),
        speed_limit=table.get("speed_limit_mps", np.inf),
        lane_edges=_lanes(path, keys),
    )
    _refuse_crossings(path, road, points, lines)
    return road


def write(road: Road, path: Path) -> None:
    """Write `road` as track CSV through a temporary file beside it.

    Raises:
        RoadError: lanes whose width changes along the road, which this format cannot hold.
    """
    lanes = []
    for lane in road.lanes:
        if np.ptp(lane.right) > 1e-9 or np.ptp(lane.left) > 1e-9:
            if len(road.lanes) == 1:
                break
            raise RoadError(f"{path}: track CSV holds lanes of constant width only, {road.name} has others")
        lanes.append(f"{'forward' if lane.direction > 0 else 'backward'} {lane.right[0]:g} {lane.left[0]:g}")
    points = road.reference.position(road.s)
    columns = [*REQUIRED, "z_m"] + (["speed_limit_mps"] if np.all(np.isfinite(road.speed_limit)) else [])
    table = np.column_stack([points, -road.right, road.left, road.height, road.speed_limit])[:, : len(columns)]
    head = [f"# name: {road.name}", f"# closed: {str(road.closed).lower()}"]
    head += [f"# lanes: {'; '.join(lanes)}"] if lanes else []
    text = "\n".join([*head, "# " + ",".join(columns), *(",".join(_plain(v) for v in row) for row in table)]) + "\n"
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
        Path(temporary).chmod(0o644)
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def _plain(value: float) -> str:
    """Micrometre resolution without trailing zeros."""
    text = f"{value:.6f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _parse(path: Path) -> tuple[dict[str, str], list[str], Floats, list[int]]:
    """Split the file into keys, column names, a table (n, columns) and the line number of each row."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise RoadError(f"{path}: no such file") from None
    except UnicodeDecodeError as error:
        raise RoadError(f"{path}: not a text file (byte {error.start} is not UTF-8)") from None
    except OSError as error:
        raise RoadError(f"{path}: cannot be read: {error.strerror}") from None
    keys: dict[str, str] = {}
    columns: list[str] | None = None
    rows: list[list[float]] = []
    lines: list[int] = []
    for number, raw in enumerate(text.splitlines(), 1):
        line = raw.strip()
        if not line:
            continue
        words = [word.strip() for word in line.lstrip("# ").split(";" if ";" in line and "," not in line else ",")]
        if not rows and columns is None and REQUIRED[0] in words:
            columns = _columns(path, number, words)
        elif line.startswith("#"):
            key, colon, value = line.lstrip("# ").partition(":")
            if colon and key.strip() in KEYS:
                keys[key.strip()] = value.strip()
        else:
            columns = columns or list(REQUIRED)
            rows.append(_row(path, number, words, columns))
            lines.append(number)
    if not rows or columns is None:
        raise RoadError(f"{path}: no data, expected rows of {','.join(REQUIRED)}")
    return keys, columns, np.array(rows), lines


def _columns(path: Path, number: int, words: list[str]) -> list[str]:
    missing = [name for name in REQUIRED if name not in words]
    unknown = [name for name in words if name not in REQUIRED + OPTIONAL]
    if missing or unknown or len(set(words)) != len(words):
        raise RoadError(f"{path}:{number}: columns {','.join(words)}, expected {','.join(REQUIRED)} and perhaps {', '.join(OPTIONAL)}, each once")
    return words


def _row(path: Path, number: int, words: list[str], columns: list[str]) -> list[float]:
    if len(words) != len(columns):
        raise RoadError(f"{path}:{number}: {len(words)} columns, expected {len(columns)} ({','.join(columns)})")
    values: list[float] = []
    for name, word in zip(columns, words, strict=True):
        try:
            value = float(word)
        except ValueError:
            value = float("nan")
        if not abs(value) < LARGEST:
            raise RoadError(f"{path}:{number}: {name} is {word!r}, expected a finite number" + (f" below {LARGEST:g}" if np.isfinite(value) else ""))
        values.append(value)
    return values


def _closed_key(path: Path, keys: dict[str, str]) -> bool | None:
    word = keys.get("closed")
    if word not in (None, "true", "false"):
        raise RoadError(f"{path}: closed is {word!r}, expected true or false")
    return None if word is None else word == "true"


def _looks_closed(points: Floats, longest: float) -> bool:
    """Whether the way from the last point to the first goes on with the road: no longer than three steps and without a sharp turn."""
    if len(points) <= 3:
        return False
    seam = points[0] - points[-1]
    gap = float(np.hypot(*seam))
    if gap < SAME_PLACE:
        return True
    directions = (step / max(float(np.hypot(*step)), SAME_PLACE) for step in (points[-1] - points[-2], points[1] - points[0]))
    return gap <= 3.0 * longest and all(float(direction @ seam) > 0.5 * gap for direction in directions)


def _lanes(path: Path, keys: dict[str, str]) -> list[tuple[int, float, float]]:
    lanes: list[tuple[int, float, float]] = []
    for entry in filter(None, (part.strip() for part in keys.get("lanes", "").split(";"))):
        words = entry.split()
        try:
            direction = {"forward": 1, "backward": -1}[words[0]]
            right, left = float(words[1]), float(words[2])
            if len(words) != 3 or not right < left:
                raise ValueError
        except (KeyError, IndexError, ValueError):
            raise RoadError(
                f"{path}: lane {entry!r}, expected 'forward|backward right_offset left_offset' with right < left, in m, positive left"
            ) from None
        lanes.append((direction, right, left))
    if lanes and not any(direction > 0 for direction, _, _ in lanes):
        raise RoadError(f"{path}: lanes {keys['lanes']!r}, expected at least one forward lane")
    return sorted(lanes, key=lambda lane: lane[1])


def _road(path: Path, name: str, *arguments: Any, **options: Any) -> Road:
    try:
        return Road.from_points(name, *arguments, **options)
    except RoadError as error:
        raise RoadError(f"{path}: {error}") from None


def _refuse_crossings(path: Path, road: Road, points: Floats, lines: list[int]) -> None:
    """A reference that crosses itself on one level, or borders that cross each other, have no corridor."""
    for i, j, place in self_crossings(points, closed=road.closed):
        if abs(road.height[i] - road.height[j]) < BRIDGE_CLEARANCE:
            raise RoadError(
                f"{path}:{lines[j]}: the road crosses itself at ({place[0]:.1f}, {place[1]:.1f}) m, where line {lines[i]} passed on the same level"
            )
    normal = road.reference.normal(road.s)
    edges = (points + road.left[:, None] * normal, points + road.right[:, None] * normal)
    for i, j, place in mutual_crossings(*edges):
        apart = abs(road.s[i] - road.s[j])
        if min(apart, road.length - apart if road.closed else apart) < LOCAL:
            raise RoadError(f"{path}:{lines[i]}: the borders cross at ({place[0]:.1f}, {place[1]:.1f}) m, expected left and right edge apart")
