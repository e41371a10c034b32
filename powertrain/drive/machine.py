"""One electric machine with its inverter, quasi-stationary in the dq frame (M1): what the sections of a car's description say of it, no car needed.

Torque follows from the torque-forming current, `tau = 1.5 z_p psi_PM I_q`. Losses are the integrand of (3.39), split by where they arise. Where a
car gives inductance, voltage and current limit, a field-weakening current -I_d keeps the voltage above base speed; the voltage across the winding
resistance is neglected in that limit. Plain functions of NumPy operations: numbers, arrays and CasADi symbols all pass.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..description.sections import Drive, Steering, Weakening
from ..errors import VehicleError


class MachineLosses(NamedTuple):
    """Losses of a machine with its inverter in W."""

    copper: Any
    iron: Any
    inverter: Any
    friction: Any


def copper_per_torque(machine: Drive | Steering) -> float:
    """b in `b tau^2`: copper loss per squared torque of a machine, W/Nm^2."""
    return 2.0 * machine.phase_resistance_ohm / (3.0 * machine.pole_pairs**2 * machine.magnet_flux_wb**2)


def inverter_per_torque(machine: Drive | Steering) -> float:
    """a in `a |tau|`: current-dependent inverter loss per torque of a machine, W/Nm."""
    return 2.0 * machine.inverter_per_current_wpa / (3.0 * machine.pole_pairs * machine.magnet_flux_wb)


def machine_losses(machine: Drive | Steering, torque: Any, speed: Any) -> MachineLosses:
    """Losses of a traction or steering machine at shaft `torque` (Nm) and `speed` (rad/s): the integrand of (3.39) and (3.41), W."""
    turning = abs(speed)
    return MachineLosses(
        copper=copper_per_torque(machine) * torque**2,
        iron=machine.hysteresis_nm * turning + machine.eddy_nms * speed**2,
        inverter=machine.inverter_constant_w + inverter_per_torque(machine) * abs(torque),
        friction=machine.friction_nm * turning,
    )


def torque_constant(drive: Drive) -> float:
    """Torque per torque-forming current (amplitude), Nm/A."""
    return 1.5 * drive.pole_pairs * drive.magnet_flux_wb


def weakening_current(drive: Drive, torque: Any, speed: Any) -> Any:
    """The flux-forming current I_d <= 0 in A that keeps the voltage limit at `torque` (Nm) and `speed` (rad/s); zero below base speed.

    Least |I_d| with (L I_q)^2 + (psi + L I_d)^2 <= (u / omega_e)^2, u the linear modulation's amplitude, DC voltage over sqrt(3).

    Raises:
        VehicleError: the drive has no `weakening`.
    """
    p = _weakening(drive)
    i_q = torque / torque_constant(drive)
    flux = p.dc_voltage_v / np.sqrt(3.0) / (drive.pole_pairs * np.fmax(abs(speed), 1e-6))
    # the smallest flux keeps the root's derivative finite for who optimises over it
    room = np.sqrt(np.fmax(flux**2 - (p.inductance_h * i_q) ** 2, 1e-18))
    return np.fmin(room - drive.magnet_flux_wb, 0.0) / p.inductance_h


def voltage_limited_torque(drive: Drive, speed: Any) -> Any:
    """The largest torque in Nm at `speed` (rad/s) that voltage and current allow: constant, then field weakening, then most torque per voltage.

    Raises:
        VehicleError: the drive has no `weakening`.
    """
    p = _weakening(drive)
    short = drive.magnet_flux_wb / p.inductance_h  # the short-circuit current: centre of the voltage circle
    circle = p.dc_voltage_v / np.sqrt(3.0) / (drive.pole_pairs * np.fmax(abs(speed), 1e-6) * p.inductance_h)
    meeting = (circle**2 - p.current_max_a**2 - short**2) / (2.0 * short)
    i_d = np.fmax(np.fmin(meeting, 0.0), -short)
    i_q = np.sqrt(np.fmax(np.fmin(p.current_max_a**2 - i_d**2, circle**2 - (i_d + short) ** 2), 0.0))
    return torque_constant(drive) * i_q


def unreachable(drive: Drive, speed_max: float) -> str | None:
    """Where the torque and power limits ask for more than voltage and current give, in words; None if nowhere up to `speed_max` (rad/s)."""
    speeds = np.linspace(0.0, speed_max, 501)[1:]
    for torque, power, key in (
        (drive.torque_max_nm, drive.power_max_w, "torque_max_nm and power_max_w"),
        (drive.regen_torque_max_nm, drive.regen_power_max_w, "regen_torque_max_nm and regen_power_max_w"),
    ):
        asked, given = np.minimum(torque, power / speeds), voltage_limited_torque(drive, speeds)
        worst = int(np.argmax(asked - given))
        if asked[worst] > given[worst] * (1.0 + 1e-3) + 1e-9:
            return (
                f"drive.{key} ask for {asked[worst]:.1f} Nm at {speeds[worst]:.0f} rad/s, expected at most the {given[worst]:.1f} Nm that "
                f"drive.weakening allows"
            )
    return None


def _weakening(drive: Drive) -> Weakening:
    if drive.weakening is None:
        raise VehicleError("the voltage limit needs the section [drive.weakening], which the description has not")
    return drive.weakening


def torque_limits(drive: Drive, speed: Any) -> tuple[Any, Any]:
    """Largest driving and recuperating torque of one motor in Nm (both positive) at `speed` (rad/s)."""
    turning = np.fmax(abs(speed), 1e-9)
    return np.fmin(drive.torque_max_nm, drive.power_max_w / turning), np.fmin(drive.regen_torque_max_nm, drive.regen_power_max_w / turning)
