"""`energy-mgr front`: time against energy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from .plan_options import plan_options, taken_request
from .progress import ProgressLine
from .road_options import chosen, road_options, told


@click.command("front")
@click.argument("road")
@click.option("--vehicle", default="romo", show_default=True, help="Name of a shipped car, or a TOML file.")
@plan_options("corridor", "path", "margin")
@click.option("--count", type=click.IntRange(2, 1000), default=12, show_default=True, help="Number of drives.")
@click.option("--slowest", type=float, help="Time of the last drive, s. Default: that of the thriftiest, at most four times the least.")
@road_options
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), help="File for the table (.csv) or the figure (.png, .svg, .pdf).")
def front_command(road: str, out: Path | None, **options: Any) -> None:
    """What arriving earlier costs on ROAD: drives from the fastest to the thriftiest, each with the least energy for its time.

    Every row says how far its energy may at most be above the least there is (gap).
    """
    progress = ProgressLine()
    from powertrain import VehicleError
    from roads import RoadError, open_road

    from ..errors import PlanningError
    from ..planning import plan_front
    from ..report.plan.front import front_table, refuse_suffix, save_front

    try:
        vehicle, request = options.pop("vehicle"), taken_request(options)
        if out is not None:
            refuse_suffix(out)
        path, limits, front = plan_front(told(open_road(road, **chosen(options, vehicle))), vehicle, request, report=progress, **options)
        if out is not None:
            save_front(front, limits, out)
    except (RoadError, VehicleError, PlanningError) as error:
        raise click.ClickException(str(error)) from None
    finally:
        progress.close()
    click.echo(front_table(front, limits, path.curve.length))
    if out is not None:
        click.echo(f"\nwritten: {out}")
