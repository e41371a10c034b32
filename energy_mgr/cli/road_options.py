"""Options that say which road of a file is meant; shared by all commands that read roads."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

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


_OPTIONS = (
    click.option("--closed/--open", "closed", default=None, help="Whether the road is a circuit. Default: as the file says, or as its ends suggest."),
    click.option("--road", "road_id", help="Network: the road of this id."),
    click.option("--from", "start", type=PlaceType(), help="Network: where the route begins: 'x,y' in m, or the id of a road or lane."),
    click.option("--to", "goal", type=PlaceType(), help="Network: where the route ends."),
    None,  # the cost of a route, whose name is not the same everywhere
    click.option("--width", type=float, help="Width of the road in m, for files that hold a line only (GPX, GeoJSON, path tables)."),
    click.option("--lane", type=float, help="Width of the lane in m about the line of a path table; without any width it is 3.5 m."),
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
    found = {key: options.pop(key) for key in ("closed", "start", "goal", "width", "lane", "cost")}
    found["road"] = options.pop("road_id")
    if found["cost"] == "energy":
        from powertrain import load_vehicle

        from ..consumption import route_energy

        found["cost"] = route_energy(load_vehicle(vehicle))
    return found
