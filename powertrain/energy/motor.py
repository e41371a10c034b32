"""Traction drive M1 of a car: its motors with inverters and gears (`machine`), their losses, and the forces that they give.

A field-weakening current adds its copper loss. Plain functions of NumPy operations: numbers, arrays and CasADi symbols all pass.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..drive.machine import copper_per_torque, inverter_per_torque, machine_losses, torque_limits, weakening_current
from ..errors import VehicleError
from ..vehicle import Vehicle


class MotorLosses(NamedTuple):
    """Losses of one motor with its inverter and gear in W."""

    copper: Any
    iron: Any
    inverter: Any
    friction: Any
    gear: Any


def copper_factor(vehicle: Vehicle) -> float:
    """b in `b tau^2` of the traction motors, W/Nm^2."""
    return copper_per_torque(vehicle.drive)


def inverter_factor(vehicle: Vehicle) -> float:
    """a in `a |tau|` of the traction motors, W/Nm."""
    return inverter_per_torque(vehicle.drive)


def gear_factor(vehicle: Vehicle) -> float:
    """Gear loss over the power that passes, without unit."""
    return 1.0 - vehicle.drive.gear_efficiency


def motor_losses(vehicle: Vehicle, torque: Any, speed: Any, temperature: Any = None) -> MotorLosses:
    """Losses of one motor (3.39).

    Args:
        vehicle: the car.
        torque: shaft torque, Nm, negative when generating.
        speed: shaft speed, rad/s.
        temperature: of the winding, K; None for the warm resistance. Needs `drive.thermal`.

    Raises:
        VehicleError: a temperature for a car without `drive.thermal`.
    """
    p = vehicle.drive
    plain = machine_losses(p, torque, speed)
    copper = plain.copper
    if p.weakening is not None:
        copper = copper + 1.5 * p.phase_resistance_ohm * weakening_current(p, torque, speed) ** 2
    if temperature is not None:
        copper = copper * resistance_rise(vehicle, temperature)
    return MotorLosses(
        copper=copper,
        iron=plain.iron,
        inverter=plain.inverter,
        friction=plain.friction,
        gear=gear_factor(vehicle) * abs(torque * speed),
    )


def resistance_rise(vehicle: Vehicle, temperature: Any) -> Any:
    """Winding resistance at `temperature` (K) over the one that the car gives.

    Raises:
        VehicleError: the car has no `drive.thermal`.
    """
    node = vehicle.drive.thermal
    if node is None:
        raise VehicleError(f"{vehicle.name}: a winding temperature needs the section [drive.thermal], which the description has not")
    return 1.0 + node.copper_per_k * (temperature - node.reference_k)


def force_limits(vehicle: Vehicle, v: Any) -> tuple[Any, Any]:
    """Largest driving and largest recuperating force in N (both positive) at speed `v` (m/s, not negative)."""
    p = vehicle.drive
    gain = p.motor_count * vehicle.motor_ratio
    if isinstance(v, float):  # the same on plain numbers, ten times faster than through arrays
        turning = max(v, 1e-9) * vehicle.motor_ratio
        return gain * min(p.torque_max_nm, p.power_max_w / turning), gain * min(p.regen_torque_max_nm, p.regen_power_max_w / turning)
    drive, regen = torque_limits(p, np.maximum(np.asarray(v, dtype=np.float64), 0.0) * vehicle.motor_ratio)
    return gain * drive, gain * regen
