"""Options that bound a drive beside the car's own limits, shared by the commands that plan one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from collections.abc import Callable

    from ..speed import DriveRules

_NAMES = ("start_speed", "end_speed", "stops", "windows", "jerk", "grip", "friction_brakes", "step")


def rule_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of `DriveRules` to a command."""
    for option in reversed(
        [
            click.option("--start-speed", type=float, default=0.0, show_default=True, help="Speed at the start of an open road, m/s."),
            click.option("--end-speed", type=float, default=0.0, show_default=True, help="Speed at the end of an open road, m/s."),
            click.option("--stop", "stops", type=float, multiple=True, metavar="S", help="Stop line at station S of the road, m. May be repeated."),
            click.option(
                "--window", "windows", multiple=True, metavar="S:T1:T2", help="Pass station S (m) T1 to T2 s after the start. May be repeated."
            ),
            click.option("--jerk", type=float, help="Largest jerk, m/s^3. Default: no limit."),
            click.option("--grip", type=float, help="Friction coefficient on dry asphalt, for the friction ellipse. Default: no limit."),
            click.option("--friction-brakes", is_flag=True, help="Brake with the friction brakes too, not by recuperation alone."),
            click.option("--step", type=float, default=2.0, show_default=True, help="Largest distance between stations, m."),
        ]
    ):
        command = option(command)
    return command


def taken_rules(options: dict[str, Any]) -> DriveRules:
    """Take the options of `rule_options` out of `options`.

    Raises:
        click.BadParameter: a window that is not S:T1:T2.
    """
    from ..speed import DriveRules

    given: dict[str, Any] = {name: options.pop(name) for name in _NAMES}
    given["windows"] = tuple(_window(text) for text in given["windows"])
    return DriveRules(**given)


def _window(text: str) -> Any:
    from ..speed import Window

    parts = text.split(":")
    try:
        s, earliest, latest = (float(part) for part in parts)
    except ValueError:
        raise click.BadParameter(f"{text!r}, expected a station and two times, S:T1:T2", param_hint="--window") from None
    return Window(s, earliest, latest)
