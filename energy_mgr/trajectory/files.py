"""Trajectories as files: CSV, Parquet, and path tables that `roads.read` takes.

A CSV file holds the columns `LABELS` in shortest digits that read back bit for bit, with the lines `# name:` and `# closed:` above
them; Parquet holds the same columns and keeps name and flag in its metadata. Both readers take columns in any order and leave further ones
aside. A file that does not say whether it is closed is closed if its last row goes on as its first one, not from standstill. Columns that say
the same twice (a and v, t and v, psi and the points) must agree to 0.1 %, so that a table in other units or by other conventions is noticed.
"""

from __future__ import annotations

import importlib
import json
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from roads import RoadError
from roads.formats.tables.table import read_table, shown
from roads.formats.text import read_bytes

from ..errors import PlanningError
from .check import LABELS, discord, ends_meet, first_fault

if TYPE_CHECKING:
    from collections.abc import Callable
    from os import PathLike

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


class Columns(Protocol):
    """What is written: a `Trajectory`, or anything with its columns."""

    @property
    def columns(self) -> dict[str, Floats]:
        """The arrays by name, in the order of `LABELS`."""
        ...

    @property
    def name(self) -> str:
        """Of the trajectory."""
        ...

    @property
    def closed(self) -> bool:
        """Whether it is a circuit."""
        ...


class Table(NamedTuple):
    """What was read and agrees with itself: the columns of a `Trajectory`."""

    columns: dict[str, Floats]
    closed: bool
    name: str


SUFFIXES = (".csv", ".parquet")
#: The columns of a path table and the attributes they come from.
PATH_TABLE = {"s_m": "s", "x_m": "x", "y_m": "y", "psi_rad": "psi", "v_mps": "v", "kappa_radpm": "kappa"}
#: Where the metadata of a Parquet file has ours.
_KEY = b"energy_mgr.trajectory"


def save(trajectory: Columns, path: str | PathLike[str]) -> None:
    """Write CSV or Parquet, as the suffix says, whole or not at all.

    Raises:
        PlanningError: another suffix, a place that cannot be written to.
    """
    (write_csv if _suffix(path) == ".csv" else write_parquet)(trajectory, path)


def read(path: str | PathLike[str]) -> Table:
    """Read CSV or Parquet, as the suffix says; `Trajectory.load` makes a trajectory of it.

    Raises:
        PlanningError: in one line what is wrong where: file, line, column, found, expected.
    """
    return (read_csv if _suffix(path) == ".csv" else read_parquet)(path)


def write_csv(trajectory: Columns, path: str | PathLike[str], *, remarks: bool = True) -> None:
    """Write a CSV file. Without `remarks` its first line is the header, as some programs want it; name and closed flag are then not kept.

    Raises:
        PlanningError: a place that cannot be written to.
    """
    above = _remarks(trajectory) if remarks else ""
    _write_text(path, above, trajectory.columns, tuple(LABELS.values()))


def write_path_table(trajectory: Columns, path: str | PathLike[str], *, height: bool = False) -> None:
    """Write a path table: s, x, y, psi, v, kappa, which `roads.read` takes as a road about this line (`lane` and `width` given).

    Args:
        trajectory: what to write.
        path: CSV file.
        height: add a column `z_m`; a road without it is flat.

    Raises:
        PlanningError: another suffix than .csv, a place that cannot be written to.
    """
    if Path(path).suffix.lower() != ".csv":
        raise PlanningError(f"{path}: unknown kind of path table {Path(path).suffix!r}, expected .csv")
    wanted = PATH_TABLE | ({"z_m": "z"} if height else {})
    _write_text(path, _remarks(trajectory), {name: trajectory.columns[name] for name in wanted.values()}, tuple(wanted))


def read_csv(path: str | PathLike[str]) -> Table:
    """Read a CSV file.

    Raises:
        PlanningError: in one line what is wrong where: file, line, column, found, expected.
    """
    try:
        table = read_table(Path(path))
    except RoadError as error:
        raise PlanningError(str(error)) from None
    if not table.names:
        raise PlanningError(f"{path}:{table.lines[0]}: no line with the names of columns above the data, expected {', '.join(LABELS.values())}")
    _refuse_columns(f"{path}:{table.header}", table.names)
    word = table.keys.get("closed")
    if word not in (None, "true", "false"):
        raise PlanningError(f"{path}: closed is {word[:40]!r}, expected true or false")
    columns = {name: table.rows[:, table.names.index(label)] for name, label in LABELS.items()}
    return _made(path, columns, None if word is None else word == "true", table.keys.get("name", ""), table.at)


def write_parquet(trajectory: Columns, path: str | PathLike[str]) -> None:
    """Write a Parquet file with check sums.

    Raises:
        PlanningError: a place that cannot be written to.
    """
    arrow, parquet = _pyarrow()
    about = {_KEY: json.dumps({"name": trajectory.name, "closed": trajectory.closed}).encode()}
    table = arrow.table(dict(zip(tuple(LABELS.values()), trajectory.columns.values(), strict=True))).replace_schema_metadata(about)
    _whole(path, lambda staged: parquet.write_table(table, staged, write_page_checksum=True))


def read_parquet(path: str | PathLike[str]) -> Table:
    """Read a Parquet file.

    Raises:
        PlanningError: in one line what is wrong where: file, row (from 0), column, found, expected.
    """
    arrow, parquet = _pyarrow()
    try:
        # from memory: no name of a folder is taken for a column
        table = parquet.ParquetFile(arrow.BufferReader(read_bytes(Path(path))), page_checksum_verification=True).read()
    except RoadError as error:
        raise PlanningError(str(error)) from None
    except (arrow.ArrowException, OSError, ValueError) as error:
        raise PlanningError(f"{path}: not a readable Parquet file ({_line(error)})") from None
    _refuse_columns(str(path), table.column_names)
    closed, name = _about(path, (table.schema.metadata or {}).get(_KEY))
    columns = {key: _numbers(path, label, table.column(label), arrow) for key, label in LABELS.items()}
    return _made(path, columns, closed, name, lambda row: f"{path}: row {row}")


def _made(path: str | PathLike[str], columns: dict[str, Floats], closed: bool | None, name: str, at: Callable[[int], str]) -> Table:
    if len(columns["s"]) < 2:
        raise PlanningError(f"{path}: {len(columns['s'])} rows, expected at least 2")
    fault = first_fault(columns, closed=bool(closed)) or discord(columns)
    if fault:
        raise PlanningError(f"{at(fault.row)}: {fault.text}")
    return Table(columns, ends_meet(columns) if closed is None else closed, name or Path(path).stem)


def _refuse_columns(where: str, names: list[str]) -> None:
    for label in LABELS.values():
        if names.count(label) != 1:
            found = "no column" if label not in names else f"{names.count(label)} columns"
            raise PlanningError(f"{where}: {found} {label} among {shown(names)}, expected one each of {', '.join(LABELS.values())}")


def _numbers(path: str | PathLike[str], label: str, column: Any, arrow: Any) -> Floats:
    if not (arrow.types.is_floating(column.type) or arrow.types.is_integer(column.type)):
        raise PlanningError(f"{path}: {label} is of type {column.type}, expected numbers")
    if column.null_count:
        row = int(np.argmax(column.is_null().to_numpy()))
        raise PlanningError(f"{path}: row {row}: {label} is null, expected a finite number")
    return column.to_numpy().astype(np.float64)


def _about(path: str | PathLike[str], found: bytes | None) -> tuple[bool | None, str]:
    """Closed flag and name in the metadata; None and nothing where the file is not ours."""
    if found is None:
        return None, ""
    try:
        about = json.loads(found)
        if isinstance(about["closed"], bool) and isinstance(about["name"], str):
            return about["closed"], about["name"]
    except (ValueError, KeyError, TypeError):
        pass
    raise PlanningError(f"{path}: metadata {_KEY.decode()} is {_line(found)}, expected an object with closed (true or false) and name")


def _pyarrow() -> tuple[Any, Any]:
    """The library, loaded when the first Parquet file is touched: it takes longer to load than a short trajectory to write."""
    return importlib.import_module("pyarrow"), importlib.import_module("pyarrow.parquet")


def _suffix(path: str | PathLike[str]) -> str:
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise PlanningError(f"{path}: unknown kind of trajectory file {suffix!r}, expected one of {', '.join(SUFFIXES)}")
    return suffix


def _remarks(trajectory: Columns) -> str:
    return f"# name: {trajectory.name}\n# closed: {'true' if trajectory.closed else 'false'}\n"


def _write_text(path: str | PathLike[str], above: str, columns: dict[str, Floats], names: tuple[str, ...]) -> None:
    rows = np.column_stack(list(columns.values())).tolist()
    # repr writes the fewest digits that read back as the same number
    text = above + ",".join(names) + "\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows)
    _whole(path, lambda staged: staged.write_text(text, encoding="utf-8", newline="\n"))


def _whole(path: str | PathLike[str], write: Callable[[Path], Any]) -> None:
    """Let `write` make the file under another name in the same folder, then move it in."""
    out = Path(path)
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=out.parent, prefix=".trajectory-") as folder:
            staged = Path(folder) / f"trajectory{out.suffix}"
            write(staged)
            staged.replace(out)
    except OSError as error:
        raise PlanningError(f"{out}: cannot be written: {error.strerror or error}") from None


def _line(found: object) -> str:
    """On one line and not too long."""
    return " ".join(str(found).split())[:120]
