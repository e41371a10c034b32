"""One road out of the lanes of a route: the middle of the lanes driven becomes the reference, borders are measured from it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ..borders import dense, narrowed_at, places_beside, spaced, way_along
from ..errors import RoadError
from ..geometry.curve import PlanarCurve, read_only
from ..lane import Lane
from ..road import Road

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .links import LinkMap
    from .routing import Step

    Floats = NDArray[np.float64]

#: Where cross-sections change at once, edges do so within this stretch, m.
AT_ONCE = 0.01
#: The reference is not drawn through points closer than this, m.
NEAREST = 0.02
#: Middles of lanes that meet within this are the same place, m; larger offsets are blended over `BLEND`.
SAME = 2e-3
BLEND = 30.0
#: Lanes that follow each other on a route may begin this far from where the one before ends, m and rad.
GAP, KINK = 3.0, 0.7
#: A change of lane takes at most this way, m.
CHANGE = 80.0
#: And at least this way for each lane, m.
LEAST_CHANGE = 12.0


@dataclass(frozen=True, eq=False)
class _Part:
    """One cross-section run: the middle line driven (n, 3), and borders (m, 3) by link, from right to left."""

    middle: Floats
    lanes: list[tuple[str, int, Floats, Floats]]
    followed: int
    limit: Floats
    exact: bool


def assemble(name: str, network: LinkMap, route: list[list[Step]]) -> Road:
    """The road along `route`.

    Raises:
        RoadError: lanes that are no longer than a few centimetres, or that do not meet.
    """
    try:
        return _assembled(name, network, route)
    except RoadError as error:
        raise error if str(error).startswith(network.path) else RoadError(f"{network.path}: {error}") from None


def _assembled(name: str, network: LinkMap, route: list[list[Step]]) -> Road:
    parts = [part for steps in route if (part := _part(network, steps)) is not None]
    if not parts:
        raise RoadError(f"{network.path}: the route is shorter than {2 * NEAREST} m, expected a longer one")
    _check_joints(network, route, parts)
    middles = _blended([part.middle for part in parts])
    line, owner = _merged(middles)
    if len(line) < 2:
        raise RoadError(f"{network.path}: the route is shorter than {2 * NEAREST} m, expected a longer one")
    curve = PlanarCurve.through(line[:, :2])
    sections = [_measured(curve, part, curve.breaks_s[owner == k]) for k, part in enumerate(parts)]
    return _road(name, network, curve, line[:, 2], owner, parts, sections)


def _part(network: LinkMap, steps: list[Step]) -> _Part | None:
    """The run of cross-sections that `steps` (lanes side by side) drive."""
    first, last = steps[0], steps[-1]
    share = (first.start / first.link.length, last.end / last.link.length) if first.link.length > NEAREST else (0.0, 1.0)
    lanes, followed, middles = [], 0, []
    beside = first.link.beside or (first.link.id,)
    against = first.link.against or (False,)
    for name, is_against in zip(beside, against, strict=True):
        link = network.links[name]
        left, right = link.borders
        if is_against:
            left, right = right[::-1], left[::-1]
        if name == last.link.id:
            followed = len(lanes)
        lanes.append((name, -1 if is_against else 1, _cut(left, share, exact=link.exact), _cut(right, share, exact=link.exact)))
    middles += [_cut(step.link.centre, share, exact=step.link.exact) for step in steps]
    middle = middles[0] if len(middles) == 1 else _changed(network, steps, middles)
    length = float(way_along(middle)[-1])
    if length < NEAREST:
        return None
    at = way_along(middle)
    # a point where a limit begins is past it, though the way to it is that of a line whose ends were moved onto the curve
    limit = last.link.limit_at(share[0] * last.link.length + at * ((share[1] - share[0]) * last.link.length / length) + SAME)
    return _Part(middle, lanes, followed, limit, first.link.exact)


def _cut(line: Floats, share: tuple[float, float], *, exact: bool) -> Floats:
    """The part of `line` between two shares of its length; new ends lie on its curve (`exact`) or on the polyline."""
    if share == (0.0, 1.0):
        return line
    s = way_along(line)
    low, high = share[0] * s[-1], share[1] * s[-1]
    inner = (s > low + 1e-6) & (s < high - 1e-6)
    at = np.concatenate([[low], s[inner], [high]])
    made = np.column_stack([np.interp(at, s, line[:, axis]) for axis in range(3)])
    if exact and len(line) > 2 and s[-1] > 4.0 * NEAREST:
        made[[0, -1]] = _along(line, np.array(share))
    return made


def _changed(network: LinkMap, steps: list[Step], middles: list[Floats]) -> Floats:
    """From the first to the last of lines that lie side by side, smoothly, at the end of the stretch.

    Raises:
        RoadError: too little way for the change.
    """
    s = way_along(middles[0])
    changes = len(middles) - 1
    if s[-1] < LEAST_CHANGE * changes:
        raise RoadError(
            f"{network.path}: changing from lane {steps[0].link.id} to {steps[-1].link.id} takes at least {LEAST_CHANGE * changes:g} m, "
            f"{s[-1]:.1f} m are left"
        )
    way = min(CHANGE * changes, float(s[-1]))
    begin = float(s[-1]) - way
    fine = np.concatenate([s[s < begin - 0.5], np.linspace(begin, s[-1], max(int(way), 12) + 1)])
    first, last = _along(middles[0], fine / s[-1]), _along(middles[-1], fine / s[-1])
    share = _eased(np.clip((fine - begin) / way, 0.0, 1.0))[:, None]
    return (1.0 - share) * first + share * last


def _along(line: Floats, share: Floats) -> Floats:
    """Places (n, 3) at shares of the length of `line`: on the spline through its points, heights linear."""
    s = way_along(line)
    keep = spaced(s, NEAREST)
    curve = PlanarCurve.through(line[keep, :2])
    # the spline's own length runs a little ahead of the polyline's
    at = np.interp(share * s[-1], s[keep], curve.breaks_s)
    return np.column_stack([curve.position(at), np.interp(share * s[-1], s, line[:, 2])])


def _eased(share: Floats) -> Floats:
    """From 0 to 1 with two vanishing derivatives at both ends."""
    return share**3 * (10.0 - 15.0 * share + 6.0 * share**2)


def _check_joints(network: LinkMap, route: list[list[Step]], parts: list[_Part]) -> None:
    for before, after in pairwise(parts):
        gap = float(np.hypot(*(after.middle[0, :2] - before.middle[-1, :2])))
        turn = _direction(after.middle[:2]) - _direction(before.middle[-2:])
        kink = abs((turn + np.pi) % (2.0 * np.pi) - np.pi)
        if gap > GAP or kink > KINK:
            names = before.lanes[before.followed][0], after.lanes[after.followed][0]
            limits = f"expected at most {GAP} m and {KINK} rad"
            raise RoadError(f"{network.path}: lane {names[1]} begins {gap:.2f} m and {kink:.2f} rad away from the end of {names[0]}, {limits}")


def _direction(pair: Floats) -> float:
    return float(np.arctan2(*(pair[-1, :2] - pair[0, :2])[::-1]))


def _blended(middles: list[Floats]) -> list[Floats]:
    """Lines whose ends meet: what they miss each other by is spread over the stretch after the joint, smoothly."""
    found = [middles[0]]
    for line in middles[1:]:
        miss = found[-1][-1] - line[0]
        if float(np.hypot(*miss[:2])) <= SAME:
            found.append(line)
            continue
        s = way_along(line)
        way = min(BLEND, float(s[-1]))
        fine = np.concatenate([np.linspace(0.0, way, max(int(2 * way), 8) + 1), s[s > way + 0.25]])
        line = _along(line, fine / s[-1])
        found.append(line + _eased(np.clip(1.0 - fine / way, 0.0, 1.0))[:, None] * miss)
    return found


def _merged(lines: list[Floats]) -> tuple[Floats, NDArray[np.intp]]:
    """All points in order without near repetitions, and the part that each belongs to (a joint to the part that begins there)."""
    line = np.concatenate(lines)
    owner = np.repeat(np.arange(len(lines)), [len(points) for points in lines])
    keep = np.ones(len(line), dtype=bool)
    last = len(line) - 1
    for k in (np.flatnonzero(np.hypot(*np.diff(line[:, :2], axis=0).T) < NEAREST) + 1).tolist():
        here = k - 1
        while not keep[here]:
            here -= 1
        if np.hypot(line[k, 0] - line[here, 0], line[k, 1] - line[here, 1]) >= NEAREST:
            continue
        if k == last or owner[k] != owner[here]:
            # the end and the joints stay, the point just before them goes, unless it is the start
            keep[here] = here == 0
        else:
            keep[k] = False
    return line[keep], owner[keep]


def _measured(curve: PlanarCurve, part: _Part, stations: Floats) -> tuple[Floats, Floats, Floats]:
    """Offsets (lanes, n) of right and left borders at `stations`, and the bank (n,)."""
    start = float(stations[0]) if len(stations) else 0.0
    right, left, bank = [], [], np.zeros(len(stations))
    for k, (_, _, left_line, right_line) in enumerate(part.lanes):
        offsets, heights = [], []
        for line in (right_line, left_line):
            fine = line if part.exact else dense(line)
            s = way_along(fine)
            near = np.clip(start + s / max(s[-1], 1e-9) * way_along(part.middle)[-1], 0.0, curve.length)
            offset, height = places_beside(curve, fine, near, stations)
            offsets.append(offset)
            heights.append(height)
        right.append(np.minimum(*offsets))
        left.append(np.maximum(*offsets))
        if k == part.followed:
            bank = np.arctan2(heights[1] - heights[0], np.maximum(offsets[1] - offsets[0], 0.5))
    return np.array(right), np.array(left), bank


def _limits(part: _Part, way: Floats) -> Floats:
    """Speed limits of the lane driven, (n,) m/s, at distances `way` (m) along the part."""
    along = way_along(part.middle)
    return part.limit[np.clip(np.searchsorted(along, np.clip(way, 0.0, along[-1]) + 1e-6, side="right") - 1, 0, len(along) - 1)]


def _lanes(network: LinkMap, part: _Part, here: NDArray[np.bool_], sides: list[Floats]) -> list[Lane]:
    """The part's lanes over the stations of the whole road: there where `here` says so, from `sides`, right and left (lanes, n)."""
    made = []
    for (identity, direction, _, _), *offsets in zip(part.lanes, *sides, strict=True):
        bounds = np.full((2, len(here)), np.nan)
        bounds[:, here] = offsets
        made.append(Lane(direction, read_only(bounds[0]), read_only(bounds[1]), network.links[identity].kind, identity))
    return made


def _road(
    name: str,
    network: LinkMap,
    curve: PlanarCurve,
    height: Floats,
    owner: NDArray[np.intp],
    parts: list[_Part],
    sections: list[tuple[Floats, Floats, Floats]],
) -> Road:
    """Lanes end with their part, except those driven; edges change at once where parts meet, on the wider side."""
    s = curve.breaks_s
    joints = np.flatnonzero(np.diff(owner)) + 1
    extra = np.concatenate([s[joints] - AT_ONCE, s[joints] + AT_ONCE])
    extra = extra[(extra > 0.0) & (extra < s[-1])]
    stations = np.union1d(s, extra)
    part_at = np.append(owner[np.searchsorted(s, stations[:-1], side="right") - 1], owner[-1])
    right, left, bank = (np.empty(len(stations)) for _ in range(3))
    limit = np.empty(len(stations))
    drive_right, drive_left = np.empty(len(stations)), np.empty(len(stations))
    lanes: list[Lane] = []
    for k, (part, (lane_right, lane_left, banks)) in enumerate(zip(parts, sections, strict=True)):
        here = part_at == k
        own = s[owner == k]
        if not len(own):
            continue
        at = stations[here]
        right[here], left[here] = np.interp(at, own, lane_right[0]), np.interp(at, own, lane_left[-1])
        bank[here] = np.interp(at, own, banks)
        limit[here] = _limits(part, at - own[0])
        mid_right, mid_left = np.interp(at, own, lane_right[part.followed]), np.interp(at, own, lane_left[part.followed])
        # the reference is the middle driven: while it changes lanes, the strip to be driven goes with it
        half = 0.5 * (mid_left - mid_right)
        drive_right[here], drive_left[here] = -half, half
        lanes += _lanes(network, part, here, [np.array([np.interp(at, own, row) for row in side]) for side in (lane_right, lane_left)])
    right, left = narrowed_at(right, left, np.searchsorted(stations, s[joints]))
    lanes = [Lane(lane.direction, np.clip(lane.right, right, left), np.clip(lane.left, right, left), lane.kind, lane.name) for lane in lanes]
    drive = Lane(1, np.clip(drive_right, right, left), np.clip(drive_left, right, left), "driving", "route")
    left_hand = network.links[parts[0].lanes[parts[0].followed][0]].left_hand
    z = np.interp(stations, s, height)
    return Road(
        name,
        curve,
        read_only(stations),
        read_only(right),
        read_only(left),
        read_only(z),
        read_only(limit),
        tuple(lanes),
        read_only(bank),
        drive=drive,
        left_hand=left_hand,
    )
