"""Roads as left and right edge, point by point beside each other: columns `left_x_m, left_y_m, right_x_m, right_y_m`, with optional heights.

# name: test, # closed: true    as in track CSV
left_x_m,left_y_m,right_x_m,right_y_m[,left_z_m,right_z_m][,speed_limit_mps]
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...borders import offsets_beside
from ...conditioning.closing import SAME_PLACE, looks_closed
from ...crossings import crossings_of
from ...errors import RoadError
from ...geometry.curve import PlanarCurve, read_only
from ...lane import Lane
from ...road import Road
from .closing import closed_key
from .order import by_place
from .table import shown

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .table import Table

    Floats = NDArray[np.float64]

REQUIRED = ("left_x", "left_y", "right_x", "right_y")
OPTIONAL = ("left_z", "right_z", "speed_limit")


def columns_of(names: list[str]) -> list[str] | None:
    """Standard names of a header's words (`x_left_m` counts as `left_x`); None where one of the four is missing."""
    found = []
    for name in names:
        stem = name.lower().removesuffix("_m").removesuffix("_mps")
        parts = stem.split("_")
        if len(parts) == 2 and parts[0] in ("x", "y", "z") and parts[1] in ("left", "right"):
            stem = f"{parts[1]}_{parts[0]}"
        found.append(stem)
    return found if all(found.count(name) == 1 for name in REQUIRED) else None


def of_table(table: Table, *, closed: bool | None) -> Road:
    """The road between the edges; its reference is the middle of the points beside each other.

    Raises:
        RoadError: unknown columns, fewer than two places, edges that cross or change sides, a road that folds over itself, repeated places.
    """
    names = columns_of(table.names)
    unknown = [] if names is None else [name for name in names if name not in REQUIRED + OPTIONAL]
    if names is None or unknown:
        raise RoadError(
            f"{table.path}:{table.header}: columns {shown(table.names)}, expected {', '.join(REQUIRED)} and perhaps {', '.join(OPTIONAL)}"
        )
    order = by_place(_middle(names, table.rows), table.at)
    table = table.only(order.keep)
    columns = dict(zip(names, table.rows.T, strict=True))
    left, right = (
        np.column_stack([columns[f"{side}_x"], columns[f"{side}_y"], columns.get(f"{side}_z", np.zeros(len(table.rows)))])
        for side in ("left", "right")
    )
    limit = columns.get("speed_limit")
    if limit is not None and np.any(limit <= 0.0):
        raise RoadError(f"{table.at(int(np.argmax(limit <= 0.0)))}: speed limit {float(np.min(limit)):g} m/s, expected more than 0")
    middle = 0.5 * (left + right)
    steps = np.hypot(*np.diff(middle[:, :2], axis=0).T)
    if np.any(steps < SAME_PLACE):
        raise RoadError(f"{table.at(int(np.argmax(steps < SAME_PLACE)) + 1)}: repeats the place of the line before, expected each place once")
    closed = closed_key(table.path, table.keys) if closed is None else closed
    closed = looks_closed(middle[:, :2]) if closed is None else closed
    if closed and len(middle) > 1 and np.hypot(*(middle[0] - middle[-1])[:2]) < SAME_PLACE:
        left, right, middle = left[:-1], right[:-1], middle[:-1]
        limit = None if limit is None else limit[:-1]
    try:
        made = _between(table, table.keys.get("name", table.path.stem), left, right, middle, limit, closed)
        return replace(made, findings=(*order.findings, *crossings_of(made, table.at)))
    except RoadError as error:
        if str(error).startswith(str(table.path)):
            raise
        raise RoadError(f"{table.path}: {error}") from None


def _middle(names: list[str], rows: Floats) -> Floats:
    """The middle (n, 2) of the points beside each other."""
    x, y = (0.5 * (rows[:, names.index(f"left_{axis}")] + rows[:, names.index(f"right_{axis}")]) for axis in "xy")
    return np.column_stack([x, y])


def _between(table: Table, name: str, left: Floats, right: Floats, middle: Floats, limit: Floats | None, closed: bool) -> Road:
    reference = PlanarCurve.through(middle[:, :2], closed=closed)
    s = reference.breaks_s[:-1] if closed else reference.breaks_s
    offsets = []
    for edge in (right, left):
        found, _ = reference.project(edge[:, :2], s)
        off = np.abs(found - s)
        if np.max(off) > max(2.0 * float(np.max(np.diff(reference.breaks_s))), 5.0):
            at = int(np.argmax(off))
            raise RoadError(
                f"{table.at(at)}: the edge point lies {off[at]:z.1f} m of way from its partner on the other edge, expected them beside each other"
            )
        offsets.append(offsets_beside(reference, edge, s, s))
    if np.any(offsets[1] <= offsets[0]):
        at = int(np.argmax(offsets[1] <= offsets[0]))
        raise RoadError(f"{table.at(at)}: the left edge is not left of the right one, expected left of the direction of the lines")
    bank = np.arctan2(left[:, 2] - right[:, 2], np.hypot(*(left - right)[:, :2].T))
    edges = read_only(offsets[0]), read_only(offsets[1])
    limits = np.full(len(s), np.inf) if limit is None else limit
    return Road(name, reference, read_only(s), *edges, read_only(middle[:, 2]), read_only(limits), (Lane(1, *edges),), read_only(bank))
