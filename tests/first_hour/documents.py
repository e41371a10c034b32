"""Commands and Python blocks of a Markdown document, with the line at which each stands."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

#: What a reader would type from the text: `energy-mgr plan rural --time 180`.
_INLINE = re.compile(r"`((?:\.venv/bin/)?energy-mgr [^`]+|(?:\.venv/bin/)?python -m [^`]+|make [^`]+)`")
_FENCE = re.compile(r"^```(\w*)\s*$")
#: In a shell a comment begins with a # after a blank.
_COMMENT = re.compile(r"\s+#\s.*$")
_OUT = re.compile(r"(?:--out|-o) (\S+)")


@dataclass(frozen=True)
class Block:
    """A fenced block.

    Attributes:
        document: name of the file, relative to the checkout.
        line: of the block's first line of content, from 1.
        language: what stands after the fence: `sh`, `python`, `toml`, or nothing.
        section: the last heading of the second level before it; empty before the first.
        text: the content.
    """

    document: str
    line: int
    language: str
    section: str
    text: str


@dataclass(frozen=True)
class Command:
    """A line for the shell.

    Attributes:
        document: name of the file, relative to the checkout.
        line: in it, from 1.
        text: the command, without its comment.
    """

    document: str
    line: int
    text: str

    @property
    def name(self) -> str:
        """The command without where the program lies: what two documents have in common that call the same."""
        return self.text.removeprefix(".venv/bin/")

    @property
    def written(self) -> list[str]:
        """The files and folders that the command says it writes."""
        return _OUT.findall(self.text)


def blocks(checkout: Path, document: str) -> list[Block]:
    """All fenced blocks of a document in order, as `blocks_of`."""
    return blocks_of((checkout / document).read_text(encoding="utf-8"), document)


def blocks_of(text: str, document: str) -> list[Block]:
    """All fenced blocks of a text in order.

    Raises:
        ValueError: a fence that is not closed.
    """
    found: list[Block] = []
    section, language, start, kept = "", None, 0, []
    for number, line in enumerate(text.splitlines(), start=1):
        fence = _FENCE.match(line)
        if language is None:
            if fence:
                language, start, kept = fence[1], number + 1, []
            elif line.startswith("## "):
                section = line[3:].strip()
        elif fence:
            found.append(Block(document, start, language, section, "\n".join(kept) + "\n"))
            language = None
        else:
            kept.append(line)
    if language is not None:
        raise ValueError(f"{document}:{start - 1}: fence is not closed")
    return found


def commands(checkout: Path, document: str) -> list[Command]:
    """The lines of `sh` blocks, and what stands between backticks in the text and begins as a command does; in the order of the document."""
    fenced = blocks(checkout, document)
    found = [
        Command(document, block.line + k, _COMMENT.sub("", line).strip())
        for block in fenced
        if block.language == "sh"
        for k, line in enumerate(block.text.splitlines())
        if line.strip() and not line.lstrip().startswith("#")
    ]
    inside = {block.line + k for block in fenced for k in range(len(block.text.splitlines()))}
    for number, line in enumerate((checkout / document).read_text(encoding="utf-8").splitlines(), start=1):
        if number not in inside:
            found += [Command(document, number, text) for text in _INLINE.findall(line)]
    return sorted(found, key=lambda command: command.line)
