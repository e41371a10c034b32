"""A drive as files: written whole or not at all."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from powertrain import KWH

from ...errors import PlanningError
from .. import folder as folder_of
from .table import account, planned_energy, planned_time

if TYPE_CHECKING:
    from collections.abc import Callable
    from os import PathLike

    from roads import Road

    from ...planning import Plan
    from ...simulation import Drive

#: Of folders that files are made in before they are moved.
PREFIX = ".drive-"
#: The files of a drive; an animation comes as a fourth.
FILES = ("log.parquet", "drive.json", "drive.png")


def check_place(folder: str | PathLike[str], animation: str = "none") -> list[str]:
    """The names of the files that `save_drive` would write; asked before a long drive, so that it is not driven in vain.

    Args:
        folder: where they shall go.
        animation: `none`, `gif` or `mp4`.

    Raises:
        PlanningError: for an MP4, ffmpeg is missing; or the place is taken or cannot be written to.
    """
    folder = Path(folder)
    names = [*FILES, *([] if animation == "none" else [f"drive.{animation}"])]
    if animation != "none":
        from .animation import check_kind

        check_kind(folder / names[-1])
    folder_of.check_place(folder, names, PREFIX)
    return names


def save_drive(
    drive: Drive,
    folder: str | PathLike[str],
    *,
    plan: Plan | None = None,
    road: Road | None = None,
    animation: str = "none",
    seconds: float = 20.0,
    fps: int = 12,
    report: Callable[[str], None] | None = None,
) -> list[Path]:
    """Write `log.parquet`, `drive.json`, `drive.png` and perhaps `drive.gif` or `drive.mp4` into `folder`, which is made if need be.

    All are written beside their place first and then moved in; if anything fails before, nothing in `folder` has changed.

    Args:
        drive: what to write.
        folder: where.
        plan: the plan that was driven, where there is one.
        road: whose borders the pictures show; by default that of the plan.
        animation: `none`, `gif` or `mp4`.
        seconds, fps: of the animation, as in `animate_drive`.
        report: told about progress.

    Returns:
        The paths of the files.

    Raises:
        PlanningError: as `check_place`, and an animation of no length.
    """
    from .animation import animate_drive
    from .figure import draw_drive

    folder, names = Path(folder), check_place(folder, animation)
    road = plan.road if road is None and plan is not None else road
    try:
        staging = folder_of.staging_beside(folder, PREFIX)
        try:
            drive.save(staging / names[0])
            text = json.dumps(summary(drive, plan) | {"files": names}, indent=2)
            (staging / names[1]).write_text(text + "\n", encoding="utf-8")
            if report:
                report("drawing")
            draw_drive(drive, staging / names[2], plan=plan, road=road)
            if animation != "none":
                animate_drive(drive, staging / names[3], road=road, seconds=seconds, fps=fps, report=report)
            folder_of.move_in(staging, folder, names)
        finally:
            shutil.rmtree(staging, ignore_errors=True)
    except OSError as error:
        raise PlanningError(f"{folder}: cannot be written: {error.strerror or error}") from None
    return [folder / name for name in names]


def summary(drive: Drive, plan: Plan | None = None) -> dict[str, Any]:
    """The content of `drive.json`: plain numbers, units in the names; null where a number would mean nothing."""
    line, way, soc, ledger = drive.trajectory, drive.columns["s_m"], drive.columns["soc"], drive.ledger
    return {
        "trajectory": {"name": line.name, "length_m": line.length, "closed": line.closed, "journey_time_s": line.journey_time},
        "vehicle": drive.vehicle.name,
        "options": {name: value if isinstance(value, str | int | float | bool) else str(value) for name, value in drive.options.items()},
        "outcome": drive.outcome,
        "duration_s": drive.duration,
        "journey_time_s": drive.journey_time,
        "driven_m": float(way[-1] - way[0]),
        "drive_energy_kwh": drive.drive_energy / KWH,
        "planned_time_s": planned_time(drive),
        "planned_energy_kwh": planned_energy(drive, plan) / KWH,
        "battery_energy_kwh": drive.battery_energy / KWH,
        "unserved_kwh": ledger.unserved / KWH,
        "soc_start": float(soc[0]),
        "soc_end": float(soc[-1]),
        "offset_rms_m": drive.offset_rms,
        "offset_max_m": drive.offset_max,
        "torque_jitter_nmps": _number(drive.torque_jitter),
        "steering_jitter_radps": _number(drive.steering_jitter),
        "statuses": dict(drive.statuses),
        "refused": dict(drive.refused),
        "errors": drive.errors,
        "happened": [{"at_s": t, **_event(event)} for t, event in drive.happened],
        "noticed": [{"at_s": t, "what": words} for t, words in drive.noticed],
        "step_time_ms": {"median": 1e3 * float(np.median(drive.step_time)), "p99": 1e3 * float(np.percentile(drive.step_time, 99.0))},
        "wall_s": drive.wall,
        "real_time_factor": drive.duration / drive.wall,
        "energy_by_component_kwh": {row.name: {"plan": row.plan / KWH, "drive": row.drive / KWH} for row in account(drive, plan)},
        "plant_energy_kwh": {name: value / KWH for name, value in ledger.energy.items()},
        "beyond_cell_limits_s": dict(ledger.outside),
        "imbalance": dict(ledger.imbalance),
    }


def _event(event: Any) -> dict[str, Any]:
    return {name: getattr(event, name) for name in event.__struct_fields__}


def _number(value: float) -> float | None:
    """`value`, or None where it is none: JSON has no such number."""
    return float(value) if math.isfinite(value) else None
