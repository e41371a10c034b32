"""Readers of cell test files: dynamic tests as G. L. Plett publishes them, and exports of Arbin cyclers."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...errors import VehicleError
from ..tables import ZERO_CELSIUS
from .records import DynamicTest, OcvTest, Script

if TYPE_CHECKING:
    from collections.abc import Sequence
    from os import PathLike

#: Temperature of the scripts that empty and fill the cell, K.
REFERENCE = 25.0 + ZERO_CELSIUS

_DYNAMIC = ("time", "current", "voltage", "chgAh", "disAh")
_ARBIN = ("Test_Time(s)", "Current(A)", "Voltage(V)", "Charge_Capacity(Ah)", "Discharge_Capacity(Ah)")
_NAME = re.compile(r"_(?P<kind>DYN|OCV)_(?:(?P<middle>\w+)_)?(?P<sign>[PN])(?P<degc>\d{1,2})_[sS](?P<script>[1-4])$")

#: How many scripts a test of each kind has.
_SCRIPTS = {"OCV": 4, "DYN": 3}


class Label(NamedTuple):
    """What a file's name says: kind "DYN" or "OCV", temperature in K, number of the script."""

    kind: str
    temperature: float
    script: int


def label(path: str | PathLike[str]) -> Label:
    """Kind, temperature and script from a name such as `A123_DYN_50_P25_s1.csv` or `A123_OCV_N05_S3.csv`.

    Raises:
        VehicleError: another name, one with two temperatures, a script number that the kind does not have.
    """
    found = _NAME.search(Path(path).stem)
    if not found:
        raise VehicleError(f"{path}: name says no test, expected an ending such as _DYN_50_P25_s1.csv or _OCV_N05_S3.csv (P plus, N minus degC)")
    more = [word for word in (found["middle"] or "").split("_") if re.fullmatch(r"[PN]\d{1,2}", word)]
    if more:
        raise VehicleError(f"{path}: name has the temperatures {', '.join(more)} and {found['sign']}{found['degc']}, expected one")
    if int(found["script"]) > _SCRIPTS[found["kind"]]:
        raise VehicleError(f"{path}: name says {found['kind']} script {found['script']}, expected 1 to {_SCRIPTS[found['kind']]}")
    degrees = float(found["degc"]) * (1.0 if found["sign"] == "P" else -1.0)
    return Label(found["kind"], degrees + ZERO_CELSIUS, int(found["script"]))


def kind_of(path: str | PathLike[str]) -> str:
    """What a file's header says: "DYN" or "OCV".

    Raises:
        VehicleError: a header that is neither.
    """
    header = _header(Path(path))
    for kind, wanted in (("DYN", _DYNAMIC), ("OCV", _ARBIN)):
        if set(wanted) <= set(header):
            return kind
    raise VehicleError(f"{path}: header is {', '.join(header)!r}, expected the columns {', '.join(_DYNAMIC)} or {', '.join(_ARBIN)}")


def read_dynamic(path: str | PathLike[str]) -> Script:
    """A script as Plett publishes dynamic tests: `time, step, current, voltage, chgAh, disAh`, current positive on discharge.

    Raises:
        VehicleError: a file that cannot be read, lacks a column, has it twice or holds something else than finite numbers, with the line.
    """
    return _script(Path(path), _DYNAMIC, current_sign=1.0)


def read_arbin(path: str | PathLike[str]) -> Script:
    """A script as an Arbin cycler exports it, current negative on discharge (turned round here).

    Raises:
        VehicleError: as `read_dynamic`.
    """
    return _script(Path(path), _ARBIN, current_sign=-1.0)


def _header(path: Path) -> list[str]:
    try:
        with path.open(encoding="utf-8-sig") as file:
            return [word.strip() for word in file.readline().split(",")]
    except FileNotFoundError:
        raise VehicleError(f"{path}: no such file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise VehicleError(f"{path}: cannot be read as text: {error}") from None


def _script(path: Path, columns: Sequence[str], current_sign: float) -> Script:
    header = _header(path)
    missing = [name for name in columns if name not in header]
    if missing:
        raise VehicleError(f"{path}: line 1 lacks the column {missing[0]}, found {', '.join(header)}")
    twice = [name for name in columns if header.count(name) > 1]
    if twice:
        raise VehicleError(f"{path}: line 1 has the column {twice[0]} {header.count(twice[0])} times, expected once")
    places = [header.index(name) for name in columns]
    if not _has_data(path):
        raise VehicleError(f"{path}: 0 lines of data, expected at least two")
    try:
        table = np.loadtxt(path, delimiter=",", skiprows=1, usecols=places, ndmin=2, encoding="utf-8-sig", comments=None)
    except (ValueError, UnicodeDecodeError):
        raise VehicleError(_first_fault(path, columns, places)) from None
    if len(table) < 2:
        raise VehicleError(f"{path}: {len(table)} lines of data, expected at least two")
    if not np.all(np.isfinite(table)):
        row, column = (int(k) for k in np.argwhere(~np.isfinite(table))[0])
        raise VehicleError(f"{path}: {columns[column]} in data row {row + 1} is {table[row, column]}, expected a finite number")
    t, i, v, charged, discharged = table.T
    for name, column in ((columns[3], charged), (columns[4], discharged)):
        if column[0] < 0.0:
            raise VehicleError(f"{path}: {name} in data row 1 is {column[0]:g}, expected a counter from 0 up")
    return Script(str(path), t - t[0], current_sign * i, v, 3600.0 * charged, 3600.0 * discharged)


def _has_data(path: Path) -> bool:
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        next(file, None)
        return any(line.strip() for line in file)


def _first_fault(path: Path, columns: Sequence[str], places: Sequence[int]) -> str:
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines()[1:], start=2):
        words = line.split(",")
        for name, place in zip(columns, places, strict=True):
            try:
                float(words[place])
            except IndexError:
                return f"{path}: line {number} has {len(words)} columns, expected {name} in column {place + 1}"
            except ValueError:
                return f"{path}: {name} in line {number} is {words[place].strip()!r}, expected a number"
    return f"{path}: not a table of numbers"


def sort_files(files: Sequence[str | PathLike[str]]) -> tuple[list[OcvTest], list[DynamicTest]]:
    """Tests from files, sorted by their headers and names.

    Raises:
        VehicleError: a file that is no test, whose header and name disagree, that comes twice; a test that lacks a script, with its name.
    """
    if not files:
        raise VehicleError("no test files given, expected OCV scripts S1 to S4 and dynamic scripts s1 to s3 of at least one temperature")
    found: dict[Label, Path] = {}
    for path in map(Path, files):
        kind, name = kind_of(path), label(path)
        if kind != name.kind:
            raise VehicleError(f"{path}: name says {name.kind}, header says {kind}")
        if name in found:
            degrees = name.temperature - ZERO_CELSIUS
            raise VehicleError(f"{path}: {name.kind} script {name.script} at {degrees:g} degC comes twice, also {found[name]}")
        found[name] = path
    _complain_of_gaps(found)
    ocv, dynamic = [], []
    for kind, temperature in sorted({(name.kind, name.temperature) for name in found}):
        reader = read_arbin if kind == "OCV" else read_dynamic
        parts = [reader(found[Label(kind, temperature, k)]) for k in range(1, _SCRIPTS[kind] + 1)]
        if kind == "OCV":
            ocv.append(OcvTest(temperature, discharge=parts[0], empty=parts[1], charge=parts[2], full=parts[3]))
        else:
            dynamic.append(DynamicTest(temperature, drive=parts[0], empty=parts[1], full=parts[2]))
    return ocv, dynamic


def _complain_of_gaps(found: dict[Label, Path]) -> None:
    gaps = []
    for kind, count in sorted(_SCRIPTS.items()):
        warmth = sorted({name.temperature for name in found if name.kind == kind})
        if not warmth:
            gaps.append(f"every {kind} script (1 to {count})")
        for temperature in warmth:
            lacking = [k for k in range(1, count + 1) if Label(kind, temperature, k) not in found]
            if lacking:
                gaps.append(f"{kind} at {temperature - ZERO_CELSIUS:g} degC script {', '.join(map(str, lacking))}")
    if gaps:
        raise VehicleError(f"test files: missing {'; '.join(gaps)}")
