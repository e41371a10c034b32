"""What a car can do, in closed form or by one quadrature: top speed, acceleration, climbing, handling.

Quasi-static, on its motors' limits and driving resistances; friction is taken to suffice, and torque to be there at once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..description.sections import Body
from ..drive.machine import torque_limits
from ..errors import VehicleError
from ..vehicle import GRAVITY, Vehicle
from .motor import force_limits, motor_losses
from .resistance import driving_resistance

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

#: No car here is faster, m/s.
_FASTEST = 150.0


def spare_force(vehicle: Vehicle, v: Floats | float, slope: float = 0.0) -> Floats:
    """Driving force beyond the resistances at speed `v` (m/s) on slope dz/ds, N."""
    drive, _ = force_limits(vehicle, np.asarray(v, dtype=np.float64))
    return np.asarray(drive - driving_resistance(vehicle, np.asarray(v, dtype=np.float64), slope))


def top_speed(vehicle: Vehicle, slope: float = 0.0) -> float:
    """The speed in m/s that the car can hold on slope dz/ds: what its motors give, at most its own limit; zero if it cannot climb."""
    speeds = np.linspace(0.0, min(vehicle.limits.speed_max_mps, _FASTEST), 4001)
    spare = spare_force(vehicle, speeds, slope)
    if np.all(spare >= 0.0):
        return float(speeds[-1])
    k = int(np.argmax(spare < 0.0))
    if k == 0:
        return 0.0
    return float(speeds[k - 1] + (speeds[k] - speeds[k - 1]) * spare[k - 1] / (spare[k - 1] - spare[k]))


def acceleration_time(vehicle: Vehicle, speed: float, start: float = 0.0, slope: float = 0.0) -> float:
    """Shortest time in s from `start` to `speed` (m/s) on slope dz/ds; infinite where the car does not get there.

    Raises:
        VehicleError: speeds that are not finite, negative or out of order.
    """
    if not (np.isfinite(speed) and np.isfinite(start) and 0.0 <= start <= speed):
        raise VehicleError(f"acceleration from {start} to {speed} m/s, expected finite speeds, not negative and in order")
    v = np.linspace(start, speed, 2001)
    spare = spare_force(vehicle, v, slope)
    if np.any(spare <= 0.0) or speed > vehicle.limits.speed_max_mps * (1.0 + 1e-12):
        return float("inf")
    inverse = vehicle.effective_mass / spare
    return float(np.sum(0.5 * (inverse[1:] + inverse[:-1]) * np.diff(v)))


class BestPoint(NamedTuple):
    """Where motor, inverter and gear lose least of what passes: share, Nm, rad/s."""

    efficiency: float
    torque: float
    speed: float


def best_point(vehicle: Vehicle) -> BestPoint:
    """The most efficient driving point of a motor within its limits, on a grid of 200 by 200."""
    speeds = np.linspace(0.01, 1.0, 200) * vehicle.limits.speed_max_mps * vehicle.motor_ratio
    torque = np.linspace(0.01, 1.0, 200)[:, None] * torque_limits(vehicle.drive, speeds)[0]
    efficiency = torque * speeds / (torque * speeds + sum(motor_losses(vehicle, torque, speeds)))
    row, column = np.unravel_index(int(np.argmax(efficiency)), efficiency.shape)
    return BestPoint(float(efficiency[row, column]), float(torque[row, column]), float(speeds[column]))


def steepest_slope(vehicle: Vehicle, v: float = 0.0) -> float:
    """The slope dz/ds that the motors climb at speed `v` (m/s)."""
    return float(spare_force(vehicle, v)) / (vehicle.chassis.mass_kg * GRAVITY)


def axle_stiffness(vehicle: Vehicle) -> tuple[float, float]:
    """Cornering stiffness of the front and the rear axle under static load, N/rad.

    Raises:
        VehicleError: the description lacks body or tyre.
    """
    body, weight = vehicle.need("body", Body), vehicle.chassis.mass_kg * GRAVITY
    front, rear = vehicle.tyres()
    share = body.rear_axle_m / body.wheelbase_m
    return 2.0 * float(front.cornering_stiffness(0.5 * weight * share)), 2.0 * float(rear.cornering_stiffness(0.5 * weight * (1.0 - share)))


def understeer_gradient(vehicle: Vehicle) -> float:
    """m / L (l_r / C_f - l_f / C_r): steering angle per lateral acceleration beyond the geometric one, rad s^2/m; negative oversteers.

    Raises:
        VehicleError: the description lacks body or tyre.
    """
    body = vehicle.need("body", Body)
    front, rear = axle_stiffness(vehicle)
    return vehicle.chassis.mass_kg / body.wheelbase_m * (body.rear_axle_m / front - body.front_axle_m / rear)


def characteristic_speed(vehicle: Vehicle) -> float:
    """sqrt(L / K): where an understeering car turns most per steering angle, m/s; for an oversteering one minus its critical speed.

    Raises:
        VehicleError: the description lacks body or tyre.
    """
    gradient = understeer_gradient(vehicle)
    if gradient == 0.0:
        return float("inf")
    return float(np.sign(gradient) * np.sqrt(vehicle.need("body", Body).wheelbase_m / abs(gradient)))
