"""Traction drive M1: permanent-magnet motors with inverters, quasi-stationary in the dq frame.

Torque follows from the torque-forming current, `tau = 1.5 z_p psi_PM I_q`; only that current is commanded (no field weakening). Losses are the
integrand of (3.39), split by where they arise.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .vehicle import Vehicle


class MotorLosses(NamedTuple):
    """Losses of one motor with its inverter in W."""

    copper: Any
    iron: Any
    inverter: Any
    friction: Any


def copper_factor(vehicle: Vehicle) -> float:
    """b in `b tau^2`: copper loss per squared torque, W/Nm^2."""
    p = vehicle.drive
    return 2.0 * p.phase_resistance_ohm / (3.0 * p.pole_pairs**2 * p.magnet_flux_wb**2)


def inverter_factor(vehicle: Vehicle) -> float:
    """a in `a |tau|`: current-dependent inverter loss per torque, W/Nm."""
    p = vehicle.drive
    return 2.0 * p.inverter_per_current_wpa / (3.0 * p.pole_pairs * p.magnet_flux_wb)


def motor_losses(vehicle: Vehicle, torque: Any, speed: Any) -> MotorLosses:
    """Losses of one motor (3.39).

    Args:
        vehicle: the car.
        torque: shaft torque, Nm, negative when generating.
        speed: shaft speed, rad/s.
    """
    p = vehicle.drive
    turning = abs(speed)
    return MotorLosses(
        copper=copper_factor(vehicle) * torque**2,
        iron=p.hysteresis_nm * turning + p.eddy_nms * speed**2,
        inverter=p.inverter_constant_w + inverter_factor(vehicle) * abs(torque),
        friction=p.friction_nm * turning,
    )


def force_limits(vehicle: Vehicle, v: Any) -> tuple[Any, Any]:
    """Largest driving and largest recuperating force in N (both positive) at speed `v` (m/s, not negative)."""
    p = vehicle.drive
    gain = p.motor_count * vehicle.motor_ratio
    if isinstance(v, float):  # the same on plain numbers, ten times faster than through arrays
        turning = max(v, 1e-9) * vehicle.motor_ratio
        return gain * min(p.torque_max_nm, p.power_max_w / turning), gain * min(p.regen_torque_max_nm, p.regen_power_max_w / turning)
    speed = np.maximum(np.asarray(v, dtype=np.float64), 1e-9) * vehicle.motor_ratio
    drive = np.minimum(p.torque_max_nm, p.power_max_w / speed)
    regen = np.minimum(p.regen_torque_max_nm, p.regen_power_max_w / speed)
    return gain * drive, gain * regen
