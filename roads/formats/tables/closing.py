"""Whether a line in a file is a circuit: by what the file says, else by the gap between its ends."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...errors import RoadError

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

#: Points closer than this are one, m.
SAME_PLACE = 1e-6


def closed_key(path: Path, keys: dict[str, str]) -> bool | None:
    """What the line `# closed:` says, None where there is none.

    Raises:
        RoadError: another word than true and false.
    """
    word = keys.get("closed")
    if word not in (None, "true", "false"):
        raise RoadError(f"{path}: closed is {word[:40]!r}, expected true or false")
    return None if word is None else word == "true"


def looks_closed(points: Floats) -> bool:
    """Whether the way from the last of `points` (n, 2), m, to the first goes on with the line: little longer than a step and without a sharp turn."""
    if len(points) <= 3:
        return False
    seam = points[0] - points[-1]
    gap = float(np.hypot(*seam))
    if gap < SAME_PLACE:
        return True
    directions = (step / max(float(np.hypot(*step)), SAME_PLACE) for step in (points[-1] - points[-2], points[1] - points[0]))
    longest = float(np.max(np.hypot(*np.diff(points, axis=0).T)))
    return gap <= 1.5 * longest and all(float(direction @ seam) > 0.5 * gap for direction in directions)
