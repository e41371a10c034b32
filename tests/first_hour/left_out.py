"""What is not run, each by name and with its reason. A name that no document has any more is a failure: the list does not outlive its reasons."""

from __future__ import annotations

import shutil

#: Run before all others, in the fresh copy.
FIRST = "make plan"

LEFT_OUT = {
    "make test": "CI runs it itself, in a clean clone",
    "make experiments": "CI runs it itself, in a clean clone",
    "make first-hour": "this is it",
    "python -m tests.acceptance.closed_loop": "minutes; `make experiments` makes the same drives and holds its tables to them",
    "make docs": "serves until it is stopped; `make test` builds the pages",
    "make bench": "minutes of measuring, which need a quiet machine",
    "energy-mgr plan": "the name of the command, not a call",
}

#: What a command or block calls, what that needs, and the programs of which one will do. Where none is there it is not run, and told so.
NEEDS = (
    (".compile_c()", "a C compiler", ("cc", "gcc", "clang")),
    ("--animate mp4", "ffmpeg", ("ffmpeg",)),
)


def lacking(text: str) -> str:
    """What a command or block needs that is not on this machine; empty if nothing is missing."""
    return ", ".join(name for call, name, programs in NEEDS if call in text and not any(map(shutil.which, programs)))
