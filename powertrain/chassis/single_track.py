"""Extended single-track model (ESTM, O1): side slip, speed, yaw and position of a car whose axles are one wheel each, (C.1) to (C.6).

Corrected against the source as its errata say: the smooth lower bound of the speed is (v + sqrt(v^2 + 4 v_min^2)) / 2, and the slip angles divide by
v cos(beta). (C.5) and (C.6), which are lost, are taken as quasi-static wheels: torque over radius less rolling resistance.

Through standstill, forwards. Rolling resistance holds the car where the drive does not overcome it: it takes the value that brings the car to rest
within `_STOP`, but not more than it has. Torque against the motion brakes the car to rest and holds it there; the model does not drive backwards.
Side forces, side slip and yaw rate, which the tyre equations do not determine at rest, fade out below `v_min`. Up to about 1 m/s the lower bound of
the speed makes slip angles of turned wheels too large, as it does in the source: with both axles turned far, the model may not drive off.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..description.sections import Body
from ..energy.resistance import drag_force, rolling_coefficient
from ..vehicle import GRAVITY, Vehicle

if TYPE_CHECKING:
    from collections.abc import Sequence

#: Time constant in s in which rolling resistance stops the car, and in which side slip and yaw rate fade at rest.
_STOP = 0.1


class SingleTrack:
    """The ESTM of one car.

    States: side slip angle, speed, yaw rate, yaw, position. Inputs: torques at the wheels in Nm, steering angles of the axles in rad.
    """

    states: tuple[str, ...] = ("beta", "v", "yaw_rate", "psi", "x", "y")
    inputs: tuple[str, ...] = ("torque_fl", "torque_fr", "torque_rl", "torque_rr", "delta_f", "delta_r")
    #: What the observer measures, as names of states.
    outputs: tuple[str, ...] = ("yaw_rate", "x", "y")

    def __init__(self, vehicle: Vehicle, *, v_min: float = 0.4) -> None:
        """The model of `vehicle`; slip angles are those of at least `v_min` (m/s).

        Raises:
            VehicleError: the description lacks body or tyre.
        """
        self.vehicle, self.v_min = vehicle, v_min
        self.body = vehicle.need("body", Body)
        self.tyres = vehicle.tyres()

    def derivative(self, x: Sequence[Any], u: Sequence[Any]) -> list[Any]:
        """d x/dt for states and inputs in their order: numbers, arrays or CasADi symbols."""
        beta, v, yaw_rate, psi, _, _ = x
        b, mass, radius = self.body, self.vehicle.chassis.mass_kg, self.vehicle.chassis.wheel_radius_m
        moving = 0.5 * (v + np.sqrt(v * v + 4.0 * self.v_min**2))
        cos, sin = np.cos(beta), np.sin(beta)
        alpha_f = u[4] - np.arctan((moving * sin + b.front_axle_m * yaw_rate) / (moving * cos))
        alpha_r = u[5] - np.arctan((moving * sin - b.rear_axle_m * yaw_rate) / (moving * cos))
        side_f, side_r = self._side_force(0, alpha_f), self._side_force(1, alpha_r)
        drive_f, drive_r = (u[0] + u[1]) / radius, (u[2] + u[3]) / radius
        held = self._rolling(drive_f + drive_r, v)
        long_f = drive_f - held * b.rear_axle_m / b.wheelbase_m
        long_r = drive_r - held * b.front_axle_m / b.wheelbase_m
        # one where the car moves, zero at rest
        share = v * v / (v * v + self.v_min**2 * np.exp(-((v / self.v_min) ** 2)) + 1e-12)
        side_f, side_r = share * side_f, share * side_r
        cos_f, sin_f, cos_r, sin_r = np.cos(u[4]), np.sin(u[4]), np.cos(u[5]), np.sin(u[5])
        front_x, front_y = cos_f * long_f - sin_f * side_f, cos_f * side_f + sin_f * long_f
        rear_x, rear_y = cos_r * long_r - sin_r * side_r, cos_r * side_r + sin_r * long_r
        f_x, f_y = front_x + rear_x - drag_force(self.vehicle, v * np.fabs(v)), front_y + rear_y
        rest = (1.0 - share) / _STOP
        return [
            share * ((cos * f_y - sin * f_x) / (mass * moving) - yaw_rate) - rest * beta,
            (cos * f_x + sin * f_y) / mass * share + (1.0 - share) * (drive_f + drive_r - held) / mass,
            share * (b.front_axle_m * front_y - b.rear_axle_m * rear_y) / b.yaw_inertia_kgm2 - rest * yaw_rate,
            yaw_rate,
            v * np.cos(psi + beta),
            v * np.sin(psi + beta),
        ]

    def _side_force(self, axle: int, alpha: Any) -> Any:
        """Side force in N of the front (0) or rear (1) axle under its static load."""
        other = self.body.rear_axle_m if axle == 0 else self.body.front_axle_m
        load = 0.5 * self.vehicle.chassis.mass_kg * GRAVITY * other / self.body.wheelbase_m
        return 2.0 * self.tyres[axle].forces(0.0, alpha, load).lateral

    def _rolling(self, drive: Any, v: Any) -> Any:
        """Rolling resistance in N against the motion; at rest, what holds the car against `drive` (N): backwards anything, forwards what it has."""
        mass = self.vehicle.chassis.mass_kg
        most = mass * GRAVITY * rolling_coefficient(self.vehicle, np.fabs(v))
        return np.fmin(drive + mass * v / _STOP, most)
