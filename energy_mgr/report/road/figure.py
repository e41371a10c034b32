"""The figure of a road or a network: map with edges and lanes; height, curvature and speed limit over the way."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from ..style import BASELINE, BORDER, BOUND, KMH, PLAN, STYLE

if TYPE_CHECKING:
    from os import PathLike

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from roads import Network, Road

    Floats = NDArray[np.float64]

#: No map needs more points than this to look smooth.
MOST_POINTS = 6000


def draw_road(road: Road, path: str | PathLike[str], *, dpi: int = 200) -> None:
    """Draw `road` into the picture file `path` (PNG, PDF or SVG by suffix)."""
    with rc_context(STYLE):
        figure = Figure(figsize=(9.0, 4.8))
        FigureCanvasAgg(figure)
        left = figure.add_gridspec(1, 1, left=0.07, right=0.5, bottom=0.1, top=0.92)
        right = figure.add_gridspec(3, 1, left=0.6, right=0.985, bottom=0.1, top=0.92, hspace=0.14)
        _draw_map(figure.add_subplot(left[0]), road)
        s = np.linspace(0.0, road.length, min(max(int(road.length), 200), MOST_POINTS))
        for row, draw in enumerate((_draw_height, _draw_curvature, _draw_limit)):
            axes = figure.add_subplot(right[row])
            draw(axes, road, s)
            axes.grid(True, linewidth=0.3, color="#cccccc")
            axes.set_xlim(0.0, road.length)
            axes.yaxis.set_label_coords(-0.13, 0.5)
            axes.locator_params(axis="y", nbins=5)
            if row < 2:
                axes.tick_params(labelbottom=False)
            else:
                axes.set_xlabel("station in m")
        figure.savefig(path, dpi=dpi)


def draw_network(network: Network, path: str | PathLike[str], *, dpi: int = 200) -> None:
    """Draw the lanes of `network` with their directions and the ids of its longest roads into the picture file `path`."""
    with rc_context(STYLE):
        figure = Figure(figsize=(9.0, 6.5), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.add_subplot()
        links = list(network.links.values())
        borders = [line[:, :2] for link in links for line in link.borders]
        axes.add_collection(LineCollection(borders, colors=BORDER, linewidths=0.5))
        axes.add_collection(LineCollection([link.centre[:, :2] for link in links], colors=PLAN, linewidths=0.5, linestyles=(0, (4, 3))))
        for link in links:
            middle = len(link.centre) // 2
            before, after = link.centre[max(middle - 1, 0), :2], link.centre[min(middle + 1, len(link.centre) - 1), :2]
            if link.length > 8.0:
                axes.annotate("", tuple(after), tuple(before), arrowprops={"arrowstyle": "->", "color": PLAN, "linewidth": 0.8})
        _label_roads(axes, network)
        axes.set_aspect("equal", adjustable="datalim")
        axes.autoscale_view()
        total = sum(network.lengths.values()) / 1000.0
        axes.set_title(f"{network.name}: {network.format}, {len(network.roads)} roads, {total:z.2f} km, {len(links)} lanes for cars")
        axes.set_xlabel("x in m")
        axes.set_ylabel("y in m")
        figure.savefig(path, dpi=dpi)


def _label_roads(axes: Axes, network: Network) -> None:
    """Ids beside the middle of the longest roads: as many as stay readable."""
    named: set[str] = set()
    low, high = (np.array([reduce(link.centre[:, :2], axis=0) for link in network.links.values()]) for reduce in (np.min, np.max))
    extent = float(np.max(np.max(high, axis=0) - np.min(low, axis=0)))
    wanted = {name for name in sorted(network.roads, key=lambda name: -network.lengths[name])[:40] if network.lengths[name] > 0.06 * extent}
    for link in network.links.values():
        if link.road in wanted and link.road not in named:
            named.add(link.road)
            place = link.centre[len(link.centre) // 2]
            axes.annotate(
                link.road, (float(place[0]), float(place[1])), fontsize=6, color=BASELINE, textcoords="offset points", xytext=(4, 4), clip_on=True
            )


def _line(road: Road, s: Floats, offset: Floats) -> Floats:
    at = np.interp(s, road.s, offset, period=road.length if road.closed else None)
    return road.reference.position(s) + at[:, None] * road.reference.normal(s)


def _draw_map(axes: Axes, road: Road) -> None:
    s = np.linspace(0.0, road.length, min(max(int(2 * road.length), 400), MOST_POINTS))
    for lane in road.lanes:
        there = np.interp(s, road.s, np.isnan(lane.right).astype(float)) == 0.0
        for offset in (lane.right, lane.left):
            line = _line(road, s, np.nan_to_num(offset))
            axes.plot(*np.where(there[:, None], line, np.nan).T, color=BOUND, linewidth=0.5, linestyle=(0, (6, 4)), zorder=1)
    axes.plot(*_line(road, s, road.right).T, color=BORDER, linewidth=0.8, zorder=2, label="edges")
    axes.plot(*_line(road, s, road.left).T, color=BORDER, linewidth=0.8, zorder=2)
    axes.plot(*road.reference.position(s).T, color=PLAN, linewidth=0.7, zorder=3, label="reference")
    start, ahead = road.reference.position(0.0), road.reference.position(min(0.02 * road.length + 1.0, road.length))
    axes.plot(*start, marker="o", markersize=4, color=PLAN, zorder=4)
    axes.annotate("", tuple(ahead), tuple(start), arrowprops={"arrowstyle": "->", "color": PLAN, "linewidth": 1.2}, zorder=4)
    axes.set_aspect("equal", adjustable="datalim")
    kinds = len({(lane.direction, lane.name) for lane in road.lanes})
    axes.set_title(f"{road.name}: {road.length / 1000.0:z.3f} km, {'closed' if road.closed else 'open'}, {kinds} lane{'s' * (kinds != 1)}")
    axes.set_xlabel("x in m")
    axes.set_ylabel("y in m")
    axes.legend(loc="best", frameon=False)


def _draw_height(axes: Axes, road: Road, s: Floats) -> None:
    axes.plot(s, road.height_at(s), color=PLAN, linewidth=1.0)
    axes.set_ylabel("height\nin m")
    if np.ptp(road.height) < 1.0:
        middle = float(np.mean(road.height))
        axes.set_ylim(middle - 1.0, middle + 1.0)
    slope = 100.0 * road.slope_at(s)
    axes.set_title(f"slope {np.min(slope):+z.1f} to {np.max(slope):+z.1f} %, bank up to {np.degrees(np.max(np.abs(road.bank))):z.1f}°")


def _draw_curvature(axes: Axes, road: Road, s: Floats) -> None:
    axes.plot(s, road.reference.curvature(s), color=PLAN, linewidth=0.8)
    axes.set_ylabel("curvature\nin 1/m")


def _draw_limit(axes: Axes, road: Road, s: Floats) -> None:
    limit = KMH * road.speed_limit_at(s)
    if np.any(np.isfinite(limit)):
        axes.plot(s, np.where(np.isfinite(limit), limit, np.nan), color=BASELINE, linewidth=1.2, drawstyle="steps-post")
        axes.set_ylim(0.0, 1.15 * float(np.max(limit[np.isfinite(limit)])))
    else:
        axes.text(0.5, 0.5, "none posted", transform=axes.transAxes, ha="center", va="center", color=BOUND)
        axes.set_yticks([])
    axes.set_ylabel("speed limit\nin km/h")
