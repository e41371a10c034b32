"""A recording made fit for a road: everything that was done to it is told."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..borders import way_along
from ..errors import RoadError
from ..findings import Finding, Findings
from .chords import beside, marks
from .closing import looks_closed
from .heights import STEEPEST, smoothed_heights
from .legs import Leg, legs_of
from .line import QUIET, Line, anchors, apart, smoothed_line
from .progress import recorded_drive
from .recording import Recording, astray, in_time, spread
from .spline import noise_of
from .wish import Wish

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..recorded import Recorded
    from ..road import Road

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

#: Points closer than this are one (a receiver that stands), m.
STANDING = 0.05
#: A step longer than this, and than this many typical ones, is a gap worth a word, m.
_GAP, _GAP_STEPS = 50.0, 4.0
#: An anchor with so many times as many points as the typical one is a stop.
_CROWD, _CROWDED = 4.0, 8
#: Recorded speeds are used if the way that they cover is that of the places by this share.
_AGREED = 0.1
#: Of times that go back more than this share are not used at all.
_MOST_BACK = 0.1
#: A point farther off than this many times the typical distance is worth a word.
_FAR_OFF = 6.0


@dataclass(frozen=True, eq=False)
class Conditioned:
    """What a road is made of.

    Attributes:
        points: (m, 2) places, m.
        height: (m,) m.
        closed: whether it is a circuit.
        recorded: the drive along the line through the points; None where no times or speeds were recorded.
        findings: what was done.
    """

    points: Floats
    height: Floats
    closed: bool
    recorded: Recorded | None
    findings: tuple[Finding, ...]


def conditioned(recording: Recording, wish: Wish, closed: bool | None) -> Conditioned:
    """The places and heights of a road out of a recording.

    Args:
        recording: what was recorded.
        wish: how it is to be taken.
        closed: whether it is a circuit; None: as the gap between its ends suggests.

    Raises:
        RoadError: nothing that moved, or no such leg.
    """
    told = Findings()
    if wish.raw:
        return _as_it_is(recording, closed, told)
    words: list[str] = []
    recording = _sound(recording, told, words)
    if len(recording) < 2:
        raise RoadError(f"{recording.place}: {len(recording)} usable point, expected at least 2")
    recording = _leg(recording, wish.leg, told)
    _tell_gaps(recording, told)
    moving, at_place = _moving(recording)
    if len(moving) < 2:
        raise RoadError(f"{recording.place}: stands at one place, expected a way")
    seam = float(np.hypot(*(moving.points[0] - moving.points[-1])))
    if closed and seam > max(_GAP, _GAP_STEPS * moving.typical_step):
        told.warn(recording.place, f"a circuit was asked for, whose ends are {seam:.0f} m apart: a way of that length is made up")
    closed = looks_closed(moving.points) if closed is None else closed
    noise, step = noise_of(moving.points), moving.typical_step
    crowds = _stops(moving)
    if crowds:
        words.append(f"{crowds} stop{'s' * (crowds > 1)} drawn together")
    quiet = wish.plane is None and noise < QUIET and not crowds
    line = None if quiet else smoothed_line(moving.points, step, wish.plane, closed=closed)
    if line is not None and wish.plane is None and _strays(line, moving):
        told.warn(recording.place, "no smooth line stays beside its places (a drawn or thinned line?): they are taken as they are")
        line = None
    if line is None:
        made = _from_points(recording, wish, closed, told, words)
    else:
        largest = int(np.argmax(np.abs(line.off)))
        far = abs(float(line.off[largest]))
        words.append(f"line smoothed, the points lie {line.noise:.2f} m off it (root mean square, at most {far:.1f} m)")
        if far > max(_FAR_OFF * line.noise, 1.0):
            where = f"{recording.place}: {moving.names[largest]} at s = {line.station[largest]:.0f} m"
            told.warn(where, f"lies {far:.1f} m off the smoothed line, the others {line.noise:.2f} m; look whether a bend was cut")
        ends = np.vstack([line.points, line.points[:1]]) if closed else line.points
        at = way_along(ends)
        height = _heights(moving, line.station, at[: len(line.points)], wish, told, words)
        made = Conditioned(line.points, height, closed, _drive(recording, line.station[at_place], float(np.max(line.station)), told), ())
    _summary(recording, wish, words, told)
    return Conditioned(made.points, made.height, made.closed, made.recorded, tuple(told.all()))


def _strays(line: Line, recording: Recording) -> bool:
    """Whether a smoothed line swings out between the recorded places, farther than these scatter about it."""
    return beside(line.points, recording.points) > max(_FAR_OFF * line.noise, float(np.max(np.abs(line.off))) + line.noise, 2.0)


def _as_it_is(recording: Recording, closed: bool | None, told: Findings) -> Conditioned:
    closed = looks_closed(_moving(recording)[0].points) if closed is None else closed
    return _from_points(recording, Wish(raw=True), closed, told, [])


def _from_points(recording: Recording, wish: Wish, closed: bool, told: Findings, words: list[str]) -> Conditioned:
    """The recorded places themselves."""
    moving, at_place = _moving(recording)
    seam = float(np.hypot(*(moving.points[0] - moving.points[-1]))) if closed else 0.0
    s = way_along(moving.points)
    count = len(moving) - (closed and len(moving) > 1 and seam < STANDING)
    kept = moving.of(slice(0, count))
    given = np.zeros(count) if kept.height is None else kept.height
    height = given if wish.raw else _heights(kept, s[:count], s[:count], wish, told, words)
    in_order = recording.time is None or bool(np.all(np.diff(recording.time) > 0.0))
    recorded = _drive(recording, s[at_place], float(s[-1]), told) if in_order else None
    at = marks(kept.points)
    points = np.column_stack([np.interp(at, np.arange(count), column) for column in kept.points.T])
    return Conditioned(points, np.interp(at, np.arange(count), height), closed, recorded, ())


def _sound(recording: Recording, told: Findings, words: list[str]) -> Recording:
    """Without points that go back in time or were put astray."""
    if recording.time is not None:
        recording = replace(recording, time=spread(recording.time))
        back = float(np.mean(~in_time(recording)))
        if back > _MOST_BACK:
            told.warn(recording.place, f"{100.0 * back:.0f} % of its times are not after those before them: its times are not used")
            recording = replace(recording, time=None, speed=None)
    for mask, word, what in (
        (~in_time(recording), "out of order in time", "its time is not after that of the point before, expected times that increase"),
        (None, "astray", "far from where the points before and after it lead"),
    ):
        mask = astray(recording) if mask is None else mask
        if mask.any():
            first = int(np.argmax(mask))
            count = int(np.count_nonzero(mask))
            more = f" ({count} such points)" if count > 1 else ""
            told.warn(f"{recording.place}: {recording.names[first]}", f"left out, {what}{more}")
            words.append(f"{count} point{'s' * (count > 1)} {word} left out")
            recording = recording.of(~mask)
    return recording


def _leg(recording: Recording, wanted: int | None, told: Findings) -> Recording:
    legs = legs_of(recording)
    if wanted is not None and wanted > len(legs):
        raise RoadError(f"{recording.place}: leg {wanted} of a drive that has {len(legs)}, expected at most that")
    # of two that are as long but for noise, as out and back, the first
    enough = 0.95 * max(leg.length for leg in legs)
    leg = next(leg for leg in legs if leg.length >= enough) if wanted is None else legs[wanted - 1]
    if len(legs) > 1:
        why = [f"turns back on its own line at {_after(one)}" if one.ended == "turn" else f"breaks off at {_after(one)}" for one in legs[:-1]]
        ways = ", ".join(f"leg {k} of {one.length:.0f} m" for k, one in enumerate(legs, 1))
        number = legs.index(leg) + 1
        told.warn(recording.place, f"the drive {'; '.join(why[:6])}: {len(legs)} ways along roads ({ways}); leg {number} is read")
    return recording.of(slice(leg.first, leg.last + 1))


def _after(leg: Leg) -> str:
    return f"{leg.start + leg.length:.0f} m"


def _tell_gaps(recording: Recording, told: Findings) -> None:
    steps = recording.steps
    gaps = np.flatnonzero(steps > max(_GAP, _GAP_STEPS * recording.typical_step))
    if len(gaps):
        k = int(gaps[np.argmax(steps[gaps])])
        more = f" (the longest of {len(gaps)})" if len(gaps) > 1 else ""
        told.warn(f"{recording.place}: {recording.names[k]}", f"gap of {steps[k]:.0f} m to the next point is bridged{more}: nothing is known there")


def _moving(recording: Recording) -> tuple[Recording, Ints]:
    """Without points that repeat the place of the one before, and which (n,) of these each point is at."""
    keep = np.append(True, recording.steps >= STANDING)
    for k in (np.flatnonzero(~keep)).tolist():
        # creeping adds up
        last = k - 1 - int(np.argmax(keep[k - 1 :: -1]))
        keep[k] = np.hypot(*(recording.points[k] - recording.points[last])) >= STANDING
    return recording.of(keep), np.cumsum(keep) - 1


def _stops(recording: Recording) -> int:
    """How often points crowd and scatter; where a car creeps on exactly there is nothing to draw together."""
    owner = anchors(recording.points, apart(recording.points, recording.typical_step)).owner
    count = np.bincount(owner)
    crowded = count > max(_CROWD * float(np.median(count)), _CROWDED)
    for at in np.flatnonzero(crowded).tolist():
        crowded[at] = noise_of(recording.points[owner == at]) >= QUIET
    return int(np.count_nonzero(np.diff(np.concatenate([[0], crowded.astype(int)])) > 0))


def _heights(recording: Recording, s: Floats, at: Floats, wish: Wish, told: Findings, words: list[str]) -> Floats:
    if recording.height is None:
        return np.zeros(len(at))
    found = smoothed_heights(s, recording.height, at, wish.height)
    if found.wrong.any():
        misses = np.where(found.wrong, recording.height - np.interp(s, at, found.height), 0.0)
        first, count = int(np.argmax(np.abs(misses))), int(np.count_nonzero(found.wrong))
        off = float(misses[first])
        told.warn(
            f"{recording.place}: {recording.names[first]} at s = {s[first]:.0f} m",
            f"height {off:+.1f} m off its surroundings is left out ({count} height{'s' * (count > 1)} in all): to get there a road would be steeper "
            f"than {100.0 * STEEPEST:.0f} %",
        )
        words.append(f"{count} height{'s' * (count > 1)} no road could reach left out")
    slope = np.abs(np.diff(found.height)) / np.maximum(np.diff(at), 1e-6)
    if len(slope) and float(np.max(slope)) > STEEPEST:
        k = int(np.argmax(slope))
        told.warn(
            f"{recording.place} at s = {at[k]:.0f} m", f"the height steps by {found.height[k + 1] - found.height[k]:+.1f} m: no road does, look there"
        )
    if found.noise > 0.0:
        words.append(f"heights smoothed by {found.noise:.2f} m" + (f" (told in steps of {found.step:g} m)" if found.step else ""))
    return found.height


def _drive(recording: Recording, station: Floats, length: float, told: Findings) -> Recorded | None:
    if recording.time is None:
        return None
    speed = recording.speed
    if speed is not None:
        way = float(np.sum(0.5 * (speed[1:] + speed[:-1]) * np.diff(recording.time)))
        if not abs(way - length) <= _AGREED * length:
            told.warn(recording.place, f"its speeds cover {way:.0f} m, its places {length:.0f} m: the speeds are not used")
            speed = None
    return recorded_drive(recording.time, station, speed, length)


def _summary(recording: Recording, wish: Wish, words: list[str], told: Findings) -> None:
    if words:
        told.note(recording.place, f"recorded drive of {len(recording)} points: {'; '.join(words)}")


def with_drive(road: Road, made: Conditioned) -> Road:
    """`road`, whose reference runs through the points of `made`, with the drive that was recorded."""
    if made.recorded is None:
        return road
    ends = np.vstack([made.points, made.points[:1]]) if made.closed else made.points
    # the curve through the points is a little longer than the way from point to point
    return replace(road, recorded=made.recorded.laid(way_along(ends), road.reference.breaks_s))
