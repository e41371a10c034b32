"""What goes into the energy manager and what comes out of it: plain numbers."""

from __future__ import annotations

import math
from typing import NamedTuple

from ..motion import VehicleState


class Measurements(NamedTuple):
    """What is measured in one control period.

    Attributes:
        t: when this was put together, s.
        x, y, psi: place of the centre of gravity (m) and heading (rad).
        v_x, v_y, yaw_rate: velocities in the car's axes, m/s and rad/s.
        a_x, a_y: accelerations along the car's axes without gravity, m/s^2.
        wheel_speeds: of the four wheels, rad/s.
        torques: that the motors report, Nm; empty where they do not: dead motors are then not noticed.
        angles: of the steered wheels, rad; empty where they are not measured: stuck steering is then not noticed.
        soc: state of charge of the battery, 0 to 1.
        power_min, power_max: what the battery can take (negative) and give, W.
        brakes: share of its torque that each friction brake reports to have; empty for all of it.
        friction: of the road, relative to the one that the tyres were described for; 1 where nobody knows better.
        pose_time: when place and heading were true, s; None for `t`.
    """

    t: float
    x: float
    y: float
    psi: float
    v_x: float
    v_y: float
    yaw_rate: float
    a_x: float = 0.0
    a_y: float = 0.0
    wheel_speeds: tuple[float, ...] = ()
    torques: tuple[float, ...] = ()
    angles: tuple[float, ...] = ()
    soc: float = 0.5
    power_min: float = -math.inf
    power_max: float = math.inf
    brakes: tuple[float, ...] = ()
    friction: float = 1.0
    pose_time: float | None = None

    @property
    def motion(self) -> VehicleState:
        """How the car moves, as it is measured."""
        return VehicleState(self.x, self.y, self.psi, self.v_x, self.v_y, self.yaw_rate, self.a_x, self.a_y, self.friction)


class WheelCommands(NamedTuple):
    """What the actuators shall do in the coming period.

    Attributes:
        torques: of the motors, Nm.
        brakes: clamped friction torque of the wheels front left, front right, rear left, rear right, Nm.
        angles: of the steered wheels, rad.
        status: of the allocation (`solved`, `limited`, `held`), or `rejected` (a bad measurement: the last safe command), `stopping` (no good
            measurement for too long: braking blindly) or `arrived` (standing at the end of the road).
        reason: what was wrong with the measurement, or which actuators are at fault; empty if nothing is.
        s: station on the trajectory, m.
    """

    torques: tuple[float, ...]
    brakes: tuple[float, ...]
    angles: tuple[float, ...]
    status: str
    reason: str
    s: float

    @property
    def inputs(self) -> list[float]:
        """In the order of the plant's inputs, without grade, bank and friction."""
        return [*self.torques, *self.brakes, *self.angles]
