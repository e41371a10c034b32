"""A car as text for a person: what it is, what it can do, what it loses."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from powertrain import KWH
from powertrain.battery import load_cell
from powertrain.energy.balance import spoken
from powertrain.energy.cycle import drive_cycle
from powertrain.energy.performance import acceleration_time, best_point, characteristic_speed, steepest_slope, top_speed, understeer_gradient
from powertrain.energy.thermal import continuous_torque
from roads import cycles

from ..picture import save_picture
from ..style import KMH

if TYPE_CHECKING:
    from pathlib import Path

    from powertrain import Vehicle

#: The cycle that consumption is told for, at most as fast as the car.
CYCLE = "wltc_3b"
RPM = 30.0 / math.pi


def vehicle_table(vehicle: Vehicle) -> str:
    """A car in some fifteen lines."""
    chassis, limits = vehicle.chassis, vehicle.limits
    lines = [
        f"{vehicle.name}: {chassis.mass_kg:z.0f} kg, {chassis.width_m:z.2f} m wide, wheel radius {chassis.wheel_radius_m:z.3f} m",
        *_drive_lines(vehicle),
        f"top speed      {KMH * top_speed(vehicle):z.0f} km/h (stated {KMH * limits.speed_max_mps:z.0f})",
        f"acceleration   {', '.join(_sprints(vehicle)) or 'none'}",
        f"climbs         {100 * steepest_slope(vehicle):z.0f} % from rest, {100 * steepest_slope(vehicle, 50 / KMH):z.0f} % at 50 km/h",
        *_handling_lines(vehicle),
        *_consumption_lines(vehicle),
    ]
    return "\n".join(lines)


def _drive_lines(vehicle: Vehicle) -> list[str]:
    drive = vehicle.drive
    axles = drive.driven or ("rear" if drive.motor_count == 1 else "all")
    place = "one per wheel" if drive.per_wheel else "one per axle" if drive.motor_count == 2 else "with differential"
    wheels = {"all": "all wheels", "front": "front wheels", "rear": "rear wheels"}[axles]
    best = best_point(vehicle)
    gear = f", gear {drive.gear_ratio:g} : 1" if drive.gear_ratio != 1.0 else ", direct"
    motors = f"{drive.motor_count} motor{'s' * (drive.motor_count > 1)} of {drive.torque_max_nm:z.0f} Nm and {drive.power_max_w / 1e3:z.0f} kW"
    lines = [
        f"drive          {motors}, {place}, {wheels}{gear}",
        f"best point     {100 * best.efficiency:z.1f} % at {best.torque:z.0f} Nm and {RPM * best.speed:z.0f} rpm",
    ]
    if drive.thermal is not None:
        speed = 0.5 * vehicle.limits.speed_max_mps * vehicle.motor_ratio
        lines.append(f"continuous     {continuous_torque(vehicle, speed):z.0f} Nm per motor at half the top speed, 25 degC outside")
    return lines


def _sprints(vehicle: Vehicle) -> list[str]:
    found = []
    for kmh in (50.0, 80.0, 100.0):
        if kmh / KMH > vehicle.limits.speed_max_mps + 1e-6:
            continue
        seconds = acceleration_time(vehicle, min(kmh / KMH, vehicle.limits.speed_max_mps))
        if math.isfinite(seconds):
            found.append(f"0 to {kmh:z.0f} km/h in {seconds:z.1f} s")
    return found


def _handling_lines(vehicle: Vehicle) -> list[str]:
    if vehicle.body is None or vehicle.tyre is None:
        return []
    gradient = understeer_gradient(vehicle)
    if abs(gradient) < 1e-7:
        return ["handling       neutral"]
    kind, name = ("understeers", "characteristic") if gradient > 0.0 else ("oversteers", "critical")
    return [f"handling       {kind} by {1e3 * abs(gradient):z.3f} mrad per m/s^2, {name} speed {KMH * abs(characteristic_speed(vehicle)):z.0f} km/h"]


def _consumption_lines(vehicle: Vehicle) -> list[str]:
    cycle = cycles.load(CYCLE)
    ledger = drive_cycle(vehicle, cycle.t, np.minimum(cycle.v, vehicle.limits.speed_max_mps))
    parts = ", ".join(f"{spoken(name)} {value / ledger.energy:.0%}" for name, value in ledger.components.items() if value > 0.005 * ledger.energy)
    slow = f" at {KMH * vehicle.limits.speed_max_mps:z.0f} km/h at most" if np.max(cycle.v) > vehicle.limits.speed_max_mps else ""
    slow += f", falling behind by {KMH * ledger.missed:z.0f} km/h" if ledger.missed > 0.1 else ""
    lines = [f"consumption    {ledger.consumption / KWH * 1e5:z.1f} kWh/100 km from the battery on the WLTC{slow} ({parts})"]
    if vehicle.battery is None:
        return lines
    cell, pack = load_cell(vehicle.battery.cell), vehicle.battery
    soc = np.linspace(0.0, 1.0, 101)
    volts = np.asarray(cell.ocv_v(soc))
    energy = float(np.mean(volts)) * cell.capacity * pack.series * pack.parallel
    usable = energy * (cell.limits.soc_max - cell.limits.soc_min)
    middle = float(cell.ocv_v(0.5)) * pack.series
    return [
        *lines,
        f"battery        {pack.series}s{pack.parallel}p of {cell.name}: {energy / KWH:z.1f} kWh, {middle:z.0f} V at half charge",
        f"range          {ledger.range(usable) / 1e3:z.0f} km on the WLTC with {usable / KWH:z.1f} kWh usable, losses in the battery not counted",
    ]


def save_vehicle_figure(vehicle: Vehicle, out: Path) -> None:
    """Draw the drive of `vehicle` into the picture file `out`, whole or not at all.

    Raises:
        PlanningError: a suffix that is no picture's, or a place that cannot be written to.
    """
    from .figure import draw_vehicle

    save_picture(lambda path: draw_vehicle(vehicle, path), out)
