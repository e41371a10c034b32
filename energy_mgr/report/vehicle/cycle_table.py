"""A drive cycle of a car as text for a terminal, as columns in a file, and as a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from powertrain import KWH
from powertrain.energy.balance import spoken

from ...errors import PlanningError
from ..picture import PICTURES, save_picture
from ..style import KMH

if TYPE_CHECKING:
    from pathlib import Path

    from powertrain import Vehicle
    from powertrain.energy.cycle_charge import ChargeLedger, Shortfall

#: Columns of the file; power and current are those that hold until the next row.
COLUMNS = ("t_s", "distance_m", "v_mps", "power_w", "current_a", "voltage_v", "soc")
#: What is in the way, for a person.
WORDS = {
    "soc": "the charge at its limit",
    "voltage": "the voltage limit of the cell",
    "current": "the current limit of the cell",
    "power": "more than the battery's resistance lets through",
}


def cycle_table(vehicle: Vehicle, name: str, ledger: ChargeLedger, *, until_empty: bool) -> str:
    """What a cycle named `name` took from the battery and left in it, in some twenty lines."""
    way, time = float(ledger.distance[-1]), float(ledger.time[-1])
    lines = [f"{vehicle.name} on {name}" + (", again and again" if until_empty else "")]
    if way <= 0.0:
        return "\n".join([*lines, f"range          0 km: at {100 * ledger.soc[0]:z.1f} % the battery gives no power ({WORDS[ledger.end]})"])
    lines.append(
        f"driven         {way / 1e3:z.2f} km in {duration(time)}, {KMH * way / time:z.1f} km/h on average, "
        f"up to {KMH * np.max(ledger.speed):z.0f} km/h"
    )
    if ledger.cycle.missed > 0.1:
        lines.append(f"               the car falls behind by up to {KMH * ledger.cycle.missed:z.0f} km/h; energy is told as if it did not")
    per, asked = 1e5 / KWH / way, ledger.energy + ledger.unserved
    lines.append(f"consumption    {asked * per:z.2f} kWh/100 km at the battery's terminals, {asked / KWH:z.3f} kWh in all")
    lines.append(f"{'':18}{'kWh':>9}{'kWh/100 km':>12}{'%':>8}")
    rows = {key: value for key, value in ledger.components.items() if abs(value) > 1e-6 * max(map(abs, ledger.components.values()))}
    lines += [f"  {spoken(key):16}{value / KWH:z9.3f}{value * per:z12.2f}{_percent(value, asked):>8}" for key, value in rows.items()]
    return "\n".join([*lines, *_battery_lines(ledger), *_limit_lines(ledger), _range_line(ledger, until_empty)])


def duration(seconds: float) -> str:
    """`95 s`, `30 min`, `4 h 48 min`."""
    if seconds < 600.0:
        return f"{seconds:z.0f} s"
    minutes = round(seconds / 60.0)
    return f"{minutes} min" if minutes < 120 else f"{minutes // 60} h {minutes % 60:02d} min"


def save_cycle(vehicle: Vehicle, name: str, ledger: ChargeLedger, out: Path) -> None:
    """Write `ledger` to `out`, whole or not at all: columns (.csv) or a picture (.png, .svg, .pdf).

    Raises:
        PlanningError: another suffix, nothing that was driven, or a place that cannot be written to.
    """
    check_suffix(out)
    if len(ledger.time) < 2:
        raise PlanningError(f"{out}: not written, there is nothing to show: the battery gives no power from the start")
    if out.suffix.lower() != ".csv":
        from .cycle_figure import draw_cycle

        return save_picture(lambda path: draw_cycle(vehicle, name, ledger, path), out)
    from roads.formats.text import write_whole

    held = [np.append(row, row[-1]) for row in (ledger.power, ledger.current)]
    table = np.column_stack([ledger.time, ledger.distance, ledger.speed, *held, ledger.voltage, ledger.soc])
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PlanningError(f"{out}: cannot be written: {error.strerror}") from None
    return write_whole(out, "\n".join([",".join(COLUMNS), *(",".join(f"{x:.9g}" for x in row) for row in table)]) + "\n")


def check_suffix(out: Path) -> None:
    """Refuse a file that is neither a table nor a picture.

    Raises:
        PlanningError: with what can be written.
    """
    if out.suffix.lower() not in (".csv", *PICTURES):
        raise PlanningError(f"{out}: unknown kind of file {out.suffix!r}, expected one of {', '.join(('.csv', *PICTURES))}")


def _percent(value: float, whole: float) -> str:
    return f"{100.0 * value / whole:z.1f}" if whole > 0.0 else "-"


def _battery_lines(ledger: ChargeLedger) -> list[str]:
    held = ledger.energy + ledger.loss
    share = f" ({100.0 * ledger.loss / held:z.1f} % of what the charge held)" if held > 0.0 else ""
    volts, amps = ledger.voltage, ledger.current
    return [
        f"battery        {100 * ledger.soc[0]:z.1f} % to {100 * ledger.soc[-1]:z.1f} % of charge, {ledger.charge_ah:z.2f} Ah; lost inside: "
        f"{ledger.loss / KWH:z.3f} kWh{share}",
        f"               {np.min(volts):z.0f} to {np.max(volts):z.0f} V, {np.min(amps):z.0f} to {np.max(amps):z.0f} A",
    ]


def _limit_lines(ledger: ChargeLedger) -> list[str]:
    lines = []
    if ledger.refusal is not None:
        lines.append(f"refused        {ledger.refused / KWH:z.3f} kWh of recuperation, {_where(ledger.refusal)}; the friction brakes took it")
    if ledger.unserved > 0.0 and ledger.shortage is not None:
        lines.append(f"missing        {ledger.unserved / KWH:z.3f} kWh for driving, {_where(ledger.shortage)}: the car cannot drive this cycle")
    return lines


def _where(place: Shortfall) -> str:
    return f"first after {duration(place.time)} and {place.distance / 1e3:z.2f} km ({WORDS[place.reason]})"


def _range_line(ledger: ChargeLedger, until_empty: bool) -> str:
    if ledger.range is None:
        return "range          none to tell: " + ("the battery cannot drive it" if ledger.shortage else "the charge does not fall")
    if not until_empty:
        return f"range          {ledger.range / 1e3:z.0f} km from {100 * ledger.soc[0]:z.0f} % of charge, if all goes on like this"
    why = "the battery is empty" if ledger.end == "soc" else f"the battery does not give the power any more ({WORDS[ledger.end]})"
    return f"range          {ledger.range / 1e3:z.1f} km: {ledger.cycles:z.2f} cycles, then {why} at {100 * ledger.soc[-1]:z.1f} %"
