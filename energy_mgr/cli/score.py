"""`energy-mgr score`: what a recorded drive took, and what a plan would have saved on it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from .complaints import complaints
from .plan_options import plan_options, taken_request
from .progress import ProgressLine
from .road_options import chosen, road_options, told


@click.command("score")
@click.argument("file")
@click.option("--vehicle", default="romo", show_default=True, help="Name of a shipped car, or a TOML file.")
@plan_options("corridor", "path", "margin", about="Of the plan: ")
@road_options
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), help="Write all figures as JSON.")
def score_command(file: str, vehicle: str, out: Path | None, **options: Any) -> None:
    """Score the drive recorded in FILE: its time, its energy by component, and what a plan would save at the same arrival time.

    FILE is a GPX track with times, a GeoJSON line with times, or a path table with times or speeds. The plan keeps the road's limits and the
    recorded stops.
    """
    progress = ProgressLine()
    with complaints():
        import json

        from roads import open_road
        from roads.formats.text import write_whole

        from ..planning import score
        from ..report.plan.score import score_summary, score_table

        try:
            made = score(told(open_road(file, **chosen(options, vehicle))), vehicle, taken_request(options), report=progress)
        finally:
            progress.close()
        click.echo(score_table(made))
        if out is not None:
            write_whole(out, json.dumps(score_summary(made), indent=2) + "\n")
            click.echo(f"\nwritten: {out}")
