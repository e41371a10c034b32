"""`energy-mgr vehicle`: look at cars, check their descriptions, draw their maps."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from .complaints import complaints

if TYPE_CHECKING:
    from powertrain import Vehicle


@click.group("vehicle")
def vehicle_group() -> None:
    """Look at cars, check their descriptions, draw their maps.

    NAME is a shipped car (romo, compact, dual_motor, van) or a TOML file.
    """


@vehicle_group.command("info")
@click.argument("name")
def info_command(name: str) -> None:
    """What NAME is, what it can do and what it consumes."""
    from ..report import vehicle_table

    vehicle = _load(name)
    with complaints():
        click.echo(vehicle_table(vehicle))


@vehicle_group.command("check")
@click.argument("name")
@click.pass_context
def check_command(context: click.Context, name: str) -> None:
    """Every finding about the description of NAME with key and severity; exit code 1 if there are errors."""
    from powertrain.check import check

    findings = check(name)
    for finding in findings:
        click.echo(str(finding))
    count = {severity: sum(finding.severity == severity for finding in findings) for severity in ("error", "warning", "note")}
    click.echo(", ".join(f"{number} {severity}{'s' * (number != 1)}" for severity, number in count.items()))
    context.exit(1 if count["error"] else 0)


@vehicle_group.command("map")
@click.argument("name")
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), default=Path("vehicle.png"), show_default=True, help="PNG, PDF or SVG.")
def map_command(name: str, out: Path) -> None:
    """Draw the efficiency map with its envelope, the losses and the forces of NAME."""
    from ..report import save_vehicle_figure

    vehicle = _load(name)
    with complaints():
        save_vehicle_figure(vehicle, out)
    click.echo(f"written: {out}")


def _load(name: str) -> Vehicle:
    from powertrain import load_vehicle

    with complaints():
        return load_vehicle(name)
