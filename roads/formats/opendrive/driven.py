"""The lane of an OpenDRIVE road that is driven: the one to follow where none leads on from start to end, and what is posted for it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...errors import RoadError
from ...geometry.curve import read_only
from ...lane import Lane
from .carriageway import borders_at
from .records import DRIVABLE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .carriageway import Stations
    from .geometry import RoadShape

    Floats = NDArray[np.float64]

#: Changing from a lane that ends to its neighbour takes this stretch before the end, m.
CHANGE = 60.0
#: A lane narrower than this is none to drive in, m.
NARROW = 2.0


def followed_lane(s: Floats, lanes: list[Lane], edges: tuple[Floats, Floats], along: int, left_hand: bool, *, closed: bool) -> Lane | None:
    """The lane to follow where it is not the one that `Road.driving_lane` would take, else None.

    Where no lane leads on from start to end, it changes to the neighbour before each one ends.
    """
    forward = [_wide(lane) for lane in lanes if lane.direction in (0, along)]
    if not np.all(np.any([~np.isnan(lane.right) for lane in forward], axis=0)):
        forward = [lane for lane in lanes if lane.direction in (0, along)]
    through = [lane for lane in forward if lane.kind == "driving"] or forward
    outer = through[::-1] if left_hand == (along > 0) else through
    count = len(s) - closed
    whole = next((lane for lane in outer if not np.isnan(lane.right).any()), None)
    if whole is not None:
        return None if whole.name == outermost(lanes, along, left_hand).name else open_ended(whole, count)
    right, left, changes = _in_turn(s, outer, forward)
    for stop, before, after in changes:
        _blend(s, right, left, stop, before, after)
    right, left = np.clip(right, *edges), np.clip(left, *edges)
    return Lane(along, read_only(right[:count]), read_only(left[:count]), "driving", "followed")


def outermost(lanes: list[Lane], along: int, left_hand: bool) -> Lane:
    """The lane that `Road.driving_lane` would take."""
    order = lanes[::-1] if left_hand == (along > 0) else lanes
    return next(lane for lane in order if lane.direction in (0, along) and not np.isnan(lane.right).any())


def posted_on(shape: RoadShape, stations: Stations, lane: Lane, along: int) -> tuple[Floats, Floats]:
    """Speed limit and friction (n,) of the lane that is driven, section by section the one that it lies on."""
    record, (s, rows, sections) = shape.record, stations
    limit, friction = np.full(len(s), np.inf), np.ones(len(s))
    # the lane of a circuit does not repeat its first station
    middle = np.resize(0.5 * (lane.right + lane.left), len(s))
    for index, section in enumerate(shape.sections):
        here = np.flatnonzero(sections == index)
        at = here[len(here) // 2]
        borders = borders_at(shape, section, rows[[at]])[:, 0]
        candidates = [k for k, other in enumerate(section.lanes) if other.kind in DRIVABLE and other.direction in (0, along)]
        if not candidates:
            continue
        best = min(candidates, key=lambda k: abs(0.5 * (borders[k] + borders[k + 1]) - middle[at]))
        driven = section.lanes[best]
        part = record.sections[index]
        for start, speed in driven.limits(part.start, part.end, record.speeds):
            limit[here[s[here] >= start - 1e-9]] = speed
        for start, share in driven.frictions:
            friction[here[s[here] >= start - 1e-9]] = share
    return limit, friction


def open_ended(lane: Lane, count: int) -> Lane:
    """The first `count` stations of a lane; a circuit does not repeat its first one."""
    return Lane(lane.direction, read_only(lane.right[:count]), read_only(lane.left[:count]), lane.kind, lane.name)


def _wide(lane: Lane) -> Lane:
    """The lane without the stretches where it is too narrow for a car, as where it begins or ends in a taper."""
    narrow = ~(lane.left - lane.right >= NARROW)
    return replace(lane, right=np.where(narrow, np.nan, lane.right), left=np.where(narrow, np.nan, lane.left))


def _in_turn(s: Floats, outer: list[Lane], forward: list[Lane]) -> tuple[Floats, Floats, list[tuple[int, Lane, Lane]]]:
    """Borders (n,) of one lane after the other, each to where it ends, and the changes: number of the station, lane before, lane after.

    Lanes to change to are those of `outer`; where there is none, any that leads `forward`.
    """
    right, left = np.empty(len(s)), np.empty(len(s))
    at = 0
    current = next(lane for lane in (*outer, *forward) if not np.isnan(lane.right[0]))
    changes: list[tuple[int, Lane, Lane]] = []
    while at < len(s):
        gone = np.flatnonzero(np.isnan(current.right[at:]))
        stop = at + int(gone[0]) if len(gone) else len(s)
        right[at:stop], left[at:stop] = current.right[at:stop], current.left[at:stop]
        if stop == len(s):
            break
        middle = 0.5 * (current.right[stop - 1] + current.left[stop - 1])
        present = [lane for lane in outer if not np.isnan(lane.right[stop])] or [lane for lane in forward if not np.isnan(lane.right[stop])]
        if not present:
            raise RoadError(f"no lane leads on at s = {s[stop]:.1f} m, expected one from start to end")
        after = min(present, key=lambda lane: abs(0.5 * (lane.right[stop] + lane.left[stop]) - middle))
        changes.append((stop, current, after))
        current, at = after, stop
    return right, left, changes


def _blend(s: Floats, right: Floats, left: Floats, stop: int, before: Lane, after: Lane) -> None:
    """Move over smoothly while both lanes are there; where they never are, after the end, as far as the change reaches."""
    both = ~np.isnan(before.right) & ~np.isnan(after.right) & (s >= s[stop] - CHANGE) & (s < s[stop])
    if np.count_nonzero(both) > 2:
        span = np.flatnonzero(both)
        share = _smooth((s[span] - s[span[0]]) / (s[span[-1]] - s[span[0]]))
        right[span] = (1 - share) * before.right[span] + share * after.right[span]
        left[span] = (1 - share) * before.left[span] + share * after.left[span]
        return
    jump = 0.5 * (right[stop] + left[stop] - right[stop - 1] - left[stop - 1])
    if abs(jump) < 1e-3:
        return
    span = np.flatnonzero((s >= s[stop]) & (s < s[stop] + CHANGE))
    share = 1.0 - _smooth((s[span] - s[stop]) / CHANGE)
    # on the side it comes from the strip reaches back to the lane before
    if jump > 0.0:
        right[span] -= 2.0 * jump * share
    else:
        left[span] -= 2.0 * jump * share


def _smooth(share: Floats) -> Floats:
    return share**2 * (3.0 - 2.0 * share)
