"""Where a road crosses itself: over a bridge, which is a road, or in a fold, which is none.

A file without heights cannot say which passage is above, and planning does not need to know: stations keep the passages apart. What must be plain is
that there are two: they cross at a clear angle, far from each other along the road, and once. All else (a line that turns back, laps beside each
other, borders that change sides) folds the strip onto itself.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .errors import RoadError
from .findings import Finding
from .geometry.crossing import mutual_crossings, self_crossings

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from .road import Road

    Floats = NDArray[np.float64]

#: A road may pass over itself where the levels are at least this far apart, m.
BRIDGE_CLEARANCE = 3.0
#: Borders that meet again further along than this belong to different parts of the road, m; a road needs as much to come round to itself.
LOCAL = 60.0
#: Passages cross at more than this angle: below it they lie over each other for three times their width.
_CLEAR = np.radians(20.0)
#: Crossings closer than this along both passages are one, m.
_SAME = 1e-3
#: A line that crosses itself more often is no road.
_MOST = 300
#: Crossings that are named one by one.
_NAMED = 5


class Crossing(NamedTuple):
    """Where two passages cross.

    Attributes:
        first: number of the reference's point before the crossing on the first passage.
        second: the same on the second.
        place: (2,) where, m.
        s: stations of both, m.
        angle: between them, rad, 0 to pi/2.
        apart: along the road, m; on a circuit the shorter way.
        level: by how much their heights differ, m.
    """

    first: int
    second: int
    place: Floats
    s: tuple[float, float]
    angle: float
    apart: float
    level: float


def crossings_of(road: Road, place: Callable[[int], str], *, refuse: bool = True) -> tuple[Finding, ...]:
    """Warnings about the crossings of `road` with itself on one level; those over a bridge of known height are none.

    Args:
        road: a road whose reference runs through a file's points, at its stations.
        place: names the file's place of a point, as `file:line`.
        refuse: raise where the road folds; else that is a warning too.

    Raises:
        RoadError: a fold, with its place.
    """
    try:
        found = [crossing for crossing in _crossings(road) if crossing.level < BRIDGE_CLEARANCE]
    except RoadError as error:
        if refuse:
            raise RoadError(f"{road.name}: {error}") from None
        return (Finding("warning", place(0), str(error)),)
    findings: list[Finding] = []
    for crossing in found:
        words = _words(crossing, place)
        fold = _fold(road, crossing, found)
        if fold and refuse:
            raise RoadError(f"{place(crossing.second)}: {words}: {fold}")
        what = fold or "taken as a bridge; heights that differ by 3 m or more (column z_m in tables) would say which passage is above"
        findings.append(Finding("warning", place(crossing.second), f"{words}: {what}"))
    if len(findings) > _NAMED:
        last = findings[_NAMED - 1]
        more = f"{last.message} (and {len(findings) - _NAMED} more crossings)"
        findings = [*findings[: _NAMED - 1], Finding("warning", last.place, more)]
    return tuple(findings)


def refuse_crossing_borders(road: Road, place: Callable[[int], str]) -> None:
    """Refuse a road whose right border crosses its left one nearby: it has no corridor there.

    Raises:
        RoadError: with the place.
    """
    points, normal = _points(road)
    edges = (points + road.left[:, None] * normal, points + road.right[:, None] * normal)
    for i, j, where in mutual_crossings(*edges):
        if _apart(road, abs(float(road.s[i] - road.s[j]))) < LOCAL:
            raise RoadError(f"{place(i)}: the borders cross at ({where[0]:z.1f}, {where[1]:z.1f}) m, expected left and right edge apart")


def _points(road: Road) -> tuple[Floats, Floats]:
    """Places (n, 2) and unit normals (n, 2) of the reference at the road's stations, which mostly are its breaks."""
    reference, count = road.reference, len(road.s)
    at_breaks = np.array_equal(reference.breaks_s[:count], road.s)
    place, first = reference.pieces(reference.pieces.breaks[:count] if at_breaks else reference.parameter(road.s), 1)
    return place, np.column_stack([-first[:, 1], first[:, 0]]) / np.hypot(*first.T)[:, None]


def _crossings(road: Road) -> list[Crossing]:
    points, _ = _points(road)
    steps = np.roll(points, -1, axis=0) - points if road.closed else np.diff(points, axis=0)
    ends = np.append(road.s[1:], road.length) if road.closed else road.s[1:]
    found: list[Crossing] = []
    for i, j, place in self_crossings(points, closed=road.closed):
        stations = []
        for k in (i, j):
            share = float(np.hypot(*(place - points[k])) / np.hypot(*steps[k]))
            stations.append(float(road.s[k] + share * (ends[k] - road.s[k])))
        turn = abs(float(steps[i][0] * steps[j][1] - steps[i][1] * steps[j][0]))
        angle = float(np.arctan2(turn, abs(float(steps[i] @ steps[j]))))
        low, high = road.height_at(stations)
        made = Crossing(i, j, place, (stations[0], stations[1]), angle, _apart(road, stations[1] - stations[0]), abs(float(high - low)))
        # in a point of the line all segments that meet there cross
        if not any(_near(road, made, other, _SAME) for other in found[-8:]):
            found.append(made)
        if len(found) > _MOST:
            x, y = found[0].place
            raise RoadError(f"the line crosses itself more than {_MOST} times, first at ({x:z.1f}, {y:z.1f}) m, expected a road")
    return found


def _near(road: Road, one: Crossing, other: Crossing, reach: float) -> bool:
    """Whether two crossings are of the same passages: both stations are within `reach`, m, whichever comes first on a circuit."""
    pairs = other.s, other.s[::-1]
    return any(all(_apart(road, abs(a - b)) < reach for a, b in zip(one.s, pair, strict=True)) for pair in pairs)


def _apart(road: Road, way: float) -> float:
    return min(way, road.length - way) if road.closed else way


def _fold(road: Road, crossing: Crossing, every: list[Crossing]) -> str:
    """Why a crossing is a fold; empty if it is none."""
    if crossing.apart < LOCAL:
        return f"it folds, {crossing.apart:z.0f} m of road are too little to come round; expected a line that does not turn back on itself"
    if crossing.angle < _CLEAR:
        return "it folds, passages beside each other cannot be told apart (laps, or a way out and back, in one file?); expected one passage"
    reach = _half_width(road, crossing.s) * 2.0 / np.sin(crossing.angle)
    for other in every:
        if other is not crossing and _near(road, crossing, other, reach):
            return f"it folds, it crosses the same passage again at ({other.place[0]:z.1f}, {other.place[1]:z.1f}) m; expected one crossing"
    return ""


def _half_width(road: Road, stations: tuple[float, float]) -> float:
    wide = np.maximum(np.abs(road.left), np.abs(road.right))
    return float(np.max(np.interp(stations, road.s, wide)))


def _words(crossing: Crossing, place: Callable[[int], str]) -> str:
    x, y = crossing.place
    before = place(crossing.first).rpartition(":")[2].strip()
    before = f"line {before}" if before.isdigit() else before
    return (
        f"the road crosses itself at ({x:z.1f}, {y:z.1f}) m, where {before} passed on the same level, s = {crossing.s[0]:z.1f} and "
        f"{crossing.s[1]:z.1f} m, at {np.degrees(crossing.angle):z.0f} degrees"
    )
