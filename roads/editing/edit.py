"""One road made from several that follow each other."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ..borders import narrowed_at
from ..errors import RoadError
from ..geometry.curve import PlanarCurve, read_only
from ..lane import Lane
from ..road import Road

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

#: Ends of roads that are to be joined may be this far apart, m and rad.
GAP, KINK = 0.01, 0.01
#: Edges that change at a joint do so within this stretch, m.
AT_ONCE = 0.01
#: And their heights by this much, m.
STEP = 0.1


def join(roads: Sequence[Road], name: str | None = None) -> Road:
    """One road out of `roads` that follow each other.

    Lanes go on by their order from the right where their number and directions agree; otherwise each road's lanes end with it.

    Args:
        roads: each begins where the one before ends.
        name: of the whole; default: the names joined by " + ".

    Raises:
        RoadError: nothing to join, a closed road, or ends that are more than 1 cm, 0.01 rad or 0.1 m of height apart.
    """
    if not roads:
        raise RoadError("no roads to join, expected at least one")
    name = name or " + ".join(road.name for road in roads)
    for before, after in pairwise(roads):
        _check_joint(name, before, after)
    points = np.concatenate([road.reference.position(road.knots)[1 if k else 0 :] for k, road in enumerate(roads)])
    curve = PlanarCurve.through(points)
    ends = np.concatenate([[0.0], np.cumsum([road.length for road in roads])]) * (curve.length / sum(road.length for road in roads))
    parts = [_part_of(road, ends[k], ends[k + 1], first=k == 0, last=k == len(roads) - 1) for k, road in enumerate(roads)]
    own = [np.full(len(part.s), k) for k, part in enumerate(parts)]
    s, owner = np.concatenate([part.s for part in parts]), np.concatenate(own)

    def chained(pick: Callable[[Road], Floats]) -> Floats:
        return np.concatenate([pick(part) for part in parts])

    right, left = chained(lambda road: road.right), chained(lambda road: road.left)
    right, left = narrowed_at(right, left, np.flatnonzero(np.diff(owner)) + 1)
    lanes = _joined_lanes(parts, chained, right, left)
    drive = None
    if any(road.drive is not None for road in roads):
        driven = [np.clip(chained(lambda road, side=side: getattr(road.driving_lane(), side)), right, left) for side in ("right", "left")]
        drive = Lane(1, read_only(driven[0]), read_only(driven[1]), "driving", "followed")
    return Road(
        name,
        curve,
        read_only(s),
        read_only(right),
        read_only(left),
        read_only(chained(lambda road: road.height)),
        read_only(chained(lambda road: road.speed_limit)),
        lanes,
        read_only(chained(lambda road: road.bank)),
        read_only(chained(lambda road: road.friction)),
        drive=drive,
        left_hand=roads[0].left_hand,
        origin=roads[0].origin,
    )


def _part_of(road: Road, start: float, end: float, *, first: bool, last: bool) -> Road:
    """`road`'s data at stations of the whole: its last station moves a centimetre back from the joint, its first is doubled a centimetre on."""
    at = road.s if last else np.append(road.s[:-1][road.s[:-1] < road.length - 2.0 * AT_ONCE], road.length - AT_ONCE)
    if not first and at[1] > 2.0 * AT_ONCE:
        at = np.insert(at, 1, AT_ONCE)
    return road.laid_along(road.reference, start + at * ((end - start) / road.length), at)


def _check_joint(name: str, before: Road, after: Road) -> None:
    if before.closed or after.closed:
        raise RoadError(f"{name}: {(before if before.closed else after).name} is closed, expected open roads")
    gap = float(np.hypot(*(after.reference.position(0.0) - before.reference.position(before.length))))
    turn = float(after.reference.heading(0.0) - before.reference.heading(before.length))
    kink = abs((turn + np.pi) % (2 * np.pi) - np.pi)
    step = abs(float(after.height[0] - before.height[-1]))
    if gap > GAP or kink > KINK or step > STEP:
        raise RoadError(
            f"{name}: {after.name} begins {gap:.3f} m, {kink:.4f} rad and {step:.3f} m of height away from where {before.name} ends, "
            f"expected at most {GAP} m, {KINK} rad and {STEP} m"
        )


def _joined_lanes(parts: Sequence[Road], chained: Callable[[Callable[[Road], Floats]], Floats], right: Floats, left: Floats) -> tuple[Lane, ...]:
    def lane(like: Lane, name: str, pick: Callable[[Road], Lane | None]) -> Lane:
        sides = []
        for side in ("right", "left"):
            found = chained(lambda road, side=side: np.full(len(road.s), np.nan) if pick(road) is None else getattr(pick(road), side))
            sides.append(read_only(np.clip(found, right, left)))
        return Lane(like.direction, sides[0], sides[1], like.kind, name)

    if len({tuple(lane.direction for lane in road.lanes) for road in parts}) == 1:
        return tuple(lane(like, like.name, lambda road, k=k: road.lanes[k]) for k, like in enumerate(parts[0].lanes))
    return tuple(
        lane(like, f"{owner.name}:{like.name}", lambda road, owner=owner, like=like: like if road is owner else None)
        for owner in parts
        for like in owner.lanes
    )
