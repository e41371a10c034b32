"""Errors of the library, and faults of it, as a person should read them."""

from __future__ import annotations

import os
import traceback
from pathlib import Path

import click

#: Exit code after a fault of the program itself (EX_SOFTWARE of sysexits.h).
FAULT = 70
#: Environment variable that asks for the traceback of a fault; anything but empty or 0 does.
TRACEBACK = "ENERGY_MGR_TRACEBACK"
#: Packages of the project: a fault is placed where it left them.
_OWN = ("energy_mgr", "roads", "powertrain")
#: A word of the command line, or the text of an exception, is shown up to so many letters.
_LONGEST = 300


class complaints:  # noqa: N801  (used like a function)
    """Errors of the library become one line on standard error."""

    def __enter__(self) -> None:
        """Nothing to prepare."""

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: object) -> None:
        """Raise what a person should read."""
        from powertrain import VehicleError
        from roads import RoadError

        from ..errors import PlanningError

        if isinstance(error, RoadError | VehicleError | PlanningError):
            raise click.ClickException(str(error)) from None


def fault_words(error: BaseException, group: click.Group, arguments: list[str]) -> str:
    """One line about an exception that nobody foresaw: command, files given to it, exception and place, and what to do.

    Args:
        error: what was raised.
        group: the commands, to tell their names from other words.
        arguments: the command line.
    """
    about = f"{_command(group, arguments)}: "
    if isinstance(error, MemoryError):
        return _line(f"{about}more memory is needed than there is; try a shorter road, or one with fewer points")
    kind = type(error).__name__
    what = f"{kind} at {_place(error)}" + (f": {text}" if (text := str(error)[:_LONGEST]) else "")
    asked = f"; {TRACEBACK}=1 shows where it comes from" if not wants_traceback() else ""
    return _line(f"{about}{what}. This is a fault of energy-mgr and nothing was written: please report this line together with the file{asked}")


def wants_traceback() -> bool:
    """Whether the environment asks for tracebacks."""
    return os.environ.get(TRACEBACK, "0") not in ("", "0")


def _command(group: click.Group, arguments: list[str]) -> str:
    """The commands' names, and the words after them that name files; where there are none, all words after them that are no options."""
    names: list[str] = []
    for word in arguments:
        found = group.commands.get(word)
        if found is None:
            break
        names.append(word)
        if not isinstance(found, click.Group):
            break
        group = found
    words = [word.partition("=")[2] if word.startswith("--") and "=" in word else word for word in arguments[len(names) :]]
    files = [word for word in words if _is_file(word)] or [word for word in words if not word.startswith("-")]
    return " ".join([*names, *(word[:_LONGEST] for word in files)])


def _is_file(word: str) -> bool:
    try:
        return Path(word).is_file()
    except (OSError, ValueError):
        return False


def _place(error: BaseException) -> str:
    """Module and line where the exception left the project's own code, and where it was raised if that is another."""
    frames = [(str(frame.f_globals.get("__name__", "?")), line) for frame, line in traceback.walk_tb(error.__traceback__)]
    own = [frame for frame in frames if frame[0].split(".")[0] in _OWN]
    places = [f"{module}:{line}" for module, line in dict.fromkeys([*own[-1:], *frames[-1:]])]
    return " in ".join(reversed(places)) if places else "unknown place"


def _line(text: str) -> str:
    return "".join(letter if letter.isprintable() else letter.encode("unicode_escape").decode("ascii") for letter in text.replace("\n", " "))
