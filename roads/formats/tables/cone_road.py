"""A road out of the gates between cones."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ...borders import dense, offsets_beside, spaced, way_along
from ...crossings import crossings_of
from ...errors import RoadError
from ...findings import Finding
from ...geometry.curve import read_only
from ...lane import Lane
from ...road import Road
from .closing import closed_key
from .cone_strip import gates_between

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from .cone_strip import Cones
    from .table import Rows

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

#: The middle line is smoothed by this share of the road's width (root of the mean square): the middle jumps from gate to gate.
_SMOOTH = 0.03
#: Places of the middle line are this far apart at least, m.
_LEAST_STEP = 0.3
#: More than this share of the cones beside the longest strip means that it is not the road.
_MOST_LEFT = 0.1


def road_between(rows: Rows, left: Cones, right: Cones, *, start: Floats | None, orange: int, known: bool, closed: bool | None) -> Road:
    """The road between left and right cones.

    Args:
        rows: their file, for names and lines.
        left: cones on the left.
        right: cones on the right.
        start: (2,) where the road begins, m; None: at the file's first cone.
        orange: how many cones mark the start.
        known: the colours tell left from right; else the order of the rows does.
        closed: as in `roads.read`.

    Raises:
        RoadError: cones that bound no road; with the line.
    """
    path = rows.path
    try:
        strips = gates_between(left.places, right.places)
    except RoadError as error:
        raise RoadError(f"{path}: {error}") from None
    gates, ring = strips[0] if strips else (np.zeros((0, 2), dtype=np.intp), False)
    _refuse_rest(rows, left, right, gates)
    if not known and _against(left.rows[gates[:, 0]]) + _against(right.rows[gates[:, 1]]) > 0:
        left, right, gates = right, left, gates[::-1, ::-1]
    closed = closed_key(path, rows.keys) if closed is None else closed
    closed = ring if closed is None else closed
    middle = 0.5 * (left.places[gates[:, 0]] + right.places[gates[:, 1]])
    if ring:
        first = min(int(left.rows[0]), int(right.rows[0]))
        begin = start if start is not None else (left.places[0] if left.rows[0] == first else right.places[0])
        turn = -int(np.argmin(np.hypot(*(middle - begin).T)))
        gates, middle = np.roll(gates, turn, axis=0), np.roll(middle, turn, axis=0)
    width = float(np.median(np.hypot(*(left.places[gates[:, 0]] - right.places[gates[:, 1]]).T)))
    try:
        made = _made(rows, left.places[gates[:, 0]], right.places[gates[:, 1]], middle, width, closed)
        line_of = _lines_beside(rows, made, middle, left.rows[gates[:, 0]])
        crossings = crossings_of(made, line_of)
    except RoadError as error:
        raise error if str(error).startswith(str(path)) else RoadError(f"{path}: {error}") from None
    return replace(made, findings=(_assumed(rows, left, right, gates, orange, known, closed), *crossings))


def _made(rows: Rows, left: Floats, right: Floats, middle: Floats, width: float, closed: bool) -> Road:
    keep = spaced(way_along(middle), _LEAST_STEP)
    if closed and np.hypot(*(middle[keep][0] - middle[keep][-1])) < _LEAST_STEP:
        keep[np.flatnonzero(keep)[-1]] = False
    if np.count_nonzero(keep) < 4:
        raise RoadError(f"{np.count_nonzero(keep)} gates between cones of two colours, expected at least 4")
    line = _smooth(middle[keep], _SMOOTH * width, closed=closed)
    bare = Road.from_points(rows.keys.get("name") or rows.path.stem, line, -width, width, closed=closed)
    s = np.linspace(0.0, bare.length, max(int(np.ceil(bare.length)), 8) + 1)
    s = s[:-1] if closed else s
    edges = [_offsets(bare, edge, middle, s, closed) for edge in (right, left)]
    if np.any(edges[1] <= edges[0]):
        x, y = bare.reference.position(s[int(np.argmin(edges[1] - edges[0]))])
        raise RoadError(f"the edges of cones cross near ({x:z.1f}, {y:z.1f}) m, expected left and right ones apart")
    made = Road.from_points(bare.name, bare.reference.position(s), edges[0], edges[1], closed=closed)
    # driven is the smooth middle, not the one between the corners of both edges
    half = np.minimum(made.left, -made.right)
    return replace(made, drive=Lane(1, read_only(-half), read_only(half))) if np.all(half > 0.1 * width) else made


def _smooth(points: Floats, typical: float, *, closed: bool) -> Floats:
    """The smoothing spline (Dierckx) that lies `typical` (m) off the points (n, 2) in the root of the mean square, at these."""
    from scipy.interpolate import splev, splprep

    line = np.vstack([points, points[:1]]) if closed else points
    fitted: Any = splprep(line.T, u=way_along(line), s=len(points) * typical**2, per=closed)
    places: Any = splev(fitted[1], fitted[0])
    return np.column_stack(places)[: len(points)]


def _offsets(road: Road, edge: Floats, middle: Floats, s: Floats, closed: bool) -> Floats:
    """Offsets (k,) of the polyline through the gates' ends `edge` (n, 2) from the road's reference at stations `s` (k,), m."""
    near, _ = road.reference.locate(middle)
    once = np.append(True, np.hypot(*np.diff(edge, axis=0).T) > 1e-9)
    edge, near = edge[once], np.unwrap(near[once], period=road.length) if closed else np.maximum.accumulate(near[once])
    if closed:
        edge, near = np.vstack([edge[-1:], edge, edge[:1]]), np.concatenate([[near[-1] - road.length], near, [near[0] + road.length]])
    line = dense(np.column_stack([edge, near]), 0.5)
    return offsets_beside(road.reference, line[:, :2], line[:, 2], s)


def _against(numbers: Ints) -> int:
    """How many more steps lead to earlier rows than to later ones."""
    steps = np.diff(numbers)
    return int(np.count_nonzero(steps < 0) - np.count_nonzero(steps > 0))


def _refuse_rest(rows: Rows, left: Cones, right: Cones, gates: Ints) -> None:
    """Raise RoadError where the strip leaves more cones beside it than stray ones."""
    rest = _rest(left, right, gates)
    if len(gates) < 4 or len(rest) > _MOST_LEFT * (len(left.rows) + len(right.rows)):
        words = f"{len(rest)} of {len(left.rows) + len(right.rows)} cones lie beside the longest way between the colours ({len(gates)} gates)"
        line = rows.lines[int(rest[0])] if len(rest) else rows.lines[0]
        raise RoadError(f"{rows.path}:{line}: {words}, this one first; expected edges without gaps wider than twice the road")


def _rest(left: Cones, right: Cones, gates: Ints) -> Ints:
    """Rows of the cones that no gate has."""
    return np.sort(np.concatenate([np.delete(left.rows, gates[:, 0]), np.delete(right.rows, gates[:, 1])]))


def _lines_beside(rows: Rows, road: Road, middle: Floats, numbers: Ints) -> Callable[[int], str]:
    """Names the line of the left cone beside a point of the road."""
    near, _ = road.reference.locate(middle)
    return lambda point: f"{rows.path}:{rows.lines[int(numbers[int(np.argmin(np.abs(near - road.s[point])))])]}"


def _assumed(rows: Rows, left: Cones, right: Cones, gates: Ints, orange: int, known: bool, closed: bool) -> Finding:
    rest = _rest(left, right, gates)
    words = f"{len(left.rows)} cones called {left.name!r} are the left edge, {len(right.rows)} called {right.name!r} the right one"
    words += "" if known else " (their names say nothing, the order of the rows does)"
    words += f", straight between cones, {'closed' if closed else 'open'}"
    words += f"; {orange} orange cones or marks of the start are no edge" if orange else ""
    if len(rest):
        lines = ", ".join(str(rows.lines[int(row)]) for row in rest[:8].tolist())
        words += f"; {len(rest)} cones beside the way are left out (lines {lines}{', ...' if len(rest) > 8 else ''})"
    return Finding("warning" if len(rest) else "note", str(rows.path), words)
