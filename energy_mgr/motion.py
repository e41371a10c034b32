"""The nouns between observers, following, allocation and plant: plain named tuples of floats, cheap enough for every control period."""

from __future__ import annotations

from typing import NamedTuple


class VehicleState(NamedTuple):
    """How the car moves; its centre of gravity in the plane, velocities in the car's axes.

    Attributes:
        x, y: place, m.
        psi: heading, rad; need not be unwrapped.
        v_x, v_y: velocity ahead and to the left, m/s.
        yaw_rate: rad/s.
        a_x, a_y: acceleration of the centre of gravity in the plane along the car's axes, m/s^2 (what the forces give, not d v_x/dt).
        friction: of the road, relative to the one that the tyres were described for.
    """

    x: float
    y: float
    psi: float
    v_x: float
    v_y: float
    yaw_rate: float
    a_x: float = 0.0
    a_y: float = 0.0
    friction: float = 1.0


class MotionDemand(NamedTuple):
    """What the wheels together shall give the car: force over mass along its axes and yaw moment over yaw inertia.

    Driving resistances and slopes are part of the demand, since the wheels have to overcome them; `a_x` is the acceleration that a level road
    without air would show, rolling resistance and the turning of wheels included.

    Attributes:
        a_x, a_y: m/s^2, ahead and to the left.
        yaw_acceleration: rad/s^2, to the left.
    """

    a_x: float
    a_y: float
    yaw_acceleration: float
