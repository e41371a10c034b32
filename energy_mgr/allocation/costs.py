"""What commands cost, as parabolas about an operating point: true losses, the published physical cost (A2), the heuristic (A3), and blends.

A parabola is a pair (gradient, curvature) over the commands in physical units, in W; curvatures are diagonal, since no loss couples two actuators.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from powertrain.drive.steering import Contact, steering_power
from powertrain.energy.motor import copper_factor, motor_losses
from powertrain.symbolic import ca
from powertrain.tyre.force import sliding_power
from powertrain.vehicle import GRAVITY

from ..errors import PlanningError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .effectiveness import WheelForce
    from .layout import Layout

CostKind = Literal["physical", "heuristic", "blended"]
COSTS: tuple[str, ...] = ("physical", "heuristic", "blended")
#: Torque in Nm below which the kink of the inverter's loss at zero is rounded off.
_ROUND = 1.0
#: Steering rate in rad/s below which the kink of the drive's friction is rounded off.
_ROUND_RATE = 0.01
#: W/rad^2: least curvature of the steering's cost, so that the programme stays strictly convex.
_FLATTEST = 1e3
#: Share of the heuristic in the blended cost.
BLEND = 0.5
#: Below this wheel speed in m/s a friction brake counts as if it wasted this much: the parking car has a reason, too, to prefer motors.
_CREEP = 2.0


class Parabola(NamedTuple):
    """gradient' du + 0.5 du' diag(curvature) du, W."""

    gradient: list[Any]
    curvature: list[Any]


def checked_cost(cost: str) -> str:
    """`cost` if there is one of that name.

    Raises:
        PlanningError: there is none.
    """
    if cost not in COSTS:
        raise PlanningError(f"allocation cost {cost!r}, expected one of {', '.join(COSTS)}")
    return cost


def losses(layout: Layout, u: Any, wheels: Sequence[WheelForce], speeds: Sequence[Any]) -> Any:
    """What the commands lose in W: motors with their inverters and gears, friction brakes, sliding of the tyres. Symbols only.

    Args:
        layout: the actuators.
        u: vector of commands.
        wheels: the wheels under these commands.
        speeds: of the motors, rad/s.
    """
    motors = sum(sum(motor_losses(layout.vehicle, u[k], speeds[k])) for k in range(layout.motors))
    brakes = sum(u[layout.brakes.start + k] * np.fabs(wheel.spin) for k, wheel in enumerate(wheels))
    return motors + brakes + slip_losses(wheels)


def slip_losses(wheels: Sequence[WheelForce]) -> Any:
    """Power lost in the contact patches, W; not cut off at zero, which would take the curvature away where there is no force yet."""
    return sum(sliding_power(wheel.along, wheel.side, wheel.along / wheel.stiffness, wheel.alpha, wheel.speed) for wheel in wheels)


def true_losses(layout: Layout, u: Any, wheels: Sequence[WheelForce], speeds: Sequence[Any]) -> Parabola:
    """The losses about `u`: exact gradient; curvature of the parabola through zero torque with that slope for motors, exact for tyres.

    A motor's loss grows with |tau| and tau^2, so as a function of tau^2 it is concave: the parabola with its slope at the present torque lies above
    it everywhere, and stepping to the parabola's least does not raise the loss, kink or not. Below `_ROUND`, where the kink is rounded off so that
    the curvature stays finite, it may: by up to 11 W (1.5 W for the ROMO).
    """
    gradient = ca.gradient(losses(layout, u, wheels, speeds), u)
    torque = ca.SX.sym("torque", layout.motors)
    slope = ca.gradient(sum(sum(motor_losses(layout.vehicle, torque[k], speeds[k])) for k in range(layout.motors)), torque)
    rounded = ca.vertcat(*(np.sqrt(u[k] ** 2 + _ROUND**2) for k in range(layout.motors)))
    secant = ca.substitute(slope, torque, rounded) / rounded
    slip = slip_losses(wheels)
    bend = ca.diag(ca.hessian(slip, u)[0])
    curvature: list[Any] = []
    for k in range(layout.size):
        motor = secant[k] if k < layout.motors else 0.0
        curvature.append(motor + np.fmax(bend[k], 0.0))
    for k, wheel in enumerate(wheels):
        at = layout.brakes.start + k
        # below walking pace the way that a brake's torque goes is too short to matter, but not the choice between it and a motor
        gradient[at] = gradient[at] + np.fmax(_CREEP / layout.vehicle.chassis.wheel_radius_m - np.fabs(wheel.spin), 0.0)
    return Parabola(ca.vertsplit(gradient), curvature)


def published_physical(layout: Layout, u: Any, wheels: Sequence[WheelForce], speeds: Sequence[Any], turned: Any, dt: float) -> Parabola:
    """A2, (3.45): steering power about the last increments `turned` (rad), motor losses about the present torques; over the increments `du`.

    The steering part is expanded about du = turned, which shifts its gradient; brakes cost nothing (they are not allocated there).
    """
    start, count = layout.steers.start, len(layout.steered)
    step = ca.SX.sym("step", count)
    power: Any = 0.0
    for k, wheel in enumerate(layout.steered):
        force = wheels[wheel]
        contact = Contact(force.side, force.along, force.load, force.speed, force.aligning, left=1.0 if wheel % 2 == 0 else -1.0)
        power = power + steering_power(layout.track.steering, step[k] / dt, (step[k] - turned[k]) / dt**2, contact).total
    slope = ca.gradient(power, step)
    bend = ca.diag(ca.jacobian(slope, step))
    slope, bend = ca.substitute(slope, step, turned), ca.substitute(bend, step, turned)
    # the drive's friction is |rate|, and the parabola at its kink knows nothing of the other side: taken as it is, increments change their sign every
    # period and the wheels of an axle drift apart; as with torques the parabola through rest with the same slope takes its place
    drag = layout.track.steering.gear_ratio * (layout.track.steering.friction_nm + layout.track.steering.hysteresis_nm) / dt
    rounded = np.sqrt(turned**2 + (_ROUND_RATE * dt) ** 2)
    slope, bend = slope - drag * ca.sign(turned) + drag * turned / rounded, bend + drag / rounded
    motor = true_losses(layout, u, wheels, speeds)
    gradient, curvature = [*motor.gradient], [*motor.curvature]
    torques = sum(sum(motor_losses(layout.vehicle, u[k], speeds[k])) for k in range(layout.motors))
    by_torque = ca.gradient(torques, u)
    for k in range(layout.motors):
        gradient[k], curvature[k] = by_torque[k], 2.0 * copper_factor(layout.vehicle)
    for k in range(4):
        gradient[layout.brakes.start + k], curvature[layout.brakes.start + k] = 0.0, 0.0
    for k in range(count):
        bent = np.fmax(bend[k], _FLATTEST)
        gradient[start + k], curvature[start + k] = slope[k] - bent * turned[k], bent
    return Parabola(gradient, curvature)


def heuristic(layout: Layout, u: Any, wheels: Sequence[WheelForce]) -> Parabola:
    """A3, (3.46): steering rates towards zero, torques towards the most recuperation; weights in W so that both costs can be blended.

    The published weights are not given. Here a torque weighs as its copper loss does, and a steering increment as one that makes as large a force.
    """
    gradient: list[Any] = [0.0] * layout.size
    curvature: list[Any] = [0.0] * layout.size
    most = layout.vehicle.drive.regen_torque_max_nm
    for k in range(layout.motors):
        curvature[k] = 2.0 * copper_factor(layout.vehicle)
        gradient[k] = curvature[k] * (u[k] + most)
    for k, wheel in enumerate(layout.steered):
        tyre, load = layout.track.tyres[wheel], layout.vehicle.chassis.mass_kg * GRAVITY / 4.0
        torque_per_angle = float(tyre.cornering_stiffness(load)) * layout.vehicle.chassis.wheel_radius_m
        curvature[layout.steers.start + k] = 2.0 * copper_factor(layout.vehicle) * torque_per_angle**2
    return Parabola(gradient, curvature)


def blended(one: Parabola, other: Parabola, share: float = BLEND) -> Parabola:
    """`share` of the other and the rest of the one."""

    def mix(a: list[Any], b: list[Any]) -> list[Any]:
        return [(1.0 - share) * p + share * q for p, q in zip(a, b, strict=True)]

    return Parabola(mix(one.gradient, other.gradient), mix(one.curvature, other.curvature))
