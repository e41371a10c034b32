"""Paths cut and put together at knots."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from roads.geometry.cubic import PiecewiseCubic

from ..problem.ends import End

if TYPE_CHECKING:
    from .window import Tables


def end_of(pieces: PiecewiseCubic, at: float, tables: Tables, knot: int) -> End:
    """The end condition that continues `pieces` at the knot at station `at`: place, heading, curvature."""
    inner = knot % tables.count
    place, first, second = (value[0] for value in pieces(np.array([at - 1e-9]), 2))
    tangent, normal = tables.frame[0][inner], tables.frame[1][inner]
    gap = place - tables.place[inner] - tables.problem.spline.origin
    speed = float(np.hypot(*first))
    kappa = float(first[0] * second[1] - first[1] * second[0]) / speed**3
    return End(float(gap @ normal), float(np.arctan2(first @ normal, first @ tangent)), kappa, speed)


def joined(before: PiecewiseCubic | None, after: PiecewiseCubic, start: float) -> PiecewiseCubic:
    """`before` from about `start` up to where `after` begins, then `after`."""
    if before is None:
        return after
    at = after.breaks[0]
    low = max(int(np.searchsorted(before.breaks, start, side="right")) - 1, 0)
    high = int(np.searchsorted(before.breaks, at - 1e-6))
    breaks = np.concatenate([before.breaks[low:high], after.breaks])
    return PiecewiseCubic(breaks, np.concatenate([before.coefficients[:, :, low:high], after.coefficients], axis=2))


def cut(pieces: PiecewiseCubic, end: float) -> PiecewiseCubic:
    """The pieces up to station `end`."""
    high = int(np.searchsorted(pieces.breaks, end - 1e-9))
    if high >= len(pieces.breaks) - 1 and end >= pieces.breaks[-1] - 1e-9:
        return pieces
    high = max(high, 1)
    return PiecewiseCubic(np.append(pieces.breaks[:high], max(end, pieces.breaks[high - 1] + 1e-6)), pieces.coefficients[:, :, :high].copy())
