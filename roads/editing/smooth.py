"""Smoothing of noisy centre lines: the line with least change of curvature that stays within a stated distance of the points.

What is minimised is `sum m_i |z_i - y_i|^2 + lam int |z'''(s)|^2 ds` over places z beside the points y, a banded system of width 3. `lam` is
the largest one of a geometric ladder that leaves the typical deviation at a third of the bound and the largest near it; then the weights m of
points farther off than the bound grow until none is, with a weaker `lam` where that does not end. Every step costs time in proportion to the
number of points.

The bound is kept at the points and, by the final check, by the curve through the new points at the old ones.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import solveh_banded

from ..borders import offsets_beside, way_along
from ..errors import RoadError
from ..geometry.curve import PlanarCurve, read_only

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ..lane import Lane
    from ..road import Road

    Floats = NDArray[np.float64]

#: Share of the bound that the root mean square deviation is led to before single points are pulled back.
_TYPICAL = 1.0 / 3.0
#: And share of it that no point may exceed before that.
_FARTHEST = 1.3
#: A closed line is wound on by this many points at both ends.
_WRAP = 200
_ROUNDS = 12


@dataclass(frozen=True)
class SmoothingReport:
    """What smoothing did to a centre line.

    Attributes:
        bound: stated largest deviation, m.
        largest_left: how far the line moved to the left at most, m.
        largest_right: to the right, m.
        rms_left: root mean square of the moves to the left, m.
        rms_right: to the right, m.
        squared_curvature_before: integral of curvature squared over the length, 1/m.
        squared_curvature_after: the same of the smoothed line, 1/m.
    """

    bound: float
    largest_left: float
    largest_right: float
    rms_left: float
    rms_right: float
    squared_curvature_before: float
    squared_curvature_after: float


def smooth_points(points: ArrayLike, bound: float, *, closed: bool = False) -> Floats:
    """The smoothed line's points (n, 2), each within `bound` (m) of its own one; the ends of an open line stay.

    Raises:
        RoadError: a bound that is not positive, or points that make no curve.
    """
    points = np.asarray(points, dtype=np.float64)
    if not 0.0 < bound < np.inf:
        raise RoadError(f"largest deviation {bound} m, expected more than 0")
    PlanarCurve.through(points, closed=closed)  # says what is wrong with the points
    if len(points) < 5:
        return points.copy()
    count = len(points)
    wrap = min(_WRAP, count) if closed else 0
    line = np.vstack([points[count - wrap :], points, points[:wrap]]) if closed else points
    inner = slice(wrap, wrap + count)
    penalty = _Penalty.of(line)
    weight = np.ones(len(line))
    if not closed:
        weight[[0, -1]] = 1e9
    # around the middle scale of the problem: where point and penalty weigh the same
    scale = 1.0 / float(np.median(penalty.bands[-1]))
    lam = scale
    for factor in 10.0 ** np.arange(0.0, 12.0, 0.5):
        off = _distance(_solved(line, weight, scale * factor, penalty), line)[inner]
        if float(np.sqrt(np.mean(off**2))) > _TYPICAL * bound or float(np.max(off)) > _FARTHEST * bound:
            break
        lam = scale * factor
    while lam > 1e-6 * scale:
        found = _pulled_back(line, weight.copy(), lam, penalty, bound, inner, closed)
        if found is not None:
            return found
        lam *= 0.1
    return points.copy()


def _pulled_back(line: Floats, weight: Floats, lam: float, penalty: _Penalty, bound: float, inner: slice, closed: bool) -> Floats | None:
    """The smoothed points with all of them within `bound`; None where that takes a weaker penalty."""
    # the bound is on the curve as well as on its points: a little is kept in hand for what lies between
    aim = 0.9 * bound
    for _ in range(_ROUNDS):
        found = _solved(line, weight, lam, penalty)
        off = _distance(found, line)
        if closed:
            off = np.maximum(off, _rolled(off[inner], len(line), inner.start))
        if np.max(off[inner]) <= aim:
            return found[inner] if _kept(found[inner], line[inner], bound, closed) else None
        weight *= np.maximum(off / (0.8 * aim), 1.0) ** 3
    return None


def _rolled(off: Floats, count: int, wrap: int) -> Floats:
    """Deviations of one round repeated over the parts that are wound on."""
    return np.concatenate([off[len(off) - wrap :], off, off[:wrap]])[:count]


def _kept(line: Floats, points: Floats, bound: float, closed: bool) -> bool:
    curve = PlanarCurve.through(line, closed=closed)
    near = curve.breaks_s[:-1] if closed else curve.breaks_s
    _, offset = curve.project(points, near)
    return bool(np.max(np.abs(offset)) <= bound)


def _distance(a: Floats, b: Floats) -> Floats:
    return np.hypot(a[:, 0] - b[:, 0], a[:, 1] - b[:, 1])


@dataclass(frozen=True, eq=False)
class _Penalty:
    """The matrix of the squared third derivative, which is taken by divided differences.

    Attributes:
        bands: (4, n) upper bands of the matrix.
        pull: (n, 2) the matrix times the points themselves.
    """

    bands: Floats
    pull: Floats

    @classmethod
    def of(cls, line: Floats) -> _Penalty:
        s = way_along(line)
        count = len(s)
        window = [s[k : count - 3 + k] for k in range(4)]
        rows = np.array([6.0 / np.prod([window[k] - window[j] for j in range(4) if j != k], axis=0) for k in range(4)])
        rows = rows * np.sqrt((window[3] - window[0]) / 3.0)
        bands = np.zeros((4, count))
        for a in range(4):
            for b in range(a, 4):
                bands[3 - (b - a), b : count - 3 + b] += rows[a] * rows[b]
        differences = np.sum([rows[k][:, None] * line[k : count - 3 + k] for k in range(4)], axis=0)
        pull = np.zeros_like(line)
        for k in range(4):
            pull[k : count - 3 + k] += rows[k][:, None] * differences
        return cls(bands, pull)


def _solved(line: Floats, weight: Floats, lam: float, penalty: _Penalty) -> Floats:
    """The minimiser, solved for how far it lies from the points: that keeps its digits where the penalty outweighs the points by far."""
    bands = lam * penalty.bands
    bands[3] += weight
    return line - solveh_banded(bands, lam * penalty.pull, check_finite=False)


def smoothed(road: Road, bound: float) -> tuple[Road, SmoothingReport]:
    """`road` with its reference smoothed, moved by at most `bound` (m); edges and lanes stay where they are and are measured anew.

    Where an edge lies as far inside a bend as the bend's centre, it cannot be measured from the new reference as it was from the old one.

    Raises:
        RoadError: a bound that is not positive, or one so large that the new reference leaves the road.
    """
    # stations a centimetre apart, where edges change at once, are no points to draw a line through
    keep = np.isin(road.s, road.knots)
    old = road.reference.position(road.s[keep])
    curve = PlanarCurve.through(smooth_points(old, bound, closed=road.closed), closed=road.closed)
    knots = curve.breaks_s[:-1] if road.closed else curve.breaks_s
    ends = (np.append(road.s[keep], road.length), curve.breaks_s) if road.closed else (road.s[keep], knots)
    # what runs beside a smoother line no longer runs straight: data every metre or less
    fine = np.union1d(road.s, np.linspace(0.0, road.length, int(np.ceil(road.length)) + 1))
    fine = fine[fine < road.length - 1e-9] if road.closed else fine
    s = np.interp(fine, *ends)
    base = road.laid_along(road.reference, fine, fine)
    place, normal = road.reference.position(fine), road.reference.normal(fine)

    def anew(offset: Floats) -> Floats:
        return read_only(offsets_beside(curve, place + offset[:, None] * normal, s, s))

    right, left = anew(base.right), anew(base.left)

    def lane_anew(lane: Lane) -> Lane:
        gone = np.isnan(lane.right)
        sides = [np.where(gone, np.nan, np.clip(anew(np.where(gone, 0.0, side)), right, left)) for side in (lane.right, lane.left)]
        return replace(lane, right=sides[0], left=sides[1])

    made = replace(
        base,
        reference=curve,
        s=read_only(s),
        right=right,
        left=left,
        lanes=tuple(lane_anew(lane) for lane in base.lanes),
        drive=None if base.drive is None else lane_anew(base.drive),
    )
    return made, _report(road, curve, bound, old, knots)


def _report(road: Road, curve: PlanarCurve, bound: float, old: Floats, near: Floats) -> SmoothingReport:
    _, offset = curve.project(old, near)
    # where the old line is to the right of the new one, the line moved to the left
    to_left, to_right = np.maximum(-offset, 0.0), np.maximum(offset, 0.0)
    return SmoothingReport(
        bound,
        float(np.max(to_left)),
        float(np.max(to_right)),
        float(np.sqrt(np.mean(to_left**2))),
        float(np.sqrt(np.mean(to_right**2))),
        road.reference.squared_curvature(),
        curve.squared_curvature(),
    )
