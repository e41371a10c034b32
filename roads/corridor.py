"""The strip of road that a point may use, as offsets from a reference curve."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .curve import curvature_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .curve import PlanarCurve

    Floats = NDArray[np.float64]

#: Offsets towards the inside of a bend end at this fraction of the bend's radius, where normals of the reference would meet.
FOLD = 0.9


@dataclass(frozen=True, eq=False)
class Corridor:
    """Borders as offsets from `reference` (positive left), shrunk by `margin` on both sides when asked.

    Attributes:
        name: the road's name, for messages.
        reference: the curve that stations and offsets refer to.
        s: (n,) stations of the offsets, m.
        right: (n,) right border, m.
        left: (n,) left border, m.
        margin: distance kept from both borders, m.
    """

    name: str
    reference: PlanarCurve
    s: Floats
    right: Floats
    left: Floats
    margin: float

    def borders(self, s: ArrayLike) -> tuple[Floats, Floats]:
        """Right and left offset at stations `s`, without the margin: linear between the data, m."""
        s = np.asarray(s, dtype=np.float64)
        if self.reference.closed:
            s = np.mod(s, self.reference.length)
            length = self.reference.length
            return np.interp(s, self.s, self.right, period=length), np.interp(s, self.s, self.left, period=length)
        return np.interp(s, self.s, self.right), np.interp(s, self.s, self.left)

    def offsets(self, s: ArrayLike) -> tuple[Floats, Floats]:
        """Right and left offset that a point may use at stations `s`, m.

        The margin is kept at right angles to the border, also where the road widens. Inside tight bends the strip ends at 0.9 of the
        reference's radius, since beyond its centre of curvature an offset no longer means one place. Where the road is narrower than
        twice the margin the right offset comes out larger than the left one; see `narrowest`.
        """
        return self._usable(s, self.reference.curvature(s))

    def _usable(self, s: ArrayLike, kappa: Floats) -> tuple[Floats, Floats]:
        right, left = self.borders(s)
        step = 0.5
        right_ahead, left_ahead = self.borders(np.asarray(s) + step)
        right_behind, left_behind = self.borders(np.asarray(s) - step)
        right = right + self.margin * _slant((right_ahead - right_behind) / (2 * step), 1.0 - kappa * right)
        left = left - self.margin * _slant((left_ahead - left_behind) / (2 * step), 1.0 - kappa * left)
        radius = FOLD / np.maximum(np.abs(kappa), 1e-9)
        left = np.where(kappa > 0.0, np.minimum(left, radius), left)
        right = np.where(kappa < 0.0, np.maximum(right, -radius), right)
        return right, left

    def narrowest(self, spacing: float = 1.0) -> tuple[float, float]:
        """Station and usable width (m, negative where nothing is left) of the narrowest place."""
        count = max(int(np.ceil(self.reference.length / spacing)), 2)
        s = np.unique(np.concatenate([self.s, np.linspace(0.0, self.reference.length, count + 1)]))
        right, left = self.offsets(s)
        at = int(np.argmin(left - right))
        return float(s[at]), float(left[at] - right[at])

    def violation(self, points: ArrayLike, near: ArrayLike) -> Floats:
        """How far each of `points` (n, 2) lies outside, m; zero or less inside. `near` (n,) are stations close to the points'."""
        u, _, offset = self.reference.project_parameter(points, near)
        right, left = self._usable(self.reference.station(u), curvature_of(self.reference.pieces, u))
        return np.maximum(offset - left, right - offset)


def _slant(widening: Floats, stretch: Floats) -> Floats:
    """How much longer the way across is when the border is not parallel to the reference: 1 / cos of their angle."""
    return np.sqrt(1.0 + (widening / np.maximum(stretch, 0.1)) ** 2)
