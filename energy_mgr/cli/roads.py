"""`energy-mgr roads`: look at road files, check them, convert them, find routes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .complaints import complaints
from .road_options import Place, chosen, road_options

if TYPE_CHECKING:
    from roads import Network, Road


@click.group("roads")
def roads_group() -> None:
    """Look at road files, check and convert them, find routes through networks.

    FILE is a shipped road (commute, rural, descent, handling, roundabout) or a file: OpenDRIVE .xodr, CommonRoad .xml, SUMO .net.xml, Lanelet2
    .osm, GPX, GeoJSON, or CSV (track, edges, cones, path table), path table .mat.
    """


@roads_group.command("info")
@click.argument("file")
@road_options
def info_command(file: str, **options: Any) -> None:
    """What FILE holds: a network's roads, or one road's length, lanes, heights, bends and limits."""
    from ..report import network_table, road_table

    made = _open(file, chosen(options))
    click.echo(road_table(made) if _is_road(made) else network_table(made))


@roads_group.command("check")
@click.argument("file")
@road_options
@click.pass_context
def check_command(context: click.Context, file: str, **options: Any) -> None:
    """Every finding about FILE with place and severity; exit code 1 if there are errors."""
    from roads.check import check
    from roads.gallery.shelf import find

    with complaints():
        findings = check(find(file), **chosen(options))
    for finding in findings:
        click.echo(str(finding))
    count = {severity: sum(finding.severity == severity for finding in findings) for severity in ("error", "warning", "note")}
    click.echo(", ".join(f"{number} {severity}{'s' * (number != 1)}" for severity, number in count.items()))
    context.exit(1 if count["error"] else 0)


@roads_group.command("convert")
@click.argument("file")
@click.argument("out", type=click.Path(path_type=Path, dir_okay=False))
@road_options
@click.option("--smooth", type=float, help="Smooth the reference line; no point moves farther than this, m.")
@click.option("--spacing", type=float, help="Sample the road anew, stations at most this far apart, m.")
@click.option("--reverse", is_flag=True, help="Turn the road round: stations count from its other end.")
@click.option("--start-at", type=float, help="Cut: first station, m.")
@click.option("--end-at", type=float, help="Cut: last station, m.")
def convert_command(
    file: str, out: Path, smooth: float | None, spacing: float | None, reverse: bool, start_at: float | None, end_at: float | None, **options: Any
) -> None:
    """Write the road of FILE as OUT: OpenDRIVE (.xodr), track CSV (.csv) or GeoJSON (.geojson)."""
    made = _one_road(file, chosen(options))
    with complaints():
        import roads
        from roads.editing.smooth import smoothed
        from roads.formats.registry import not_kept
        from roads.gallery.shelf import find

        if out.exists() and out.resolve() == find(file).resolve():
            raise click.ClickException(f"{out}: is the file that is read, give another one to write")

        if start_at is not None or end_at is not None:
            made = made[start_at:end_at]
        if reverse:
            made = made.reversed()
        if smooth is not None:
            made, report = smoothed(made, smooth)
            click.echo(
                f"smoothed: largest deviation {report.largest_left:z.3f} m left, {report.largest_right:z.3f} m right, rms {report.rms_left:z.3f} m "
                f"left, {report.rms_right:z.3f} m right (bound {smooth:g} m); integral of squared curvature "
                f"{report.squared_curvature_before:.4g} -> {report.squared_curvature_after:.4g} 1/m"
            )
        if spacing is not None:
            made = made.resampled(spacing)
        roads.write(made, out)
    lost = not_kept(made, out)
    click.echo(f"written: {out} ({made.length:z.1f} m)" + (f"; not kept: {'; '.join(lost)}" if lost else ""))


@roads_group.command("show")
@click.argument("file")
@road_options
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), default=Path("out/road.png"), show_default=True, help="PNG, SVG or PDF.")
def show_command(file: str, out: Path, **options: Any) -> None:
    """Draw FILE: edges, lanes, height, curvature, speed limits; of a network the map of its lanes."""
    made = _open(file, chosen(options))
    with complaints():
        from ..report import save_road_figure

        save_road_figure(made, out)
    click.echo(f"written: {out}")


@roads_group.command("route")
@click.argument("file")
@road_options
@click.option("--vehicle", default="romo", show_default=True, help="Car whose energy counts with --cost energy.")
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), help="Write the route as a road: .xodr, .csv or .geojson.")
def route_command(file: str, vehicle: str, out: Path | None, start: Place | None, goal: Place | None, **options: Any) -> None:
    """The cheapest way --from A --to B through the network of FILE as one road."""
    import roads
    from roads.gallery.shelf import find

    from ..report import road_table, route_table

    if start is None or goal is None:
        raise click.UsageError("give both --from and --to: a position 'x,y' in m, or the id of a road or lane")
    with complaints():
        cost = chosen({**options, "start": start, "goal": goal}, vehicle)["cost"]
        network = roads.read_network(find(file))
        steps, made = network.steps(start, goal, cost=cost), network.route(start, goal, cost=cost)
        click.echo(route_table(steps))
        click.echo(road_table(made))
        if out is not None:
            roads.write(made, out)
            click.echo(f"written: {out}")


def _is_road(made: Road | Network) -> bool:
    from roads import Road

    return isinstance(made, Road)


def _open(file: str, options: dict[str, Any]) -> Any:
    """The road that is meant, or the network where none is chosen and there are several."""
    import roads
    from roads.formats.registry import NETWORKS
    from roads.gallery.shelf import find

    with complaints():
        path = find(file)
        if path.suffix.lower() in NETWORKS and all(options[key] is None for key in ("road", "start", "goal")):
            network = roads.read_network(path)
            if len(network.roads) > 1:
                return network
        return roads.read(path, **options)


def _one_road(file: str, options: dict[str, Any]) -> Road:
    import roads
    from roads.gallery.shelf import find

    with complaints():
        return roads.read(find(file), **options)
