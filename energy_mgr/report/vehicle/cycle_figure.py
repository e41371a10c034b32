"""The figure of a drive cycle: speed, power at the battery and charge over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from powertrain import KWH

from ..style import BASELINE, BORDER, BOUND, KMH, PLAN, STYLE

if TYPE_CHECKING:
    from os import PathLike

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from powertrain import Vehicle
    from powertrain.energy.cycle_charge import ChargeLedger

    Floats = NDArray[np.float64]

#: From how many seconds on the axis is in minutes, and in hours.
_MINUTES, _HOURS = 600.0, 7200.0


def draw_cycle(vehicle: Vehicle, name: str, ledger: ChargeLedger, path: str | PathLike[str], *, dpi: int = 200) -> None:
    """Draw the cycle named `name`, driven by `vehicle`, into the picture file `path` (PNG, PDF or SVG by suffix)."""
    unit, scale = _unit(float(ledger.time[-1]))
    time = ledger.time / scale
    with rc_context(STYLE):
        figure = Figure(figsize=(9.0, 4.8))
        FigureCanvasAgg(figure)
        grid = figure.add_gridspec(3, 1, left=0.075, right=0.985, bottom=0.095, top=0.9, hspace=0.12)
        for row, draw in enumerate((_draw_speed, _draw_power, _draw_charge)):
            axes = figure.add_subplot(grid[row])
            draw(axes, time, ledger)
            axes.grid(True, linewidth=0.3, color="#cccccc")
            axes.set_axisbelow(True)
            axes.set_xlim(0.0, float(time[-1]))
            axes.yaxis.set_label_coords(-0.045, 0.5)
            axes.locator_params(axis="y", nbins=5, steps=[1, 2, 5, 10])
            if row == 0:
                axes.set_title(_title(vehicle, name, ledger), loc="left", parse_math=False)
            axes.tick_params(labelbottom=row == 2)
            if row == 2:
                axes.set_xlabel(f"time in {unit}")
        figure.savefig(path, dpi=dpi)


def _unit(duration: float) -> tuple[str, float]:
    return ("h", 3600.0) if duration >= _HOURS else ("min", 60.0) if duration >= _MINUTES else ("s", 1.0)


def _title(vehicle: Vehicle, name: str, ledger: ChargeLedger) -> str:
    way = float(ledger.distance[-1])
    consumption = f", {(ledger.energy + ledger.unserved) / KWH / way * 1e5:z.1f} kWh/100 km at the battery" if way > 0.0 else ""
    times = f"{ledger.cycles:z.1f} times " if ledger.cycles > 1.01 else ""
    return f"{vehicle.name}\n{times}{name}: {way / 1e3:z.1f} km{consumption}"


def _draw_speed(axes: Axes, time: Floats, ledger: ChargeLedger) -> None:
    axes.plot(time, KMH * ledger.speed, color=PLAN, linewidth=_width(ledger))
    axes.set_ylabel("speed\nin km/h")
    axes.set_ylim(0.0, 1.06 * KMH * float(np.max(ledger.speed)) + 1e-3)


def _draw_power(axes: Axes, time: Floats, ledger: ChargeLedger) -> None:
    power = np.append(ledger.power, ledger.power[-1:] if len(ledger.power) else 0.0) / 1e3
    for half, colour, label in ((np.maximum(power, 0.0), PLAN, "drawn"), (np.minimum(power, 0.0), BASELINE, "recuperated")):
        axes.fill_between(time, half, step="post", color=colour, linewidth=0.2, label=label)
    axes.axhline(0.0, color=BORDER, linewidth=0.5)
    low, high = float(np.min(power)), float(np.max(power))
    # room above the curves for the legend
    axes.set_ylim(1.1 * low - 1e-3, high + 0.32 * (high - low) + 1e-3)
    axes.set_ylabel("battery power\nin kW")
    axes.legend(loc="upper left", frameon=False, ncols=2)


def _draw_charge(axes: Axes, time: Floats, ledger: ChargeLedger) -> None:
    soc = 100.0 * ledger.soc
    axes.plot(time, soc, color=PLAN, linewidth=1.4)
    empty = ledger.shortage is not None and ledger.end == "soc"
    for event, words in ((ledger.refusal, "first recuperation refused"), (ledger.shortage, "empty" if empty else "first power not met")):
        if event is not None:
            at = float(event.time / ledger.time[-1] * time[-1])
            axes.axvline(at, color=BOUND, linewidth=0.8, linestyle="--")
            late = at > 0.5 * time[-1]  # charge falls: the corners above its end and below its beginning are free
            axes.annotate(
                words, (at, 0.93 if late else 0.07), xycoords=("data", "axes fraction"), xytext=(-4 if late else 4, 0), textcoords="offset points",
                ha="right" if late else "left", va="top" if late else "bottom", color=BORDER, fontsize=7,
            )  # fmt: skip
    middle, half = 0.5 * (np.max(soc) + np.min(soc)), max(0.56 * float(np.ptp(soc)), 0.25)
    axes.set_ylim(middle - half, middle + half)
    axes.set_ylabel("charge\nin %")


def _width(ledger: ChargeLedger) -> float:
    return 1.0 if len(ledger.time) < 4000 else 0.4
