"""Jerk at the stations: speed times the change of acceleration from interval to interval, over the way between their middles.

With speed squared linear between the stations acceleration is piecewise constant; its change at a station is spread over the two half intervals.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .speed_limits import SpeedLimits

    Floats = NDArray[np.float64]

#: What is added to v^2/2 under the root, scaled.
_REST = 1e-16
_SIGNS = np.array([1.0, -1.0])


def jerk_of(ds: Floats, v: Floats) -> Floats:
    """(n-2,) jerk at the inner stations, m/s^3."""
    acceleration = np.diff(v**2) / (2.0 * ds)
    return v[1:-1] * np.diff(acceleration) / (0.5 * (ds[1:] + ds[:-1]))


class JerkModel:
    """Rows j / j_max - 1 and -j / j_max - 1 at the inner stations, over scaled v^2/2."""

    def __init__(self, limits: SpeedLimits, energy_scale: float) -> None:
        before, after = limits.ds[:-1], limits.ds[1:]
        self._before, self._after = 1.0 / before, 1.0 / after
        self._scale = np.sqrt(2.0 * energy_scale) * energy_scale / (0.5 * (before + after)) / limits.jerk

    def _parts(self, x: Floats) -> tuple[Floats, Floats]:
        """Root of x at the inner stations, and the change of acceleration."""
        return np.sqrt(x[1:-1] + _REST), (x[2:] - x[1:-1]) * self._after - (x[1:-1] - x[:-2]) * self._before

    def values(self, x: Floats) -> Floats:
        """(n-2, 2) rows."""
        root, change = self._parts(x)
        return (self._scale * root * change)[:, None] * _SIGNS - 1.0

    def _gradient(self, x: Floats) -> Floats:
        """(n-2, 3) of the first row by x before, at and after the station."""
        root, change = self._parts(x)
        middle = -root * (self._before + self._after) + 0.5 * change / root
        return self._scale[:, None] * np.column_stack([root * self._before, middle, root * self._after])

    def along(self, x: Floats, direction: Floats) -> Floats:
        """(n-2, 2) derivative of the rows along a direction."""
        gradient = self._gradient(x)
        by = gradient[:, 0] * direction[:-2] + gradient[:, 1] * direction[1:-1] + gradient[:, 2] * direction[2:]
        return by[:, None] * _SIGNS

    def add_gradient(self, gradient: Floats, x: Floats, dual: Floats) -> None:
        """Add the rows' gradients times multipliers (n-2, 2)."""
        own = self._gradient(x) * (dual @ _SIGNS)[:, None]
        for k in range(3):
            gradient[k : len(x) - 2 + k] += own[:, k]

    def add_curvature(self, band: Floats, rhs: Floats, x: Floats, slack: Floats, dual: Floats, barrier: float, free: NDArray[np.bool_]) -> None:
        """Add what the rows put into the band (upper storage, two off-diagonals) and into the right-hand side."""
        root, change = self._parts(x)
        mask = np.column_stack([free[:-2], free[1:-1], free[2:]])
        gradient = self._gradient(x) * mask
        weight = dual / slack
        wanted = ((barrier / slack - dual + weight * (self.values(x) + slack)) @ _SIGNS)[:, None] * gradient
        total, count = np.sum(weight, axis=1), len(x) - 2
        for k in range(3):
            rhs[k : count + k] -= wanted[:, k]
            for far in range(k, 3):
                band[2 - (far - k), far : count + far] += total * gradient[:, k] * gradient[:, far]
        bend = (dual @ _SIGNS) * self._scale
        both = (bend * 0.5 / root)[:, None] * np.column_stack([self._before, self._after])
        both = both * (mask[:, [0, 2]] & mask[:, [1, 1]])
        band[1, 1 : count + 1] += both[:, 0]
        band[1, 2:] += both[:, 1]
        own = bend * (-(self._before + self._after) / root - 0.25 * change / root**3)
        band[2, 1 : count + 1] += own * free[1:-1]
