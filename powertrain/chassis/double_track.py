"""Double-track plant (M5): plane motion, roll and pitch with their load transfer, four spinning wheels, tyre relaxation, actuator lags.

The body moves in the plane of the road (velocities v_x, v_y and yaw rate r of the centre of gravity, in its frame) and rolls and pitches about axes
on the ground. A body that leans by phi > 0 (to the right) carries its centre to the right of the contact patches, so that these move with
v_y + h phi'; likewise v_x - h theta' under pitch theta > 0 (nose down). Tyre forces act through exactly these velocities, which makes the power
balance of the model exact. Wheel loads follow from the moments of springs and dampers, hence without algebraic loop.

Left out: the tyres' aligning moment on the yaw motion, wheel hop, wheels that lift (their load ends at zero, the others' does not fall for it), the
pitch reaction of wheel spin, roll-centre geometry, camber.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..description.sections import Body, Brakes, Steering
from ..drive.brake import brake_torque, hold_rate
from ..drive.machine import torque_limits
from ..energy.resistance import drag_force, rolling_coefficient
from ..errors import VehicleError
from ..vehicle import GRAVITY, Vehicle
from .wheel import Patch, Wheel, saturated, wheel_on_road

if TYPE_CHECKING:
    from collections.abc import Sequence

WHEELS = ("fl", "fr", "rl", "rr")
#: Steering: rate per angle still to go over the rate's own lag; four is critical damping.
_STEERING = 4.0


class DoubleTrack:
    """The plant of one car: names of its states and inputs, derivative, wheels.

    All states and inputs are SI; angles in rad. Inputs: `torque_cmd_<motor>` per motor in Nm, `brake_cmd_<wheel>` clamped friction torque in Nm,
    `steer_cmd_<wheel>` in rad for the steered wheels, all cut to what motors, brakes and steering can do; `grade` and `bank` as slopes dz over d way
    (uphill, left side up), `friction` scaling the tyres.
    """

    def __init__(self, vehicle: Vehicle) -> None:
        """The plant of `vehicle`.

        Raises:
            VehicleError: the description lacks a section that the plant needs, or has no four wheels with inertia.
        """
        self.vehicle = vehicle
        self.body = vehicle.need("body", Body)
        self.brakes = vehicle.need("brakes", Brakes)
        self.steering = vehicle.need("steering", Steering)
        front, rear = vehicle.tyres()
        if vehicle.chassis.wheel_count != 4 or vehicle.chassis.wheel_inertia_kgm2 == 0.0:
            chassis = vehicle.chassis
            found = f"chassis has {chassis.wheel_count} wheels of {chassis.wheel_inertia_kgm2} kg m^2"
            raise VehicleError(f"{vehicle.name}: {found}, expected four with inertia for the double track")
        self.tyres: tuple[Any, ...] = (front, front, rear, rear)
        self.motors = tuple(str(k + 1) for k in range(vehicle.drive.motor_count))
        steered = self.steering.steered_wheels
        self.steered = tuple(wheel for wheel, turns in zip(WHEELS, steered, strict=True) if turns)
        self.states: tuple[str, ...] = (
            *("x", "y", "psi", "v_x", "v_y", "yaw_rate", "roll", "pitch", "roll_rate", "pitch_rate"),
            *(f"{name}_{wheel}" for name in ("omega", "u", "w", "clamp", "hold") for wheel in WHEELS),
            *(f"torque_{motor}" for motor in self.motors),
            *(f"{name}_{wheel}" for name in ("delta", "delta_rate") for wheel in self.steered),
        )
        self.inputs: tuple[str, ...] = (
            *(f"torque_cmd_{motor}" for motor in self.motors),
            *(f"brake_cmd_{wheel}" for wheel in WHEELS),
            *(f"steer_cmd_{wheel}" for wheel in self.steered),
            *("grade", "bank", "friction"),
        )

    def initial(self, speed: float = 0.0, **values: float) -> list[float]:
        """A state of straight rolling at `speed` (m/s) in the order of `states`; `values` replace single ones.

        Raises:
            KeyError: a name that is no state.
        """
        state = dict.fromkeys(self.states, 0.0)
        state["v_x"] = speed
        for wheel in WHEELS:
            state[f"omega_{wheel}"] = speed / self.vehicle.chassis.wheel_radius_m
        return _replaced(state, values, "state")

    def command(self, **values: float) -> list[float]:
        """Inputs in the order of `inputs`: all zero on a level road of full friction but for `values`; `brake_cmd`, `torque_cmd` and `steer_cmd`
        without a wheel or motor stand for all of them.

        Raises:
            KeyError: a name that is no input.
        """
        inputs = dict.fromkeys(self.inputs, 0.0) | {"friction": 1.0}
        spread = {name: value for short, value in values.items() for name in self.inputs if name == short or name.startswith(f"{short}_")}
        if unknown := [name for name in values if name not in inputs and not any(own.startswith(f"{name}_") for own in inputs)]:
            raise KeyError(f"{', '.join(unknown)}: no input of the plant, expected {', '.join(self.inputs)}")
        return _replaced(inputs, spread, "input")

    def derivative(self, x: Sequence[Any], u: Sequence[Any]) -> list[Any]:
        """d x/dt for states and inputs in the order of `states` and `inputs`: numbers, arrays or CasADi symbols."""
        s, c = self.named(x, u)
        wheels = self.wheels(s, c)
        rate = self._plane(s, c, wheels) | self._lean(s, wheels) | self._actuators(s, c)
        radius = self.vehicle.chassis.wheel_radius_m
        torques = []
        for name, wheel, drive in zip(WHEELS, wheels, self.drive_torques(s), strict=True):
            brake = brake_torque(self.brakes, s[f"clamp_{name}"], s[f"omega_{name}"], s[f"hold_{name}"])
            torques.append(drive - brake - wheel.rolling - radius * wheel.longitudinal)
            rate[f"u_{name}"], rate[f"w_{name}"] = wheel.u_rate, wheel.w_rate
            rate[f"hold_{name}"] = hold_rate(self.brakes, s[f"clamp_{name}"], s[f"omega_{name}"], s[f"hold_{name}"])
        rate |= {f"omega_{name}": spin for name, spin in zip(WHEELS, self._spins(torques), strict=True)}
        return [rate[name] for name in self.states]

    def named(self, x: Sequence[Any], u: Sequence[Any]) -> tuple[dict[str, Any], dict[str, Any]]:
        """States and inputs by name."""
        return dict(zip(self.states, x, strict=True)), dict(zip(self.inputs, u, strict=True))

    def weight(self, c: dict[str, Any]) -> Any:
        """Weight normal to a road of `grade` and `bank`, N."""
        return self.vehicle.chassis.mass_kg * GRAVITY / np.sqrt(1.0 + c["grade"] ** 2 + c["bank"] ** 2)

    def loads(self, s: dict[str, Any], c: dict[str, Any]) -> list[Any]:
        """Wheel loads in N, at least zero."""
        b, weight = self.body, self.weight(c)
        roll = b.roll_stiffness_nmprad * s["roll"] + b.roll_damping_nmsprad * s["roll_rate"]
        pitch = (b.pitch_stiffness_nmprad * s["pitch"] + b.pitch_damping_nmsprad * s["pitch_rate"]) / (2.0 * b.wheelbase_m)
        front, rear = 0.5 * weight * b.rear_axle_m / b.wheelbase_m + pitch, 0.5 * weight * b.front_axle_m / b.wheelbase_m - pitch
        across_front, across_rear = b.roll_front_share * roll / b.front_track_m, (1.0 - b.roll_front_share) * roll / b.rear_track_m
        return [np.fmax(load, 0.0) for load in (front - across_front, front + across_front, rear - across_rear, rear + across_rear)]

    def wheels(self, s: dict[str, Any], c: dict[str, Any], *, powers: bool = False) -> list[Wheel]:
        """The four wheels on the road for states `s` and inputs `c` by name; `powers` as in `wheel_on_road`."""
        b, loads = self.body, self.loads(s, c)
        v_x, v_y = s["v_x"] - b.cog_height_m * s["pitch_rate"], s["v_y"] + b.cog_height_m * s["roll_rate"]
        rolling = rolling_coefficient(self.vehicle, np.fabs(s["v_x"]))
        found = []
        for k, name in enumerate(WHEELS):
            patch = Patch(
                v_x=v_x - b.wheel_y[k] * s["yaw_rate"],
                v_y=v_y + b.wheel_x[k] * s["yaw_rate"],
                delta=s.get(f"delta_{name}"),
                omega=s[f"omega_{name}"],
                u=s[f"u_{name}"],
                w=s[f"w_{name}"],
                load=loads[k],
            )
            found.append(wheel_on_road(self.tyres[k], self.vehicle.chassis.wheel_radius_m, patch, c["friction"], rolling, powers=powers))
        return found

    def drive_torques(self, s: dict[str, Any]) -> list[Any]:
        """Torque of the drive at each wheel, Nm."""
        drive = self.vehicle.drive
        return [0.0 if motor is None else self._share * s[f"torque_{self.motors[motor]}"] for motor in drive.motor_of_wheel]

    def motor_speeds(self, s: dict[str, Any]) -> list[Any]:
        """Speed of each motor, rad/s; through a differential it is the mean of its wheels."""
        speeds: list[Any] = [0.0] * len(self.motors)
        for name, motor in zip(WHEELS, self.vehicle.drive.motor_of_wheel, strict=True):
            if motor is not None:
                speeds[motor] = speeds[motor] + self._share * s[f"omega_{name}"]
        return speeds

    def torque_range(self, speed: Any) -> tuple[Any, Any]:
        """Largest torque forwards and backwards at a motor speed in rad/s, Nm: driving or recuperating, as the motor turns."""
        p = self.vehicle.drive
        drive, regen = torque_limits(p, speed)
        if (p.torque_max_nm, p.power_max_w) == (p.regen_torque_max_nm, p.regen_power_max_w):
            return drive, drive
        forward, backward = np.fmax(np.fmin(1.0 + speed, 1.0), 0.0), np.fmax(np.fmin(1.0 - speed, 1.0), 0.0)
        return regen + (drive - regen) * forward, regen + (drive - regen) * backward

    def _spins(self, torques: list[Any]) -> list[Any]:
        """Angular accelerations of the wheels in rad/s^2 under `torques` in Nm, rotors included.

        The rotor behind a differential turns with the mean of both wheels: it couples them.
        """
        drive, own = self.vehicle.drive, self.vehicle.chassis.wheel_inertia_kgm2
        rotor = drive.rotor_inertia_kgm2 * self._share**2
        found = []
        for k, (torque, driven) in enumerate(zip(torques, drive.driven_wheels, strict=True)):
            if not driven or rotor == 0.0:
                found.append(torque / own)
            elif drive.per_wheel:
                found.append(torque / (own + rotor))
            else:
                found.append(((own + rotor) * torque - rotor * torques[k ^ 1]) / (own * (own + 2.0 * rotor)))
        return found

    @property
    def _share(self) -> float:
        """Wheel torque over its motor's torque."""
        drive = self.vehicle.drive
        return drive.gear_ratio if drive.per_wheel else 0.5 * drive.gear_ratio

    def _plane(self, s: dict[str, Any], c: dict[str, Any], wheels: list[Wheel]) -> dict[str, Any]:
        mass, weight = self.vehicle.chassis.mass_kg, self.weight(c)
        drag = drag_force(self.vehicle, s["v_x"] * np.fabs(s["v_x"]))
        moment = sum(self.body.wheel_x[k] * wheel.body_y - self.body.wheel_y[k] * wheel.body_x for k, wheel in enumerate(wheels))
        cos, sin = np.cos(s["psi"]), np.sin(s["psi"])
        return {
            "x": s["v_x"] * cos - s["v_y"] * sin,
            "y": s["v_x"] * sin + s["v_y"] * cos,
            "psi": s["yaw_rate"],
            "v_x": (sum(wheel.body_x for wheel in wheels) - drag - weight * c["grade"]) / mass + s["yaw_rate"] * s["v_y"],
            "v_y": (sum(wheel.body_y for wheel in wheels) - weight * c["bank"]) / mass - s["yaw_rate"] * s["v_x"],
            "yaw_rate": moment / self.body.yaw_inertia_kgm2,
        }

    def _lean(self, s: dict[str, Any], wheels: list[Wheel]) -> dict[str, Any]:
        b = self.body
        heel = self.vehicle.chassis.mass_kg * GRAVITY * b.cog_height_m
        roll = b.cog_height_m * sum(wheel.body_y for wheel in wheels)
        pitch = -b.cog_height_m * sum(wheel.body_x for wheel in wheels)
        held_roll = (b.roll_stiffness_nmprad - heel) * s["roll"] + b.roll_damping_nmsprad * s["roll_rate"]
        held_pitch = (b.pitch_stiffness_nmprad - heel) * s["pitch"] + b.pitch_damping_nmsprad * s["pitch_rate"]
        return {
            "roll": s["roll_rate"],
            "pitch": s["pitch_rate"],
            "roll_rate": (roll - held_roll) / b.roll_inertia_kgm2,
            "pitch_rate": (pitch - held_pitch) / b.pitch_inertia_kgm2,
        }

    def _actuators(self, s: dict[str, Any], c: dict[str, Any]) -> dict[str, Any]:
        drive, steering = self.vehicle.drive, self.steering
        rate: dict[str, Any] = {}
        for motor, speed in zip(self.motors, self.motor_speeds(s), strict=True):
            forward, backward = self.torque_range(speed)
            wanted = np.fmax(np.fmin(c[f"torque_cmd_{motor}"], forward), -backward) - s[f"torque_{motor}"]
            rate[f"torque_{motor}"] = drive.torque_rate_nmps * saturated(wanted * (1.0 / (drive.torque_lag_s * drive.torque_rate_nmps)))
        brakes = (self.brakes.front_torque_max_nm,) * 2 + (self.brakes.rear_torque_max_nm,) * 2
        for wheel, most in zip(WHEELS, brakes, strict=True):
            rate[f"clamp_{wheel}"] = (np.fmax(np.fmin(c[f"brake_cmd_{wheel}"], most), 0.0) - s[f"clamp_{wheel}"]) * (1.0 / self.brakes.lag_s)
        for wheel in self.steered:
            angle = np.fmax(np.fmin(c[f"steer_cmd_{wheel}"], steering.angle_max_rad), -steering.angle_max_rad)
            wanted = (angle - s[f"delta_{wheel}"]) * (1.0 / (steering.lag_s * steering.rate_max_radps))
            limited = steering.rate_max_radps * saturated(wanted)
            rate[f"delta_{wheel}"] = s[f"delta_rate_{wheel}"]
            rate[f"delta_rate_{wheel}"] = (limited - s[f"delta_rate_{wheel}"]) * (_STEERING / steering.lag_s)
        return rate


def _replaced(named: dict[str, float], values: dict[str, float], kind: str) -> list[float]:
    if unknown := values.keys() - named.keys():
        raise KeyError(f"{', '.join(sorted(unknown))}: no {kind} of the plant, expected {', '.join(named)}")
    return [float(value) for value in (named | values).values()]
