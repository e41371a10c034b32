"""Quasi-stationary temperatures: one node that heats by its losses and cools towards the surroundings (M1, M8).

C dT/dt = heat - (T - T_ambient) / R
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..description.sections import Thermal
from ..errors import VehicleError
from ..vehicle import Vehicle
from .motor import motor_losses


def temperature_rate(node: Thermal, temperature: Any, heat: Any, ambient: Any) -> Any:
    """dT/dt of the node in K/s, for `heat` in W and temperatures in K."""
    return (heat - (temperature - ambient) / node.resistance_kpw) / node.heat_capacity_jpk


def temperature_after(node: Thermal, temperature: Any, heat: Any, ambient: Any, duration: Any) -> Any:
    """The node's temperature in K after `duration` (s) of constant `heat` (W): the exact solution."""
    settled = ambient + heat * node.resistance_kpw
    return settled + (temperature - settled) * np.exp(-duration / (node.resistance_kpw * node.heat_capacity_jpk))


def motor_heat(vehicle: Vehicle, torque: Any, speed: Any, temperature: Any) -> Any:
    """What heats the motor at `torque` (Nm), `speed` (rad/s) and winding `temperature` (K): copper and iron losses, W."""
    losses = motor_losses(vehicle, torque, speed, temperature)
    return losses.copper + losses.iron


def settled_temperature(vehicle: Vehicle, torque: float, speed: float, ambient: float) -> float:
    """The winding temperature in K at which heat and cooling balance; infinite where resistance rises faster than the cooling.

    Heat is linear in the temperature, so the balance is solved in closed form.

    Raises:
        VehicleError: the car has no `drive.thermal`, or a number that is not finite.
    """
    node = _thermal(vehicle)
    if not np.all(np.isfinite([torque, speed, ambient])):
        raise VehicleError(f"{vehicle.name}: torque {torque}, speed {speed}, ambient {ambient}, expected finite numbers")
    cold = motor_heat(vehicle, torque, speed, ambient)
    rise = motor_heat(vehicle, torque, speed, ambient + 1.0) - cold
    left = 1.0 - node.resistance_kpw * rise
    return float(ambient + node.resistance_kpw * cold / left) if left > 0.0 else float("inf")


def continuous_torque(vehicle: Vehicle, speed: float, ambient: float = 298.15) -> float:
    """The largest torque in Nm that can be held for ever at `speed` (rad/s) without passing `drive.thermal.max_k`; zero if none.

    Raises:
        VehicleError: the car has no `drive.thermal`.
    """
    node = _thermal(vehicle)
    room = (node.max_k - ambient) / node.resistance_kpw
    most = float(vehicle.drive.torque_max_nm)
    if motor_heat(vehicle, most, speed, node.max_k) <= room:
        return most
    low, high = 0.0, most
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if motor_heat(vehicle, middle, speed, node.max_k) <= room else (low, middle)
    return low


def _thermal(vehicle: Vehicle) -> Thermal:
    if vehicle.drive.thermal is None:
        raise VehicleError(f"{vehicle.name}: motor temperatures need the section [drive.thermal], which the description has not")
    return vehicle.drive.thermal
