"""The comparison as text for a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from powertrain import KWH
from powertrain.energy.balance import spoken

from ...planning import saving_percent

if TYPE_CHECKING:
    from roads import Recorded

    from ...planning import Plan, Run


def comparison_table(plan: Plan) -> str:
    """Several lines: what was planned, the four ways to drive it, where the energy of the plan goes."""
    road, path = plan.road, plan.chosen.path.report
    compared = plan.comparison
    rows = [
        ("lane centre, V1 (baseline)", compared.reference or plan.baseline),
        ("path only", compared.path_only),
        ("speed only", compared.speed_only),
        ("path and speed", compared.both),
        *([("path and speed, jointly", compared.joint)] if compared.joint is not None else []),
        *([("as recorded", compared.recorded)] if compared.recorded is not None else []),
    ]
    if not any(run is plan.chosen for _, run in rows):
        rows.append(("this plan", plan.chosen))
    lines = [
        f"{road.name}: {road.length:z.0f} m, {'closed' if road.closed else 'open'}, {plan.vehicle.name}, corridor {plan.corridor}, "
        f"margin {plan.margin:g} m",
        f"path: integral of squared curvature {path.cost_centre:z.4f} -> {path.cost:z.4f} 1/m, {path.status}, "
        f"{'proven inside everywhere' if path.certified else 'not proven inside'}, {path.knots} knots, {path.iterations} QPs, "
        f"{path.solve_ms:z.0f} ms",
        "",
        f"{'':28}{'time s':>9}{'energy kWh':>12}{'saved kWh':>11}{'saved %':>9}",
        *(_row(label, run, plan.baseline, run is plan.chosen) for label, run in rows),
        "",
        "energy of the plan in kWh: " + ", ".join(f"{spoken(name)} {value / KWH:z.4f}" for name, value in plan.chosen.ledger.components.items()),
        *_notes(plan),
    ]
    return "\n".join(lines)


def _row(label: str, run: Run | None, baseline: Run, chosen: bool) -> str:
    mark = "> " if chosen else "  "
    if run is None:
        return f"{mark}{label:26}{'-':>9}   cannot arrive by then"
    saved = (baseline.ledger.total - run.ledger.total) / KWH
    percent = saving_percent(run, baseline)
    share = f"{percent:z9.2f}" if percent is not None else f"{'-':>9}"
    return f"{mark}{label:26}{run.journey_time:z9.2f}{run.energy_kwh:z12.4f}{saved:z11.4f}{share}"


def _notes(plan: Plan) -> list[str]:
    notes: list[str] = []
    compared = plan.comparison
    if compared.reference is not None and compared.reference.profile.scale >= 1.0:
        notes.append("The baseline is the fastest drive of its lane, so at its arrival time no other speed exists there: speed only saves nothing.")
    if compared.reference is not None and (np.isfinite(plan.chosen.limits.jerk) or plan.chosen.limits.windows):
        notes.append("The drives by V1 (baseline, path only) know neither the limit of jerk nor windows.")
    if plan.saving_percent is None:
        notes.append("The baseline gains energy on this road; percentages would mean nothing.")
    profile = plan.chosen.profile
    if np.isfinite(profile.lower_bound):
        least = "the least there is" if profile.gap < 1e-6 else f"proven to be within {100.0 * profile.gap:.2g} % of the least"
        where = f"on this path, in this time and with stations {np.max(np.diff(profile.s)):.2g} m apart"
        notes.append(f"Speed: {profile.method}, {profile.status}, {profile.solve_ms:z.0f} ms; {where} the energy is {least}.")
    if plan.battery is not None:
        notes.append(_battery_note(plan))
    if plan.road.recorded is not None:
        notes.append(_recorded_note(plan.road.recorded, plan))
    if plan.chosen.profile.status == "solved early":
        why = "driving slower would cost more energy" if not plan.chosen.limits.windows else "its windows or the thriftiest speed ask for no later"
        notes.append(f"Arrives {compared.journey_time - plan.journey_time:z.1f} s before the time allowed: {why}.")
    elif not plan.equal_time:
        notes.append(
            f"Plan and baseline differ by {plan.journey_time - plan.baseline.journey_time:+z.1f} s in arrival: not a comparison at equal time."
        )
    return notes


def _recorded_note(drive: Recorded, plan: Plan) -> str:
    words = f"As recorded: {drive.moving_time:z.1f} s in motion"
    stops = drive.stops
    words += (
        f" and {len(stops)} stop{'s' * (len(stops) > 1)} of {drive.duration - drive.moving_time:z.0f} s in all, which count nowhere" if stops else ""
    )
    journey_time, v = plan.journey_time, plan.chosen.profile.v
    if max(abs(v[0] - drive.v[0]), abs(v[-1] - drive.v[-1])) > 0.5:
        ends = f"{3.6 * drive.v[0]:z.0f} and {3.6 * drive.v[-1]:z.0f} km/h"
        words += f"; it begins and ends with {ends}, the plan with {3.6 * v[0]:z.0f} and {3.6 * v[-1]:z.0f}: no like with like"
    if abs(journey_time - drive.moving_time) > 0.1:
        words += f"; the plan arrives {abs(journey_time - drive.moving_time):z.1f} s {'later' if journey_time > drive.moving_time else 'earlier'}"
    return words + ". `energy-mgr score` counts stops and ends as driven."


def _battery_note(plan: Plan) -> str:
    battery = plan.battery
    if battery is None:
        return ""
    soc, charge = battery.soc, battery.charge
    words = f"Battery: state of charge {soc[0]:z.3f} -> {soc[-1]:z.3f}, {charge.energy / KWH:z.4f} kWh with auxiliaries, "
    words += f"{charge.loss / KWH:z.4f} kWh lost inside."
    if battery.put_off > 0.1:
        words += f" The arrival is put off by {battery.put_off:z.1f} s, from {battery.asked_time:z.1f} s, for power and charge to last."
    return words
