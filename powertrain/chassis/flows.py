"""Where the power of the double-track plant goes: every flow in W, and what is stored in J.

At every instant  d(stored)/dt = motor + clamping - (rolling + drag + slope + brake + tyre + carcass + damping),  exactly.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..drive.brake import brake_torque, hold_rate, stored
from ..drive.steering import Contact, steering_power
from ..energy.motor import motor_losses
from ..energy.resistance import drag_force
from ..vehicle import GRAVITY
from .double_track import WHEELS, DoubleTrack

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .wheel import Wheel

#: Flows into the body's motion: `motor` is shaft power, `clamping` the work of brake actuators on stretched pads.
SOURCES = ("motor", "clamping")
#: Losses of the moving car, never negative (but for `brake` in the instant a clamped wheel swings back).
SINKS = ("rolling", "drag", "brake", "tyre", "damping")
#: Flows into what the car keeps apart from `kept`: height, and the deflection of the tyres.
KEPT = ("slope", "carcass")
#: Losses of drives and steering, never negative.
ELECTRIC = ("copper", "iron", "inverter", "friction", "gear", "steering")
#: Flows of the steering drives that may come back: inertia and aligning torque.
STEERING_KEPT = ("steering_work",)
FLOWS: tuple[str, ...] = (*SOURCES, *SINKS, *KEPT, *ELECTRIC, *STEERING_KEPT)


def flows(plant: DoubleTrack, x: Sequence[Any], u: Sequence[Any], temperature: Any = None) -> dict[str, Any]:
    """The flows of `FLOWS` in W for states and inputs of the plant: numbers, arrays or symbols.

    Args:
        plant: the car.
        x: states.
        u: inputs.
        temperature: of the windings, K; None for the warm resistance.
    """
    s, c = plant.named(x, u)
    wheels = plant.wheels(s, c, powers=True)
    rate = dict(zip(plant.states, plant.derivative(x, u), strict=True))
    body, weight = plant.body, plant.weight(c)
    found: dict[str, Any] = {
        "drag": drag_force(plant.vehicle, s["v_x"] * np.fabs(s["v_x"])) * s["v_x"],
        "slope": weight * (c["grade"] * s["v_x"] + c["bank"] * s["v_y"]),
        "damping": body.roll_damping_nmsprad * s["roll_rate"] ** 2 + body.pitch_damping_nmsprad * s["pitch_rate"] ** 2,
        "rolling": sum(wheel.rolling * s[f"omega_{name}"] for name, wheel in zip(WHEELS, wheels, strict=True)),
        "tyre": sum(wheel.slip_loss for wheel in wheels),
        "carcass": sum(wheel.carcass for wheel in wheels),
    }
    found |= _brakes(plant, s, rate) | _drives(plant, s, temperature) | _steering(plant, s, c, rate, wheels)
    return {name: found[name] for name in FLOWS}


def kept(plant: DoubleTrack, x: Sequence[Any]) -> Any:
    """Energy of motion, springs and pads in J."""
    s = dict(zip(plant.states, x, strict=True))
    body, chassis = plant.body, plant.vehicle.chassis
    heel = chassis.mass_kg * GRAVITY * body.cog_height_m
    twice = (
        chassis.mass_kg * (s["v_x"] ** 2 + s["v_y"] ** 2)
        + body.yaw_inertia_kgm2 * s["yaw_rate"] ** 2
        + body.roll_inertia_kgm2 * s["roll_rate"] ** 2
        + body.pitch_inertia_kgm2 * s["pitch_rate"] ** 2
        + (body.roll_stiffness_nmprad - heel) * s["roll"] ** 2
        + (body.pitch_stiffness_nmprad - heel) * s["pitch"] ** 2
        + sum(chassis.wheel_inertia_kgm2 * s[f"omega_{name}"] ** 2 for name in WHEELS)
        + sum(plant.vehicle.drive.rotor_inertia_kgm2 * speed**2 for speed in plant.motor_speeds(s))
    )
    return 0.5 * twice + sum(stored(plant.brakes, s[f"clamp_{name}"], s[f"hold_{name}"]) for name in WHEELS)


def _brakes(plant: DoubleTrack, s: dict[str, Any], rate: dict[str, Any]) -> dict[str, Any]:
    heat: Any = 0.0
    clamping: Any = 0.0
    for name in WHEELS:
        clamp, omega, hold = s[f"clamp_{name}"], s[f"omega_{name}"], s[f"hold_{name}"]
        stretch = plant.brakes.presliding_rad * hold
        heat = heat + brake_torque(plant.brakes, clamp, omega, hold) * omega - clamp * stretch * hold_rate(plant.brakes, clamp, omega, hold)
        clamping = clamping + 0.5 * rate[f"clamp_{name}"] * stretch * hold
    return {"brake": heat, "clamping": clamping}


def _drives(plant: DoubleTrack, s: dict[str, Any], temperature: Any) -> dict[str, Any]:
    found: dict[str, Any] = dict.fromkeys(("motor", "copper", "iron", "inverter", "friction", "gear"), 0.0)
    for motor, speed in zip(plant.motors, plant.motor_speeds(s), strict=True):
        torque = s[f"torque_{motor}"]
        found["motor"] = found["motor"] + torque * speed
        for name, loss in motor_losses(plant.vehicle, torque, speed, temperature)._asdict().items():
            found[name] = found[name] + loss
    return found


def _steering(plant: DoubleTrack, s: dict[str, Any], c: dict[str, Any], rate: dict[str, Any], wheels: list[Wheel]) -> dict[str, Any]:
    lost: Any = 0.0
    work: Any = 0.0
    for name, wheel in zip(WHEELS, wheels, strict=True):
        if name not in plant.steered:
            continue
        left = 1.0 if name.endswith("l") else -1.0
        contact = Contact(wheel.side, wheel.longitudinal, wheel.load, wheel.ground_speed, wheel.aligning, c["friction"], left)
        power = steering_power(plant.steering, s[f"delta_rate_{name}"], rate[f"delta_rate_{name}"], contact)
        work = work + power.acceleration + power.aligning
        lost = lost + power.bore + power.gear + power.copper + power.iron + power.inverter + power.friction
    return {"steering": lost, "steering_work": work}
