"""The figure of a car's drive: efficiency map with envelope, losses over speed, driving force against resistance."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from powertrain.drive.machine import torque_limits
from powertrain.drive.motor_map import read_map
from powertrain.energy.motor import force_limits, motor_losses
from powertrain.energy.resistance import driving_resistance

from ..style import BASELINE, BORDER, KMH, PLAN, STYLE

if TYPE_CHECKING:
    from os import PathLike

    from matplotlib.axes import Axes

    from powertrain import Vehicle

RPM = 30.0 / np.pi
#: Contours of the map, per cent.
LEVELS = (50, 60, 70, 80, 85, 88, 90, 92, 94, 95, 96, 97)
COLOURS = ("#4c78a8", "#72b7b2", "#f2b134", "#b07aa1", "#9c755f")


def draw_vehicle(vehicle: Vehicle, path: str | PathLike[str], *, dpi: int = 200) -> None:
    """Draw the drive of `vehicle` into the picture file `path` (PNG, PDF or SVG by suffix)."""
    with rc_context(STYLE):
        figure = Figure(figsize=(9.0, 4.8))
        FigureCanvasAgg(figure)
        left = figure.add_gridspec(1, 1, left=0.07, right=0.5, bottom=0.1, top=0.9)
        right = figure.add_gridspec(2, 1, left=0.6, right=0.985, bottom=0.1, top=0.92, hspace=0.16)
        _draw_map(figure.add_subplot(left[0]), vehicle)
        _draw_losses(figure.add_subplot(right[0]), vehicle)
        _draw_forces(figure.add_subplot(right[1]), vehicle)
        figure.savefig(path, dpi=dpi)


def _draw_map(axes: Axes, vehicle: Vehicle) -> None:
    drive = vehicle.drive
    fastest = vehicle.limits.speed_max_mps * vehicle.motor_ratio
    speed = np.linspace(1e-3, fastest, 300)
    most, least = torque_limits(drive, speed)
    torque = np.linspace(-drive.regen_torque_max_nm, drive.torque_max_nm, 401)[:, None] * np.ones_like(speed)
    power = torque * speed
    loss = read_map(drive.map).at(torque, speed * np.ones_like(torque)) if drive.map else sum(motor_losses(vehicle, torque, speed))
    with np.errstate(divide="ignore", invalid="ignore"):
        efficiency = 100.0 * np.where(power >= 0.0, power / (power + loss), (power + loss) / power)
    efficiency[(torque > most) | (torque < -least) | (efficiency < 0.0)] = np.nan
    filled = axes.contourf(RPM * speed, torque[:, 0], efficiency, levels=[0, *LEVELS, 100], cmap="Greens", extend="neither", alpha=0.85)
    filled.set_clim(30, 105)
    lines = axes.contour(RPM * speed, torque[:, 0], efficiency, levels=list(LEVELS), colors="#444444", linewidths=0.4)
    axes.clabel(lines, fmt="%g %%", fontsize=6)
    axes.plot(RPM * speed, most, color=PLAN, linewidth=1.4)
    axes.plot(RPM * speed, -least, color=PLAN, linewidth=1.4)
    axes.axhline(0.0, color=BORDER, linewidth=0.5)
    axes.set_xlim(0.0, RPM * fastest)
    axes.set_ylim(-1.08 * drive.regen_torque_max_nm - 1e-3, 1.08 * drive.torque_max_nm)
    axes.set_xlabel("motor speed in rpm")
    axes.set_ylabel("torque of one motor in Nm")
    what = "measured map" if drive.map else "loss model"
    axes.set_title(f"{vehicle.name}\nefficiency of motor, inverter and gear ({what})", fontsize=7.5, loc="left", parse_math=False)


def _draw_losses(axes: Axes, vehicle: Vehicle) -> None:
    v = np.linspace(0.5, vehicle.limits.speed_max_mps, 200)
    count, ratio = vehicle.drive.motor_count, vehicle.motor_ratio
    losses = motor_losses(vehicle, driving_resistance(vehicle, v, 0.0) / (count * ratio), v * ratio)._asdict()
    rows = {name: np.broadcast_to(count * np.asarray(loss), v.shape) for name, loss in losses.items()}
    shown = {name: row for name, row in rows.items() if np.any(row > 0.0)}
    axes.stackplot(KMH * v, [row / 1e3 for row in shown.values()], labels=list(shown), colors=COLOURS[: len(shown)])
    axes.set_xlim(0.0, KMH * v[-1])
    axes.set_ylim(bottom=0.0)
    axes.set_ylabel("drive losses in kW\nat constant speed, level")
    axes.legend(loc="upper left", frameon=False, fontsize=6.5)
    axes.tick_params(labelbottom=False)


def _draw_forces(axes: Axes, vehicle: Vehicle) -> None:
    v = np.linspace(0.0, vehicle.limits.speed_max_mps, 200)
    drive, regen = force_limits(vehicle, v)
    axes.plot(KMH * v, drive / 1e3, color=PLAN, linewidth=1.4, label="driving")
    axes.plot(KMH * v, -regen / 1e3, color=PLAN, linewidth=1.4, linestyle="--", label="recuperating")
    for slope, style in ((0.0, "-"), (0.05, "--"), (0.1, ":")):
        resistance = driving_resistance(vehicle, v, slope) / 1e3
        axes.plot(KMH * v, resistance, color=BASELINE, linewidth=1.0, linestyle=style, label=f"resistance, {slope:.0%}")
    axes.axhline(0.0, color=BORDER, linewidth=0.5)
    axes.set_xlim(0.0, KMH * v[-1])
    # room for the legend above the curves
    axes.set_ylim(-1.1 * float(np.max(regen)) / 1e3 - 1e-3, 2.1 * float(np.max(drive)) / 1e3)
    axes.set_xlabel("speed in km/h")
    axes.set_ylabel("force in kN")
    axes.legend(loc="upper right", frameon=False, fontsize=6.5, ncols=2)
