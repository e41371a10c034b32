"""A front of time against energy as text, CSV and figure."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from powertrain import KWH

from ...errors import PlanningError
from ..picture import PICTURES, TABLE, save_picture

if TYPE_CHECKING:
    from os import PathLike

    from ...speed import Front, SpeedLimits

_COLUMNS = ("time_s", "energy_kwh", "later_percent", "less_percent", "price_w", "gap", "top_speed_mps", "status")


def front_table(front: Front, limits: SpeedLimits, length: float) -> str:
    """One line per drive: time, energy, both against the fastest drive, price of a second, proven gap, top speed."""
    lines = [
        f"{limits.name}: {length:z.0f} m of path, {limits.vehicle.name}, {len(limits.s)} stations",
        "",
        f"{'time s':>9}{'energy kWh':>12}{'later %':>9}{'less energy %':>15}{'price W':>11}{'gap':>9}{'top km/h':>10}",
    ]
    for row in _rows(front):
        time, energy, later, less, price, gap, top, _ = row
        shown = f"{less:z15.2f}" if np.isfinite(less) else f"{'-':>15}"
        cost = f"{price:z11.0f}" if np.isfinite(price) else f"{'-':>11}"
        lines.append(f"{time:z9.2f}{energy:z12.5f}{later:z9.2f}{shown}{cost}{gap:9.0e}{3.6 * top:z10.1f}")
    return "\n".join(lines)


def _rows(front: Front) -> list[tuple[float, float, float, float, float, float, float, str]]:
    first_time, first = float(front.journey_time[0]), float(front.energy[0])
    rows = []
    for k, profile in enumerate(front.profiles):
        time, energy = float(front.journey_time[k]), float(front.energy[k])
        less = 100.0 * (1.0 - energy / first) if first > 0.0 else np.nan
        later = 100.0 * (time / first_time - 1.0)
        rows.append((time, energy / KWH, later, less, float(front.price[k]), float(front.gap[k]), float(np.max(profile.v)), profile.status))
    return rows


def refuse_suffix(file: Path) -> None:
    """Raise PlanningError unless `file` is named as a table or a picture."""
    if file.suffix.lower() not in (TABLE, *PICTURES):
        raise PlanningError(f"{file}: unknown kind of file {file.suffix!r}, expected one of {', '.join((TABLE, *PICTURES))}")


def save_front(front: Front, limits: SpeedLimits, file: str | PathLike[str]) -> None:
    """Write the front as a table (`.csv`) or as a figure (`.png`, `.svg`, `.pdf`), whole or not at all.

    Raises:
        PlanningError: another suffix, a place that cannot be written.
    """

    def write(path: Path) -> None:
        lines = [",".join(_COLUMNS), *(",".join(str(value) for value in row) for row in _rows(front))]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")

    file = Path(file)
    refuse_suffix(file)
    if file.suffix.lower() == TABLE:
        save_picture(write, file, kinds=(TABLE,))
    else:
        save_picture(lambda path: draw_front(front, limits, path), file)


def draw_front(front: Front, limits: SpeedLimits, file: str | PathLike[str], *, dpi: int = 200) -> None:
    """Draw energy over time, and some of the speed profiles."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    from ..style import BOUND, STYLE

    with rc_context(STYLE):
        figure = Figure(figsize=(8.0, 3.4), layout="constrained")
        FigureCanvasAgg(figure)
        left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.6))
        chosen = sorted({round(k) for k in np.linspace(0, len(front.profiles) - 1, 4)})
        colours = ["#D55E00", "#009E73", "#0072B2", "#CC79A7"]
        left.plot(front.journey_time, front.energy / KWH, color="#333333", linewidth=1.0, marker=".", markersize=4)
        right.plot(limits.s / 1e3, 3.6 * limits.v_max, color=BOUND, linewidth=0.7, label="limit")
        for k, colour in zip(chosen, colours, strict=False):
            profile = front.profiles[k]
            left.plot(front.journey_time[k], front.energy[k] / KWH, marker="o", markersize=6, color=colour)
            right.plot(profile.s / 1e3, 3.6 * profile.v, color=colour, linewidth=1.0, label=f"{profile.journey_time:z.0f} s")
        left.set_xlabel("journey time in s")
        left.set_ylabel("energy in kWh")
        left.set_title(f"{limits.name}, {limits.vehicle.name}")
        right.set_xlabel("station on the path in km")
        right.set_ylabel("speed in km/h")
        right.set_ylim(bottom=0.0)
        right.legend(ncols=5, frameon=False, loc="lower center")
        for axes in (left, right):
            axes.grid(True, linewidth=0.3, color="#cccccc")
        figure.savefig(file, dpi=dpi)
