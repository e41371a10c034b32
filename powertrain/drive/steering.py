"""Steering drive M2: what it takes to turn one wheel about its king pin, (3.40) and (3.41).

The motor turns the wheel through a gear of ratio i. About the king pin act the wheel's own inertia, the bore torque of the contact patch and the
tyre's forces on their trails; the gear loses a share of the load's power and a constant drag. Losses of the motor are those of (3.39).

Plain functions of NumPy operations: numbers, arrays and CasADi symbols all pass.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..description.sections import Steering
from .machine import machine_losses

#: Below this sliding speed in m/s the bore torque is smooth in the steering rate; it only rounds off the step at rest.
_REST = 1e-3


class Contact(NamedTuple):
    """What the road does to a steered wheel."""

    #: side and longitudinal force on the wheel in N, in the wheel's frame
    side: Any
    longitudinal: Any
    #: wheel load, N
    load: Any
    #: speed of the wheel over the ground, m/s
    speed: Any
    #: the tyre's own aligning moment, Nm, and friction coefficient
    aligning: Any = 0.0
    friction: Any = 1.0
    #: 1 for a wheel on the left, -1 on the right: longitudinal forces pull the two about their king pins in opposite directions
    left: float = 1.0


class SteeringPower(NamedTuple):
    """Where the power of one steering drive goes, W; `acceleration` and `aligning` may come back, the others are lost."""

    acceleration: Any
    aligning: Any
    bore: Any
    gear: Any
    copper: Any
    iron: Any
    inverter: Any
    friction: Any

    @property
    def total(self) -> Any:
        """Electrical power drawn, W."""
        return sum(self)


def bore_torque(steering: Steering, rate: Any, contact: Contact) -> Any:
    """Torque about the king pin in Nm that turns the contact patch on the spot; fades as the wheel rolls.

    A disc of radius r pressed with F_z resists turning with 2/3 mu F_z r. The share of that which works against turning is the turning speed of
    its rim over the whole sliding speed, rolling included.
    """
    rim = rate * steering.contact_radius_m
    return 2.0 / 3.0 * contact.friction * contact.load * steering.contact_radius_m * rim / np.sqrt(rim**2 + contact.speed**2 + _REST**2)


def aligning_torque(steering: Steering, contact: Contact) -> Any:
    """Torque about the king pin in Nm that the drive holds against the tyre's aligning moment and its forces on caster trail and scrub radius."""
    return contact.side * steering.caster_trail_m - contact.aligning + contact.left * contact.longitudinal * steering.scrub_radius_m


def steering_power(steering: Steering, rate: Any, acceleration: Any, contact: Contact) -> SteeringPower:
    """Power of one steering drive.

    Args:
        steering: the drive.
        rate: of the steering angle, rad/s, positive to the left.
        acceleration: of the steering angle, rad/s^2.
        contact: forces, load and speed of the wheel.
    """
    p, ratio = steering, steering.gear_ratio
    speed = ratio * rate
    bore, align = bore_torque(p, rate, contact), aligning_torque(p, contact)
    load = (p.wheel_yaw_inertia_kgm2 * acceleration + bore + align) / ratio
    gear = (1.0 - p.gear_efficiency) * np.fabs(load * speed) + p.gear_drag_nm * np.fabs(speed)
    # the gear's loss seen as a torque, without dividing by a speed that may be zero
    loss_torque = ((1.0 - p.gear_efficiency) * np.fabs(load) + p.gear_drag_nm) * np.sign(speed)
    torque = load + p.motor_inertia_kgm2 * ratio * acceleration + loss_torque
    return SteeringPower(
        acceleration=(p.wheel_yaw_inertia_kgm2 / ratio + p.motor_inertia_kgm2 * ratio) * acceleration * speed,
        aligning=align * rate,
        bore=bore * rate,
        gear=gear,
        **machine_losses(p, torque, speed)._asdict(),
    )
