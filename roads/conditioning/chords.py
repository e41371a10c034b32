"""Long pieces of a line, as drawn and thinned lines and gaps in recordings have them: places on them, so that no curve swings out beside."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

#: A piece is long if it is so many times as long as its shorter neighbour.
_LONG = 3.0
#: A line of this many places, at most, is looked at between them.
_MOST = 400_000


def marks(points: Floats) -> Floats:
    """Places (k,) along the points (n, 2), counted in points, where a curve through `points` should be held: the points, and some on long pieces.

    On a long piece the distances of the places double from either end: a spline through places at very uneven distances swings out over the long
    ones, by a share of their length.
    """
    steps = np.hypot(*np.diff(points, axis=0).T)
    found = [np.zeros(1)]
    before, after = np.append(np.inf, steps[:-1]), np.append(steps[1:], np.inf)
    for k, (step, first, last) in enumerate(zip(steps.tolist(), before.tolist(), after.tolist(), strict=True)):
        inner = [1.0]
        for short, at_end in ((first, False), (last, True)):
            if step > _LONG * short:
                distances = short * (2.0 ** np.arange(1, 30) - 1.0)
                inner += [1.0 - d / step if at_end else d / step for d in distances[distances < 0.5 * step].tolist()]
        found.append(k + np.unique(inner))
    return np.concatenate(found)


def beside(line: Floats, points: Floats) -> float:
    """How far the places of `line` (m, 2) lie from the polyline of `points` (n, 2) at most, m; to half a metre."""
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    fine = np.union1d(way, np.linspace(0.0, way[-1], int(min(way[-1] / 0.5, _MOST)) + 2))
    dense = np.column_stack([np.interp(fine, way, column) for column in points.T])
    return float(np.max(cKDTree(dense).query(line)[0]))
