"""`energy-mgr plan`: the main job."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from .plan_options import plan_options, taken_request
from .progress import ProgressLine
from .quick import lean_scipy
from .road_options import chosen, road_options, told


@click.command("plan")
@click.argument("road")
@click.option("--vehicle", default="romo", show_default=True, help="Name of a shipped car, or a TOML file.")
@plan_options()
@click.option(
    "--method",
    type=click.Choice(["sequential", "joint"]),
    default="sequential",
    show_default=True,
    help="First the path, then the speed; or both at once, which saves more and takes longer.",
)
@click.option("--price", type=float, help="Price of time in W (joules for every second), instead of an arrival time.")
@click.option(
    "--soc",
    type=float,
    help="State of charge at the start, 0 to 1: the drive keeps within what the battery gives, and arrives later if it must.",
)
@road_options
@click.option(
    "--path-method",
    type=click.Choice(["gauss-newton", "linearised", "gradient", "slsqp", "trust-constr", "ipopt"]),
    default="gauss-newton",
    show_default=True,
    help="Solver of the path; the others are for comparison, and slower or worse.",
)
@click.option("--knots", default="need", show_default=True, help="Knots of the path: `need` (closer in bends), or a distance in m.")
@click.option("--qp", default="piqp", show_default=True, help="Solver of the path's QPs: piqp, clarabel, osqp, or another that qpsolvers finds.")
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), default=Path("out/plan"), show_default=True, help="Folder for the results.")
def plan_command(road: str, out: Path, path_method: Any, knots: str, qp: str, **options: Any) -> None:
    """Plan a thrifty drive along ROAD: a road file (see `energy-mgr roads`), or a shipped road (commute, rural, descent, handling, roundabout).

    Prints a comparison with the lane centre at equal arrival time and writes trajectory.csv, plan.json and plan.png.
    """
    from ..report.plan.painter import Painter

    progress = ProgressLine()
    with Painter() as painter:
        with lean_scipy():
            import scipy.linalg  # noqa: F401
        from powertrain import VehicleError
        from roads import RoadError, open_road

        from ..errors import PlanningError
        from ..path import PathOptions
        from ..planning import plan
        from ..report import comparison_table, save_plan
        from ..report.plan.files import check_place

        try:
            check_place(out)
            vehicle = options.pop("vehicle")
            request = taken_request(options, path_options=PathOptions(knots=_knots(knots), method=path_method, qp=qp))
            made = plan(told(open_road(road, **chosen(options, vehicle))), vehicle, request, report=progress)
            progress("drawing")
            files = save_plan(made, out, draw=painter.draw)
        except (RoadError, VehicleError, PlanningError) as error:
            raise click.ClickException(str(error)) from None
        finally:
            progress.close()
    click.echo(comparison_table(made))
    click.echo("\nwritten: " + ", ".join(str(file) for file in files))


def _knots(text: str) -> Any:
    """`need`, or a distance."""
    try:
        return text if text == "need" else float(text)
    except ValueError:
        raise click.BadParameter(f"{text!r}, expected `need` or a distance in m", param_hint="--knots") from None
