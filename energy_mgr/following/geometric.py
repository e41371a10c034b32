"""Geometric path following with four steered wheels: side-slip angle and curvature of motion instead of forces.

A car that steers both axles chooses the direction in which it moves (course = heading + side slip beta) and the curvature of its turning apart
from each other. The course is set so that the offset decays exponentially, d e_y/dt = V sin(course error) = -rate e_y; the turning, so that the
heading error does. Both become accelerations by first-order tracking of v_y = V sin beta and r = V kappa_icr. No model of mass or tyres, no
integral action; limits are those of the geometry (largest course angle, largest curvature).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .law import Course, Resistances, limited, scheduled, speed_demand

if TYPE_CHECKING:
    from powertrain import Vehicle

    from ..motion import MotionDemand, VehicleState
    from .projected import Projected


@dataclass(frozen=True)
class GeometricGains:
    """Of `GeometricLaw`.

    Attributes:
        offset: decay of the offset, 1/s.
        heading: decay of the heading error, 1/s.
        length: below this speed times 1/offset it decays per way: metres for a factor e.
        tracking: time constant in which side slip and yaw rate follow, s.
        course_max: largest angle between course and path while approaching, rad.
        beta_ref: side-slip angle to drive with, rad: the car's nose points to the right of its course by it.
        curvature_max: of turning, 1/m.
        speed, correction: as in `speed_demand`, 1/s and m/s^2.
    """

    offset: float = 1.0
    heading: float = 2.0
    length: float = 4.0
    tracking: float = 0.2
    course_max: float = 0.3
    beta_ref: float = 0.0
    curvature_max: float = 0.4
    speed: float = 1.5
    correction: float = 2.0


class GeometricLaw:
    """Side slip and curvature of motion; has no state beyond `supervised`."""

    def __init__(self, vehicle: Vehicle, gains: GeometricGains | None = None) -> None:
        self.gains = gains or GeometricGains()
        self.supervised = False
        self._resistances = Resistances(vehicle)

    def steering(self, state: VehicleState, at: Projected) -> tuple[float, float]:
        """The controls of the law: side-slip angle, rad, and curvature of the turning about the instantaneous centre, 1/m."""
        g, c = self.gains, Course.of(state, at)
        speed = math.hypot(state.v_x, state.v_y)
        rate = scheduled(g.offset, speed, g.length)
        lean = rate * at.e_y / max(speed, 1e-3)
        course = -math.asin(limited(lean, math.sin(g.course_max)))
        self.supervised = abs(lean) > math.sin(g.course_max)
        turning = c.kappa * c.sdot - scheduled(g.heading, speed, g.length / 2.0) * (at.e_psi + g.beta_ref)
        curvature = limited(turning / max(speed, 1e-3), g.curvature_max)
        return limited(course - at.e_psi, 0.5 * math.pi), curvature

    def demand(self, state: VehicleState, at: Projected, dt: float) -> MotionDemand:
        """As `TrackingLaw`."""
        g, c = self.gains, Course.of(state, at)
        beta, curvature = self.steering(state, at)
        speed = math.hypot(state.v_x, state.v_y)
        ahead = speed_demand(at, state.v_x, g.speed, g.correction)
        yaw = c.yaw_feed(at.e_y, ahead) + (speed * curvature - state.yaw_rate) / g.tracking
        # accelerations of the centre of gravity: d v_x/dt = a_x + r v_y, d v_y/dt = a_y - r v_x
        a_x = ahead - state.yaw_rate * state.v_y
        a_y = (speed * math.sin(beta) - state.v_y) / g.tracking + state.yaw_rate * state.v_x
        return self._resistances.demand(a_x, a_y, yaw, state, at)

    def achieved(self, demand: MotionDemand, given: MotionDemand) -> None:
        """Nothing to do: there is no integral action."""

    def adapt(self, lean: float, pace: float) -> None:
        """As `TrackingLaw`: this law knows no faults."""

    def reset(self) -> None:
        """Nothing limits."""
        self.supervised = False

    def snapshot(self) -> tuple[Any, ...]:
        """Whether a limit held."""
        return (self.supervised,)

    def restore(self, snapshot: tuple[Any, ...]) -> None:
        """Go back to a `snapshot`."""
        (self.supervised,) = snapshot
