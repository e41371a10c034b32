"""`energy-mgr simulate`: drive a plan with the whole car in the loop."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from .plan_options import plan_options, taken_request
from .progress import ProgressLine
from .road_options import chosen, road_options, told

if TYPE_CHECKING:
    from collections.abc import Callable

    from powertrain import Vehicle

    from ..planning import Plan
    from ..simulation import Drive
    from ..trajectory.trajectory import Trajectory

#: Exit code of a drive that did not arrive.
NOT_ARRIVED = 3
#: Suffixes of files that may hold a plan, and the columns that no road file has together.
_SUFFIXES, _COLUMNS = (".csv", ".parquet"), {"v_mps", "t_s"}
#: Options of the drive; all others are the planner's, and mean nothing where the plan is there already.
_DRIVE = ("allocator", "allocation_cost", "follower", "sensors", "faults", "offset", "seed", "longest")


@click.command("simulate")
@click.argument("road", metavar="ROAD|PLAN")
@click.option("--vehicle", default="romo", show_default=True, help="Name of a shipped car, or a TOML file.")
@click.option(
    "--allocator",
    type=click.Choice(["efficient", "preview", "two-step", "weighted", "minimum-norm", "equal-split"]),
    default="efficient",
    show_default=True,
    help="Control allocation: how motors, brakes and steering share what the tracking law demands.",
)
@click.option(
    "--cost",
    "allocation_cost",
    type=click.Choice(["physical", "heuristic", "blended"]),
    default="physical",
    show_default=True,
    help="Losses that the allocator saves.",
)
@click.option("--follower", type=click.Choice(["linearising", "geometric", "pd"]), default="linearising", show_default=True, help="Tracking law.")
@click.option(
    "--sensors",
    type=click.Choice(["ideal", "real"]),
    default="ideal",
    show_default=True,
    help="Perfect ones, or noisy and late ones with dead reckoning.",
)
@click.option("--faults", type=click.Path(path_type=Path), metavar="FILE", help="TOML file of what goes wrong on the way: tables [[event]].")
@click.option(
    "--soc",
    type=float,
    help="State of charge at the start, 0 to 1. Default: 0.7. Given, a plan by --speed eco keeps to what the battery gives.",
)
@click.option("--offset", type=float, default=0.0, show_default=True, help="How far to the left of the trajectory the car starts, m.")
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Seed of the noise of real sensors.")
@click.option("--longest", type=float, help="Time allowed, s. Default: twice the planned one and 30 s more.")
@click.option("--animate", type=click.Choice(["none", "gif", "mp4"]), default="none", show_default=True, help="Write a film; MP4 needs ffmpeg.")
@click.option("--animate-seconds", type=float, default=20.0, show_default=True, help="Length of the film at most; long drives run faster in it.")
@click.option("--fps", type=click.IntRange(1, 60), default=12, show_default=True, help="Frames per second of the film.")
@plan_options(about="Planning: ")
# `--cost` is the allocator's here
@partial(road_options, cost=("--route-cost", "cost"))
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), default=Path("out/drive"), show_default=True, help="Folder for the results.")
@click.pass_context
def simulate_command(
    context: click.Context,
    road: str,
    vehicle: str,
    out: Path,
    faults: Path | None,
    animate: str,
    animate_seconds: float,
    fps: int,
    **options: Any,
) -> None:
    """Drive ROAD or PLAN with the car in the loop: tyres, motors, steering, battery, sensors, and the energy manager at the wheel.

    PLAN is a trajectory, such as the trajectory.csv of `energy-mgr plan`: a .parquet file, or a .csv file with columns v_mps and t_s. Everything else
    is a ROAD: a shipped one (commute, rural, descent, handling, roundabout) or a road file, which is planned first; the options of `plan` that are
    not here need a PLAN.

    Prints how the drive went and where its energy went beside the plan's, and writes log.parquet, drive.json and drive.png. Exit code 3 if the
    drive does not arrive; the files are written all the same.
    """
    progress = ProgressLine()
    from powertrain import VehicleError, load_vehicle
    from roads import RoadError

    from ..errors import PlanningError
    from ..report.drive.files import check_place, save_drive
    from ..report.drive.table import OUTCOMES, drive_table

    try:
        _refuse(options | {"animate_seconds": animate_seconds})
        check_place(out, animate)
        car = load_vehicle(vehicle)
        events = _events(faults, car)
        if _is_plan(road):
            _refuse_planning(context, road)
            plan, trajectory = None, _load(road)
        else:
            plan = _plan(road, car, vehicle, options, progress)
            trajectory = plan.trajectory
        drive = _drive(trajectory, car, events, options, progress)
        files = save_drive(drive, out, plan=plan, animation=animate, seconds=animate_seconds, fps=fps, report=progress)
    except (RoadError, VehicleError, PlanningError) as error:
        raise click.ClickException(str(error)) from None
    finally:
        progress.close()
    click.echo(drive_table(drive, plan))
    click.echo("\nwritten: " + ", ".join(str(file) for file in files))
    if drive.outcome != "arrived":
        way = float(drive.columns["s_m"][-1] - trajectory.s[0])
        click.echo(f"energy-mgr: {OUTCOMES[drive.outcome]}, after {drive.duration:z.1f} s at {way:z.0f} of {trajectory.length:z.0f} m", err=True)
        context.exit(NOT_ARRIVED)


def _refuse(options: dict[str, Any]) -> None:
    """Numbers that make no drive, before anything takes time."""
    soc, offset, longest, film = options["soc"], options["offset"], options["longest"], options["animate_seconds"]
    if not 0.1 <= film <= 600.0:
        raise click.BadParameter(f"{film} s, expected 0.1 to 600 s", param_hint="--animate-seconds")
    if soc is not None and not 0.0 <= soc <= 1.0:
        raise click.BadParameter(f"{soc}, expected 0 to 1", param_hint="--soc")
    if not math.isfinite(offset):
        raise click.BadParameter(f"{offset} m, expected a finite number", param_hint="--offset")
    if longest is not None and not 1.0 <= longest < 1e7:
        raise click.BadParameter(f"{longest} s, expected 1 to 1e7 s", param_hint="--longest")


def _events(faults: Path | None, car: Vehicle) -> Any:
    """The events of a file, if this car can have them."""
    if faults is None:
        return ()
    from ..allocation import Layout
    from ..errors import PlanningError
    from ..simulation import read_events
    from ..simulation.events import checked

    try:
        return checked(read_events(faults), Layout(car))
    except PlanningError as error:
        raise PlanningError(f"{faults}: {error}") from None


def _is_plan(file: str) -> bool:
    """Whether this is a file with a trajectory; what is no file at all is left to whoever opens roads."""
    path = Path(file)
    if path.suffix.lower() not in _SUFFIXES or not path.is_file():
        return False
    if path.suffix.lower() == ".parquet":  # no road comes as one
        return True
    with path.open(encoding="utf-8", errors="replace") as lines:
        for _, line in zip(range(100), lines, strict=False):
            if set(line.lstrip("#").replace(";", ",").replace("\t", ",").replace(" ", "").strip().split(",")) >= _COLUMNS:
                return True
    return False


def _refuse_planning(context: click.Context, file: str) -> None:
    """Options of the planner, given for what is planned already."""
    driving = (*_DRIVE, "road", "vehicle", "soc", "animate", "animate_seconds", "fps", "out")
    for option in context.command.params:
        name = option.name or ""
        if name not in driving and context.get_parameter_source(name) is ParameterSource.COMMANDLINE:
            raise click.UsageError(f"{option.opts[0]} is for planning a road, but {file} is planned already")


def _load(file: str) -> Trajectory:
    from ..trajectory.trajectory import Trajectory

    return Trajectory.load(file)


def _plan(road: str, car: Vehicle, name: str, options: dict[str, Any], report: Callable[[str], None]) -> Plan:
    from roads import open_road

    from ..planning import plan

    planning = {key: value for key, value in options.items() if key not in _DRIVE}
    request = taken_request({**planning, "soc": planning["soc"] if planning["speed"] == "eco" else None})
    return plan(told(open_road(road, **chosen(planning, name))), car, request, report=report)


def _drive(trajectory: Trajectory, car: Vehicle, events: Any, options: dict[str, Any], report: Callable[[str], None]) -> Drive:
    from ..simulation import simulate

    given = {key: options[key] for key in ("allocator", "follower", "sensors", "offset", "seed", "longest")}
    soc = 0.7 if options["soc"] is None else options["soc"]
    report("driving")
    return simulate(trajectory, car, cost=options["allocation_cost"], events=events, soc=soc, report=report, **given)
