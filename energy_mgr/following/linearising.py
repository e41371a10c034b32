"""Input-output linearisation in path coordinates with demand supervision: the default tracking law (F3).

Outputs are offset e_y, heading error e_psi and the speed u along the path's tangent. With A_t, A_n the acceleration of the centre of gravity along
tangent and normal, the motion in path coordinates is exactly

    d e_y/dt   = w                            d w/dt = A_n - kappa sdot u              sdot = u / (1 - kappa e_y)
    d e_psi/dt = r - kappa sdot               d u/dt = A_t + kappa sdot w

so that demands chosen for the right-hand sides are two rotations away from the car's axes, for any heading error. Offset and heading get two real
poles each, which fade with speed over length; far from the path they approach it at a limited speed from which a limited acceleration can still
stop (a square-root law), hence without overshoot. What the tyres can give goes to the path's own curvature first, corrections take what is left.
Integral action is that of `Disturbance`: it needs the velocities to be right; a bias of the measured course stays as a small offset.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .disturbance import Disturbance
from .law import Course, Resistances, limited, scheduled, speed_demand

if TYPE_CHECKING:
    from powertrain import Vehicle

    from ..motion import MotionDemand, VehicleState
    from .projected import Projected


@dataclass(frozen=True)
class LinearisingGains:
    """Of `LinearisingLaw`; tuned with 40 ms lag of the lateral and 10 ms of the longitudinal force.

    Attributes:
        offset: slow and fast pole of the offset, 1/s.
        heading: slow and fast pole of the heading error, 1/s.
        length: the slow pole of the offset is at most speed over this (m), that of the heading twice as much; the fast ones keep their ratio.
        speed: pole of the speed error, 1/s.
        approach: lateral acceleration, m/s^2, and yaw acceleration, rad/s^2, with which an approach is braked.
        approach_angle: largest angle between motion and path while approaching, rad.
        correction: largest corrections, m/s^2 ahead, m/s^2 aside, rad/s^2.
        grip: horizontal acceleration that the tyres give on a road of friction 1, m/s^2.
        yaw_max: largest yaw acceleration at friction 1, rad/s^2.
        integral: bandwidth of the disturbance estimate, 1/s; 0 switches it off.
        lags: that the estimate counts with from demand to force, s, for a_x, a_y and yaw.
    """

    offset: tuple[float, float] = (1.6, 3.2)
    heading: tuple[float, float] = (3.0, 4.5)
    length: float = 4.0
    speed: float = 1.5
    approach: tuple[float, float] = (1.5, 1.2)
    approach_angle: float = 0.35
    correction: tuple[float, float, float] = (2.0, 2.5, 2.5)
    grip: float = 8.0
    yaw_max: float = 6.0
    integral: float = 0.8
    lags: tuple[float, float, float] = (0.01, 0.04, 0.04)


class LinearisingLaw:
    """Keeps the disturbance estimate; see the module."""

    def __init__(self, vehicle: Vehicle, gains: LinearisingGains | None = None) -> None:
        self.gains = gains or LinearisingGains()
        self._resistances = Resistances(vehicle)
        self._disturbance = Disturbance(self.gains.integral, self.gains.lags, (1.0, 1.5, 1.0))
        self._lean, self._pace = 0.0, 1.0
        self.reset()

    def adapt(self, lean: float, pace: float) -> None:
        """As `TrackingLaw`."""
        self._lean, self._pace = lean, pace

    def demand(self, state: VehicleState, at: Projected, dt: float) -> MotionDemand:
        """As `TrackingLaw`."""
        c = Course.of(state, at)
        d_x, d_y, d_yaw = self._disturbance.update(state, dt)
        a_t, a_n, held = self._plane(state, at, c)
        yaw, turned = self._yaw(state, at, c, a_t)
        self.supervised = held or turned or at.how == "outside"
        # below walking pace the estimate counts in part: a standing car asks for nothing aside
        fade = min(math.hypot(state.v_x, state.v_y), 1.0)
        a_x = a_t * c.cos + a_n * c.sin - fade * d_x
        a_y = a_n * c.cos - a_t * c.sin - fade * d_y
        yaw -= fade * d_yaw
        self._disturbance.asked(a_x, a_y, yaw)
        return self._resistances.demand(a_x, a_y, yaw, state, at)

    def _plane(self, state: VehicleState, at: Projected, c: Course) -> tuple[float, float, bool]:
        """Acceleration along tangent and normal of the path, and whether a limit held."""
        g = self.gains
        grip = g.grip * max(state.friction, 0.05)
        bend = c.kappa * c.sdot * c.ahead
        speed = math.hypot(c.ahead, c.aside)
        slow, fast = _poles(g.offset, speed, g.length)
        wanted, far = approach(at.e_y, c.aside, slow, fast, g.approach[0], speed * math.sin(g.approach_angle))
        a_n = limited(bend + limited(wanted, g.correction[1]), grip)
        a_t = self._speed(state, at, c) - c.kappa * c.sdot * c.aside
        # a car that is too fast for the bend must still be able to brake
        room = max(math.sqrt(max(grip**2 - a_n**2, 0.0)), 0.3 * grip)
        held_t = limited(a_t, room)
        a_n = limited(a_n, math.sqrt(max(grip**2 - held_t**2, 0.0)))
        return held_t, a_n, far or abs(a_n - bend - wanted) > 1e-9 or held_t != a_t

    def _speed(self, state: VehicleState, at: Projected, c: Course) -> float:
        g = self.gains
        if c.cos >= 0.5:
            if self._pace != 1.0:
                v, a = at.speed
                at = at._replace(v=self._pace * v, a=self._pace**2 * a)
            return speed_demand(at, c.ahead, g.speed, g.correction[0])
        # more than 60 degrees off: speed along the path says little, turn slowly first; this is asked along the car, not along the path
        slowly = at._replace(v=min(at.point.v, 3.0), a=0.0)
        return c.cos * speed_demand(slowly, state.v_x, g.speed, g.correction[0])

    def _yaw(self, state: VehicleState, at: Projected, c: Course, a_t: float) -> tuple[float, bool]:
        """Yaw acceleration, and whether a limit held."""
        g = self.gains
        most, speed = g.yaw_max * max(state.friction, 0.05), math.hypot(c.ahead, c.aside)
        slow, fast = _poles(g.heading, speed, 0.5 * g.length)
        rate = state.yaw_rate - c.kappa * c.sdot
        wanted, far = approach(math.remainder(at.e_psi + self._lean, math.tau), rate, slow, fast, g.approach[1], min(1.0, speed))
        feed = c.yaw_feed(at.e_y, a_t + c.kappa * c.sdot * c.aside)
        yaw = limited(limited(feed, most) + limited(wanted, g.correction[2]), most)
        return yaw, far or abs(yaw - feed - wanted) > 1e-9

    def achieved(self, demand: MotionDemand, given: MotionDemand) -> None:
        """As `TrackingLaw`: the estimate counts with what was given."""
        self._disturbance.corrected(given.a_x - demand.a_x, given.a_y - demand.a_y, given.yaw_acceleration - demand.yaw_acceleration)

    def reset(self) -> None:
        """Forget the disturbances."""
        self.supervised = False
        self._disturbance.reset()

    def snapshot(self) -> tuple[Any, ...]:
        """The disturbance estimate, what was adapted, and whether a limit held."""
        return self.supervised, self._lean, self._pace, self._disturbance.snapshot()

    def restore(self, snapshot: tuple[Any, ...]) -> None:
        """Go back to a `snapshot`."""
        self.supervised, self._lean, self._pace, disturbance = snapshot
        self._disturbance.restore(disturbance)


def _poles(fastest: tuple[float, float], speed: float, length: float) -> tuple[float, float]:
    """Slow and fast pole, 1/s, in the same ratio at all speeds; `length` (m) is that of the slow one."""
    slow, fast = fastest
    return scheduled(slow, speed, length), scheduled(fast, speed, length * slow / fast)


def approach(error: float, rate: float, slow: float, fast: float, braking: float, fastest: float) -> tuple[float, bool]:
    """Second derivative for an error that changes by `rate`, and whether it is so far off that the linear law does not hold.

    Near zero the poles are `slow` and `fast` (1/s): e'' = -(slow + fast) e' - slow fast e. Beyond `braking`/slow^2 the wanted rate grows with the
    square root of the error, so that decelerating it never takes more than `braking`, and it ends at `fastest`.
    """
    size, slow = abs(error), max(slow, 1e-6)
    linear = braking / slow**2
    far = size > linear
    target, slope = slow * size, slow
    if far:
        target = math.sqrt(2.0 * braking * (size - 0.5 * linear))
        slope = braking / target
    if target > fastest:
        target, slope, far = fastest, 0.0, True
    return -fast * (rate + math.copysign(target, error)) - slope * rate, far
