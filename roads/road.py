"""A road: a reference curve with edges, lanes, height, slope, bank, speed limit and friction along its stations."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .borders import spaced
from .corridor import Corridor
from .curve import PlanarCurve, read_only
from .errors import RoadError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import ArrayLike, NDArray
    from scipy.interpolate import PchipInterpolator

    from .plan_view import Element

    Floats = NDArray[np.float64]

Extent = Literal["lane", "own", "road"]

#: Where a cross-section changes at once data lie a centimetre apart; a curve is drawn through every place at most this close, m.
KNOTS = 0.02
#: Stands for a quantity that was not given; no road has as few stations.
_UNSET = np.zeros(0)


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
        bank: (n,) superelevation, rad, positive where the left side is higher.
        friction: (n,) what the surface offers, as a share of dry asphalt.
        drive: the lane to be driven where it is not simply the outermost one that leads this way.
        left_hand: traffic keeps left.
        plan_view: the elements that the reference was drawn with, where they are known; writers use them instead of the spline.
        columns: further columns of the road's file, (n,) each, kept for comparison.
        origin: latitude and longitude in degrees of (0, 0), where they are known (x east, y north, transverse Mercator).
    """

    name: str
    reference: PlanarCurve
    s: Floats
    right: Floats
    left: Floats
    height: Floats
    speed_limit: Floats
    lanes: tuple[Lane, ...] = field(default=())
    bank: Floats = field(default_factory=lambda: _UNSET)
    friction: Floats = field(default_factory=lambda: _UNSET)
    drive: Lane | None = None
    left_hand: bool = False
    plan_view: tuple[Element, ...] = ()
    columns: Mapping[str, Floats] = field(default_factory=dict)
    origin: tuple[float, float] | None = None

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
        lane_edges: Sequence[tuple[int, ArrayLike, ArrayLike]] = (),
        bank: ArrayLike = 0.0,
        friction: ArrayLike = 1.0,
        **more: Any,
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
            bank: rad, scalar or (n,).
            friction: scalar or (n,).
            **more: `left_hand`, `plan_view`, `columns`, `origin`, as in the class.

        Raises:
            RoadError: points or values that are not finite, repeated points, or a right edge left of the left one.
        """
        reference = PlanarCurve.through(points, closed=closed)
        s = reference.breaks_s[:-1] if closed else reference.breaks_s

        def along(values: ArrayLike) -> Floats:
            return read_only(np.broadcast_to(np.asarray(values, dtype=np.float64), s.shape))

        edges = along(right), along(left)
        lanes = tuple(Lane(direction, along(lo), along(hi)) for direction, lo, hi in lane_edges) or (Lane(1, *edges),)
        return cls(name, reference, read_only(s), *edges, along(height), along(speed_limit), lanes, along(bank), along(friction), **more)

    def __post_init__(self) -> None:
        if not self.name.isprintable():
            # names come out of files and go into files, tables and terminals
            object.__setattr__(self, "name", self.name.encode("unicode_escape").decode("ascii"))
        for label, standard in (("bank", 0.0), ("friction", 1.0)):
            if getattr(self, label) is _UNSET:
                object.__setattr__(self, label, read_only(np.full(self.s.shape, standard)))
        for label in ("right", "left", "height", "bank", "friction"):
            values = getattr(self, label)
            if values.shape != self.s.shape:
                raise RoadError(f"{self.name}: {label} has shape {values.shape}, expected {self.s.shape}")
            if not np.all(np.isfinite(values)):
                at = int(np.argmin(np.isfinite(values)))
                raise RoadError(f"{self.name}: {label} at s = {self.s[at]:.1f} m is {values[at]}, expected a finite number")
        if np.any(self.left < self.right - 1e-9):
            at = int(np.argmin(self.left - self.right))
            beyond = self.right[at] - self.left[at]
            raise RoadError(f"{self.name}: the borders cross at s = {self.s[at]:.1f} m: the right edge is {beyond:.3f} m left of the left edge")
        for lane in (*self.lanes, *filter(None, [self.drive])):
            absent = np.isnan(lane.right) & np.isnan(lane.left)
            good = absent | ((lane.right <= lane.left) & (lane.right >= self.right - 1e-6) & (lane.left <= self.left + 1e-6))
            if not np.all(good):
                at = int(np.argmin(good))
                raise RoadError(
                    f"{self.name}: lane {f'{lane.name} ' * bool(lane.name)}from {lane.right[at]:g} to {lane.left[at]:g} m at s = {self.s[at]:.1f} m, "
                    f"expected right before left and within the road, {self.right[at]:g} to {self.left[at]:g} m"
                )
        if not np.all(self.friction > 0.0):
            at = int(np.argmin(self.friction > 0.0))
            raise RoadError(f"{self.name}: friction at s = {self.s[at]:.1f} m is {self.friction[at]:g}, expected more than 0")
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
        """The lane to drive in: `drive` where given, else the outermost lane in the direction of the stations (rightmost where traffic keeps right).

        Raises:
            RoadError: no lane leads that way all along.
        """
        if self.drive is not None:
            return self.drive
        for lane in reversed(self.lanes) if self.left_hand else self.lanes:
            if lane.direction >= 0 and not np.isnan(lane.right).any():
                return lane
        raise RoadError(f"{self.name}: no lane leads in the direction of the stations from start to end")

    def must_lead_on(self, path: object) -> None:
        """Refuse to write a road that nobody could drive along its stations: readers would turn it round.

        Raises:
            RoadError: no lane leads in the direction of the stations.
        """
        if not any(lane.direction >= 0 for lane in self.lanes):
            raise RoadError(f"{path}: no lane of {self.name} leads in the direction of its stations, write it the other way round (`reversed()`)")

    def lane_centre(self, lane: Lane | None = None) -> PlanarCurve:
        """The centre curve of `lane` (default: the driving lane)."""
        lane = lane or self.driving_lane()
        s = self.knots
        middle = np.interp(s, self.s, 0.5 * (lane.left + lane.right))
        return PlanarCurve.through(self.reference.position(s) + middle[:, None] * self.reference.normal(s), closed=self.closed)

    @cached_property
    def knots(self) -> Floats:
        """Stations that curves beside the road are drawn through: `s` without those that lie within `KNOTS` m of the one before."""
        return self.s[spaced(self.s, KNOTS)]

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
            own = [lane for lane in self.lanes if lane.direction >= 0] + ([] if self.drive is None else [self.drive])
            own = own or [self.driving_lane()]
            there = [self._reliable(lane) for lane in own]
            right = np.fmin.reduce([np.where(good, lane.right, np.nan) for good, lane in zip(there, own, strict=True)])
            left = np.fmax.reduce([np.where(good, lane.left, np.nan) for good, lane in zip(there, own, strict=True)])
            if np.isnan(right).any():
                right, left = np.fmin.reduce([lane.right for lane in own]), np.fmax.reduce([lane.left for lane in own])
        else:
            raise RoadError(f"corridor {extent!r} is unknown, expected lane, own or road")
        return Corridor(self.name, self.reference, self.s, read_only(right), read_only(left), margin)

    def _reliable(self, lane: Lane) -> NDArray[np.bool_]:
        """Where the lane exists on both sides of a station: the strip towards a station without it would reach beyond its end."""
        there = ~np.isnan(lane.right)
        if there.all():
            return there
        near = np.diff(self.s) < 0.05
        before, after = np.append(there[:1], there[:-1] | near), np.append(there[1:] | near, there[-1:])
        if self.closed:
            before[0], after[-1] = there[-1], there[0]
        return there & before & after

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

    def bank_at(self, s: ArrayLike) -> Floats:
        """Superelevation in rad at stations `s`, positive where the left side is higher: linear between the data."""
        return self._linear(self.bank, s)

    def friction_at(self, s: ArrayLike) -> Floats:
        """Friction as a share of dry asphalt at stations `s`: linear between the data."""
        return self._linear(self.friction, s)

    def _linear(self, values: Floats, s: ArrayLike) -> Floats:
        return np.interp(self._wrap(s), self.s, values, period=self.length if self.closed else None)

    def reversed(self) -> Road:
        """The same road in the other direction; a closed road keeps its start. See `roads.edit.reversed_road`."""
        from .edit import reversed_road

        return reversed_road(self)

    def __getitem__(self, stretch: slice) -> Road:
        """`road[s0:s1]`: the stretch between two stations in m, with new stations from 0; on a closed road it may lead over the start.

        Raises:
            RoadError: a step, or stations that are not on the road.
        """
        from .edit import stretch_of

        return stretch_of(self, stretch)

    def resampled(self, spacing: float) -> Road:
        """The same road with data at most `spacing` (m) apart, evenly. See `roads.edit.resampled_road`."""
        from .edit import resampled_road

        return resampled_road(self, spacing)

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
