"""Integral action without overshoot: what the car does beyond what was asked of it, estimated from its velocities.

For each of v_x, v_y and yaw rate the model is v' = u(t - lag) + coupling + d with d slow. While the model holds d stays zero, whatever the path
error, so that large offsets wind nothing up; a wrong mass, a slope off the map or a wrong cornering stiffness end in d and are compensated.
`corrected` tells it what the allocator reached, which is all the anti-windup that is needed. (Disturbance observer: Ohnishi; Chen et al., IEEE
Trans. Industrial Electronics 63-2, 2016.)
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..motion import VehicleState

_Three = tuple[float, float, float]


class Disturbance:
    """Accelerations (m/s^2, m/s^2, rad/s^2) that act beside the demanded ones.

    Args:
        gain: 1/s, bandwidth of the estimate; 0 switches it off.
        lags: s, from demand to force, for the three.
        limits: largest estimates, m/s^2, m/s^2, rad/s^2.
        slowest: m/s; below this speed the estimate fades, since stiction and brakes are no disturbance to fight.
    """

    def __init__(self, gain: float, lags: _Three, limits: _Three, slowest: float = 1.0) -> None:
        self._gain, self._lags, self._limits, self._slowest = gain, lags, limits, slowest
        self.reset()

    def reset(self) -> None:
        """Nothing is known."""
        self._last: tuple[_Three, _Three] | None = None
        self._asked: _Three = (0.0, 0.0, 0.0)
        self._acting: _Three = (0.0, 0.0, 0.0)
        self.estimate: _Three = (0.0, 0.0, 0.0)

    def snapshot(self) -> tuple[Any, ...]:
        """All of its state."""
        return self._last, self._asked, self._acting, self.estimate

    def restore(self, snapshot: tuple[Any, ...]) -> None:
        """Go back to a `snapshot`."""
        self._last, self._asked, self._acting, self.estimate = snapshot

    def update(self, state: VehicleState, dt: float) -> _Three:
        """The estimate from the velocities of `state`, `dt` seconds after the last ones."""
        now = (state.v_x, state.v_y, state.yaw_rate)
        coupling = (state.yaw_rate * state.v_y, -state.yaw_rate * state.v_x, 0.0)
        if self._gain > 0.0 and self._last is not None and dt > 0.0:
            before, turned = self._last
            moving = math.hypot(state.v_x, state.v_y) > self._slowest
            share, fade = min(self._gain, 1.0 / dt), max(1.0 - dt, 0.0)
            acting, estimate = [], []
            was, asked, lags, known, limits = self._acting, self._asked, self._lags, self.estimate, self._limits
            for k in (0, 1, 2):
                most = limits[k]
                force = was[k] + (asked[k] - was[k]) * dt / (lags[k] + dt)
                # what the velocity gained beyond what was expected: dt times an acceleration
                surprise = now[k] - before[k] - dt * (force + turned[k] + known[k])
                value = known[k] + share * surprise if moving else known[k] * fade
                acting.append(force)
                estimate.append(most if value > most else -most if value < -most else value)
            self._acting, self.estimate = (acting[0], acting[1], acting[2]), (estimate[0], estimate[1], estimate[2])
        self._last = now, coupling
        return self.estimate

    def asked(self, a_x: float, a_y: float, yaw: float) -> None:
        """What the car was told to do, without driving resistances: accelerations of its centre of gravity and of yaw."""
        self._asked = (a_x, a_y, yaw)

    def corrected(self, a_x: float, a_y: float, yaw: float) -> None:
        """By how much what was given differs from what was asked."""
        x, y, r = self._asked
        self._asked = (x + a_x, y + a_y, r + yaw)
