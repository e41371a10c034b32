"""Where a line runs beside a curve: its signed distance, station by station."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .geometry.curve import PlanarCurve

    Floats = NDArray[np.float64]


#: A line is given no more further points.
MOST_POINTS = 100_000


def spaced(s: Floats, least: float) -> NDArray[np.bool_]:
    """Which of the stations `s` (n,) to draw a curve through: those more than `least` (m) beyond the one before, and both ends."""
    keep = np.append(True, np.diff(s) > least)
    if not keep[-1]:
        keep[np.flatnonzero(keep)[-1]] = np.count_nonzero(keep) == 1
        keep[-1] = True
    return keep


def narrowed_at(right: Floats, left: Floats, joints: NDArray[np.intp]) -> tuple[Floats, Floats]:
    """Edges where cross-sections meet: at each index of `joints` the inner ones of it and of the station before, so that none is too wide."""
    right, left = right.copy(), left.copy()
    for at in joints.tolist():
        low, high = max(right[at - 1], right[at]), min(left[at - 1], left[at])
        if low < high:
            right[at], left[at] = low, high
    return right, left


def way_along(line: Floats) -> Floats:
    """(n,) distance in m along the polyline `line` (n, 2 or more), in plan."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line[:, :2], axis=0).T))])


def dense(line: Floats, spacing: float = 1.0) -> Floats:
    """`line` (n, k) with further points so that none are more than `spacing` (m) apart; on lines beyond 100 km a hundred thousand more."""
    s = way_along(line)
    fine = np.union1d(s, np.linspace(0.0, s[-1], int(min(np.ceil(s[-1] / spacing), MOST_POINTS)) + 1))
    return np.column_stack([np.interp(fine, s, line[:, axis]) for axis in range(line.shape[1])])


def offsets_beside(curve: PlanarCurve, line: Floats, near: Floats, stations: Floats) -> Floats:
    """Offsets (m, positive left) at `stations` (k,) of the polyline `line` (n, 2), whose points lie near the stations `near` (n,) of the curve.

    Exact at the line's points; between them the offset runs linearly over the station. Beyond the line's ends it stays.
    """
    return places_beside(curve, line[:, :2], near, stations)[0]


def places_beside(curve: PlanarCurve, line: Floats, near: Floats, stations: Floats) -> tuple[Floats, ...]:
    """As `offsets_beside`, followed by the further columns of `line` (n, 2 + k), such as heights, at the same stations."""
    found, offset = curve.project(line[:, :2], near)
    order = np.argsort(found, kind="stable")
    period = curve.length if curve.closed else None
    return tuple(np.interp(stations, found[order], values[order], period=period) for values in (offset, *line[:, 2:].T))
