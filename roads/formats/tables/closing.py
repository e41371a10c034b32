"""Whether a line in a file is a circuit, by what the file says."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...errors import RoadError

if TYPE_CHECKING:
    from pathlib import Path


def closed_key(path: Path, keys: dict[str, str]) -> bool | None:
    """What the line `# closed:` says, None where there is none.

    Raises:
        RoadError: another word than true and false.
    """
    word = keys.get("closed")
    if word not in (None, "true", "false"):
        raise RoadError(f"{path}: closed is {word[:40]!r}, expected true or false")
    return None if word is None else word == "true"
