"""A drive as text for a terminal: how it ended, what it took, and its energy account beside that of the plan."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from powertrain import KWH, drive_energy

if TYPE_CHECKING:
    from ...planning import Plan
    from ...simulation import Drive, Event

#: What the ends of a drive mean, for a person.
OUTCOMES = {
    "arrived": "arrived",
    "stopped": "stopped before the end",
    "lost": "lost: farther from the trajectory than the simulation follows",
    "late": "late: not there in the time allowed",
}
#: Rows of the account: a name, what the plan calls it, flows of the plant that count in full, flows that are taken off.
_ROWS: tuple[tuple[str, str, tuple[str, ...], tuple[str, ...]], ...] = (
    ("rolling", "rolling", ("rolling",), ()),
    ("drag", "drag", ("drag",), ()),
    ("slope", "slope", ("slope",), ()),
    ("copper", "copper", ("copper",), ()),
    ("iron", "iron", ("iron",), ()),
    ("inverter", "inverter", ("inverter",), ()),
    ("motor friction", "friction", ("friction",), ()),
    ("gear", "gear", ("gear",), ()),
    ("tyre slip", "", ("tyre",), ()),
    ("steering", "", ("steering", "steering_work"), ()),
    ("brake", "brake", ("brake",), ("clamping",)),
    ("suspension", "", ("damping", "carcass"), ()),
)
#: Differences below this share of the whole are not worth a word.
_WORTH = 1e-3
#: Accounts of less than this are in Wh, J.
_SHORT = 0.02 * KWH
#: Events told one by one.
_MOST = 12


class Row(NamedTuple):
    """One line of the account, J; the plan counts nothing where it has no such component."""

    name: str
    plan: float
    drive: float

    @property
    def more(self) -> float:
        """What the drive took beyond the plan, J."""
        return self.drive - self.plan


def planned_components(drive: Drive, plan: Plan | None = None) -> dict[str, float]:
    """The quasi-static account in J by component: that of `plan`, else of driving the trajectory exactly, with the car that drove.

    Of a drive that did not arrive, only as far as it came.
    """
    if plan is not None and drive.outcome == "arrived":
        return plan.chosen.ledger.components
    line, way = drive.trajectory, _reached(drive)
    inside = line.s < way - 1e-6
    if np.sum(inside) == 0:
        return {}
    end = line.point(way)
    s, v, z = (np.append(row[inside], last) for row, last in ((line.s, end.s), (line.v, end.v), (line.z, end.z)))
    return drive_energy(drive.vehicle, s, v, z).components


def _reached(drive: Drive) -> float:
    """The last station that can be compared, m: the trajectory's own where the drive arrived."""
    line, way = drive.trajectory, drive.columns["s_m"]
    return float(line.s[-1]) if drive.outcome == "arrived" else min(max(float(way[-1]), float(line.s[0])), float(line.s[-1]))


def account(drive: Drive, plan: Plan | None = None) -> list[Row]:
    """The energy of the drives (`Drive.drive_energy`) by component beside the quasi-static one; the rows of each add up to its whole.

    The last row, `rest`, is the integrator's error, and what was drawn since the battery's last step and is on no account yet.
    """
    planned, energy = planned_components(drive, plan), drive.ledger.energy
    rows = [
        Row(name, planned.get(key, 0.0), sum(energy[flow] for flow in spent) - sum(energy[flow] for flow in off)) for name, key, spent, off in _ROWS
    ]
    rows.append(Row("motion", planned.get("kinetic", 0.0), drive.ledger.kept))
    return [*rows, Row("rest", 0.0, drive.drive_energy - sum(row.drive for row in rows))]


def planned_energy(drive: Drive, plan: Plan | None = None) -> float:
    """What was planned to be drawn, J: of the trajectory's own power, else of driving it exactly; as far as the drive came."""
    line = drive.trajectory
    if np.any(line.power != 0.0):
        drawn = np.append(0.0, np.cumsum(line.power[:-1] * np.diff(line.t)))
        return float(np.interp(line.point(_reached(drive)).t, line.t, drawn))
    return sum(planned_components(drive, plan).values())


def planned_time(drive: Drive) -> float:
    """When the plan is where the drive ended, s after its start."""
    line = drive.trajectory
    return float(line.point(_reached(drive)).t - line.t[0])


def drive_table(drive: Drive, plan: Plan | None = None) -> str:
    """Some thirty lines: outcome, time, energy, tracking, what went wrong, and the account beside the plan's."""
    line, way = drive.trajectory, drive.columns["s_m"]
    driven, options = float(way[-1] - way[0]), drive.options
    how = ", ".join(f"{key} {options[key]}" for key in ("follower", "allocator", "cost", "sensors") if key in options)
    return "\n".join(
        [
            f"{line.name}: {driven:z.0f} of {line.length:z.0f} m, {drive.vehicle.name}" + (f", {how}" if how else ""),
            f"outcome        {OUTCOMES.get(drive.outcome, drive.outcome)}",
            f"time           {drive.journey_time:z.2f} s, planned {planned_time(drive):z.2f} s{_so_far(drive)}; "
            f"{drive.duration:z.2f} s were simulated",
            *_energy_lines(drive, plan),
            f"tracking       offset {_length(drive.offset_rms)} rms, {_length(drive.offset_max)} at most",
            f"jitter         {_jitter(drive)}",
            *_trouble_lines(drive),
            f"speed          {drive.duration / drive.wall:z.1f} times real time; a step of the manager takes {_step(drive)}",
            "",
            *_account_lines(drive, plan),
        ]
    )


def event_words(event: Event) -> str:
    """One event for a person: `motor_1 dead`, `friction 0.3`."""
    if event.part == "friction":
        return f"friction {event.share:g}"
    more = f" ({event.share:.0%} left)" if event.kind == "weak" else f" by {event.size:g} m" if event.kind == "jump" else ""
    return f"{event.part} {event.kind}" + (f" by {event.size:g} s" if event.kind == "late" else more)


def _energy_lines(drive: Drive, plan: Plan | None) -> list[str]:
    energy, planned = drive.drive_energy, planned_energy(drive, plan)
    share = f", {100.0 * (energy / planned - 1.0):+z.2f} %" if planned > 0.0 else ""
    missing = f"; {drive.ledger.unserved / KWH:z.4f} kWh more than it could give" if drive.ledger.unserved > 0.0 else ""
    soc, per = drive.columns["soc"], drive.ledger.energy
    beyond = [f"{name} for {seconds:z.1f} s" for name, seconds in drive.ledger.outside.items() if seconds > 0.0]
    return [
        f"drives         {energy / KWH:z.4f} kWh, planned {planned / KWH:z.4f} kWh{_so_far(drive)} ({(energy - planned) / KWH:+z.4f} kWh{share})",
        f"battery        {drive.battery_energy / KWH:z.4f} kWh at its terminals, {(per['auxiliary'] + per['converter']) / KWH:z.4f} of them for "
        f"auxiliaries; state of charge {100.0 * soc[0]:z.2f} % to {100.0 * soc[-1]:z.2f} %{missing}",
        *([f"               beyond the cell's limits: {', '.join(beyond)}"] if beyond else []),
    ]


def _so_far(drive: Drive) -> str:
    return "" if drive.outcome == "arrived" else " for this part of the way"


def _length(metres: float) -> str:
    return f"{100.0 * metres:z.1f} cm" if metres < 1.0 else f"{metres:z.2f} m"


def _jitter(drive: Drive) -> str:
    if math.isnan(drive.torque_jitter):
        return "no stretch of constant driving to tell it by"
    return f"commands change by {drive.torque_jitter:z.1f} Nm/s and {drive.steering_jitter:z.4f} rad/s rms (torques, steering) in constant driving"


def _trouble_lines(drive: Drive) -> list[str]:
    whole = max(sum(drive.statuses.values()), 1)
    states = ", ".join(f"{name} {_percent(count / whole)}" for name, count in sorted(drive.statuses.items(), key=lambda item: -item[1]))
    refused = ", ".join(f"{name} {count}" for name, count in drive.refused.items() if count) or "none"
    lines = [f"statuses       {states}", f"refused        measurements: {refused}"]
    if drive.errors:
        lines.append(f"errors         {drive.errors} steps of the manager failed on a measurement that had been believed")
    return lines + _listed("happened", [(t, event_words(event)) for t, event in drive.happened]) + _listed("noticed", drive.noticed)


def _listed(title: str, rows: list[tuple[float, str]]) -> list[str]:
    """Times with words, as many as a person reads."""
    lines = [f"{title if k == 0 else '':15}{t:z.2f} s: {words}" for k, (t, words) in enumerate(rows[:_MOST])]
    return lines + ([f"{'':15}and {len(rows) - _MOST} more"] if len(rows) > _MOST else [])


def _percent(share: float) -> str:
    return f"{100.0 * share:z.1f} %" if share > 5e-4 else "< 0.1 %"


def _step(drive: Drive) -> str:
    times = 1e3 * np.asarray(drive.step_time)
    return f"{np.median(times):z.2f} ms (median), {np.percentile(times, 99.0):z.2f} ms (99 %)"


def _account_lines(drive: Drive, plan: Plan | None) -> list[str]:
    rows = [row for row in account(drive, plan) if row.plan != 0.0 or row.drive != 0.0]
    total = Row("drives", sum(row.plan for row in rows), drive.drive_energy)
    # four digits of a kWh say little about a short drive
    unit, joules = ("kWh", KWH) if sum(abs(row.drive) for row in rows) > _SHORT else ("Wh", 1e-3 * KWH)
    lines = [f"{'energy in ' + unit:18}{'plan':>10}{'drive':>10}{'difference':>12}"]
    for row in (*rows, total):
        plan_told, drive_told, more = (_shown(value / joules) for value in (row.plan, row.drive, row.more))
        sign = "+" if row.more > 0.0 and more != _shown(0.0) else ""
        lines.append(f"  {row.name:16}{plan_told:>10}{drive_told:>10}{sign + more:>12}")
    return [*lines, *_reasons(drive, rows, total, planned_energy(drive, plan), (unit, joules))]


def _shown(value: float) -> str:
    """Four digits; no minus before a zero."""
    return f"{value if abs(value) >= 5e-5 else 0.0:z.4f}"


def _reasons(drive: Drive, rows: list[Row], total: Row, planned: float, scale: tuple[str, float]) -> list[str]:
    """What the difference is made of, largest first, and what the numbers do not mean."""
    unit, joules = scale
    size = max(_WORTH * sum(abs(row.drive) for row in rows), 5e-5 * joules)
    large = sorted((row for row in rows if abs(row.more) > size and row.name != "rest"), key=lambda row: -abs(row.more))
    lines = []
    if large:
        lines.append("The difference: " + ", ".join(f"{row.name} {row.more / joules:+z.4f}" for row in large[:5]) + f" {unit}.")
    unknown = [row.name for row in large if row.name in ("tyre slip", "steering", "suspension")]
    if unknown:
        words = "is" if len(unknown) == 1 else "are"
        lines.append(f"The plan is quasi-static: {', '.join(unknown)} {words} not in it.")
    if rows and rows[-1].name == "rest" and abs(rows[-1].drive) > size:
        lines.append("The rest was drawn since the battery's last step and is on no account yet.")
    if abs(total.plan - planned) > 0.01 * abs(planned):
        lines.append(f"The trajectory's own power adds up to {planned / KWH:z.4f} kWh: planned for another car, with friction brakes, or otherwise.")
    if drive.outcome != "arrived":
        lines.append("The plan's account is that of the part of the way that was driven.")
    return lines
