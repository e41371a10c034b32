"""The parts of a document or of a source file that speak of the project: what stands between backticks, lines of code, links."""

from __future__ import annotations

import re
from dataclasses import dataclass

from tests.first_hour.documents import blocks_of

_TICKED = re.compile(r"`([^`\n]+)`")
_LINK = re.compile(r"\]\(([^)\s]+)\)")


@dataclass(frozen=True)
class Span:
    """A part of a text.

    Attributes:
        line: in the text, from 1.
        kind: `ticked`, `link`, or the language of the fenced block (`sh`, `python`, empty).
        text: of the part; of a block, one line.
    """

    line: int
    kind: str
    text: str


def of_markdown(text: str) -> list[Span]:
    """The lines of fenced blocks; outside of them what is ticked, and the targets of links."""
    inside = {
        block.line + k: Span(block.line + k, block.language, line)
        for block in blocks_of(text, "text")
        for k, line in enumerate(block.text.splitlines())
    }
    found = list(inside.values())
    for number, line in enumerate(text.splitlines(), start=1):
        if number not in inside and not line.startswith("```"):
            found += [Span(number, "ticked", part) for part in _TICKED.findall(line)]
            found += [Span(number, "link", part) for part in _LINK.findall(line)]
    return sorted(found, key=lambda span: span.line)


def of_source(text: str) -> list[Span]:
    """What is ticked in a Python file: its docstrings and comments; code has no backticks.

    Bare options are left out: scripts have their own.
    """
    return [
        Span(number, "ticked", part)
        for number, line in enumerate(text.splitlines(), start=1)
        for part in _TICKED.findall(line)
        if not part.startswith("--")
    ]
