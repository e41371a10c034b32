"""Does the command line know what a text shows? Lines are parsed against the commands' own declarations; nothing is run."""

from __future__ import annotations

import re
import shlex
from functools import cache
from itertools import product
from typing import TYPE_CHECKING

import click

from energy_mgr.cli.main import cli

if TYPE_CHECKING:
    from collections.abc import Iterator

    from .spans import Span

_COMMENT = re.compile(r"(^|\s)#\s.*$")
_PROGRAM = re.compile(r"^(?:\S*/)?energy-mgr(?=\s|$)")
#: `vehicle info`, as a text says it that has named the program before.
_SHORT = re.compile(r"^(roads|vehicle|battery) [a-z]+( [A-Z]+)?$")
#: `ID`, `FILES...`: what the reader puts in.
_STANDS_FOR = re.compile(r"^\[?[A-Z][A-Z_]*(\.\.\.)?\]?$")


def command_lines(span: Span) -> list[str]:
    """Complaints about `energy-mgr ...`, `vehicle info` and `--option value`."""
    text = _COMMENT.sub("", span.text).strip()
    if span.kind not in ("ticked", "sh"):
        return []
    if _PROGRAM.match(text) or (span.kind == "ticked" and _SHORT.match(text)):
        return [told for words in _spelled_out(shlex.split(_PROGRAM.sub("", text))) for told in _parsed(words)]
    if span.kind == "ticked" and text.startswith("--"):
        return [told for words in _spelled_out(shlex.split(text)) for told in _options_of_some_command(words)]
    return []


def _spelled_out(words: list[str]) -> Iterator[list[str]]:
    """`info|check` stands for two commands."""
    for chosen in product(*(word.split("|") for word in words)):
        yield list(chosen)


def _parsed(words: list[str]) -> list[str]:
    command: click.Command = cli
    context = click.Context(cli, info_name="energy-mgr")
    rest = list(words)
    while isinstance(command, click.Group) and rest and not rest[0].startswith("-"):
        name = rest.pop(0)
        inner = command.get_command(context, name)
        if inner is None:
            return [f"no command {name} in `{context.command_path}`"]
        command, context = inner, click.Context(inner, parent=context, info_name=name)
    try:
        values, left, _ = command.make_parser(context).parse_args(rest)
    except click.UsageError as error:
        return [f"`{context.command_path}`: {error.message}"]
    told = [f"`{context.command_path}` takes no further {word}" for word in left]
    for param in command.get_params(context):
        given = values.get(param.name or "")
        for value in given if isinstance(given, list | tuple) else [given]:
            told += _value(context, param, value)
    return told


def _value(context: click.Context, param: click.Parameter, value: object) -> list[str]:
    """Choices, numbers and so on; whether a file is there is not the documents' to say."""
    if not isinstance(value, str) or not isinstance(param, click.Option) or param.is_flag or isinstance(param.type, click.Path):
        return []
    if _STANDS_FOR.match(value):
        return []
    try:
        param.type.convert(value, param, context)
    except click.UsageError as error:
        return [f"`{context.command_path}` {param.opts[-1]}: {error.message}"]
    return []


@cache
def _all_options() -> dict[str, list[tuple[click.Context, click.Option]]]:
    """The options of all commands by what is typed."""
    found: dict[str, list[tuple[click.Context, click.Option]]] = {}
    todo = [click.Context(cli, info_name="energy-mgr")]
    while todo:
        context = todo.pop()
        if isinstance(context.command, click.Group):
            todo += [click.Context(inner, parent=context, info_name=name) for name, inner in context.command.commands.items()]
        for param in context.command.get_params(context):
            if isinstance(param, click.Option):
                for name in (*param.opts, *param.secondary_opts):
                    found.setdefault(name, []).append((context, param))
    return found


def _options_of_some_command(words: list[str]) -> list[str]:
    """Every option is one of some command, which takes the value behind it."""
    told = []
    for word, value in zip(words, [*words[1:], "--"], strict=True):
        if not word.startswith("--"):
            continue
        known = _all_options().get(word)
        if known is None:
            told.append(f"no command has an option {word}")
        elif not value.startswith("--"):
            complaints = [_value(context, option, value) for context, option in known]
            told += [] if any(not found for found in complaints) else complaints[0]
    return told
