"""`energy-mgr battery`: identify cells from test data."""

from __future__ import annotations

from pathlib import Path

import click

from .complaints import complaints


@click.group("battery")
def battery_group() -> None:
    """Identify battery cells from test data."""


@battery_group.command("fit")
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("-o", "--out", type=click.Path(path_type=Path, dir_okay=False), required=True, help="TOML file for the cell.")
@click.option("--model", type=click.Choice(["mesc", "esc", "rc"]), default="mesc", show_default=True, help="Kind of cell model.")
@click.option("--refine", is_flag=True, help="Also search for time constants and hysteresis rate; takes 10 to 20 s more.")
@click.option("--name", help="Name of the cell. Default: that of the output file.")
def fit_command(files: tuple[Path, ...], out: Path, model: str, refine: bool, name: str | None) -> None:
    """Identify a cell from FILES: slow charge and discharge tests (OCV) and dynamic tests, CSV.

    Each file's kind is seen by its header; temperature and script number by its name (..._P25_S1.csv is script 1 at 25 degC, N05 is -5 degC).
    """
    with complaints():
        from powertrain.battery import dump_cell
        from powertrain.battery.identify import from_files
        from roads.formats.text import write_whole

        found = from_files(files, name=name or out.stem, model=model, refine=refine)
        write_whole(out, dump_cell(found.cell))
        click.echo(str(found))
        click.echo(f"written: {out}")
