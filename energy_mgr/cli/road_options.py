"""Options that say which road of a file is meant; shared by all commands that read roads."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from roads import Road

Place = str | tuple[float, float]


class PlaceType(click.ParamType):  # pyright: ignore[reportMissingTypeArgument]
    """A position `x,y` in m, or the id of a road or lane."""

    name = "place"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Place:
        """Two numbers with a comma between them are a position, everything else is an id."""
        words = str(value).split(",")
        try:
            x, y = (float(word) for word in words)
        except ValueError:
            return str(value)
        return x, y


class AccuracyType(click.ParamType):  # pyright: ignore[reportMissingTypeArgument]
    """One accuracy in m, or two with a comma between them: in the plane and in height."""

    name = "accuracy"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float | tuple[float, float]:
        """A number, or two."""
        words = str(value).split(",")
        try:
            plane, *height = (float(word) for word in words)
        except ValueError:
            plane, height = 0.0, [0.0, 0.0]
        if len(height) > 1:
            self.fail(f"{value!r}, expected one distance in m, or two as in 3,0.5", param, ctx)
        return (plane, height[0]) if height else plane


_OPTIONS = (
    click.option("--closed/--open", "closed", default=None, help="Whether the road is a circuit. Default: as the file says, or as its ends suggest."),
    click.option("--road", "road_id", help="Network: the road of this id."),
    click.option("--from", "start", type=PlaceType(), help="Network: where the route begins: 'x,y' in m, or the id of a road or lane."),
    click.option("--to", "goal", type=PlaceType(), help="Network: where the route ends."),
    None,  # the cost of a route, whose name is not the same everywhere
    click.option("--width", type=float, help="Width of the road in m, for files that hold a line only (GPX, GeoJSON, path tables)."),
    click.option("--lane", type=float, help="Width of the lane in m about the line of a path table; without any width it is 3.5 m."),
    click.option("--raw", is_flag=True, help="Recorded line (GPX, GeoJSON, path table): take it as it is, unsmoothed."),
    click.option(
        "--accuracy",
        type=AccuracyType(),
        metavar="M[,M]",
        help="Recorded line: how far its places lie from the true line in m (root mean square), and its heights. Default: found from the line.",
    ),
    click.option("--leg", type=int, help="Recorded line that turns back on itself or breaks off: which of its ways, from 1. Default: the longest."),
)


def road_options(command: Callable[..., Any], *, cost: tuple[str, ...] = ("--cost",)) -> Callable[..., Any]:
    """Add the options above to `command`, which passes them on to `chosen`; `cost` names the option for the cost of a route."""
    kinds = click.Choice(["length", "time", "energy"])
    route = click.option(*cost, type=kinds, default="length", show_default=True, help="Network: what the route has least of.")
    for option in reversed(_OPTIONS):
        command = (option or route)(command)
    return command


def chosen(options: dict[str, Any], vehicle: str = "romo") -> dict[str, Any]:
    """Take the options above out of `options`, as arguments for `roads.read`."""
    found = {key: options.pop(key) for key in ("closed", "start", "goal", "width", "lane", "cost", "raw", "accuracy", "leg")}
    found["road"] = options.pop("road_id")
    if found["cost"] == "energy":
        from powertrain import load_vehicle

        from ..consumption import route_energy

        found["cost"] = route_energy(load_vehicle(vehicle))
    return found


def told(road: Road) -> Road:
    """`road`, after what its reader noticed or assumed was printed, a line each."""
    for finding in road.findings:
        click.echo(str(finding))
    return road
