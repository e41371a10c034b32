"""The strip of road that a point may use, as offsets from a reference curve."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from .errors import RoadError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .geometry.curve import PlanarCurve

    Floats = NDArray[np.float64]

#: Offsets towards the inside of a bend end at this fraction of the bend's radius, where normals of the reference would meet.
FOLD = 0.9
#: Places at which a border is looked up under the disc that must not touch it.
_LOOKS = 13
#: Length of the road over which the border of a narrowing leads across, m.
_STEP = 1e-3


@dataclass(frozen=True)
class Narrowing:
    """A stretch where a border is closer than the road's: a parked truck, an oncoming car's lane, road works.

    Attributes:
        start: station where it begins, m.
        end: station where it ends, m; on a circuit it may lie before the start.
        right: offset from the reference that the right border has at least, m; None leaves it.
        left: offset that the left border has at most, m; None leaves it.
    """

    start: float
    end: float
    right: float | None = None
    left: float | None = None

    def __post_init__(self) -> None:
        values = [value for value in (self.start, self.end, self.right, self.left) if value is not None]
        if not np.all(np.isfinite(values)):
            raise RoadError(f"{self}: expected finite numbers")


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

    def narrowed(self, *narrowings: Narrowing) -> Corridor:
        """The corridor with some stretches narrower; the border leads straight across at their ends.

        Raises:
            RoadError: a stretch that ends before it begins or lies beside the road's stations.
        """
        made = self
        for one in narrowings:
            made = made._with(one)
        return made

    def _with(self, one: Narrowing) -> Corridor:
        length = self.reference.length
        if not one.start < one.end and not (self.reference.closed and one.start != one.end):
            raise RoadError(f"{self.name}: narrowing from {one.start} m to {one.end} m, expected an end after the start")
        if not self.reference.closed:
            if one.end < 0.0 or one.start > length:
                raise RoadError(f"{self.name}: narrowing from {one.start} m to {one.end} m, expected stations between 0 and {length:.1f} m")
            return self._narrow(max(one.start, 0.0), min(one.end, length), one)
        if one.end - one.start >= length:
            return self._narrow(0.0, length, one)
        start, end = float(np.mod(one.start, length)), float(np.mod(one.end, length))
        return self._narrow(start, end, one) if start < end else self._narrow(start, length, one)._narrow(0.0, end, one)

    def _narrow(self, start: float, end: float, one: Narrowing) -> Corridor:
        """Narrower from `start` to `end`, both on the road."""
        cuts = np.array([start - _STEP, start, end, end + _STEP])
        # the steps lie outside the stretch, so that the whole of it is narrow
        length = self.reference.length
        there = np.min(np.abs(self.s[:, None] - cuts), axis=1) < 1e-6
        s = np.union1d(self.s[~there | (self.s == 0.0) | (self.s == length)], cuts[(cuts > 0.0) & (cuts < length)])
        right, left = self.borders(s)
        inside = (s >= start) & (s <= end)
        if one.right is not None:
            right = np.where(inside, np.maximum(right, one.right), right)
        if one.left is not None:
            left = np.where(inside, np.minimum(left, one.left), left)
        return replace(self, s=s, right=right, left=left)

    def offsets(self, s: ArrayLike) -> tuple[Floats, Floats]:
        """Right and left offset that a point may use at stations `s`, m.

        A disc of radius `margin` about a usable place touches neither border where they run evenly; where a border steps, some centimetres may
        be missing, since it is looked at in 13 places under the disc. What must not touch is proven against the borders themselves, see
        `roads.border_line`. Inside tight bends the strip ends at 0.9 of the reference's radius, since beyond its centre of curvature an offset no
        longer means one place. Where the road is too narrow for the disc the right offset comes out larger than the left one; see `narrowest`.
        """
        s = np.asarray(s, dtype=np.float64)
        right, left = self.borders(s)
        kappa = self.reference.curvature(s)
        if self.margin > 0.0:
            right, left = self._eroded(s, kappa, -right, 0, -1.0), self._eroded(s, kappa, left, 1, 1.0)
            right = -right
        radius = FOLD / np.maximum(np.abs(kappa), 1e-9)
        left = np.where(kappa > 0.0, np.minimum(left, radius), left)
        right = np.where(kappa < 0.0, np.maximum(right, -radius), right)
        return right, left

    def _eroded(self, s: Floats, kappa: Floats, border: Floats, which: int, side: float) -> Floats:
        """Distance that a disc's centre may be off the reference towards one border (counted positive that way), at stations `s`.

        The border is taken as straight between looks along it; the lowest place of each straight piece under the disc is known in closed form.
        """
        if self._is_constant[which]:
            return border - self.margin
        stretch = np.maximum(1.0 - side * kappa * border, 0.1)
        along = self.margin * np.linspace(-1.0, 1.0, _LOOKS)
        heights = [side * self.borders(s + step / stretch)[which] for step in along]
        least = np.full(np.shape(s), np.inf)
        for a, b, low, high in zip(along[:-1], along[1:], heights[:-1], heights[1:], strict=True):
            rise = (high - low) / (b - a)
            touch = np.clip(-rise * self.margin / np.sqrt(1.0 + rise**2), a, b)
            disc = np.sqrt(np.maximum(self.margin**2 - touch**2, 0.0))
            least = np.minimum(least, low + rise * (touch - a) - disc)
        return least

    @cached_property
    def _is_constant(self) -> tuple[bool, bool]:
        return bool(np.ptp(self.right) < 1e-9), bool(np.ptp(self.left) < 1e-9)

    def narrowest(self, spacing: float = 1.0) -> tuple[float, float]:
        """Station and usable width (m, negative where nothing is left) of the narrowest place."""
        count = max(int(np.ceil(self.reference.length / spacing)), 2)
        s = np.unique(np.concatenate([self.s, np.linspace(0.0, self.reference.length, count + 1)]))
        right, left = self.offsets(s)
        at = int(np.argmin(left - right))
        return float(s[at]), float(left[at] - right[at])
