"""Reader of `.tir` tyre property files (MF-Tyre, MF-Swift, Adams PAC2002): sections, `key = value $ comment`, strings in quotes.

Rules that the format leaves open are settled towards refusing: units other than SI, a key twice in a section, a coefficient in two sections and a
number that is none are errors with file and line. Text outside of keys, such as the tables of Adams' curves, is skipped where it can be told apart.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from ..errors import VehicleError
from .mf.coefficients import Coefficients

if TYPE_CHECKING:
    from os import PathLike

    from .mf.model import MfTyre

SHELF = Path(__file__).parent / "data"

#: FITTYP of a file and the equations it asks for. 6.2 changes the vertical deflection, not the forces that are modelled here.
VERSIONS: dict[int, Literal["5.2", "6.1"]] = {6: "5.2", 21: "5.2", 52: "5.2", 60: "6.1", 61: "6.1", 62: "6.1"}
#: Words that a unit may be given as; anything else is not SI.
UNITS = {
    "LENGTH": ("meter", "metre", "m"),
    "FORCE": ("newton", "n"),
    "ANGLE": ("radians", "radian", "rad"),
    "MASS": ("kg", "kilogram"),
    "TIME": ("second", "sec", "s"),
    "PRESSURE": ("pascal", "pa"),
}
_ESSENTIAL = ("FNOMIN", "UNLOADED_RADIUS", "PCX1", "PDX1", "PKX1", "PCY1", "PDY1", "PKY1", "PKY2")
_POSITIVE = ("FNOMIN", "UNLOADED_RADIUS", "LFZO", "PCX1", "PDX1", "PCY1", "PKX1", "PKY2", "LMUX", "LMUY", "LCX", "LCY", "LKX", "LKY")
_RANGES = (("KPUMIN", "KPUMAX"), ("ALPMIN", "ALPMAX"), ("CAMMIN", "CAMMAX"), ("FZMIN", "FZMAX"), ("PRESMIN", "PRESMAX"))
_LARGEST = 1_000_000
_KNOWN = frozenset(Coefficients.__struct_fields__)
_COEFFICIENT = re.compile(r"[LPQRS][A-Z]{1,4}[0-9]+")
#: Not `splitlines`, to which letters of Windows-1252 are line ends.
_LINE_END = re.compile(r"\r\n|\r|\n")
_KEY = re.compile(r"[A-Za-z][\w./-]*")


@dataclass(frozen=True)
class Entry:
    """A value of a `.tir` file with the line it stands in."""

    value: float | str
    line: int


#: What tyres of road vehicles can be: values in mm or kN are found here.
_SIZES = {"UNLOADED_RADIUS": (0.05, 2.0, "m"), "FNOMIN": (50.0, 2e5, "N")}
#: No coefficient and no stiffness is larger.
_LARGEST_NUMBER = 1e9


def read_tir(path: str | PathLike[str]) -> MfTyre:
    """The tyre that a `.tir` file describes.

    Missing coefficients are 0 and missing scaling factors 1, as the standard has it. UTF-8 and Latin-1, any line ends.

    Args:
        path: the file, or the name of one that ships with the package, such as "car205_60r15".

    Raises:
        VehicleError: a file that cannot be read, is malformed, asks for another model or other units, or lacks an essential coefficient.
    """
    from .mf.model import MfTyre

    where = Path(path)
    if where.suffix == "" and not where.is_file():
        where = SHELF / f"{path}.tir"
        if not where.is_file():
            shipped = ", ".join(sorted(file.stem for file in SHELF.glob("*.tir")))
            raise VehicleError(f"{path}: no such file and no shipped tyre, expected a .tir file or one of {shipped}")
    sections = parse_tir(where)
    version = _version(where, sections)
    _check_units(where, sections)
    numbers = _numbers(where, sections)
    _check_numbers(where, numbers)
    values = {key: float(entry.value) for key, entry in numbers.items() if key in _KNOWN}
    unused = tuple(sorted(key for key in numbers if key not in _KNOWN and _COEFFICIENT.fullmatch(key)))
    return MfTyre(name=str(where), version=version, coefficients=Coefficients(**values), side=_side(where, sections), unused=unused)


def parse_tir(path: str | PathLike[str]) -> dict[str, dict[str, Entry]]:
    """Sections of a `.tir` file with their keys, both in capitals; values are numbers or text.

    Raises:
        VehicleError: a file that cannot be read or a line that is no section, key, table row or comment.
    """
    sections: dict[str, dict[str, Entry]] = {}
    section, table = "", False
    for number, raw in enumerate(_LINE_END.split(_text(Path(path))), start=1):
        line = _without_comment(raw).strip()
        if not line:
            continue
        if line.startswith("["):
            if not line.endswith("]") or not line[1:-1].strip():
                raise _bad(path, number, line, "a section name in brackets")
            section, table = line[1:-1].strip().upper(), False
            sections.setdefault(section, {})
        elif line.startswith("{"):
            table = True
        elif "=" in line:
            _add(path, number, line, sections, section)
        elif not (table and all(_number(word) is not None for word in line.split())):
            raise _bad(path, number, line, "[SECTION], KEY = value or a comment after $ or !")
    return sections


def _text(path: Path) -> str:
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise VehicleError(f"{path}: no such file") from None
    except OSError as error:
        raise VehicleError(f"{path}: cannot be read: {error.strerror}") from None
    if len(data) > _LARGEST or b"\0" in data:
        kind = f"{len(data)} bytes" if len(data) > _LARGEST else "binary data or UTF-16"
        raise VehicleError(f"{path}: found {kind}, expected a text file in UTF-8 or Latin-1 of at most {_LARGEST} bytes")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def _without_comment(line: str) -> str:
    """The line up to a `$` or `!` that is not inside quotes."""
    quoted = False
    for at, letter in enumerate(line):
        if letter == "'":
            quoted = not quoted
        elif letter in "$!" and not quoted:
            return line[:at]
    return line


def _add(path: str | PathLike[str], number: int, line: str, sections: dict[str, dict[str, Entry]], section: str) -> None:
    key, _, text = (part.strip() for part in line.partition("="))
    if not _KEY.fullmatch(key):
        raise _bad(path, number, line, "a key of letters, digits and _ before the equals sign")
    if not section:
        raise _bad(path, number, line, "a [SECTION] before the first key")
    key = key.upper()
    if key in sections[section]:
        raise VehicleError(f"{path}: line {number}: {key} again, expected once in [{section}], first in line {sections[section][key].line}")
    if text.startswith("'"):
        if len(text) < 2 or not text.endswith("'") or "'" in text[1:-1]:
            raise _bad(path, number, line, "text between a pair of single quotes")
        value: float | str = text[1:-1].strip()
    else:
        value = text if (parsed := _number(text)) is None else parsed
        if value == "" or (key in _KNOWN and isinstance(value, str)):
            raise _bad(path, number, line, f"a finite number for {key}")
    sections[section][key] = Entry(value, number)


def _number(word: str) -> float | None:
    """The number that a word stands for (Fortran's D for an exponent, too), or None."""
    if not re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?", word):
        return None
    value = float(word.upper().replace("D", "E"))
    return value if math.isfinite(value) else None


def _bad(path: str | PathLike[str], number: int, found: str, expected: str) -> VehicleError:
    short = found if len(found) <= 60 else f"{found[:57]}..."
    return VehicleError(f"{path}: line {number}: found {short!r}, expected {expected}")


def _version(path: Path, sections: dict[str, dict[str, Entry]]) -> Literal["5.2", "6.1"]:
    model = sections.get("MODEL", {})
    entry = model.get("FITTYP")
    if entry is None:
        adams = model.get("PROPERTY_FILE_FORMAT")
        if adams is not None and str(adams.value).upper() == "PAC2002":
            return "5.2"
        raise VehicleError(f"{path}: key FITTYP of [MODEL] is missing, expected one of {', '.join(map(str, VERSIONS))}, or PAC2002 as the format")
    found = VERSIONS.get(int(entry.value)) if isinstance(entry.value, float) and entry.value.is_integer() else None
    if found is None:
        raise VehicleError(f"{path}: line {entry.line}: FITTYP is {entry.value!r}, expected one of {', '.join(map(str, VERSIONS))}")
    return found


def _check_units(path: Path, sections: dict[str, dict[str, Entry]]) -> None:
    for key, entry in sections.get("UNITS", {}).items():
        if key in UNITS and str(entry.value).lower() not in UNITS[key]:
            raise VehicleError(f"{path}: line {entry.line}: unit of {key} is {entry.value!r}, expected SI, {UNITS[key][0]!r}")


def _numbers(path: Path, sections: dict[str, dict[str, Entry]]) -> dict[str, Entry]:
    """All numbers of the file but units; a coefficient may stand in one section only."""
    numbers: dict[str, Entry] = {}
    for section, entries in sections.items():
        for key, entry in entries.items():
            if section == "UNITS" or isinstance(entry.value, str):
                if key in _KNOWN and section != "UNITS":
                    raise VehicleError(f"{path}: line {entry.line}: {key} is {entry.value!r}, expected a number")
                continue
            if key in _KNOWN and key in numbers:
                raise VehicleError(f"{path}: line {entry.line}: {key} again in [{section}], expected once, first in line {numbers[key].line}")
            numbers.setdefault(key, entry)
    return numbers


def _check_numbers(path: Path, numbers: dict[str, Entry]) -> None:
    for key in _ESSENTIAL:
        if key not in numbers:
            raise VehicleError(f"{path}: key {key} is missing, expected it among the coefficients")
    for key in (*_POSITIVE, "LONGVL", "NOMPRES", "VERTICAL_STIFFNESS"):
        if key in numbers and not _float(numbers[key]) > 0.0:
            raise VehicleError(f"{path}: line {numbers[key].line}: {key} is {numbers[key].value:g}, expected more than 0")
    for key, (least, most, unit) in _SIZES.items():
        if key in numbers and not least <= _float(numbers[key]) <= most:
            found = f"{path}: line {numbers[key].line}: {key} is {numbers[key].value:g}"
            raise VehicleError(f"{found}, expected {least:g} to {most:g} {unit}")
    if worst := [key for key in numbers if abs(_float(numbers[key])) > _LARGEST_NUMBER]:
        raise VehicleError(f"{path}: line {numbers[worst[0]].line}: {worst[0]} is {numbers[worst[0]].value:g}, expected at most {_LARGEST_NUMBER:g}")
    for key in ("PDY1", "PKY1"):
        if _float(numbers[key]) == 0.0:
            raise VehicleError(f"{path}: line {numbers[key].line}: {key} is 0, expected a number other than 0")
    for low, high in _RANGES:
        if low in numbers and high in numbers and not _float(numbers[low]) < _float(numbers[high]):
            place = f"{path}: line {numbers[high].line}"
            raise VehicleError(f"{place}: {low} is {numbers[low].value:g} and {high} is {numbers[high].value:g}, expected an increasing pair")


def _float(entry: Entry) -> float:
    return float(entry.value)


def _side(path: Path, sections: dict[str, dict[str, Entry]]) -> Any:
    entry = sections.get("MODEL", {}).get("TYRESIDE")
    side = "symmetric" if entry is None else str(entry.value).lower()
    if side in ("left", "right", "symmetric"):
        return side
    assert entry is not None
    raise VehicleError(f"{path}: line {entry.line}: TYRESIDE is {entry.value!r}, expected 'LEFT', 'RIGHT' or 'SYMMETRIC'")
