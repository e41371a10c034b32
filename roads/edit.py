"""Roads made from roads: reversed, cut, joined, resampled."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from .borders import narrowed_at
from .cubic import PiecewiseCubic
from .curve import PlanarCurve, read_only
from .errors import RoadError
from .road import Lane, Road

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

#: Ends of roads that are to be joined may be this far apart, m and rad.
GAP, KINK = 0.01, 0.01
#: No road is resampled to more points.
MOST_POINTS = 5_000_000
#: Edges that change at a joint do so within this stretch, m.
AT_ONCE = 0.01
#: And their heights by this much, m.
STEP = 0.1


def reversed_road(road: Road) -> Road:
    """`road` in the other direction: lanes swap sides and directions; a posted limit covers the same ground.

    The road knows one limit for both directions. A road that was drawn with elements loses them: its writers fall back on the spline.
    """

    def turned(values: Floats) -> Floats:
        return read_only(np.roll(values[::-1], 1) if road.closed else values[::-1])

    def other(lane: Lane) -> Lane:
        return Lane(-lane.direction, turned(-lane.left), turned(-lane.right), lane.kind, lane.name)

    s = np.roll(road.length - road.s[::-1], 1) if road.closed else road.length - road.s[::-1]
    s = np.concatenate([[0.0], s[1:]])
    limit = road.speed_limit[::-1] if road.closed else np.append(road.speed_limit[-2::-1], road.speed_limit[0])
    return Road(
        road.name,
        _backwards(road.reference),
        read_only(s),
        turned(-road.left),
        turned(-road.right),
        turned(road.height),
        read_only(limit),
        tuple(other(lane) for lane in reversed(road.lanes)),
        turned(-road.bank),
        turned(road.friction),
        drive=None if road.drive is None or road.drive.direction > 0 else other(road.drive),
        left_hand=road.left_hand,
        columns={name: turned(_from_the_other_end(name, values)) for name, values in road.columns.items()},
        origin=road.origin,
    )


def _from_the_other_end(name: str, values: Floats) -> Floats:
    """What a column says when the road is driven the other way: distances and times count from the end, curvature changes sign."""
    if name in ("s", "t"):
        return values[-1] - values
    return {"psi": values + np.pi, "kappa": -values, "a": -values}.get(name, values)


def _backwards(curve: PlanarCurve) -> PlanarCurve:
    breaks = curve.pieces.breaks
    h = np.diff(breaks)
    a, b, c, d = (row[:, ::-1] for row in curve.pieces.coefficients)
    h = h[::-1]
    # p(h - th) in powers of th
    rows = [-a, 3.0 * a * h + b, -(3.0 * a * h + 2.0 * b) * h - c, ((a * h + b) * h + c) * h + d]
    return PlanarCurve.of_pieces(PiecewiseCubic(read_only(breaks[-1] - breaks[::-1]), np.array(rows)), closed=curve.closed)


def stretch_of(road: Road, stretch: slice) -> Road:
    """The part of `road` between the stations `stretch.start` and `stretch.stop`, as an open road.

    Raises:
        RoadError: a step, or stations that are not on the road or in the wrong order.
    """
    start = 0.0 if stretch.start is None else float(stretch.start)
    end = road.length if stretch.stop is None else float(stretch.stop)
    if stretch.step is not None:
        raise RoadError(f"{road.name}: a stretch has no step, found {stretch.step}; `resampled` changes the spacing")
    if road.closed and end <= start:
        end += road.length
    if not (0.0 <= start < end and end - start <= road.length + 1e-9 and start < road.length and (road.closed or end <= road.length + 1e-6)):
        raise RoadError(f"{road.name}: stretch {stretch.start}:{stretch.stop} m, expected increasing stations between 0 and {road.length:.3f} m")
    laps = [0.0, road.length] if road.closed else [0.0]
    ends = [end] if road.closed else [min(end, road.length)]
    inner = np.concatenate([road.s + lap for lap in laps])
    s = np.concatenate([[start], inner[(inner > start + 1e-6) & (inner < ends[0] - 1e-6)], ends])
    curve = _between(road.reference, start, ends[0])
    return sampled(road, s, curve, s - start)


def resampled_road(road: Road, spacing: float) -> Road:
    """`road` with data evenly spaced by at most `spacing` (m); the reference is drawn anew through the new points.

    Where limits change between two stations the lower one counts from the earlier station on.

    Raises:
        RoadError: a spacing that is not positive.
    """
    if not 0.0 < spacing < np.inf:
        raise RoadError(f"{road.name}: spacing {spacing} m, expected more than 0")
    count = max(int(np.ceil(min(road.length / spacing, 1e12) - 1e-9)), 3 if road.closed else 1)
    if count > MOST_POINTS:
        raise RoadError(f"{road.name}: spacing {spacing:g} m makes {count:.3g} points, expected at most {MOST_POINTS}")
    s = np.linspace(0.0, road.length, count + 1)
    s = s[:-1] if road.closed else s
    curve = PlanarCurve.through(road.reference.position(s), closed=road.closed)
    made = sampled(road, s, curve, curve.breaks_s[:-1] if road.closed else curve.breaks_s, closed=road.closed)
    first = np.clip(np.searchsorted(road.s, s), 0, len(road.s) - 1)
    inside = (road.s[first] >= s) & (road.s[first] < np.append(s[1:], road.length))
    lowest = np.where(inside, np.minimum.reduceat(road.speed_limit, first), np.inf)
    return replace(made, speed_limit=read_only(np.minimum(made.speed_limit, lowest)))


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
    return sampled(road, at, road.reference, start + at * ((end - start) / road.length))


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


def _between(curve: PlanarCurve, start: float, end: float) -> PlanarCurve:
    """The part of `curve` from arc length `start` to `end` (m, perhaps beyond the length of a closed one)."""
    length, breaks = curve.length, curve.pieces.breaks
    period = breaks[-1] - breaks[0]
    laps = 2 if curve.closed else 1
    all_breaks = np.concatenate([breaks[:-1] + lap * period for lap in range(laps)] + [breaks[-1:] + (laps - 1) * period])
    coefficients = np.concatenate([curve.pieces.coefficients] * laps, axis=2)

    def parameter(s: float) -> float:
        return float(curve.parameter(s % length) + (s // length) * period) if curve.closed else float(curve.parameter(s))

    first, last = parameter(start), parameter(end)
    low = int(np.searchsorted(all_breaks, first + 1e-9, side="right")) - 1
    high = int(np.searchsorted(all_breaks, last - 1e-9, side="left"))
    a, b, c, d = coefficients[:, :, low:high].copy()
    th = np.zeros(high - low)
    th[0] = first - all_breaks[low]
    rows = np.array([a, b + 3.0 * a * th, c + (2.0 * b + 3.0 * a * th) * th, ((a * th + b) * th + c) * th + d])
    cut = np.concatenate([[first], all_breaks[low + 1 : high], [last]]) - first
    return PlanarCurve.of_pieces(PiecewiseCubic(read_only(cut), rows))


def sampled(road: Road, s: Floats, curve: PlanarCurve, new_s: Floats, *, closed: bool = False) -> Road:
    """`road`'s data at its stations `s`, laid along `curve` at stations `new_s`."""

    def linear(values: Floats) -> Floats:
        at = np.mod(s, road.length) if road.closed else s
        if np.isnan(values).any():
            # a lane that ends ends at its last station, not half way to the next
            period = road.length if road.closed else None
            near = np.interp(at, road.s, np.where(np.isnan(values), 0.0, values), period=period)
            gone = np.interp(at, road.s, np.isnan(values).astype(float), period=period) > 1e-9
            return read_only(np.where(gone, np.nan, near))
        return read_only(np.interp(at, road.s, values, period=road.length if road.closed else None))

    def cut(lane: Lane) -> Lane:
        return Lane(lane.direction, linear(lane.right), linear(lane.left), lane.kind, lane.name)

    lanes = tuple(lane for lane in map(cut, road.lanes) if not np.isnan(lane.right).all())
    return Road(
        road.name,
        curve,
        read_only(new_s),
        linear(road.right),
        linear(road.left),
        read_only(road.height_at(s)),
        read_only(road.speed_limit_at(s)),
        lanes,
        linear(road.bank),
        linear(road.friction),
        drive=None if road.drive is None else cut(road.drive),
        left_hand=road.left_hand,
        columns={name: linear(values) for name, values in road.columns.items()},
        origin=road.origin,
    )
