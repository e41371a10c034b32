"""The comparison as text for a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..planning import KWH, saving_percent

if TYPE_CHECKING:
    from ..planning import Plan, Run


def comparison_table(plan: Plan) -> str:
    """Several lines: what was planned, the four ways to drive it, where the energy of the plan goes."""
    road, path = plan.road, plan.chosen.path.report
    compared = plan.comparison
    rows = [
        ("lane centre, V1 (baseline)", compared.reference or plan.baseline),
        ("path only", compared.path_only),
        ("speed only", compared.speed_only),
        ("path and speed", compared.both),
    ]
    if not any(run is plan.chosen for _, run in rows):
        rows.append(("this plan", plan.chosen))
    lines = [
        f"{road.name}: {road.length:.0f} m, {'closed' if road.closed else 'open'}, {plan.vehicle.name}, corridor {plan.corridor}, "
        f"margin {plan.margin:g} m",
        f"path: integral of squared curvature {path.cost_centre:.4f} -> {path.cost:.4f} 1/m, {path.status}, "
        f"{'proven inside everywhere' if path.certified else 'not proven inside'}, {path.knots} knots, {path.iterations} QPs, {path.solve_ms:.0f} ms",
        "",
        f"{'':28}{'time s':>9}{'energy kWh':>12}{'saved kWh':>11}{'saved %':>9}",
        *(_row(label, run, plan.baseline, run is plan.chosen) for label, run in rows),
        "",
        "energy of the plan in kWh: " + ", ".join(f"{name} {value / KWH:.4f}" for name, value in plan.chosen.ledger.components.items()),
        *_notes(plan),
    ]
    return "\n".join(lines)


def _row(label: str, run: Run | None, baseline: Run, chosen: bool) -> str:
    mark = "> " if chosen else "  "
    if run is None:
        return f"{mark}{label:26}{'-':>9}   cannot arrive by then"
    saved = (baseline.ledger.total - run.ledger.total) / KWH
    percent = saving_percent(run, baseline)
    return f"{mark}{label:26}{run.journey_time:9.2f}{run.energy_kwh:12.4f}{saved:11.4f}" + (f"{percent:9.2f}" if percent is not None else f"{'-':>9}")


def _notes(plan: Plan) -> list[str]:
    notes: list[str] = []
    compared = plan.comparison
    if compared.reference is not None and compared.reference.profile.scale >= 1.0:
        notes.append("The baseline is the fastest drive of its lane, so at its arrival time no other speed exists there: speed only saves nothing.")
    if plan.saving_percent is None:
        notes.append("The baseline gains energy on this road; percentages would mean nothing.")
    if plan.chosen.profile.status == "solved early":
        notes.append(f"Arrives {compared.journey_time - plan.journey_time:.1f} s before the time allowed: driving slower would cost more energy.")
    elif not plan.equal_time:
        notes.append(
            f"Plan and baseline differ by {plan.journey_time - plan.baseline.journey_time:+.1f} s in arrival: not a comparison at equal time."
        )
    return notes
