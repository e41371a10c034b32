"""Find a road by name on the gallery's shelf, or by path anywhere else."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import RoadError
from ..formats import read

if TYPE_CHECKING:
    from os import PathLike

    from ..road import Road

SHELF = Path(__file__).parent


#: Shipped files that hold a network rather than one road.
NETWORKS = ("roundabout",)


def shipped() -> list[str]:
    """Names of the roads that ship with the package."""
    return sorted(path.stem for path in SHELF.glob("*.xodr") if path.stem not in NETWORKS)


def find(name_or_path: str | PathLike[str]) -> Path:
    """The file of the shipped road of that name, or that path.

    Raises:
        RoadError: neither a shipped road nor a file.
    """
    path = Path(name_or_path)
    if path.suffix == "" and not path.exists():
        known = [*shipped(), *NETWORKS]
        if str(name_or_path) not in known:
            raise RoadError(f"{name_or_path}: no such file and no shipped road, expected a road file or one of {', '.join(known)}")
        return SHELF / f"{name_or_path}.xodr"
    return path


def open_road(name_or_path: str | PathLike[str], **options: Any) -> Road:
    """The shipped road (or network) of that name, or the road file at that path; options as in `roads.read`.

    Raises:
        RoadError: neither a shipped road nor a readable road file.
    """
    return read(find(name_or_path), **options)
