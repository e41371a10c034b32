"""Smoothing of a road's reference line, which moves by no more than a stated distance while edges and lanes stay where they are."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..borders import offsets_beside
from ..columns import MOST_POINTS
from ..conditioning.bounded import smooth_points
from ..geometry.curve import PlanarCurve, read_only

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..lane import Lane
    from ..road import Road

    Floats = NDArray[np.float64]


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
    fine = np.union1d(road.s, np.linspace(0.0, road.length, int(np.ceil(min(road.length, MOST_POINTS))) + 1))
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
