"""The way between cones of two colours: gates, each between a left and a right cone, in order.

Of the triangulation (Delaunay) of all cones those triangles make the road that have cones of both colours. Each of them has two sides from colour to
colour, gates, so that they lie one after the other like the steps of a ladder: that orders both edges and puts them beside each other at once,
however many cones are on either side. Legs of the road that come close do so with cones of one colour, which no gate joins. Source: the triangulation
is what Formula Student teams use for the middle line (Kabzan et al., AMZ Driverless, Journal of Field Robotics 37, 2020, section 6.1).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...errors import RoadError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

#: A gate is no wider than so many times the usual distance of a cone from the other colour.
_WIDEST = 2.5


@dataclass(frozen=True, eq=False)
class Cones:
    """Cones of one colour: what they are called, their places (n, 2), m, and the numbers of their rows (n,)."""

    name: str
    places: Floats
    rows: NDArray[np.intp]


def gates_between(left: Floats, right: Floats) -> list[tuple[Ints, bool]]:
    """Strips of gates, the longest first: each (k, 2) numbers of left and right cones in order, and whether its end joins its start.

    They lead so that the left cones are on the left.

    Args:
        left: (n, 2) places, m.
        right: (m, 2) places, m.

    Raises:
        RoadError: places of which no triangles can be made.
    """
    from scipy.spatial import Delaunay, QhullError, cKDTree

    usual = float(np.median(np.concatenate([cKDTree(left).query(right)[0], cKDTree(right).query(left)[0]])))
    try:
        triangles = Delaunay(np.vstack([left, right])).simplices
    except QhullError:
        raise RoadError("the cones lie on one line, expected two edges beside each other") from None
    is_right = triangles >= len(left)
    mixed = triangles[is_right.any(axis=1) & ~is_right.all(axis=1)]
    # the odd one out of each triangle, and the other two in the triangle's (counter-clockwise) order
    odd_right = (mixed >= len(left)).sum(axis=1) == 1
    odd = np.argmax((mixed >= len(left)) == odd_right[:, None], axis=1)
    corners = [mixed[np.arange(len(mixed)), (odd + k) % 3] for k in range(3)]
    places = np.vstack([left, right])
    # a triangle leads from one of its gates to the other: with the odd cone on the right it turns to the right about it, from the further gate on
    first, second = np.where(odd_right, corners[2], corners[1]), np.where(odd_right, corners[1], corners[2])
    gates = [np.where(odd_right[:, None], np.column_stack([one, corners[0]]), np.column_stack([corners[0], one])) for one in (first, second)]
    wide = [np.hypot(*(places[gate[:, 0]] - places[gate[:, 1]]).T) > _WIDEST * usual for gate in gates]
    after: dict[tuple[int, int], tuple[int, int]] = {}
    for a, b, apart, too in zip(gates[0].tolist(), gates[1].tolist(), *wide, strict=True):
        if not (apart or too):
            after[tuple(a)] = tuple(b)
    return sorted(_strips(after, len(left)), key=lambda strip: -len(strip[0]))


def _strips(after: dict[tuple[int, int], tuple[int, int]], count: int) -> list[tuple[Ints, bool]]:
    """Follow the gates from those that nothing leads to, then round the rings."""
    targets = set(after.values())
    found, seen = [], set()
    for begin in [*(gate for gate in after if gate not in targets), *after]:
        if begin in seen:
            continue
        strip, gate = [begin], after.get(begin)
        while gate is not None and gate != begin:
            strip.append(gate)
            gate = after.get(gate)
        seen.update(strip)
        found.append((np.array(strip, dtype=np.intp) - [0, count], gate == begin))
    return found
