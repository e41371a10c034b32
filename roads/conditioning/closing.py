"""Whether a line is a circuit, by the gap between its ends."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

#: Points closer than this are one, m.
SAME_PLACE = 1e-6


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
