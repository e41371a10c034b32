"""Which module reads which file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import RoadError
from . import track_csv

if TYPE_CHECKING:
    from os import PathLike

    from ..road import Road

FORMATS = {".csv": track_csv}


def read(path: str | PathLike[str], *, closed: bool | None = None) -> Road:
    """Read a road file; the suffix tells the format.

    Args:
        path: the file.
        closed: True for a circuit, False for an open road, None to let the file (or the gap between its ends) tell.

    Raises:
        RoadError: the file is missing, of unknown format or wrong inside; the message says where.
    """
    path = Path(path)
    return _format_of(path).read(path, closed=closed)


def write(road: Road, path: str | PathLike[str]) -> None:
    """Write `road` in the format of the suffix, whole or not at all.

    Raises:
        RoadError: unknown format, or a road that the format cannot hold.
    """
    path = Path(path)
    _format_of(path).write(road, path)


def _format_of(path: Path):
    try:
        return FORMATS[path.suffix.lower()]
    except KeyError:
        known = ", ".join(sorted(FORMATS))
        raise RoadError(f"{path}: unknown road format {path.suffix!r}, expected one of {known}") from None
