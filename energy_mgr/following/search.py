"""Nearest places on a trajectory, over all of it or around a station; for starts and for what the Newton step cannot do."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .projected import offsets_from

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..motion import VehicleState
    from .projected import Line

#: Candidates of a global search that are looked at closely: so many of the nearest and of the best heading.
_CLOSEST, _STRAIGHTEST = 8, 8
#: m; a branch this much farther away than the nearest may win by its heading
TIE = 1.0


class Found(NamedTuple):
    """A place: station m, distance m, cosine of the heading error, and whether it lies within what was searched."""

    s: float
    distance: float
    fit: float
    interior: bool


def nearest(line: Line, state: VehicleState) -> Found:
    """The nearest place of the whole trajectory; among places about as near (within `TIE`) the one whose heading fits best."""
    path = line.trajectory
    n = len(path.s) - 1 if line.closed else len(path.s)
    far = np.hypot(path.x[:n] - state.x, path.y[:n] - state.y)
    before, after = np.roll(far, 1), np.roll(far, -1)
    if not line.closed:
        before[0] = after[-1] = np.inf
    # between stations the path may come nearer by half the longest step
    reach = float(np.min(far)) + 0.5 * float(np.max(np.diff(path.s))) + TIE
    rows = np.flatnonzero((far <= before) & (far <= after) & (far <= reach))
    fit = np.cos(path.psi[rows] - state.psi)
    chosen = {*rows[np.argsort(far[rows])[:_CLOSEST]].tolist(), *rows[np.argsort(-fit)[:_STRAIGHTEST]].tolist()}
    found = [_refined(line, state, *_around(path.s, row, line)) for row in sorted(chosen)]
    least = min(place.distance for place in found)
    # a tenth of the distance decides between equal headings
    return max((place for place in found if place.distance <= least + TIE), key=lambda place: place.fit - 0.1 * place.distance)


def around(line: Line, state: VehicleState, s: float, window: float) -> Found:
    """The nearest place within `window` (m) of station `s`."""
    return _refined(line, state, line.inside(s - window), line.inside(s + window))


def _around(stations: NDArray[np.float64], row: int, line: Line) -> tuple[float, float]:
    low = stations[row - 1] if row > 0 else (stations[-2] - line.length if line.closed else stations[0])
    return float(low), float(stations[min(row + 1, len(stations) - 1)])


def _refined(line: Line, state: VehicleState, low: float, high: float) -> Found:
    """The best of 33 places from `low` to `high`, then bisection and Newton on e_x = 0 beside it."""
    grid = np.linspace(low, high, 33)
    seen = line.trajectory.at(grid)
    far = np.hypot(seen.x - state.x, seen.y - state.y)
    best = int(np.argmin(far))
    a, b, s = float(grid[max(best - 1, 0)]), float(grid[min(best + 1, 32)]), float(grid[best])
    for _ in range(30):
        point = line.point(s)
        e_x, e_y = offsets_from(point, state)
        slope = 1.0 - point.kappa * e_y
        a, b = (s, b) if e_x > 0.0 else (a, s)
        target = s + e_x / slope if slope > 0.0 else math.nan
        target = target if a <= target <= b else 0.5 * (a + b)
        if abs(target - s) < 1e-9:
            break
        s = target
    point = line.point(s)
    distance = math.hypot(state.x - point.x, state.y - point.y)
    interior = 0 < best < 32 or not (line.closed or line.first < s < line.last)
    return Found(s, distance, math.cos(state.psi - point.psi), interior)
