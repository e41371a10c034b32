"""The speed that a tracking law is given: that of the trajectory, averaged over a short way.

Acceleration is constant between a trajectory's stations and steps at them. Torques that follow such steps jitter for nothing. Here the kinetic energy
E = v^2/2, linear between stations, is averaged over a window of w metres, so that

    v^2 = (I(s + w/2) - I(s - w/2)) 2 / w,     a = (E(s + w/2) - E(s - w/2)) / w,     I the integral of E,

belong together exactly (v dv/ds = a), and `a` is continuous. Work and energy between places that are driven evenly stay what they are. The window
closes towards stops and the ends of an open path, where starting and stopping are as planned.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ..trajectory.trajectory import Trajectory

#: Time over which is averaged (s), and least and largest length of the window, m.
_TIME, _SHORT, _LONG = 0.2, 1.0, 6.0
#: A station slower than this is a stop, m/s.
_STANDING = 0.05


class SmoothSpeed:
    """Speed and acceleration of one trajectory, averaged."""

    def __init__(self, trajectory: Trajectory) -> None:
        """Tables of E and its integral."""
        energy = 0.5 * trajectory.v**2
        step = np.diff(trajectory.s)
        integral = np.concatenate([[0.0], np.cumsum(0.5 * (energy[1:] + energy[:-1]) * step)])
        slope = np.append(np.diff(energy) / step, 0.0)
        self._s = trajectory.s.tolist()
        #: of every interval: its start, E and dE/ds and I there; the last one is the last station itself
        self._rows = list(zip(self._s, energy.tolist(), slope.tolist(), integral.tolist(), strict=True))
        self._first, self._last, self._closed = self._s[0], self._s[-1], trajectory.closed
        self._length, self._whole = self._last - self._first, float(integral[-1])
        stops = trajectory.s[trajectory.v < _STANDING].tolist()
        fixed = stops if self._closed else sorted({self._first, self._last, *stops})
        #: where the window closes, between two places that are never reached
        self._fixed = [-math.inf, *fixed, math.inf] if fixed else []

    def at(self, s: float, v: float, a: float) -> tuple[float, float]:
        """Averaged speed (m/s) and acceleration (m/s^2) at station `s` (m), where the trajectory has `v` and `a`."""
        half = 0.5 * min(max(_TIME * v, _SHORT), _LONG)
        fixed = self._fixed
        if fixed:
            place = s if not self._closed else self._first + (s - self._first) % self._length
            k = bisect_right(fixed, place)
            half = min(half, place - fixed[k - 1], fixed[k] - place)
        if half < 1e-3:
            return v, a
        energy, integral = self._of(s - half)
        more, beyond = self._of(s + half)
        return math.sqrt(max((beyond - integral) / half, 0.0)), (more - energy) / (2.0 * half)

    def _of(self, s: float) -> tuple[float, float]:
        """E and I at `s`."""
        laps = 0.0
        if self._closed and not self._first <= s <= self._last:
            laps = math.floor((s - self._first) / self._length)
            s -= laps * self._length
        start, energy, slope, integral = self._rows[bisect_right(self._s, s, 1) - 1]
        d = s - start
        rise = slope * d
        return energy + rise, integral + (energy + 0.5 * rise) * d + laps * self._whole
