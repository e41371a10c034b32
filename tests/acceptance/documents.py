"""The figures that README.md and docs/results.md print, read back, so that tests can hold the documents to what the code computes."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
README, RESULTS = "README.md", "docs/results.md"
#: A number as the documents print it: `-0.0124`, `1,512`, `1e-3`, `+8.6`; a hyphen after a digit is no sign, digits within a word are no number.
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:,\d{3})*(?:\.\d+)?(?:e[-+]?\d+)?")

Table = dict[str, dict[str, str]]


def read(document: str) -> str:
    """Text of a document of the project."""
    return (ROOT / document).read_text(encoding="utf-8")


def figures(document: str, heading_or_first_cell: str) -> Table:
    """One table of a document, see `table`."""
    return table(read(document), heading_or_first_cell)


def table(text: str, heading_or_first_cell: str) -> Table:
    """Rows of a Markdown table by their first cell, each the other cells by the table's headings.

    It is the table whose first heading is the given one, else the first below a heading of the text with these words. Of rows whose first cells
    are equal, the later ones are called "the same 2", "the same 3".
    """
    lines = text.splitlines()
    tables = [k for k in range(1, len(lines)) if re.fullmatch(r"\|(?:-+\|)+", lines[k])]
    named = [k for k in tables if cells(lines[k - 1])[0] == heading_or_first_cell]
    headings = [k for k, line in enumerate(lines) if line.startswith("#") and line.lstrip("# ") == heading_or_first_cell]
    found = named or [k for heading in headings for k in tables if k > heading]
    assert found, f"there is no table '{heading_or_first_cell}'"
    head, rows = cells(lines[found[0] - 1]), {}
    for line in lines[found[0] + 1 :]:
        if not line.startswith("|"):
            break
        first, *rest = cells(line)
        number, name = 1, first
        while name in rows:
            number, name = number + 1, f"{first} {number + 1}"
        rows[name] = dict(zip(head[1:], rest, strict=True))
    return rows


def cells(line: str) -> list[str]:
    """Cells of one row, without the marks of code and emphasis."""
    return [cell.strip().replace("`", "").replace("**", "") for cell in re.split(r"(?<!\\)\|", line.strip())[1:-1]]


def numbers(text: str) -> list[float]:
    """The numbers in a text, in order."""
    return [float(found.replace(",", "")) for found in NUMBER.findall(text)]


def units(text: str) -> list[float]:
    """One unit of the last digit of each number: 0.1 for `+8.6 %`."""
    mantissas = [found.partition("e") for found in NUMBER.findall(text)]
    return [10.0 ** ((int(exponent) if exponent else 0) - len(mantissa.partition(".")[2])) for mantissa, _, exponent in mantissas]


def differences(text: str, *computed: float, digits: float = 1.0, share: float = 0.0) -> list[str]:
    """What is wrong with the numbers of a text: those farther from the computed ones than so many units of their last digit and than that share."""
    said = numbers(text)
    if len(said) != len(computed):
        return [f"'{text}' has {len(said)} numbers, {len(computed)} are computed"]
    found = zip(said, units(text), computed, strict=True)
    # a hair more, for numbers that are decimal in the text and binary here
    off = [(one, value) for one, unit, value in found if abs(one - value) > max(1.000001 * digits * unit, share * abs(value))]
    return [f"'{text}' says {one:g}, computed is {value:.6g}" for one, value in off]


def sentence(document: str, *words: str) -> str:
    """What stands between two phrases of a document; line breaks count as blanks."""
    text = " ".join(read(document).split())
    start, end = (re.escape(part) for part in words)
    found = re.search(f"{start}((?:(?!{start}).)*?){end}", text)
    assert found, f"{document} does not say '{words[0]} ... {words[1]}'"
    return found.group(1)


def printed_comparison() -> dict[str, str]:
    """README's print of `make plan`: of each way to drive the seconds, kWh, kWh saved and % saved."""
    block = next(part for part in read(README).split("```")[1::2] if "saved kWh" in part)
    rows = [re.fullmatch(r">?\s*(.*?)((?:\s+-?\d+\.\d+){4})", line) for line in block.splitlines()]
    return {row.group(1): row.group(2).strip() for row in rows if row}
