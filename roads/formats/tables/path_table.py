"""Path tables: a driven line as columns, in CSV or in MATLAB's .mat (version 5).

Columns by name (`s x y psi v kappa`, with time, height or others among them; units after `_` or in brackets are left aside), or without names
by order:

    2 columns   x, y
    4 columns   x, y, psi, v
    5 columns   s, x, y, psi, v
    6 columns   s, x, y, psi, v, kappa
    7 columns   s, x, y, psi, kappa, v, a           (F1TENTH and TUM racing lines: psi from north)
                t, s, x, y, psi, v, kappa           (where the first column is a time: it starts at 0 and s is the second)

Only x, y and the height make the road. What else the table holds is kept in `Road.columns`, for comparison; rows whose station, time or place
breaks the order are left out, see `roads.formats.tables.order`. A path has no borders: `lane` and `width` give them, else one lane is assumed.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...conditioning.closing import SAME_PLACE, looks_closed
from ...conditioning.conditioned import conditioned, with_drive
from ...conditioning.line import QUIET
from ...conditioning.progress import from_columns
from ...conditioning.recording import Recording
from ...conditioning.spline import noise_of
from ...conditioning.wish import Wish
from ...crossings import crossings_of
from ...errors import RoadError
from ...findings import Finding
from ...road import Road
from .closing import closed_key
from .matlab import read_variables
from .order import in_order
from .table import LARGEST, read_table, shown

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from numpy.typing import NDArray

    from .table import Table

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]
    #: Name, right and left edge, lanes, and what is told of them.
    Strip = tuple[str, float, float, list[tuple[int, float, float]], tuple[Finding, ...]]

#: Width of a lane where nothing is said, m: that of country roads (German guidelines: 3.25 to 3.5 m); a road of two lanes begins at so many m.
STANDARD_LANE, TWO_LANES = 3.5, 5.0
#: Names of one quantity, in lower case, without units.
SYNONYMS = {
    "s": "s", "station": "s", "arclength": "s", "distance": "s",
    "x": "x", "xm": "x", "east": "x", "easting": "x",
    "y": "y", "ym": "y", "north": "y", "northing": "y",
    "z": "z", "height": "z", "elevation": "z",
    "psi": "psi", "heading": "psi", "yaw": "psi", "theta": "psi",
    "v": "v", "vx": "v", "speed": "v", "velocity": "v",
    "kappa": "kappa", "curvature": "kappa",
    "a": "a", "ax": "a", "t": "t", "time": "t",
}  # fmt: skip
#: Units that are read, by quantity; others would be taken for these.
UNITS = {
    "s": ("", "m"), "x": ("", "m"), "y": ("", "m"), "z": ("", "m"), "psi": ("", "rad"), "v": ("", "mps", "m/s"),
    "kappa": ("", "radpm", "rad/m", "1/m", "1pm"), "a": ("", "mps2", "m/s2", "m/s^2"), "t": ("", "s"),
}  # fmt: skip
#: Columns of a table without names, by their number.
ORDERS = {2: "x y", 4: "x y psi v", 5: "s x y psi v", 6: "s x y psi v kappa", 7: "s x y psi kappa v a"}
TIMED = "t s x y psi v kappa"


def columns_of(names: list[str]) -> list[str] | None:
    """Standard names of a header's words; None where x or y is missing or a standard name comes twice."""
    found = []
    for name in names:
        plain = name.lower().split("[")[0].split("(")[0].strip()
        stem, _, unit = plain.partition("_") if plain.partition("_")[0] in SYNONYMS else (plain, "", "")
        unit = unit or name.lower().partition("[")[2].strip("] ") or name.lower().partition("(")[2].strip(") ")
        if SYNONYMS.get(stem) in UNITS and unit not in UNITS[SYNONYMS[stem]]:
            raise RoadError(f"column {name[:40]} is in {unit[:20]}, expected {' or '.join(filter(None, UNITS[SYNONYMS[stem]]))}")
        found.append(SYNONYMS.get(stem, plain))
    return found if found.count("x") == 1 and found.count("y") == 1 and len(set(found)) == len(found) else None


def names_a_line(names: list[str]) -> bool:
    """Whether x and y are among a header's words, whatever their units."""
    try:
        return columns_of(names) is not None
    except RoadError:  # units are refused by who reads the table
        return True


def read(path: Path, *, closed: bool | None = None, lane: float | None = None, width: float | None = None, wish: Wish | None = None) -> Road:
    """Read a path table as a road about it.

    Args:
        path: CSV or .mat.
        closed: True for a circuit, False for an open road, None to let the line `# closed: true` (or `false`) tell, else the gap between its ends.
        lane: width of the lane that the path is the middle of, m; see `borders_of` for what holds without.
        width: width of the whole road, m; what is left of the lane is a lane for the other direction.
        wish: how to take a line that was recorded with noise; None: smoothed where there is noise.

    Raises:
        RoadError: with place, what was found and what was expected.
    """
    if path.suffix.lower() == ".mat":
        columns, name = _from_mat(path)
        return _road(path, columns, name, closed, borders_of(path, lane, width), wish, lambda row: f"{path}: row {row + 1}")
    return of_table(read_table(path), closed=closed, lane=lane, width=width, wish=wish)


def of_table(table: Table, *, closed: bool | None, lane: float | None, width: float | None, wish: Wish | None = None) -> Road:
    """As `read`, from a text table."""
    try:
        names = columns_of(table.names) if table.names else _by_order(str(table.path), table.rows)
    except RoadError as error:
        raise error if str(error).startswith(str(table.path)) else RoadError(f"{table.path}:{table.header}: {error}") from None
    if names is None:
        raise RoadError(f"{table.path}:{table.header}: columns {shown(table.names)}, expected x and y among them, each once")
    if closed is None:
        closed = closed_key(table.path, table.keys)
    borders = borders_of(table.path, lane, width)
    return _road(table.path, dict(zip(names, table.rows.T, strict=True)), table.keys.get("name"), closed, borders, wish, table.at)


def _by_order(path: str, rows: Floats) -> list[str]:
    count = rows.shape[1]
    if count not in ORDERS:
        raise RoadError(f"{path}: {count} columns without names, expected 2 or 4 to 7 (see the documentation of path tables) or a header")
    if count == 7 and _is_time(rows):
        return list(TIMED.split())
    return list(ORDERS[count].split())


def _is_time(rows: Floats) -> bool:
    """Whether columns 3 and 4 move by what column 2 counts: then column 1 is a time."""
    if len(rows) < 2:
        return False
    moved = np.hypot(*np.diff(rows[:, 2:4], axis=0).T)
    # single rows out of order are none of this question
    return bool(np.mean(np.abs(np.diff(rows[:, 1]) - moved) <= 0.05 * moved) > 0.8)


def borders_of(path: Path, lane: float | None, width: float | None) -> tuple[float, float, tuple[Finding, ...]]:
    """Width of the lane and of the road, m, and what was assumed about them.

    Without both: one lane of 3.5 m. With the lane alone: one lane. With the road alone: one lane below 5 m; from there on a lane of half the road, at
    most 3.5 m, and the rest for the other direction.

    Raises:
        RoadError: widths out of range.
    """
    words = ""
    if lane is None and width is None:
        lane = width = STANDARD_LANE
        words = f"holds a line without borders: one lane {lane:g} m wide about it is assumed; lane and width (--lane, --width, m) give others"
    elif width is None:
        width = lane
    elif lane is None:
        lane = width if width < TWO_LANES else min(STANDARD_LANE, 0.5 * width)
        rest = f", {width - lane:g} m on its left are for the other direction" if lane < width else ""
        words = f"holds a line without borders: a lane {lane:g} m wide about it is assumed{rest}; lane (--lane, m) gives another"
    if lane is None or width is None or not (0.5 <= lane <= width <= 1e3):
        raise RoadError(f"{path}: lane {lane} m and width {width} m, expected 0.5 <= lane <= width <= 1000")
    return lane, width, (Finding("note", str(path), words),) if words else ()


def _road(
    path: Path,
    table: dict[str, Floats],
    name: str | None,
    closed: bool | None,
    borders: tuple[float, float, tuple[Finding, ...]],
    wish: Wish | None,
    place: Callable[[int], str],
) -> Road:
    lane, width, assumed = borders
    points = np.column_stack([table["x"], table["y"]])
    order = in_order(points, table.get("s"), table.get("t"), place)
    rows = np.flatnonzero(order.keep)
    table, points = {key: values[rows] for key, values in table.items()}, points[rows]
    edges = [(1, -0.5 * lane, 0.5 * lane)] + ([(-1, 0.5 * lane, width - 0.5 * lane)] if width - lane > 0.5 else [])
    strip = name or path.stem, -0.5 * lane, max(width - 0.5 * lane, 0.5 * lane), edges, (*order.findings, *assumed)
    try:
        if (wish is not None and not wish.raw) or (wish is None and noise_of(points) >= QUIET):
            names = tuple(place(row).rpartition(":")[2].strip() for row in rows.tolist())
            recording = Recording(str(path), points, table.get("z"), table.get("t"), table.get("v"), names)
            return _recorded(recording, strip, closed, wish or Wish())
        made, kept = _as_told(table, points, strip, closed)
    except RoadError as error:
        raise error if str(error).startswith(str(path)) else RoadError(f"{path}: {error}") from None
    return replace(made, findings=made.findings + crossings_of(made, lambda point: place(int(rows[kept][point])), refuse=False))


def _as_told(table: dict[str, Floats], points: Floats, strip: Strip, closed: bool | None) -> tuple[Road, Ints]:
    """The road about the points themselves, with the table's other columns, and which of the rows are its stations."""
    name, right, left, edges, findings = strip
    given = points
    keep = np.append(True, np.hypot(*np.diff(points, axis=0).T) > SAME_PLACE)
    points = points[keep]
    if closed is None:
        closed = looks_closed(points)
    if closed and len(points) > 1 and np.hypot(*(points[0] - points[-1])) < SAME_PLACE:
        keep[np.flatnonzero(keep)[-1]] = False
        points = points[:-1]
    more = {key: _frozen(values[keep]) for key, values in table.items() if key not in ("x", "y", "z")}
    height = table["z"][keep] if "z" in table else 0.0
    made = Road.from_points(name, points, right, left, closed=closed, height=height, lane_edges=edges, columns=more, findings=findings)
    # rows that repeat a place tell that it stood there
    whole = np.append(made.s, made.length) if made.closed else made.s
    at = whole[np.minimum(np.cumsum(np.append(True, np.hypot(*np.diff(given, axis=0).T) > SAME_PLACE)) - 1, len(whole) - 1)]
    recorded = from_columns(at, table.get("t"), table.get("v"))
    if recorded is None and ("t" in table or "v" in table):
        words = "its times and speeds tell of no drive (times that do not increase, or speeds of 0 on the way): they are kept as columns alone"
        findings = (*made.findings, Finding("note", name, words))
        made = replace(made, findings=findings)
    return replace(made, recorded=recorded), np.flatnonzero(keep)


def _recorded(recording: Recording, strip: Strip, closed: bool | None, wish: Wish) -> Road:
    """The road about a line that was recorded with noise; columns that belong to single places are not kept, the drive is."""
    name, right, left, edges, findings = strip
    made = conditioned(recording, wish, closed)
    findings += made.findings
    road = Road.from_points(name, made.points, right, left, closed=made.closed, height=made.height, lane_edges=edges, findings=findings)
    return with_drive(road, made)


def _frozen(values: Floats) -> Floats:
    values = np.array(values, dtype=np.float64)
    values.setflags(write=False)
    return values


def _from_mat(path: Path) -> tuple[dict[str, Floats], str | None]:
    """The table in a .mat file: one matrix, vectors by name, or a struct of vectors."""
    values = read_variables(path)
    if len(values) == 1:
        (only,) = values.values()
        if isinstance(only, dict):
            values = only
        elif only.ndim == 2 and min(only.shape) > 1:
            matrix = only.T if only.shape[0] in ORDERS and only.shape[1] not in ORDERS else only
            _refuse_bad(path, {"matrix": matrix.ravel()})
            return dict(zip(_by_order(str(path), matrix), matrix.T, strict=True)), None
    vectors = {key: value.ravel() for key, value in values.items() if not isinstance(value, dict) and max(value.shape) == value.size > 1}
    try:
        names = columns_of(list(vectors))
    except RoadError as error:
        raise RoadError(f"{path}: {error}") from None
    lengths = {len(vector) for vector in vectors.values()}
    if names is None or len(lengths) != 1:
        kinds = {key: "struct" if isinstance(value, dict) else "x".join(map(str, value.shape)) for key, value in list(values.items())[:12]}
        shapes = ", ".join(f"{key} ({kind})" for key, kind in kinds.items()) or "no real numeric arrays"
        raise RoadError(f"{path}: holds {shapes}; expected one matrix of 2 or 4 to 7 columns, or vectors of one length with x and y among them")
    _refuse_bad(path, vectors)
    return dict(zip(names, vectors.values(), strict=True)), None


def _refuse_bad(path: Path, vectors: dict[str, Floats]) -> None:
    for key, vector in vectors.items():
        good = np.abs(vector) < LARGEST
        if not good.all():
            at = int(np.argmin(good))
            raise RoadError(f"{path}: {key}[{at}] is {vector[at]}, expected a finite number below {LARGEST:g}")
