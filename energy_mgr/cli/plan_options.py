"""Options that say what is asked of a plan, shared by the commands that make one; they come out as one `PlanRequest`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from .rule_options import rule_options, taken_rules

if TYPE_CHECKING:
    from collections.abc import Callable

    from ..request import PlanRequest

SPEEDS = ("fast", "toppra", "eco", "socp", "dp", "nlp")
#: Of those that any command may have, with what they add to a help text of its own.
_OPTIONS: dict[str, tuple[tuple[str, ...], dict[str, Any]]] = {
    "corridor": (
        ("--corridor",),
        {
            "type": click.Choice(["lane", "own", "road"]),
            "default": "own",
            "show_default": True,
            "help": "What the car may use: its lane, all lanes that lead its way, or the road from edge to edge.",
        },
    ),
    "path": (
        ("--path",),
        {"type": click.Choice(["lane", "optimal"]), "default": "optimal", "show_default": True, "help": "Lane centre, or path of least curvature."},
    ),
    "speed": (
        ("--speed",),
        {
            "type": click.Choice(SPEEDS),
            "default": "eco",
            "show_default": True,
            "help": "As fast as allowed (fast, toppra), or with least energy (eco; socp, dp and nlp find the same by other means, slower).",
        },
    ),
    "journey_time": (
        ("--time", "journey_time"),
        {
            "type": float,
            "help": "Arrival time, s after the start. Default: the least that both paths (lane, optimal) can make; with --speed fast that of --path.",
        },
    ),
    "margin": (
        ("--margin",),
        {"type": float, "default": 0.2, "show_default": True, "help": "Distance in m between the car's side and the borders."},
    ),
}
#: All that a request takes from a command line, of these options and of others.
_FIELDS = ("corridor", "path", "speed", "method", "journey_time", "price", "soc", "margin")


def plan_options(*names: str, about: str = "") -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Add options of a plan and its rules to a command.

    Args:
        names: which of corridor, path, speed, journey_time, margin; all of them if none is named.
        about: put before each help text, in a command that does more than planning.
    """

    def added(command: Callable[..., Any]) -> Callable[..., Any]:
        command = rule_options(command)
        for name in reversed(names or tuple(_OPTIONS)):
            words, how = _OPTIONS[name]
            command = click.option(*words, **{**how, "help": _after(about, how["help"])})(command)
        return command

    return added


def _after(about: str, words: str) -> str:
    return about + words[0].lower() + words[1:] if about else words


def taken_request(options: dict[str, Any], **more: Any) -> PlanRequest:
    """Take what asks something of a plan out of `options`; with `more` fields of the request.

    Raises:
        click.BadParameter: a window that is not S:T1:T2.
        PlanningError: wishes out of range.
    """
    from ..request import PlanRequest

    rules = taken_rules(options)
    given = {name: options.pop(name) for name in _FIELDS if name in options}
    return PlanRequest(**given, rules=rules, **more)
