"""The figure of a plan: map, sharpest bend, and speed, acceleration, curvature and power over the way."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

if TYPE_CHECKING:
    from os import PathLike

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from ..planning import Plan

    Floats = NDArray[np.float64]

#: Colours that stay apart in grey and for colour-blind readers (Okabe and Ito).
PLAN, BASELINE, BOUND, BORDER = "#0072B2", "#D55E00", "#999999", "#333333"
STYLE: dict[Any, Any] = {"font.size": 8, "axes.titlesize": 8, "axes.labelsize": 8, "legend.fontsize": 7, "xtick.labelsize": 7, "ytick.labelsize": 7}
KMH = 3.6


def draw_plan(plan: Plan, path: str | PathLike[str], *, dpi: int = 200) -> None:
    """Draw `plan` into the picture file `path` (PNG, PDF or SVG by suffix)."""
    with rc_context(STYLE):
        figure = Figure(figsize=(9.0, 5.6))
        FigureCanvasAgg(figure)
        # fixed margins: the automatic layout would draw everything twice
        left = figure.add_gridspec(2, 1, left=0.065, right=0.43, bottom=0.08, top=0.955, hspace=0.34)
        right = figure.add_gridspec(4, 1, left=0.53, right=0.985, bottom=0.08, top=0.955, hspace=0.12)
        _draw_map(figure.add_subplot(left[0]), plan)
        _draw_bend(figure.add_subplot(left[1]), plan)
        panels = (_draw_speed, _draw_acceleration, _draw_curvature, _draw_power)
        for row, draw in enumerate(panels):
            axes = figure.add_subplot(right[row])
            draw(axes, plan)
            axes.grid(True, linewidth=0.3, color="#cccccc")
            axes.set_xlim(0.0, max(plan.chosen.profile.s[-1], plan.baseline.profile.s[-1]))
            axes.yaxis.set_label_coords(-0.1, 0.5)
            axes.locator_params(nbins=5)
            if row < len(panels) - 1:
                axes.tick_params(labelbottom=False)
            else:
                axes.set_xlabel("station on the path in m")

        if str(path).endswith(".png"):
            figure.savefig(path, dpi=dpi, pil_kwargs={"compress_level": 3})
        else:
            figure.savefig(path, dpi=dpi)


def _edges(plan: Plan, s: Floats) -> tuple[Floats, Floats]:
    reference = plan.road.reference
    right, left = plan.road.corridor("road").borders(s)
    points, normal = reference.position(s), reference.normal(s)
    return points + right[:, None] * normal, points + left[:, None] * normal


def _stations(length: float, step: float) -> Floats:
    return np.linspace(0.0, length, max(int(length / step), 20) + 1)


def _draw_lines(axes: Axes, plan: Plan, road_s: Floats, width: float) -> None:
    for edge in _edges(plan, road_s):
        axes.plot(*edge.T, color=BORDER, linewidth=0.6, zorder=1)
    for run, colour, style, label in ((plan.baseline, BASELINE, (0, (4, 2)), "lane centre"), (plan.chosen, PLAN, "-", "plan")):
        knots = run.path.knot_road_s
        s = np.interp(road_s, knots, run.path.knot_s)
        axes.plot(*run.path.curve.position(s).T, color=colour, linestyle=style, linewidth=width, label=label, zorder=2)
    axes.set_aspect("equal", adjustable="datalim")


def _draw_map(axes: Axes, plan: Plan) -> None:
    _draw_lines(axes, plan, _stations(plan.road.length, plan.road.length / 4000.0), 0.9)
    start = plan.chosen.path.curve.position(0.0)
    axes.plot(*start, marker="o", markersize=4, color=PLAN, zorder=3)
    axes.annotate("start", (float(start[0]), float(start[1])), textcoords="offset points", xytext=(0, 6), ha="center", fontsize=7)
    place = plan.chosen.path.curve.position(_sharpest(plan)[1])
    axes.plot(*place, marker="s", markersize=9, markerfacecolor="none", markeredgecolor=BORDER, markeredgewidth=0.8, zorder=3)
    axes.set_title(f"{plan.road.name}, {plan.road.length / 1000.0:.2f} km")
    axes.set_xlabel("x in m")
    axes.set_ylabel("y in m")
    axes.legend(loc="upper right", frameon=False)


def _sharpest(plan: Plan) -> tuple[float, float]:
    """Station on the road and on the path where the baseline bends most."""
    s = _stations(plan.road.length, 1.0)
    knots = plan.baseline.path.knot_road_s
    kappa = plan.baseline.path.curve.curvature(np.interp(s, knots, plan.baseline.path.knot_s))
    at = float(s[np.argmax(np.abs(kappa))])
    return at, float(np.interp(at, plan.chosen.path.knot_road_s, plan.chosen.path.knot_s))


def _draw_bend(axes: Axes, plan: Plan) -> None:
    at = _sharpest(plan)[0]
    reach = min(60.0, 0.5 * plan.road.length)
    around = np.linspace(at - reach, at + reach, 400)
    around = np.unique(np.mod(around, plan.road.length)) if plan.road.closed else np.unique(np.clip(around, 0.0, plan.road.length))
    pieces = np.split(around, np.flatnonzero(np.diff(around) > 5.0) + 1)
    for piece in pieces:
        _draw_lines(axes, plan, piece, 1.4)
    axes.set_title(f"sharpest bend (square in the map), at {at:.0f} m")
    axes.set_xlabel("x in m")
    axes.set_ylabel("y in m")


def _both(axes: Axes, plan: Plan, values: Any, unit: str, **kwargs: Any) -> None:
    for run, colour, label, layer in ((plan.baseline, BASELINE, "baseline", 2), (plan.chosen, PLAN, "plan", 3)):
        axes.plot(run.profile.s, values(run), color=colour, linewidth=1.0, label=label, zorder=layer, **kwargs)
    axes.set_ylabel(unit)


def _draw_speed(axes: Axes, plan: Plan) -> None:
    axes.plot(plan.chosen.limits.s, KMH * plan.chosen.limits.v_max, color=BOUND, linewidth=0.7, label="limit on the plan's path", zorder=1)
    _both(axes, plan, lambda run: KMH * run.profile.v, "speed\nin km/h")
    saved = plan.saving_percent
    change = f"{saved:.1f} % less energy" if saved is not None else f"{plan.baseline.energy_kwh - plan.energy_kwh:.4f} kWh less"
    axes.set_title(f"{plan.journey_time:.1f} s, {plan.energy_kwh:.4f} kWh: {change} than the baseline ({plan.baseline.journey_time:.1f} s)")
    # room below the curves for the legend
    top = KMH * max(float(np.max(run.profile.v)) for run in (plan.chosen, plan.baseline))
    top = max(top, KMH * float(np.max(plan.chosen.limits.v_max)))
    axes.set_ylim(-0.28 * top, 1.06 * top)
    axes.legend(loc="lower center", ncols=3, frameon=False)


def _draw_acceleration(axes: Axes, plan: Plan) -> None:
    _both(axes, plan, lambda run: np.append(run.profile.acceleration, run.profile.acceleration[-1]), "acceleration\nin m/s²", drawstyle="steps-post")


def _draw_curvature(axes: Axes, plan: Plan) -> None:
    _both(axes, plan, lambda run: run.path.curve.curvature(run.profile.s), "curvature\nin 1/m")


def _draw_power(axes: Axes, plan: Plan) -> None:
    _both(axes, plan, lambda run: np.append(run.ledger.power, run.ledger.power[-1]) / 1000.0, "battery power\nin kW", drawstyle="steps-post")
