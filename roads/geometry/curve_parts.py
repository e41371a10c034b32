"""Curves made from curves: driven backwards, or a part of one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .cubic import PiecewiseCubic, counted_from
from .curve import PlanarCurve, read_only

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


def backwards(curve: PlanarCurve) -> PlanarCurve:
    """`curve` from its end to its start."""
    breaks = curve.pieces.breaks
    # each piece begins at its end, and its parameter runs the other way: odd powers change sign
    a, b, c, d = counted_from(np.diff(breaks), curve.pieces.coefficients)[:, :, ::-1]
    return PlanarCurve.of_pieces(PiecewiseCubic(read_only(breaks[-1] - breaks[::-1]), np.array([-a, b, -c, d])), closed=curve.closed)


def part_of(curve: PlanarCurve, start: float, end: float) -> PlanarCurve:
    """The part of `curve` from arc length `start` to `end` (m, perhaps beyond the length of a closed one), as an open curve."""
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
    th = np.zeros(high - low)
    th[0] = first - all_breaks[low]
    cut = np.concatenate([[first], all_breaks[low + 1 : high], [last]]) - first
    return PlanarCurve.of_pieces(PiecewiseCubic(read_only(cut), counted_from(th, coefficients[:, :, low:high])))
