"""Tables of numbers in text files: header, delimiter, keys, and errors by line."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...errors import RoadError
from ..text import read_text
from .layout import delimiter_of, layout_of, words_of

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from .layout import Layout

    Floats = NDArray[np.float64]

#: No coordinate, width, height or limit on Earth is larger in m or m/s.
LARGEST = 1e9


@dataclass(frozen=True, eq=False)
class Table:
    """A text table.

    Attributes:
        path: its file.
        keys: `# key: value` lines.
        names: column names in lower case; empty where the file has no header.
        rows: (n, k) values.
        lines: (n,) line number of each row.
        header: line number of the header, 1 where there is none.
    """

    path: Path
    keys: dict[str, str]
    names: list[str]
    rows: Floats
    lines: list[int]
    header: int = 1

    def at(self, row: int) -> str:
        """`file:line` of a row."""
        return f"{self.path}:{self.lines[row]}"

    def only(self, keep: NDArray[np.bool_]) -> Table:
        """The same table with those rows (n,) that are to be kept."""
        return replace(self, rows=self.rows[keep], lines=[line for line, kept in zip(self.lines, keep.tolist(), strict=True) if kept])


@dataclass(frozen=True, eq=False)
class Rows:
    """A text table whose rows are not yet numbers: `bodies` at `lines`, else as `Table`."""

    path: Path
    keys: dict[str, str]
    names: list[str]
    bodies: list[str]
    lines: list[int]
    layout: Layout
    header: int

    def table(self) -> Table:
        """The rows as numbers.

        Raises:
            RoadError: rows of different lengths, words that are not finite numbers.
        """
        count = len(self.layout.words(self.bodies[0]))
        numbers = _numbers(self.path, self.bodies, self.lines, self.layout, self.names, count)
        return Table(self.path, self.keys, self.names, numbers, self.lines, self.header)


def read_table(path: Path) -> Table:
    """As `read_rows`, with all words as numbers.

    Raises:
        RoadError: as there, or rows of different lengths, words that are not finite numbers.
    """
    return read_rows(path).table()


def read_rows(path: Path) -> Rows:
    """Read a table with commas, semicolons, tabs or blanks between its columns, `# key: value` lines and perhaps a header above it.

    Decimals may have commas throughout, where semicolons, tabs or blanks stand between columns.

    Raises:
        RoadError: not text, no rows, a header of another length, decimal points and commas in one file.
    """
    keys: dict[str, str] = {}
    headers: list[tuple[int, list[str], bool]] = []
    bodies: list[str] = []
    lines: list[int] = []
    everything = [raw.strip() for raw in read_text(path).splitlines()]
    for number, line in enumerate(everything, 1):
        if not line:
            continue
        if line[0] == "#":
            body = line.lstrip("# ")
            key, colon, value = body.partition(":")
            if colon and key.strip().isidentifier() and key.strip().lower() != "columns":
                keys.setdefault(key.strip().lower(), value.strip())
                continue
            body = value.strip() if colon and key.strip().lower() == "columns" else body
            if _is_header(words := words_of(body, delimiter_of(body))):
                headers.append((number, words, True))
        elif _is_header(words := words_of(line, delimiter_of(line))) and not any(not comment for _, _, comment in headers):
            headers.append((number, words, False))
        else:
            # data from here on; remarks between them say nothing
            lines = [at for at, later in enumerate(everything[number - 1 :], number) if later and later[0] != "#"]
            bodies = [everything[at - 1] for at in lines]
            break
    if not bodies:
        raise RoadError(f"{path}: no data, expected rows of numbers")
    layout = layout_of(path, bodies, lines)
    count = len(layout.words(bodies[0]))
    header = _chosen(path, headers, count, lines[0])
    names = [word.lower() for word in header[1]] if header else []
    return Rows(path, keys, names, bodies, lines, layout, header[0] if header else 1)


def _chosen(path: Path, headers: list[tuple[int, list[str], bool]], count: int, first: int) -> tuple[int, list[str], bool] | None:
    """The header among the lines above the data: one as wide as they are; a comment that only looks like one is none.

    Raises:
        RoadError: a line that names columns, though not as many as there are.
    """
    for header in reversed(headers):
        if len(header[1]) == count and (not header[2] or _names_columns(header[1]) or len(headers) == 1):
            return header
    for number, words, comment in headers:
        if not comment or _names_columns(words):
            raise RoadError(f"{path}:{first}: {count} columns, expected {len(words)} as in line {number} ({shown(words)})")
    return None


def _names_columns(words: list[str]) -> bool:
    """Whether coordinates are among the words, which no remark has."""
    return any(word.lower().split("_")[0] in ("x", "y") or "_x" in word.lower() for word in words)


def shown(words: list[str]) -> str:
    """Words for a message: printable, and not too many."""
    text = ", ".join(word.encode("unicode_escape").decode("ascii") for word in words[:12])
    return (text if len(text) <= 200 else text[:197] + "...") + (f", ... ({len(words)} in all)" if len(words) > 12 else "")


def _is_header(words: list[str]) -> bool:
    """Two or more names, no numbers among them."""
    return len(words) > 1 and all(word[:1].isalpha() and not _number(word) for word in words)


def _number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _numbers(path: Path, bodies: list[str], lines: list[int], layout: Layout, names: list[str], count: int) -> Floats:
    split = [layout.plain(body).split(layout.delimiter) for body in bodies]
    try:
        rows = np.array(split, dtype=np.float64)
        if rows.ndim == 2 and np.all(np.abs(rows) < LARGEST) and (joined := "".join(bodies)).isascii() and "_" not in joined:
            return rows
    except ValueError:
        pass
    # something is wrong: find it, word by word
    return np.array([_row(path, number, layout.words(body), layout, names, count) for number, body in zip(lines, bodies, strict=True)])


def _row(path: Path, number: int, words: list[str], layout: Layout, names: list[str], count: int) -> list[float]:
    if len(words) != count:
        raise RoadError(f"{path}:{number}: {len(words)} columns, expected {count}{' (' + shown(names) + ')' if names else ''}")
    values = []
    for k, word in enumerate(words):
        plain = layout.plain(word)
        value = float(plain) if _number(plain) and word.isascii() and "_" not in word else float("nan")
        if not abs(value) < LARGEST and not (value == np.inf and names and names[k].startswith("speed_limit")):
            label = shown([names[k]]) if names else f"column {k + 1}"
            raise RoadError(f"{path}:{number}: {label} is {word[:40]!r}, expected a finite number below {LARGEST:g}")
        values.append(value)
    return values
