"""What a film of a drive shows: still things, drawn once, and those that move, frame by frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from powertrain.chassis.double_track import WHEELS, DoubleTrack

from ..style import BASELINE, BORDER, BOUND, KMH, PLAN
from .figure import EVENT, WHEEL_COLOURS, borders
from .table import event_words

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D
    from numpy.typing import NDArray

    from powertrain.chassis.wheel import Wheel
    from roads import Road

    from ...simulation import Drive

    Floats = NDArray[np.float64]

#: 720 by 432 pixels; both even, as films need it.
DPI, _SIZE = 90, (8.0, 4.8)
#: Half of what is seen of the way and beside it, m.
_AHEAD, _ASIDE = 7.5, 6.8
#: Distance of the dots on the planned line, m.
_DOTS = 2.0
#: Body beyond the axles, over the wheelbase; half widths of a wheel's tread, m.
_OVERHANG, _TREAD = 0.22, 0.1
#: Length of the longest arrow, m.
_ARROW = 4.5


#: Every colour of a scene; what lies between them and white is what smooth edges need.
COLOURS = ("#000000", BORDER, BOUND, PLAN, BASELINE, EVENT, *WHEEL_COLOURS)


class Scene:
    """The figure of a film and how it moves.

    Attributes:
        figure: what is seen.
        moving: what changes from frame to frame.
        count: of frames.
    """

    def __init__(self, drive: Drive, wheels: list[Wheel], rows: NDArray[np.intp], rate: float, road: Road | None) -> None:
        """The film of `rows` of the log, `rate` times as fast as the drive was, with the `wheels` at these rows."""
        self.drive, self.rows, self.count, self.rate = drive, rows, len(rows), rate
        self.figure = Figure(figsize=_SIZE, dpi=DPI)
        self.moving: list[Artist] = []
        self._events = sorted(drive.happened, key=lambda item: item[0])
        self._forces = np.array([[wheel.body_x, wheel.body_y] for wheel in wheels])
        self._lines = self._world(road)
        self._draw_view()
        self._draw_map(road)
        self._draw_speed()
        self._draw_power()

    def show(self, k: int) -> None:
        """Move everything to frame `k`."""
        row, drive = int(self.rows[k]), self.drive
        x, y, psi = (float(drive[name][row]) for name in ("x_m", "y_m", "psi_rad"))
        for points, line in self._lines:
            line.set_data(*_seen(points, x, y, psi))
        for name, tread, corners, centre in self._treads:
            angle = float(drive[f"delta_{name}_rad"][row]) if f"delta_{name}_rad" in drive.columns else 0.0
            tread.set_xy(_turned(corners, angle) + centre)
        forces = self._forces[:, :, k]
        self._arrows.set_UVC(-forces[:, 1], forces[:, 0])
        for dot, across, up in self._dots:
            dot.set_data([across[row]], [up[row]])
        t = float(drive["t_s"][row])
        faster = "" if abs(self.rate - 1.0) < 0.05 else f"   ({self.rate:.2g}×)"
        self._clock.set_text(f"{t:z7.2f} s   {KMH * drive['v_x_mps'][row]:z5.1f} km/h{faster}")
        begun = sum(at <= t for at, _ in self._events)
        self._event.set_text(event_words(self._events[begun - 1][1]) if begun else "")

    def _world(self, road: Road | None) -> list[tuple[Floats, Line2D]]:
        """Lines of the world, which move past the car."""
        view = self._view = self.figure.add_axes((0.02, 0.03, 0.46, 0.88))
        planned = self.drive.trajectory
        dots = planned.at(np.arange(planned.s[0], planned.s[-1], _DOTS))
        fine = planned.at(np.linspace(planned.s[0], planned.s[-1], max(int(2.0 * planned.length), 100)))
        lines = [
            (np.column_stack([fine.x, fine.y]), view.plot([], [], color=BASELINE, linewidth=0.8)[0]),
            (np.column_stack([dots.x, dots.y]), view.plot([], [], color=BASELINE, linestyle="none", marker="o", markersize=2.5)[0]),
        ]
        if road is not None:
            lines += [(edge, view.plot([], [], color=BORDER, linewidth=1.2)[0]) for edge in borders(road, 50_000)]
        self.moving += [line for _, line in lines]
        return lines

    def _draw_view(self) -> None:
        view, body = self._view, DoubleTrack(self.drive.vehicle).body
        view.set_aspect("equal")
        view.set_xlim(-_ASIDE, _ASIDE)
        view.set_ylim(-_AHEAD, _AHEAD)
        view.set_xticks([])
        view.set_yticks([])
        over, half = _OVERHANG * body.wheelbase_m, 0.5 * self.drive.vehicle.chassis.width_m
        front, rear = body.front_axle_m + over, -body.rear_axle_m - over
        outline = [(-half, rear), (half, rear), (half, front - 0.5), (0.6 * half, front), (-0.6 * half, front), (-half, front - 0.5)]
        self.moving.append(view.add_patch(Polygon(outline, closed=True, facecolor="#e8e8e8", edgecolor=BORDER, linewidth=0.8, zorder=3)))
        radius = self.drive.vehicle.chassis.wheel_radius_m
        corners = np.array([(-_TREAD, -radius), (_TREAD, -radius), (_TREAD, radius), (-_TREAD, radius)])
        self._treads = []
        for name, x, y in zip(WHEELS, body.wheel_x, body.wheel_y, strict=True):
            tread = view.add_patch(Polygon(corners, closed=True, color=BORDER, linewidth=0.0, zorder=4))
            self._treads.append((name, tread, corners, np.array([-y, x])))
            self.moving.append(tread)
        most = max(float(np.max(np.hypot(self._forces[:, 0], self._forces[:, 1]))), 1.0)
        # the roundest force of at most two thirds of the longest arrow
        kilo = max((size for size in (10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0) if size <= most / 1.5), default=10.0)
        self._arrows = view.quiver(
            [-y for y in body.wheel_y], body.wheel_x, [0.0] * 4, [0.0] * 4, color=list(WHEEL_COLOURS), angles="xy", scale_units="xy",
            scale=most / _ARROW, width=0.011, zorder=5,
        )  # fmt: skip
        view.quiverkey(self._arrows, 0.14, 0.04, kilo, f"{kilo / 1000.0:g} kN", labelpos="E", coordinates="axes", color=BORDER)
        self._clock = view.text(0.5, 1.02, "", transform=view.transAxes, ha="center", va="bottom", fontsize=9, family="monospace")
        self._event = view.text(0.03, 0.97, "", transform=view.transAxes, va="top", fontsize=8, color=EVENT, weight="bold", zorder=10)
        self._event.set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 1.0})
        self.moving += [self._arrows, self._clock, self._event]
        self._dots: list[tuple[Line2D, Floats, Floats]] = []

    def _draw_map(self, road: Road | None) -> None:
        axes = self.figure.add_axes((0.54, 0.56, 0.44, 0.41))
        for edge in () if road is None else borders(road):
            axes.plot(*edge.T, color=BOUND, linewidth=0.5)
        axes.plot(self.drive.trajectory.x, self.drive.trajectory.y, color=BASELINE, linewidth=1.0)
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_xticks([])
        axes.set_yticks([])
        for side in axes.spines.values():
            side.set_visible(False)
        self._follow(axes, self.drive["x_m"], self.drive["y_m"])

    def _draw_speed(self) -> None:
        drive, line = self.drive, self.drive.trajectory
        axes = self.figure.add_axes((0.59, 0.34, 0.39, 0.18))
        way = drive["s_m"] - line.s[0]
        axes.plot(line.s - line.s[0], KMH * line.v, color=BASELINE, linewidth=1.6, label="planned")
        axes.plot(way, KMH * drive["v_x_mps"], color=PLAN, linewidth=0.8, label="driven")
        axes.legend(loc="lower center", frameon=False, ncols=2)
        axes.set_ylabel("km/h")
        axes.set_xlabel("station in m", labelpad=0)
        self._panel(axes, way, KMH * drive["v_x_mps"])

    def _draw_power(self) -> None:
        drive = self.drive
        axes = self.figure.add_axes((0.59, 0.1, 0.39, 0.13))
        axes.plot(drive["t_s"], drive["battery_power_w"] / 1e3, color=PLAN, linewidth=0.7)
        axes.set_ylabel("battery kW")
        axes.set_xlabel("time in s", labelpad=0)
        self._panel(axes, drive["t_s"], drive["battery_power_w"] / 1e3)

    def _panel(self, axes: Axes, across: Floats, up: Floats) -> None:
        axes.grid(True, linewidth=0.3, color="#cccccc")
        axes.margins(x=0.01)
        axes.yaxis.set_label_coords(-0.11, 0.5)
        axes.locator_params(axis="y", nbins=4)
        self._follow(axes, across, up)

    def _follow(self, axes: Axes, across: Floats, up: Floats) -> None:
        """A dot that goes along a curve."""
        dot = axes.plot([], [], marker="o", markersize=5, color=PLAN, markeredgecolor="white", markeredgewidth=0.6, linestyle="none", zorder=9)[0]
        self._dots.append((dot, across, up))
        self.moving.append(dot)


def _seen(points: Floats, x: float, y: float, psi: float) -> tuple[Floats, Floats]:
    """Points of the world as seen from the car, ahead being up; with gaps where they are out of sight."""
    dx, dy = points[:, 0] - x, points[:, 1] - y
    away = np.maximum(np.abs(dx), np.abs(dy)) > 2.0 * _AHEAD
    ahead, left = dx * np.cos(psi) + dy * np.sin(psi), -dx * np.sin(psi) + dy * np.cos(psi)
    return np.where(away, np.nan, -left), np.where(away, np.nan, ahead)


def _turned(corners: Floats, angle: float) -> Floats:
    cos, sin = np.cos(angle), np.sin(angle)
    return corners @ np.array([[cos, sin], [-sin, cos]])
