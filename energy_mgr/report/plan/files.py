"""A plan as files: written whole or not at all."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from powertrain import KWH

from ...errors import PlanningError
from ...planning import saving_percent
from ...trajectory.files import write_csv
from .. import folder as folder_of
from ..folder import move_in, staging_beside

if TYPE_CHECKING:
    from collections.abc import Callable
    from os import PathLike

    from ...planning import Plan

    Draw = Callable[[Plan, Path], Callable[[], None] | None]

#: Of folders that files are made in before they are moved.
PREFIX = ".plan-"
#: The files of a plan.
FILES = ("trajectory.csv", "plan.json", "plan.png")


def save_plan(plan: Plan, folder: str | PathLike[str], *, draw: Draw | None = None) -> list[Path]:
    """Write `trajectory.csv`, `plan.json` and `plan.png` into `folder`, which is made if need be.

    All three are written beside their place first and then moved in; if anything fails before, nothing in `folder` has changed.

    Args:
        plan: what to write.
        folder: where.
        draw: draws the figure into a file, by default `draw_plan`; what it returns, if anything, is called to wait until the file is there.

    Returns:
        The paths of the files.

    Raises:
        PlanningError: the folder cannot be written.
    """
    folder = Path(folder)
    if draw is None:
        from .figure import draw_plan as draw
    try:
        return _write(plan, folder, draw)
    except OSError as error:
        raise PlanningError(f"{folder}: cannot be written: {error.strerror or error}") from None


def check_place(folder: Path) -> None:
    """Whether `save_plan` can write into `folder`; asked before planning.

    Raises:
        PlanningError: the place is taken or cannot be written to.
    """
    folder_of.check_place(folder, FILES, PREFIX)


def _write(plan: Plan, folder: Path, draw: Draw) -> list[Path]:
    check_place(folder)
    staging = staging_beside(folder, PREFIX)
    try:
        wait = draw(plan, staging / FILES[2])
        # the header comes first, as programs that know no remarks expect it; name and closed flag are in plan.json
        write_csv(plan.trajectory, staging / FILES[0], remarks=False)
        (staging / FILES[1]).write_text(json.dumps(summary(plan), indent=2) + "\n", encoding="utf-8")
        if wait is not None:
            wait()
        move_in(staging, folder, FILES)
    finally:
        shutil.rmtree(staging, ignore_errors=True)
    return [folder / name for name in FILES]


def summary(plan: Plan) -> dict[str, Any]:
    """The content of `plan.json`: plain numbers, units in the names; null where a number would mean nothing."""
    profile = plan.chosen.profile
    return {
        "road": {"name": plan.road.name, "length_m": plan.road.length, "closed": plan.road.closed},
        "vehicle": plan.vehicle.name,
        "corridor": plan.corridor,
        "margin_m": plan.margin,
        "journey_time_s": plan.journey_time,
        "energy_kwh": plan.energy_kwh,
        "baseline": {"journey_time_s": plan.baseline.journey_time, "energy_kwh": plan.baseline.energy_kwh},
        "as_recorded": _recorded(plan),
        "equal_arrival_time": plan.equal_time,
        "saving_percent": plan.saving_percent,
        "saving_kwh": plan.baseline.energy_kwh - plan.energy_kwh,
        "decomposition": _decomposition(plan),
        "path": _path(plan),
        "speed": {
            "method": profile.method,
            "solve_ms": profile.solve_ms,
            "status": profile.status,
            "iterations": profile.iterations,
            "limit_scale": profile.scale,
            "lower_bound_kwh": _number(profile.lower_bound / KWH),
            "gap": _number(profile.gap),
            "price_w": _number(profile.price),
        },
        "battery": _battery(plan),
        "energy_by_component_kwh": {name: value / KWH for name, value in plan.chosen.ledger.components.items()},
    }


def _recorded(plan: Plan) -> dict[str, float] | None:
    run = plan.comparison.recorded
    return None if run is None else {"journey_time_s": run.journey_time, "energy_kwh": run.energy_kwh}


def _saved(plan: Plan, which: str) -> float | None:
    run, reference = getattr(plan.comparison, which), plan.comparison.reference
    return None if run is None or reference is None else reference.energy_kwh - run.energy_kwh


def _number(value: float) -> float | None:
    """`value`, or None where it is none: JSON has no infinity."""
    return float(value) if np.isfinite(value) else None


def _battery(plan: Plan) -> dict[str, float] | None:
    drive = plan.battery
    if drive is None:
        return None
    return {
        "soc_start": float(drive.soc[0]),
        "soc_end": float(drive.soc[-1]),
        "energy_kwh": drive.charge.energy / KWH,
        "loss_kwh": drive.charge.loss / KWH,
        "asked_time_s": drive.asked_time,
        "put_off_s": drive.put_off,
    }


def _decomposition(plan: Plan) -> dict[str, float | None]:
    compared = plan.comparison
    return {
        "journey_time_s": compared.journey_time,
        "path_only_percent": saving_percent(compared.path_only, compared.reference),
        "speed_only_percent": saving_percent(compared.speed_only, compared.reference),
        "both_percent": saving_percent(compared.both, compared.reference),
        "joint_percent": saving_percent(compared.joint, compared.reference),
        "path_only_kwh": _saved(plan, "path_only"),
        "speed_only_kwh": _saved(plan, "speed_only"),
        "both_kwh": _saved(plan, "both"),
        "joint_kwh": _saved(plan, "joint"),
    }


def _path(plan: Plan) -> dict[str, Any]:
    path, found = plan.chosen.path, plan.chosen.path.report
    return {
        "length_m": path.curve.length,
        "cost_centre": found.cost_centre,
        "cost": found.cost,
        "iterations": found.iterations,
        "solve_ms": found.solve_ms,
        "max_violation_m": found.max_violation_m,
        "certified": found.certified,
        "status": found.status,
        "optimality": found.optimality,
        "kkt_residual": None if np.isnan(found.kkt_residual) else found.kkt_residual,
        "max_curvature": found.max_curvature,
        "knots": found.knots,
        "method": found.method,
        "qp": found.qp,
    }
