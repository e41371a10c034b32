"""What a receiver recorded, and what can be said about single points of it: places out of order in time, and outliers."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..errors import RoadError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]

#: At most so many points in a row are taken as one excursion of the receiver.
MOST_ASTRAY = 3
#: An outlier lies at least so many typical steps, and at least this far, from what is before and after it (m).
_STEPS, _FAR = 4.0, 10.0
#: A way that goes on turns by less at a place; one that comes and goes turns by more, rad.
_ONWARD, _BACK = 1.05, 1.75
#: No car is faster, m/s.
FASTEST = 120.0


@dataclass(frozen=True, eq=False)
class Recording:
    """A drive as it was recorded.

    Attributes:
        place: the file, for messages.
        points: (n, 2) places, m.
        height: (n,) m; None where none was recorded.
        time: (n,) s; None where none was recorded.
        speed: (n,) m/s; None where none was recorded.
        names: (n,) what to call each point in messages: its number, or its line.
    """

    place: str
    points: Floats
    height: Floats | None
    time: Floats | None
    speed: Floats | None
    names: tuple[str, ...]

    def __post_init__(self) -> None:
        for label in ("points", "height", "time", "speed"):
            values = getattr(self, label)
            if values is not None and not np.all(np.isfinite(values)):
                at = int(np.argmin(np.isfinite(values).reshape(len(values), -1).all(axis=1)))
                raise RoadError(f"{self.place}: {self.names[at]}: {label} is no finite number")

    def __len__(self) -> int:
        return len(self.points)

    def of(self, which: Bools | slice) -> Recording:
        """Some of the points."""
        picked = {label: None if (values := getattr(self, label)) is None else values[which] for label in ("height", "time", "speed")}
        return replace(self, points=self.points[which], names=tuple(np.array(self.names, dtype=object)[which]), **picked)

    @property
    def steps(self) -> Floats:
        """(n-1,) distances from point to point, m."""
        return np.hypot(*np.diff(self.points, axis=0).T)

    @property
    def typical_step(self) -> float:
        """The median distance from point to point while it moves, m."""
        steps = self.steps
        moving = steps[steps > 0.25 * float(np.median(steps))]
        return float(np.median(moving)) if len(moving) else 0.0


def spread(time: Floats) -> Floats:
    """Times (n,) in whole seconds of a receiver that records faster: those that are equal are spread evenly up to the next one."""
    steps = np.diff(time)
    if not len(steps) or np.any(steps < 0.0) or np.all(steps > 0.0) or np.all(steps == 0.0):
        return time
    first = np.flatnonzero(np.append(True, steps > 0.0))
    count = np.diff(np.append(first, len(time)))
    known = time[first]
    ahead = np.append(np.diff(known), np.median(np.diff(known)))
    # who stands gets no more than a second of the time to the next place
    ahead = np.minimum(ahead, np.median(np.diff(known)))
    which = np.repeat(np.arange(len(first)), count)
    return known[which] + ahead[which] * (np.arange(len(time)) - first[which]) / count[which]


def in_time(recording: Recording) -> Bools:
    """Which points (n,) to keep for their times to increase: as many as can be."""
    if recording.time is None:
        return np.ones(len(recording), dtype=bool)
    return _longest_increasing(recording.time)


def _longest_increasing(values: Floats) -> Bools:
    """A longest strictly increasing part of `values` (n,)."""
    if np.all(np.diff(values) > 0.0):
        return np.ones(len(values), dtype=bool)
    from bisect import bisect_left

    tails: list[float] = []
    at: list[int] = []
    before = np.full(len(values), -1)
    for k, value in enumerate(values.tolist()):
        where = bisect_left(tails, value)
        if where == len(tails):
            tails.append(value)
            at.append(k)
        else:
            tails[where], at[where] = value, k
        before[k] = at[where - 1] if where else -1
    keep = np.zeros(len(values), dtype=bool)
    k = at[-1]
    while k >= 0:
        keep[k] = True
        k = int(before[k])
    return keep


def astray(recording: Recording) -> Bools:
    """Which points (n,) the receiver put astray: up to three in a row far from where the way leads without them, or where no car gets in time."""
    found = np.zeros(len(recording), dtype=bool)
    if len(recording) < 6:
        return found
    least = max(_STEPS * recording.typical_step, _FAR)
    for size in range(1, MOST_ASTRAY + 1):
        kept = np.flatnonzero(~found)
        if len(kept) < size + 4:
            break
        found[kept[_excursions(recording.points[kept], None if recording.time is None else recording.time[kept], size, least)]] = True
    return found


def _excursions(points: Floats, time: Floats | None, size: int, least: float) -> Bools:
    """Runs of `size` points that are left and come back from far off, with the way leading on without them."""
    count = len(points) - size - 1
    before, after = points[:count], points[size + 1 :]
    first, last = points[1 : count + 1], points[size : count + size]
    away, back = np.hypot(*(first - before).T), np.hypot(*(after - last).T)
    across = np.hypot(*(after - before).T)
    far = (np.minimum(away, back) > least) & (away + back > 3.0 * across)
    if time is not None:
        # what no car can drive there and back
        pace = np.minimum(away / (time[1 : count + 1] - time[:count]), back / (time[size + 1 :] - time[size : count + size]))
        far |= (pace > FASTEST) & (np.minimum(away, back) > least)
    # a dead end is left as it was entered: there the way without the tip still turns back
    reach = np.arange(count)
    onward = _turn(points[np.maximum(reach - 1, 0)], before, after) < _ONWARD
    onward &= _turn(before, after, points[np.minimum(reach + size + 2, len(points) - 1)]) < _ONWARD
    hit = np.flatnonzero(far & onward)
    found = np.zeros(len(points), dtype=bool)
    for k in range(size):
        found[hit + 1 + k] = True
    return found


def _turn(a: Floats, b: Floats, c: Floats) -> Floats:
    """Angle (n,) by which the way a, b, c turns at b, rad; 0 where two of them are one place."""
    u, v = b - a, c - b
    return np.abs(np.arctan2(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0], np.sum(u * v, axis=1)))
