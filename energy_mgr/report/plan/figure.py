"""The figure of a plan: map, sharpest bend, and speed, acceleration, curvature and power over the way."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ..style import BASELINE, BORDER, BOUND, PLAN, STYLE
from .picture import PlanPicture

if TYPE_CHECKING:
    from os import PathLike

    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

    from ...planning import Plan
    from .picture import Lines

DASHED: Any = (0, (4, 2))
#: Pixels per inch.
DPI = 200
#: The panels over the way: label, the series' attribute, how its values are joined.
PANELS = (
    ("speed\nin km/h", "speed", "default"),
    ("acceleration\nin m/s²", "acceleration", "steps-post"),
    ("curvature\nin 1/m", "curvature", "default"),
    ("battery power\nin kW", "power", "steps-post"),
)


def draw_plan(plan: Plan, path: str | PathLike[str], *, dpi: int = DPI) -> None:
    """Draw `plan` into the picture file `path` (PNG, PDF or SVG by suffix)."""
    figure = PlanFigure()
    figure.show(PlanPicture.of(plan))
    figure.save(path, dpi=dpi)


class PlanFigure:
    """The figure before it knows its plan.

    Most of the time that a figure takes goes into axes, ticks and glyphs, which are the same for all plans: a process that waits for a plan makes
    them meanwhile (`warm`), and then only exchanges the lines.
    """

    def __init__(self) -> None:
        with rc_context(STYLE):
            self._figure = Figure(figsize=(9.0, 5.6), dpi=DPI)
            FigureCanvasAgg(self._figure)
            # fixed margins: the automatic layout would draw everything twice
            left = self._figure.add_gridspec(2, 1, left=0.065, right=0.43, bottom=0.08, top=0.955, hspace=0.34)
            right = self._figure.add_gridspec(4, 1, left=0.53, right=0.985, bottom=0.08, top=0.955, hspace=0.12)
            self._map, self._bend = (self._from_above(self._figure.add_subplot(left[row])) for row in range(2))
            self._panels = [self._figure.add_subplot(right[row]) for row in range(len(PANELS))]
            self._limit = self._panels[0].plot([], [], color=BOUND, linewidth=0.7, label="limit on the plan's path", zorder=1)[0]
            self._series = [self._panel(*panel) for panel in zip(self._panels, PANELS, strict=True)]
            self._panels[0].legend(loc="lower center", ncols=3, frameon=False)
            self._panels[-1].tick_params(labelbottom=True)
            self._panels[-1].set_xlabel("station on the path in m")
            self._legend()

    def _from_above(self, axes: Axes) -> Axes:
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_xlabel("x in m")
        axes.set_ylabel("y in m")
        return axes

    def _panel(self, axes: Axes, panel: tuple[str, str, str]) -> tuple[Line2D, Line2D]:
        label, _, style = panel
        lines = [
            axes.plot([], [], color=colour, linewidth=1.0, label=name, zorder=layer, drawstyle=style)[0]
            for colour, name, layer in ((BASELINE, "baseline", 2), (PLAN, "plan", 3))
        ]
        axes.set_ylabel(label)
        axes.grid(True, linewidth=0.3, color="#cccccc")
        axes.yaxis.set_label_coords(-0.115, 0.5)
        axes.locator_params(nbins=5)
        axes.tick_params(labelbottom=False)
        return lines[0], lines[1]

    def _legend(self) -> None:
        """The map's legend: its lines come with the plan, so that proxies stand for them."""
        proxies = [self._map.plot([], [], color=colour, linestyle=dashes, linewidth=0.9)[0] for colour, dashes in ((BASELINE, DASHED), (PLAN, "-"))]
        self._map.legend(proxies, ["lane centre", "plan"], loc="upper right", frameon=False)

    def warm(self) -> None:
        """Draw what there is yet into memory: fonts are loaded and ticks made."""
        with rc_context(STYLE):
            self._figure.canvas.draw()

    def show(self, picture: PlanPicture) -> None:
        """Put a plan in; once only."""
        with rc_context(STYLE):
            self._lines(self._map, picture.road, 0.9)
            self._map.plot(*picture.start, marker="o", markersize=4, color=PLAN, zorder=3)
            place = (float(picture.start[0]), float(picture.start[1]))
            self._map.annotate("start", place, textcoords="offset points", xytext=(0, 6), ha="center", fontsize=7)
            self._map.plot(*picture.square, marker="s", markersize=9, markerfacecolor="none", markeredgecolor=BORDER, markeredgewidth=0.8, zorder=3)
            self._map.set_title(picture.map_title)
            for piece in picture.bend:
                self._lines(self._bend, piece, 1.4)
            self._bend.set_title(picture.bend_title)
            self._over_the_way(picture)

    def _lines(self, axes: Axes, lines: Lines, width: float) -> None:
        for border in (lines.right, lines.left):
            axes.plot(*border.T, color=BORDER, linewidth=0.6, zorder=1)
        axes.plot(*lines.baseline.T, color=BASELINE, linestyle=DASHED, linewidth=width, zorder=2)
        axes.plot(*lines.plan.T, color=PLAN, linewidth=width, zorder=2)

    def _over_the_way(self, picture: PlanPicture) -> None:
        self._limit.set_data(picture.limit_s, picture.limit)
        for axes, lines, (_, name, _) in zip(self._panels, self._series, PANELS, strict=True):
            for line, series in zip(lines, (picture.baseline, picture.plan), strict=True):
                line.set_data(series.s, getattr(series, name))
            axes.relim()
            axes.autoscale_view()
            axes.set_xlim(0.0, max(picture.plan.s[-1], picture.baseline.s[-1]))
        # room below the curves for the legend
        top = max(float(values.max()) for values in (picture.plan.speed, picture.baseline.speed, picture.limit))
        self._panels[0].set_ylim(-0.28 * top, 1.06 * top)
        self._panels[0].set_title(picture.title)

    def save(self, path: str | PathLike[str], *, dpi: int = DPI) -> None:
        """Write the picture file `path` (PNG, PDF or SVG by suffix)."""
        # little compression: the last tenth of the size takes half the time
        options: dict[str, Any] = {"pil_kwargs": {"compress_level": 3}} if str(path).endswith(".png") else {}
        with rc_context(STYLE):
            self._figure.savefig(path, dpi=dpi, **options)
