"""The figure of a drive: map coloured by speed, where the energy went, and what happened over the way."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from powertrain import KWH
from powertrain.chassis.double_track import WHEELS, DoubleTrack

from ..style import BASELINE, BORDER, BOUND, KMH, PLAN, STYLE
from .table import OUTCOMES, account, event_words, planned_energy, planned_time

if TYPE_CHECKING:
    from collections.abc import Sequence
    from os import PathLike

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from roads import Road

    from ...planning import Plan
    from ...simulation import Drive

    Floats = NDArray[np.float64]

#: Front left, front right, rear left, rear right (Okabe and Ito): an axle shares its hue, the left side is the darker one.
WHEEL_COLOURS = ("#0072B2", "#56B4E9", "#D55E00", "#E69F00")
#: Lines that lie on each other: the later, the thinner.
_WIDTHS = (2.1, 1.5, 1.0, 0.5)
EVENT = "#CC79A7"
#: A map needs no more points than this to look smooth.
_POINTS = 3000
#: Inches.
_SIZE = (9.0, 8.6)
#: Room for the names of events.
_NAMED = 6
#: Half of what is shown about the largest offset, m.
_REACH = 20.0


def draw_drive(drive: Drive, path: str | PathLike[str], *, plan: Plan | None = None, road: Road | None = None, dpi: int = 200) -> None:
    """Draw `drive` into a picture file.

    Args:
        drive: what was driven.
        path: PNG, PDF or SVG by suffix.
        plan: what was to be driven, for its energy account and its road; by default the account is that of driving the trajectory exactly.
        road: whose borders are drawn.
        dpi: dots per inch.
    """
    road = plan.road if road is None and plan is not None else road
    with rc_context(STYLE):
        figure = Figure(figsize=_SIZE)
        FigureCanvasAgg(figure)
        # fixed margins: the automatic layout would draw everything twice
        right = figure.add_gridspec(7, 1, left=0.515, right=0.925, bottom=0.055, top=0.92, hspace=0.14)
        edges = () if road is None else borders(road)
        _draw_map(figure, [0.075, 0.625, 0.345, 0.295], drive, edges)
        _draw_worst(figure.add_axes((0.075, 0.325, 0.345, 0.205)), drive, () if road is None else borders(road, 50_000))
        # names of components are long
        _draw_account(figure.add_axes((0.14, 0.055, 0.28, 0.205)), drive, plan)
        panels = (_draw_speed, _draw_offset, _draw_ahead, _draw_aside, _draw_torques, _draw_steering, _draw_power)
        for row, draw in enumerate(panels):
            axes = figure.add_subplot(right[row])
            draw(axes, drive, drive["s_m"] - drive.trajectory.s[0])
            _finish(axes, drive, first=row == 0, last=row == len(panels) - 1)
        figure.suptitle(_title(drive, plan), x=0.02, y=0.988, ha="left", fontsize=9, parse_math=False)
        figure.savefig(path, dpi=dpi)


def borders(road: Road, points: int = _POINTS) -> tuple[Floats, Floats]:
    """Right and left edge of `road`, (n, 2) each, m."""
    s = np.linspace(0.0, road.length, min(max(int(road.length), 100), points) + 1)
    reference = road.reference
    right, left = road.corridor("road").borders(s)
    place, normal = reference.position(s), reference.normal(s)
    return place + right[:, None] * normal, place + left[:, None] * normal


def event_places(drive: Drive) -> list[tuple[int, str]]:
    """Row of the log and words of everything that happened."""
    t = drive["t_s"]
    return [(min(int(np.searchsorted(t, at)), len(t) - 1), event_words(event)) for at, event in drive.happened]


def _title(drive: Drive, plan: Plan | None) -> str:
    how = ", ".join(str(drive.options[key]) for key in ("follower", "allocator") if key in drive.options)
    energy, planned = drive.drive_energy, planned_energy(drive, plan)
    more = f" ({100.0 * (energy / planned - 1.0):+z.1f} %)" if planned > 0.0 else f" (planned {planned / KWH:z.4f} kWh)"
    return (
        f"{drive.trajectory.name}, {drive.vehicle.name}{': ' + how if how else ''}; {OUTCOMES.get(drive.outcome, drive.outcome).split(':')[0]}\n"
        f"{drive.journey_time:z.1f} s (planned {planned_time(drive):z.1f} s), {energy / KWH:z.4f} kWh{more} for the drives, "
        f"offset {100.0 * drive.offset_rms:z.1f} cm rms, {100.0 * drive.offset_max:z.1f} cm at most"
    )


def _finish(axes: Axes, drive: Drive, *, first: bool, last: bool) -> None:
    """What all panels over the way share; events as lines, with their numbers above the first."""
    axes.grid(True, linewidth=0.3, color="#cccccc")
    axes.set_axisbelow(True)
    line, way = drive.trajectory, drive["s_m"]
    axes.set_xlim(0.0, max(line.length, float(way[-1] - line.s[0])))
    axes.yaxis.set_label_coords(-0.12, 0.5)
    axes.locator_params(axis="y", nbins=4)
    for number, (row, _) in enumerate(event_places(drive), start=1):
        at = float(way[row] - line.s[0])
        axes.axvline(at, color=EVENT, linewidth=0.8, zorder=1)
        if first:
            axes.annotate(str(number), (at, 1.0), xycoords=("data", "axes fraction"), xytext=(0, 1), textcoords="offset points",
                          ha="center", va="bottom", color=EVENT, fontsize=7)  # fmt: skip
    axes.tick_params(labelbottom=last)
    if last:
        axes.set_xlabel("station on the trajectory in m")


def _draw_map(figure: Figure, place: list[float], drive: Drive, edges: Sequence[Floats]) -> None:
    axes = figure.add_axes((place[0], place[1], place[2], place[3]))
    for edge in edges:
        axes.plot(*edge.T, color=BOUND, linewidth=0.4, zorder=1)
    # rows at equal distances, not at equal times
    way = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(drive["x_m"]), np.diff(drive["y_m"])))))
    keep = np.unique(np.searchsorted(way, np.linspace(0.0, way[-1], _POINTS)).clip(0, len(way) - 1))
    points, v = np.column_stack([drive["x_m"], drive["y_m"]])[keep], KMH * np.hypot(drive["v_x_mps"], drive["v_y_mps"])[keep]
    pieces = LineCollection(list(np.stack([points[:-1], points[1:]], axis=1)), array=0.5 * (v[1:] + v[:-1]), cmap="viridis", linewidths=2.0, zorder=2)
    pieces.set_capstyle("round")
    axes.add_collection(pieces)
    axes.plot(*points[0], marker="o", markersize=4, color=BORDER, zorder=3)
    axes.annotate("start", tuple(points[0].tolist()), textcoords="offset points", xytext=(0, 6), ha="center", fontsize=7)
    _mark_events(axes, drive)
    worst = _worst(drive)
    axes.plot(drive["x_m"][worst], drive["y_m"][worst], marker="s", markersize=8, markerfacecolor="none", markeredgecolor=BORDER, zorder=5)
    axes.set_aspect("equal", adjustable="datalim")
    axes.autoscale_view()
    axes.locator_params(nbins=6)
    axes.set_xlabel("x in m", labelpad=1)
    axes.set_ylabel("y in m")
    axes.yaxis.set_label_coords(-0.125, 0.5)
    bar = figure.colorbar(pieces, cax=figure.add_axes((place[0] + 0.10, place[1] - 0.052, place[2] - 0.10, 0.008)), orientation="horizontal")
    bar.ax.text(-0.03, 0.5, "speed in km/h", transform=bar.ax.transAxes, ha="right", va="center", fontsize=7)
    bar.ax.tick_params(pad=1, length=2)


def _mark_events(axes: Axes, drive: Drive) -> None:
    for number, (row, words) in enumerate(event_places(drive), start=1):
        label = f"{number}  {words}" if number <= _NAMED else ""
        axes.plot(drive["x_m"][row], drive["y_m"][row], marker="X", markersize=6, color=EVENT, markeredgecolor="white", markeredgewidth=0.5,
                  linestyle="none", zorder=4, label=label)  # fmt: skip
    if drive.happened:
        axes.legend(loc="best", frameon=False, handletextpad=0.2)


def _worst(drive: Drive) -> int:
    """The row at which the car is farthest from the trajectory."""
    return int(np.argmax(np.abs(drive["e_y_m"])))


def _draw_worst(axes: Axes, drive: Drive, edges: Sequence[Floats]) -> None:
    """The line driven and the line planned about the place of the largest offset."""
    worst = _worst(drive)
    centre = np.array([drive["x_m"][worst], drive["y_m"][worst]])
    line, fine = drive.trajectory, np.linspace(drive.trajectory.s[0], drive.trajectory.s[-1], max(int(2.0 * drive.trajectory.length), 100))
    planned = line.at(fine)
    for edge in edges:
        axes.plot(*_near(edge, centre).T, color=BORDER, linewidth=0.7, zorder=1)
    axes.plot(*_near(np.column_stack([planned.x, planned.y]), centre).T, color=BASELINE, linewidth=1.6, zorder=2)
    axes.plot(*_near(np.column_stack([drive["x_m"], drive["y_m"]]), centre).T, color=PLAN, linewidth=0.9, zorder=3)
    axes.plot(*centre, marker="s", markersize=8, markerfacecolor="none", markeredgecolor=BORDER, zorder=4)
    # both limits in the ratio of the panel, so that nothing is left for an automatic aspect to change
    across = _REACH * _SIZE[0] * axes.get_position().width / (_SIZE[1] * axes.get_position().height)
    axes.set_xlim(centre[0] - across, centre[0] + across)
    axes.set_ylim(centre[1] - _REACH, centre[1] + _REACH)
    axes.locator_params(nbins=5)
    axes.set_xlabel("x in m", labelpad=1)
    axes.set_ylabel("y in m")
    axes.yaxis.set_label_coords(-0.125, 0.5)
    at = drive["s_m"][worst] - line.s[0]
    axes.set_title(f"largest offset (square in the map), {100.0 * drive.offset_max:z.1f} cm at {at:z.0f} m", pad=3)


def _near(points: Floats, centre: Floats) -> Floats:
    """`points` about `centre`, with a gap in the line where it leaves."""
    away = np.max(np.abs(points - centre), axis=1) > 4.0 * _REACH
    return np.where(away[:, None], np.nan, points)


def _draw_account(axes: Axes, drive: Drive, plan: Plan | None) -> None:
    rows = [row for row in account(drive, plan) if max(abs(row.plan), abs(row.drive)) > 3e-3 * max(abs(drive.drive_energy), 1.0)][::-1]
    place = np.arange(len(rows))
    scale = 1e3 / KWH
    axes.barh(place + 0.19, [scale * row.plan for row in rows], 0.36, color=BASELINE, label="quasi-static plan")
    axes.barh(place - 0.19, [scale * row.drive for row in rows], 0.36, color=PLAN, label="drive")
    axes.set_yticks(place, [row.name for row in rows])
    axes.tick_params(axis="y", length=0)
    axes.axvline(0.0, color=BORDER, linewidth=0.5)
    axes.grid(True, axis="x", linewidth=0.3, color="#cccccc")
    axes.set_axisbelow(True)
    axes.margins(x=0.08)
    axes.set_xlabel("energy of the drives in Wh", labelpad=1)
    axes.legend(loc="best", frameon=False)


def _draw_speed(axes: Axes, drive: Drive, s: Floats) -> None:
    line = drive.trajectory
    axes.plot(line.s - line.s[0], KMH * line.v, color=BASELINE, linewidth=1.6, label="planned")
    axes.plot(s, KMH * drive["v_x_mps"], color=PLAN, linewidth=0.9, label="driven")
    axes.set_ylabel("speed\nin km/h")
    top = 1.06 * KMH * max(float(np.max(line.v)), float(np.max(drive["v_x_mps"])))
    axes.set_ylim(-0.04 * top, top)
    axes.legend(loc="lower center", frameon=False, ncols=2)


def _draw_offset(axes: Axes, drive: Drive, s: Floats) -> None:
    large = drive.offset_max >= 1.0
    axes.plot(s, (1.0 if large else 100.0) * drive["e_y_m"], color=PLAN, linewidth=0.9)
    axes.set_ylabel(f"offset\nin {'m' if large else 'cm'}", color=PLAN)
    _both_ways(axes)
    beside = _beside(axes, "heading in mrad")
    beside.plot(s, 1e3 * drive["e_psi_rad"], color=BASELINE, linewidth=0.7)
    _both_ways(beside)


def _draw_ahead(axes: Axes, drive: Drive, s: Floats) -> None:
    axes.plot(s, drive["a_ref_mps2"], color=BASELINE, linewidth=1.6)
    axes.plot(s, drive["a_x_mps2"], color=PLAN, linewidth=0.7)
    axes.set_ylabel("acceleration\nin m/s²")


def _draw_aside(axes: Axes, drive: Drive, s: Floats) -> None:
    axes.plot(s, drive["kappa_ref_1pm"] * drive["v_ref_mps"] ** 2, color=BASELINE, linewidth=1.6)
    axes.plot(s, drive["a_y_mps2"], color=PLAN, linewidth=0.7)
    axes.set_ylabel("to the left\nin m/s²")


def _draw_torques(axes: Axes, drive: Drive, s: Floats) -> None:
    track = DoubleTrack(drive.vehicle)
    torques = track.drive_torques({f"torque_{name}": drive[f"torque_{name}_nm"] for name in track.motors})
    for name, torque, colour, width in zip(WHEELS, torques, WHEEL_COLOURS, _WIDTHS, strict=True):
        if np.ndim(torque):
            axes.plot(s, torque, color=colour, linewidth=width, label=name.upper())
    brakes = sum(drive[f"clamp_{name}_nm"] for name in WHEELS)
    if np.max(brakes) > 1.0:
        axes.plot(s, np.where(brakes > 1.0, -brakes, np.nan), color=BORDER, linewidth=0.9, label="all brakes")
    axes.set_ylabel("wheel torque\nin Nm")
    _legend_above(axes)


def _draw_steering(axes: Axes, drive: Drive, s: Floats) -> None:
    for name, colour, width in zip(WHEELS, WHEEL_COLOURS, _WIDTHS, strict=True):
        if f"delta_{name}_rad" in drive.columns:
            axes.plot(s, np.degrees(drive[f"delta_{name}_rad"]), color=colour, linewidth=width, label=name.upper())
    axes.set_ylabel("steering\nin °")
    _legend_above(axes)


def _draw_power(axes: Axes, drive: Drive, s: Floats) -> None:
    axes.plot(s, drive["battery_power_w"] / 1e3, color=PLAN, linewidth=0.7)
    axes.set_ylabel("battery\nin kW", color=PLAN)
    beside = _beside(axes, "charge in %")
    beside.plot(s, 100.0 * drive["soc"], color=BASELINE, linewidth=1.2)


def _beside(axes: Axes, label: str) -> Axes:
    """A second scale to the right."""
    other: Any = axes.twinx()
    other.set_ylabel(label, color=BASELINE)
    other.locator_params(axis="y", nbins=4)
    other.yaxis.set_label_coords(1.115, 0.5)
    other.ticklabel_format(axis="y", useOffset=False)
    return other


def _both_ways(axes: Axes) -> None:
    """Zero in the middle, so that both scales of a panel share it."""
    most = max(*(abs(value) for value in axes.get_ylim()), 1e-9)
    axes.set_ylim(-most, most)


def _legend_above(axes: Axes) -> None:
    """Room above the curves for the legend."""
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.35 * (high - low))
    axes.legend(loc="upper center", frameon=False, ncols=5, handlelength=1.2, columnspacing=1.2)
