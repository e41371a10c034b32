"""Where a recorded drive turns back on its own line or breaks off: ways of their own, since no road folds back on itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .line import QUIET, Anchors, anchors, apart
from .spline import noise_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .recording import Recording

    Floats = NDArray[np.float64]

#: A drive that comes back this close to the line it came on has turned round on the spot, m, or so many times the noise.
_SAME_LINE, _NOISES = 3.0, 3.0
#: Anchors about a tip that belong to it; the direction turns there by more than this, rad; no more anchors are looked through.
_ABOUT, _BACK, _MOST = 2, 2.6, 200
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
    """The legs of a drive in their order, at least one; what is shorter than `SHORTEST` is left out where there are longer ones.

    Ways are those along anchors: along noisy places they would be longer the more there are.
    """
    steps = recording.steps
    found = anchors(recording.points, apart(recording.points, recording.typical_step))
    exact = noise_of(recording.points) < QUIET
    way = np.concatenate([[0.0], np.cumsum(steps)]) if exact else found.station[found.owner]
    breaks = [(int(k), int(k) + 1, "gap") for k in np.flatnonzero(steps > max(BRIDGED, _SHARE * float(np.sum(steps))))]
    breaks += [(k, k, "turn") for k in _turning_points(recording, found)]
    legs, first = [], 0
    for end, begin, why in [*sorted(breaks), (len(recording) - 1, 0, "end")]:
        if end - first >= 1:
            legs.append(Leg(first, end, float(way[end] - way[first]), float(way[first]), why))
        first = begin
    return [leg for leg in legs if leg.length >= SHORTEST] or [max(legs, key=lambda leg: leg.length)]


def turning_points(recording: Recording) -> list[int]:
    """Numbers of the points where the drive turns round on the spot and goes back along its own line."""
    return _turning_points(recording, anchors(recording.points, apart(recording.points, recording.typical_step)))


def _turning_points(recording: Recording, found: Anchors) -> list[int]:
    places = found.places
    near = max(_SAME_LINE, _NOISES * noise_of(recording.points))
    tips: list[int] = []
    for k in range(1, len(places) - 1):
        # a quick look first: few ways turn back within one anchor
        if (
            float((places[k] - places[k - 1]) @ (places[min(k + 1, len(places) - 1)] - places[k])) > 0.0
            and k > 1
            and (float((places[k - 1] - places[k - 2]) @ (places[k + 1] - places[k])) > 0.0)
        ):
            continue
        before, after = _away(places, k, -1), _away(places, k, 1)
        if before is None or after is None:
            continue
        came, went = places[k] - places[before], places[after] - places[k]
        turn = abs(float(np.arctan2(came[0] * went[1] - came[1] * went[0], came @ went)))
        line = places[max(before - 1, 0) : k + 2]
        if turn > _BACK and all(_distance(place, line) < near for place in places[k + 1 : after + 1]):
            tip = _tip(recording.points, found, k, came)
            if not tips or found.owner[tip] - found.owner[tips[-1]] > _ABOUT:
                tips.append(tip)
    return tips


def _away(places: Floats, k: int, way: int) -> int | None:
    """The first anchor before (-1) or after (+1) `k` that is `SHORTEST` away from it as the crow flies; None where the drive ends before."""
    at = k
    while 0 <= at + way < len(places) and abs(at - k) < _MOST:
        at += way
        if float(np.hypot(*(places[at] - places[k]))) >= SHORTEST:
            return at
    return None


def _distance(place: Floats, line: Floats) -> float:
    a, move = line[:-1], np.diff(line, axis=0)
    share = np.clip(np.sum((place - a) * move, axis=1) / np.maximum(np.sum(move**2, axis=1), 1e-12), 0.0, 1.0)
    return float(np.min(np.hypot(*(a + share[:, None] * move - place).T)))


def _tip(points: Floats, found: Anchors, k: int, ahead: Floats) -> int:
    """The point farthest on before the drive comes back."""
    near = np.flatnonzero(np.abs(found.owner - k) <= _ABOUT)
    return int(near[np.argmax((points[near] - found.places[k]) @ ahead)])
