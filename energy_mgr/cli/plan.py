"""`energy-mgr plan`: the main job."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from .progress import ProgressLine
from .quick import lean_scipy
from .road_options import chosen, road_options
from .rule_options import rule_options, with_rules


@click.command("plan")
@click.argument("road")
@click.option("--vehicle", default="romo", show_default=True, help="Name of a shipped car, or a TOML file.")
@click.option(
    "--corridor",
    type=click.Choice(["lane", "own", "road"]),
    default="own",
    show_default=True,
    help="What the car may use: its lane, all lanes that lead its way, or the road from edge to edge.",
)
@click.option("--path", type=click.Choice(["lane", "optimal"]), default="optimal", show_default=True, help="Lane centre, or path of least curvature.")
@click.option(
    "--speed",
    type=click.Choice(["fast", "toppra", "eco", "socp", "dp", "nlp"]),
    default="eco",
    show_default=True,
    help="As fast as allowed (fast, toppra), or with least energy (eco; socp, dp and nlp find the same by other means, slower).",
)
@click.option(
    "--method",
    type=click.Choice(["sequential", "joint"]),
    default="sequential",
    show_default=True,
    help="First the path, then the speed; or both at once, which saves more and takes longer.",
)
@click.option(
    "--time",
    "journey_time",
    type=float,
    help="Arrival time, s after the start. Default: the least that both paths (lane and optimal) can make; with --speed fast that of --path.",
)
@click.option("--price", type=float, help="Price of time in W (joules for every second), instead of an arrival time.")
@click.option(
    "--soc",
    type=float,
    help="State of charge at the start, 0 to 1: the drive keeps within what the battery gives, and arrives later if it must.",
)
@rule_options
@click.option("--margin", type=float, default=0.2, show_default=True, help="Distance in m between the car's side and the borders.")
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
        from ..planning.one_call import plan
        from ..report import comparison_table, save_plan

        try:
            how = PathOptions(knots=_knots(knots), method=path_method, qp=qp)
            options = with_rules(options)
            made = plan(open_road(road, **chosen(options, options["vehicle"])), path_options=how, report=progress, **options)
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
