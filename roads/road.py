"""A road: a reference curve with edges, lanes, height and speed limit along its stations."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np

from .corridor import Corridor
from .curve import PlanarCurve, read_only
from .errors import RoadError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray
    from scipy.interpolate import PchipInterpolator

    Floats = NDArray[np.float64]

Extent = Literal["lane", "own", "road"]


@dataclass(frozen=True, eq=False)
class Lane:
    """One lane: the strip between two offsets from the road's reference curve.

    Attributes:
        direction: +1 if traffic runs with the stations, -1 if against.
        right: (n,) offset of its right border at the road's stations, m, positive to the left of the reference.
        left: (n,) offset of its left border, m.
    """

    direction: int
    right: Floats
    left: Floats


@dataclass(frozen=True, eq=False)
class Road:
    """A stretch of road. All offsets are measured along the reference curve's normal, positive to the left.

    Attributes:
        name: what to call it in tables.
        reference: the curve that stations are counted along.
        s: (n,) stations of the arrays below, m, from 0; a closed road does not repeat station 0 at its end.
        right: (n,) offset of the right edge, m (negative where the edge is right of the reference).
        left: (n,) offset of the left edge, m.
        height: (n,) height of the reference, m.
        speed_limit: (n,) limit from each station on, m/s; inf where none is posted.
        lanes: from right to left.
    """

    name: str
    reference: PlanarCurve
    s: Floats
    right: Floats
    left: Floats
    height: Floats
    speed_limit: Floats
    lanes: tuple[Lane, ...] = field(default=())

    @classmethod
    def from_points(
        cls,
        name: str,
        points: ArrayLike,
        right: ArrayLike,
        left: ArrayLike,
        *,
        closed: bool = False,
        height: ArrayLike = 0.0,
        speed_limit: ArrayLike = np.inf,
        lane_edges: Sequence[tuple[int, float, float]] = (),
    ) -> Road:
        """A road whose reference runs through `points` (n, 2), with edge offsets `right`, `left` and the rest given per point.

        Args:
            name: what to call it.
            points: (n, 2) reference points, m.
            right: offsets of the right edge, m (scalar or (n,)).
            left: offsets of the left edge, m.
            closed: the last point is followed by the first.
            height: m, scalar or (n,).
            speed_limit: m/s, scalar or (n,).
            lane_edges: (direction, right offset, left offset) per lane from right to left; none means one lane over the whole width.

        Raises:
            RoadError: points or values that are not finite, repeated points, or a right edge left of the left one.
        """
        reference = PlanarCurve.through(points, closed=closed)
        s = reference.breaks_s[:-1] if closed else reference.breaks_s

        def along(values: ArrayLike) -> Floats:
            return read_only(np.broadcast_to(np.asarray(values, dtype=np.float64), s.shape))

        edges = along(right), along(left)
        lanes = tuple(Lane(direction, along(lo), along(hi)) for direction, lo, hi in lane_edges) or (Lane(1, *edges),)
        return cls(name, reference, read_only(s), *edges, along(height), along(speed_limit), lanes)

    def __post_init__(self) -> None:
        for label in ("right", "left", "height"):
            values = getattr(self, label)
            if values.shape != self.s.shape:
                raise RoadError(f"{self.name}: {label} has shape {values.shape}, expected {self.s.shape}")
            if not np.all(np.isfinite(values)):
                at = int(np.argmin(np.isfinite(values)))
                raise RoadError(f"{self.name}: {label} at s = {self.s[at]:.1f} m is {values[at]}, expected a finite number")
        if np.any(self.left <= self.right):
            at = int(np.argmin(self.left - self.right))
            beyond = self.right[at] - self.left[at]
            raise RoadError(f"{self.name}: the borders cross at s = {self.s[at]:.1f} m: the right edge is {beyond:.3f} m left of the left edge")
        for lane in self.lanes:
            good = (lane.right < lane.left) & (lane.right >= self.right - 1e-6) & (lane.left <= self.left + 1e-6)
            if not np.all(good):
                at = int(np.argmin(good))
                raise RoadError(
                    f"{self.name}: lane from {lane.right[at]:g} to {lane.left[at]:g} m at s = {self.s[at]:.1f} m, "
                    f"expected within the road, {self.right[at]:g} to {self.left[at]:g} m"
                )
        if not np.all(self.speed_limit > 0.0):
            at = int(np.argmin(self.speed_limit > 0.0))
            raise RoadError(f"{self.name}: speed limit at s = {self.s[at]:.1f} m is {self.speed_limit[at]} m/s, expected more than 0")

    @property
    def closed(self) -> bool:
        """True for a circuit."""
        return self.reference.closed

    @property
    def length(self) -> float:
        """Length of the reference curve, m."""
        return self.reference.length

    def driving_lane(self) -> Lane:
        """The rightmost lane in the direction of the stations (right-hand traffic).

        Raises:
            RoadError: no lane leads that way.
        """
        for lane in self.lanes:
            if lane.direction > 0:
                return lane
        raise RoadError(f"{self.name}: no lane leads in the direction of the stations")

    def lane_centre(self, lane: Lane | None = None) -> PlanarCurve:
        """The centre curve of `lane` (default: the driving lane)."""
        lane = lane or self.driving_lane()
        middle = 0.5 * (lane.left + lane.right)
        if not np.any(middle):
            return self.reference
        points = self.reference.position(self.s) + middle[:, None] * self.reference.normal(self.s)
        return PlanarCurve.through(points, closed=self.closed)

    def corridor(self, extent: Extent = "own", margin: float = 0.0) -> Corridor:
        """The strip that a point may use: `lane` (the driving lane), `own` (all lanes that lead this way), `road` (edge to edge).

        Args:
            extent: which part of the cross-section.
            margin: distance kept from both borders, m (half the car's width plus what a driver keeps).
        """
        if extent == "road":
            right, left = self.right, self.left
        elif extent == "lane":
            right, left = self.driving_lane().right, self.driving_lane().left
        elif extent == "own":
            own = [lane for lane in self.lanes if lane.direction > 0] or [self.driving_lane()]
            right, left = np.min([lane.right for lane in own], axis=0), np.max([lane.left for lane in own], axis=0)
        else:
            raise RoadError(f"corridor {extent!r} is unknown, expected lane, own or road")
        return Corridor(self.name, self.reference, self.s, read_only(right), read_only(left), margin)

    def height_at(self, s: ArrayLike) -> Floats:
        """Height in m at reference stations `s`: monotone cubic between the data (PCHIP), no overshoot."""
        return self._height(self._wrap(s)) if np.any(self.height != self.height[0]) else np.full(np.shape(s), self.height[0])

    def slope_at(self, s: ArrayLike) -> Floats:
        """Slope dz/ds (rise over horizontal run) along the reference at stations `s`."""
        return self._height(self._wrap(s), 1) if np.any(self.height != self.height[0]) else np.zeros(np.shape(s))

    def speed_limit_at(self, s: ArrayLike) -> Floats:
        """Posted limit in m/s at stations `s`: the value of the last data station passed."""
        passed = np.searchsorted(self.s, self._wrap(s), side="right") - 1
        return self.speed_limit[np.clip(passed, 0, len(self.s) - 1)]

    @cached_property
    def _height(self) -> PchipInterpolator:
        from scipy.interpolate import PchipInterpolator  # slow to import, and flat roads never need it

        if not self.closed:
            return PchipInterpolator(self.s, self.height)
        # three data beyond the seam on either side make the derivative there the same from both ends
        s = np.concatenate([self.s[-3:] - self.length, self.s, self.s[:3] + self.length])
        return PchipInterpolator(s, np.concatenate([self.height[-3:], self.height, self.height[:3]]))

    def _wrap(self, s: ArrayLike) -> Floats:
        s = np.asarray(s, dtype=np.float64)
        return np.mod(s, self.length) if self.closed else np.clip(s, 0.0, self.length)
