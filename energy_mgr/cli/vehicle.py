"""`energy-mgr vehicle`: look at cars, check their descriptions, draw their maps, drive cycles."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from .complaints import complaints

if TYPE_CHECKING:
    from powertrain import Vehicle


@click.group("vehicle")
def vehicle_group() -> None:
    """Look at cars, check their descriptions, draw their maps, drive cycles.

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


@vehicle_group.command("cycle")
@click.argument("cycle")
@click.option("--vehicle", "name", required=True, help="Name of a shipped car, or a TOML file.")
@click.option("--soc", type=float, default=0.9, show_default=True, help="State of charge at the start, 0 to 1.")
@click.option("--until-empty", is_flag=True, help="Repeat the cycle until the battery is empty: the range.")
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), help="Columns over time (.csv) or a picture (.png, .svg, .pdf).")
def cycle_command(cycle: str, name: str, soc: float, until_empty: bool, out: Path | None) -> None:
    """Drive CYCLE: energy by component, consumption, charge, range.

    CYCLE is a shipped cycle (wltc_1, wltc_2, wltc_3a, wltc_3b, nedc, ece15, eudc, ftp75, udds, hwfet, us06) or a CSV with columns t_s and v_mps or
    v_kmh. Where it is faster than the car's top speed, the car drives that.
    """
    vehicle = _load(name)
    with complaints():
        import numpy as np

        from powertrain import VehicleError
        from powertrain.energy.cycle_charge import charge_over_cycle
        from roads import cycles

        from ..report.vehicle.cycle_table import check_suffix, cycle_table, save_cycle

        if out is not None:
            check_suffix(out)
        found, fastest = cycles.load(cycle), vehicle.limits.speed_max_mps
        title = found.name + (f", at most {3.6 * fastest:z.0f} km/h" if np.max(found.v) > fastest else "")
        try:
            ledger = charge_over_cycle(vehicle, found.t, np.minimum(found.v, fastest), soc=soc, until="empty" if until_empty else "once")
        except VehicleError as error:
            raise click.ClickException(f"{cycle}: {error}") from None
        click.echo(cycle_table(vehicle, title, ledger, until_empty=until_empty))
        if out is not None:
            save_cycle(vehicle, title, ledger, out)
            click.echo(f"written: {out}")


def _load(name: str) -> Vehicle:
    from powertrain import load_vehicle

    with complaints():
        return load_vehicle(name)
