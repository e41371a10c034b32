"""How the rows of a text table are to be read: what stands between columns, and whether decimals begin with a point or a comma."""

from __future__ import annotations

import re
from typing import NamedTuple

from ...errors import RoadError

#: A number with a decimal comma, and a word that may stand beside such in one row.
_COMMA = re.compile(r"[+-]?\d*,\d+(e[+-]?\d+)?$|[+-]?\d+,$", re.IGNORECASE)
_BESIDE = re.compile(r"[+-]?(\d+|\d*,\d+|\d+,)(e[+-]?\d+)?$|[+-]?inf(inity)?$|nan$", re.IGNORECASE)
_POINT = re.compile(r"[+-]?\d*\.\d*(e[+-]?\d+)?$", re.IGNORECASE)


class Layout(NamedTuple):
    """What stands between columns (None: blanks), and whether decimals have a comma."""

    delimiter: str | None
    decimal_comma: bool = False

    def words(self, row: str) -> list[str]:
        """The words of a row as they stand there."""
        return words_of(row, self.delimiter)

    def plain(self, text: str) -> str:
        """A word, or a row split by something else than commas, with decimal points."""
        return text.replace(",", ".") if self.decimal_comma else text


def delimiter_of(row: str) -> str | None:
    """The first of semicolon, comma and tab that is in the row; None: blanks."""
    return next((mark for mark in (";", ",", "\t") if mark in row), None)


def words_of(row: str, delimiter: str | None) -> list[str]:
    """What stands between delimiters, without blanks and quotes about it."""
    return [word.strip().strip('"') for word in row.split(delimiter)]


def layout_of(path: object, rows: list[str], lines: list[int]) -> Layout:
    """How to read the data `rows`, whose line numbers are `lines`; decided once for the whole file.

    With semicolons between columns a comma can only be a decimal one. With tabs or blanks it is one where all words between these are numbers, which
    none would be that ends with a comma for delimiter.

    Raises:
        RoadError: decimal commas in some rows and decimal points in others.
    """
    if ";" in rows[0]:
        layout = Layout(";", any("," in row for row in rows))
    else:
        apart = "\t" if "\t" in rows[0] else None
        layout = Layout(apart, True) if "," in rows[0] and _by_blanks(rows[0], apart) else Layout(delimiter_of(rows[0]))
    if layout.decimal_comma and any("." in row for row in rows):
        _refuse_mixed(path, rows, lines, layout)
    return layout


def _by_blanks(row: str, apart: str | None) -> bool:
    words = words_of(row, apart)
    return len(words) > 1 and any("," in word for word in words) and all(_BESIDE.match(word) and not word.endswith(",") for word in words)


def _refuse_mixed(path: object, rows: list[str], lines: list[int], layout: Layout) -> None:
    """Raise RoadError that names one number of each kind, if there are both."""
    point, comma = (_first(rows, lines, layout, pattern) for pattern in (_POINT, _COMMA))
    if point and comma:
        (line, word), (other, beside) = max(point, comma), min(point, comma)
        raise RoadError(f"{path}:{line}: {word[:40]!r} beside {beside[:40]!r} in line {other}, expected decimal points or decimal commas, not both")


def _first(rows: list[str], lines: list[int], layout: Layout, pattern: re.Pattern[str]) -> tuple[int, str] | None:
    for line, row in zip(lines, rows, strict=True):
        for word in layout.words(row):
            if pattern.match(word):
                return line, word
    return None
