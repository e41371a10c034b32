"""A score as text for a terminal, and as plain data."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from powertrain import KWH
from powertrain.energy.balance import spoken

if TYPE_CHECKING:
    from ...planning import Score

#: Faster than this a car falls behind a recorded speed for more than noise, m/s.
_MISSED = 0.5
#: Times within this are the same, s.
_SAME_TIME = 0.1


def score_table(score: Score) -> str:
    """Some twenty lines: time, way and energy as recorded and as planned, by component."""
    drive, road = score.drive, score.road
    stops = drive.stops
    lines = [
        f"{road.name}: {road.length:z.0f} m, {score.vehicle.name}, recorded {drive.duration:z.1f} s"
        + (f", {len(stops)} stop{'s' * (len(stops) > 1)} of {drive.duration - drive.moving_time:z.0f} s in all" if stops else ""),
        "",
        f"{'':28}{'as recorded':>13}{'planned':>11}",
        f"{'  time s':28}{drive.duration:z13.1f}{score.planned.duration:z11.1f}",
        f"{'  energy kWh':28}{score.energy_kwh:z13.4f}{score.planned_kwh:z11.4f}",
        f"{'  kWh/100 km':28}{1e5 * score.energy_kwh / road.length:z13.2f}{1e5 * score.planned_kwh / road.length:z11.2f}",
    ]
    for name, value in score.recorded.components.items():
        lines.append(f"{'    ' + spoken(name):28}{value / KWH:z13.4f}{score.planned.components[name] / KWH:z11.4f}")
    saved = score.energy_kwh - score.planned_kwh
    percent = score.saving_percent
    lines += ["", f"A plan would save {saved:z.4f} kWh" + (f", {percent:z.1f} %" if percent is not None else "") + _when(score)]
    if score.recorded.missed > _MISSED:
        lines.append(f"The recorded speeds ask more than this car has: it would fall behind by up to {3.6 * score.recorded.missed:z.0f} km/h.")
    return "\n".join(lines)


def _when(score: Score) -> str:
    late = score.late
    if abs(late) <= _SAME_TIME and score.same_ends:
        return ", in the same time, with the same stops, within the car's limits and the road's."
    words = []
    if late > _SAME_TIME:
        words.append(f"arrives {late:z.1f} s later, since the limits of car, comfort and road do not allow the recorded time")
    elif late < -_SAME_TIME:
        words.append(f"arrives {-late:z.1f} s earlier, since going as slowly as recorded would cost more, or it does not stand where the drive did")
    if not score.same_ends:
        v = score.plan.chosen.profile.v
        here = f"{3.6 * v[0]:z.0f} and {3.6 * v[-1]:z.0f} km/h"
        words.append(f"begins and ends with {here}, the drive with {3.6 * score.drive.v[0]:z.0f} and {3.6 * score.drive.v[-1]:z.0f}")
    return f", but {' and '.join(words)}: no comparison of like with like."


def score_summary(score: Score) -> dict[str, Any]:
    """The same as plain numbers, units in the names."""
    drive = score.drive
    return {
        "road": {"name": score.road.name, "length_m": score.road.length},
        "vehicle": score.vehicle.name,
        "duration_s": drive.duration,
        "standing_s": drive.duration - drive.moving_time,
        "stops": [{"station_m": s, "duration_s": duration} for s, duration in drive.stops],
        "energy_kwh": score.energy_kwh,
        "energy_by_component_kwh": {name: value / KWH for name, value in score.recorded.components.items()},
        "speed_missed_mps": score.recorded.missed,
        "plan": {
            "duration_s": score.planned.duration,
            "late_s": score.late,
            "same_speeds_at_ends": score.same_ends,
            "energy_kwh": score.planned_kwh,
            "energy_by_component_kwh": {name: value / KWH for name, value in score.planned.components.items()},
        },
        "saving_kwh": score.energy_kwh - score.planned_kwh,
        "saving_percent": score.saving_percent,
        "findings": [str(finding) for finding in score.road.findings],
    }
