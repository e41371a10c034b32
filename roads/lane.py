"""A lane: a strip along a road, and what several of them cover."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from .errors import RoadError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

#: Stations closer than this are the two sides of one place where the cross-section changes at once, m.
ONE_PLACE = 0.05


@dataclass(frozen=True, eq=False)
class Lane:
    """One lane: the strip between two offsets from the road's reference curve.

    Attributes:
        direction: +1 if traffic runs with the stations, -1 if against, 0 if both ways.
        right: (n,) offset of its right border at the road's stations, m, positive to the left of the reference; NaN where there is no such lane.
        left: (n,) offset of its left border, m; NaN as `right`.
        kind: what it is for, in the words of OpenDRIVE: driving, entry, exit, onRamp, ...
        name: what its file calls it.
    """

    direction: int
    right: Floats
    left: Floats
    kind: str = "driving"
    name: str = ""

    def must_lie_within(self, right: Floats, left: Floats, s: Floats, road: str) -> None:
        """Refuse a lane that changes sides or reaches beyond the edges `right` and `left` (n,), m, of its road at its stations `s` (n,), m.

        Raises:
            RoadError: with the name of the road, the first bad station, and both strips.
        """
        absent = np.isnan(self.right) & np.isnan(self.left)
        good = absent | ((self.right <= self.left) & (self.right >= right - 1e-6) & (self.left <= left + 1e-6))
        if not np.all(good):
            at = int(np.argmin(good))
            raise RoadError(
                f"{road}: lane {f'{self.name} ' * bool(self.name)}from {self.right[at]:g} to {self.left[at]:g} m at s = {s[at]:.1f} m, "
                f"expected right before left and within the road, {right[at]:g} to {left[at]:g} m"
            )

    def read(self, along: Callable[[Floats], Floats]) -> Lane:
        """The same lane at other stations: `along` takes offsets (n,) and gives those there, m."""
        return replace(self, right=along(self.right), left=along(self.left))

    def opposite(self, along: Callable[[Floats], Floats]) -> Lane:
        """The same lane on the road in the other direction; `along` takes offsets (n,) and gives them in that order, m."""
        return replace(self, direction=-self.direction, right=along(-self.left), left=along(-self.right))

    def reliable(self, s: Floats, *, closed: bool) -> NDArray[np.bool_]:
        """Where (n,) the lane exists on both sides of the stations `s` (m): the strip towards a station without it would reach beyond its end."""
        there = ~np.isnan(self.right)
        if there.all():
            return there
        near = np.diff(s) < ONE_PLACE
        before, after = np.append(there[:1], there[:-1] | near), np.append(there[1:] | near, there[-1:])
        if closed:
            before[0], after[-1] = there[-1], there[0]
        return there & before & after


def covered(lanes: Sequence[Lane], s: Floats, *, closed: bool) -> tuple[Floats, Floats]:
    """Right and left border, (n,) each in m, of what `lanes` cover together at the stations `s` (m)."""
    there = [lane.reliable(s, closed=closed) for lane in lanes]
    right = np.fmin.reduce([np.where(good, lane.right, np.nan) for good, lane in zip(there, lanes, strict=True)])
    left = np.fmax.reduce([np.where(good, lane.left, np.nan) for good, lane in zip(there, lanes, strict=True)])
    if np.isnan(right).any():
        return np.fmin.reduce([lane.right for lane in lanes]), np.fmax.reduce([lane.left for lane in lanes])
    return right, left
