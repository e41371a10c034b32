"""Find a road by name on the gallery's shelf, or by path anywhere else."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import RoadError
from ..formats import read

if TYPE_CHECKING:
    from os import PathLike

    from ..road import Road

SHELF = Path(__file__).parent


def shipped() -> list[str]:
    """Names of the roads that ship with the package."""
    return sorted(path.stem for path in SHELF.glob("*.csv"))


def open_road(name_or_path: str | PathLike[str], *, closed: bool | None = None) -> Road:
    """The shipped road of that name, or the road file at that path.

    Raises:
        RoadError: neither a shipped road nor a readable road file.
    """
    path = Path(name_or_path)
    if path.suffix == "" and not path.is_file():
        if str(name_or_path) not in shipped():
            raise RoadError(f"{name_or_path}: no such file and no shipped road, expected a road file or one of {', '.join(shipped())}")
        path = SHELF / f"{name_or_path}.csv"
    return read(path, closed=closed)
