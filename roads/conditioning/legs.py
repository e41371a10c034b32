"""Where a recorded drive turns back on its own line or breaks off: ways of their own, since no road folds back on itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .line import Anchors, anchors, apart
from .spline import noise_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .recording import Recording

    Floats = NDArray[np.float64]

#: A drive that comes back this close to the line it came on has turned round on the spot, m, or so many times the noise.
_SAME_LINE, _NOISES = 3.0, 3.0
#: Anchors before and after the tip that tell; the direction between them turns by more than this, rad.
_ABOUT, _BACK = 2, 2.6
#: A gap is bridged up to this length, m, or up to this share of the way.
BRIDGED, _SHARE = 1000.0, 0.1
#: A leg shorter than this is none, m.
SHORTEST = 30.0


@dataclass(frozen=True)
class Leg:
    """A part of a recording.

    Attributes:
        first: number of its first point.
        last: number of its last point.
        length: way, m.
        start: way from the start of the recording, m.
        ended: why it ends: `turn`, `gap`, or `end`.
    """

    first: int
    last: int
    length: float
    start: float
    ended: str


def legs_of(recording: Recording) -> list[Leg]:
    """The legs of a drive in their order, at least one; what is shorter than `SHORTEST` is left out where there are longer ones."""
    steps = recording.steps
    way = np.concatenate([[0.0], np.cumsum(steps)])
    breaks = [(int(k), int(k) + 1, "gap") for k in np.flatnonzero(steps > max(BRIDGED, _SHARE * float(way[-1])))]
    breaks += [(k, k, "turn") for k in turning_points(recording)]
    found, first = [], 0
    for end, begin, why in [*sorted(breaks), (len(recording) - 1, 0, "end")]:
        if end - first >= 1:
            found.append(Leg(first, end, float(way[end] - way[first]), float(way[first]), why))
        first = begin
    return [leg for leg in found if leg.length >= SHORTEST] or [max(found, key=lambda leg: leg.length)]


def turning_points(recording: Recording) -> list[int]:
    """Numbers of the points where the drive turns round on the spot and goes back along its own line."""
    points = recording.points
    distance = apart(points, recording.typical_step)
    found = anchors(points, distance)
    places = found.places
    if len(places) < 2 * _ABOUT + 1:
        return []
    middle = np.arange(_ABOUT, len(places) - _ABOUT)
    before, after = places[middle] - places[middle - _ABOUT], places[middle + _ABOUT] - places[middle]
    turn = np.abs(np.arctan2(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0], np.sum(before * after, axis=1)))
    near = max(_SAME_LINE, _NOISES * noise_of(points))
    tips: list[int] = []
    for k in middle[turn > _BACK].tolist():
        if _retraces(places, k, near):
            tip = _tip(points, found, k)
            if not tips or tip - tips[-1] > 3:
                tips.append(tip)
    return tips


def _retraces(places: Floats, k: int, near: float) -> bool:
    """Whether the anchors after `k` lie on the polyline of those before it."""
    line = places[max(k - 2 * _ABOUT, 0) : k + 2]
    return all(_distance(place, line) < near for place in places[k + 1 : k + 1 + _ABOUT])


def _distance(place: Floats, line: Floats) -> float:
    a, move = line[:-1], np.diff(line, axis=0)
    share = np.clip(np.sum((place - a) * move, axis=1) / np.maximum(np.sum(move**2, axis=1), 1e-12), 0.0, 1.0)
    return float(np.min(np.hypot(*(a + share[:, None] * move - place).T)))


def _tip(points: Floats, found: Anchors, k: int) -> int:
    """The point farthest on before the drive comes back."""
    ahead = found.places[k] - found.places[k - _ABOUT]
    near = np.flatnonzero(np.abs(found.owner - k) <= _ABOUT)
    return int(near[np.argmax((points[near] - found.places[k]) @ ahead)])
