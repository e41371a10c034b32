"""Where the knots of the spline lie: at equal distances, as published, or where the path needs them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from roads import Corridor, PlanarCurve

    Floats = NDArray[np.float64]


#: Knots by need: this share of the root of the radius (m) apart, within limits, and spreading no faster than this per metre.
_ROOT_SHARE, _CLOSEST, _WIDEST, _GROWTH = 0.8, 2.0, 16.0, 0.25
_LOOK = 2.0


def knots_by_need(corridor: Corridor, *, density: float = 1.0, widest: float = _WIDEST) -> Floats:
    """(n,) stations that lie closer where the road bends or its borders come closer, m.

    A path's curvature is nearly linear between knots; what that misses grows with the square of the distance of knots and with how fast curvature
    changes, which on a road of radius R happens over some root of R.

    Args:
        corridor: where the path may run.
        density: how many times closer than by default.
        widest: largest distance, m.
    """
    reference = corridor.reference
    count = max(int(np.ceil(reference.length / _LOOK)), 4)
    s = np.linspace(0.0, reference.length, count + 1)
    step = float(s[1])
    radius = 1.0 / np.maximum(np.abs(reference.curvature(s)), 1e-6)
    right, left = corridor.borders(s)
    ramp = np.maximum(np.abs(np.gradient(right, step)), np.abs(np.gradient(left, step)))
    wanted = np.clip(_ROOT_SHARE * np.sqrt(radius), _CLOSEST, widest)
    wanted = np.where(ramp > 0.02, np.minimum(wanted, 4.0), wanted) / density
    wanted = _spread(wanted, step * _GROWTH, closed=reference.closed)
    passed = np.concatenate([[0.0], np.cumsum(0.5 * step * (1.0 / wanted[1:] + 1.0 / wanted[:-1]))])
    segments = max(int(np.ceil(passed[-1])), 4)
    q = np.interp(np.linspace(0.0, passed[-1], segments + 1), passed, s)
    q[-1] = reference.length
    return q[:-1] if reference.closed else q


def _spread(wanted: Floats, growth: float, *, closed: bool) -> Floats:
    """The largest function below `wanted` that changes by at most `growth` per sample."""
    doubled = np.concatenate([wanted, wanted[1:]]) if closed else wanted
    ramp = growth * np.arange(len(doubled))
    ahead = np.minimum.accumulate(doubled - ramp) + ramp
    behind = (np.minimum.accumulate(doubled[::-1] - ramp) + ramp)[::-1]
    least = np.minimum(ahead, behind)
    if not closed:
        return least
    least = np.minimum(least[: len(wanted)], np.append(least[len(wanted) - 1 :], least[-1])[: len(wanted)])
    least[0] = least[-1] = min(least[0], least[-1])
    return least


def equal_knots(reference: PlanarCurve, spacing: float) -> Floats:
    """(n,) stations about `spacing` apart; a circuit does not repeat the first, m."""
    segments = max(round(reference.length / spacing), 4)
    q = np.linspace(0.0, reference.length, segments + 1)
    return q[:-1] if reference.closed else q
