"""A folder of results appears whole or not at all."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import PlanningError

if TYPE_CHECKING:
    from collections.abc import Sequence


def check_place(folder: Path, names: Sequence[str], prefix: str) -> None:
    """Whether files of these names can be written into `folder`; asked before a long work, so that it is not done in vain.

    Raises:
        PlanningError: the place is taken or cannot be written to.
    """
    if taken := [name for name in names if (folder / name).is_dir()]:
        raise PlanningError(f"{folder / taken[0]}: is a folder, expected a file to replace or nothing")
    try:
        staging_beside(folder, prefix).rmdir()
    except OSError as error:
        raise PlanningError(f"{folder}: cannot be written: {error.strerror or error}") from None


def staging_beside(folder: Path, prefix: str) -> Path:
    """A new folder beside the place, on the same file system."""
    home = next(place for place in (folder, *folder.absolute().parents) if place.exists())
    return Path(tempfile.mkdtemp(dir=home, prefix=prefix))


def move_in(staging: Path, folder: Path, names: Sequence[str]) -> None:
    """Move the files from where they were made to their place, which is made if need be."""
    staging.chmod(0o755)
    if folder.exists():
        for name in names:
            (staging / name).replace(folder / name)
    else:
        folder.parent.mkdir(parents=True, exist_ok=True)
        staging.rename(folder)
