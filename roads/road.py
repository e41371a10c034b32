"""A road: a reference curve with edges, lanes, height, slope, bank, speed limit and friction along its stations."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from . import columns
from .borders import spaced
from .corridor import Corridor
from .errors import RoadError
from .findings import Finding
from .geometry.curve import PlanarCurve, read_only
from .geometry.curve_parts import backwards, part_of
from .lane import Lane, covered

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import ArrayLike, NDArray
    from scipy.interpolate import PchipInterpolator

    from .geometry.plan_view import Element
    from .recorded import Recorded

    Floats = NDArray[np.float64]

Extent = Literal["lane", "own", "road"]

#: Where a cross-section changes at once data lie a centimetre apart; a curve is drawn through every place at most this close, m.
KNOTS = 0.02
#: Stands for a quantity that was not given; no road has as few stations.
_UNSET = np.zeros(0)


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
        findings: what its reader noticed or assumed and a user should know.
        recorded: the drive that was recorded along it.
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
    findings: tuple[Finding, ...] = ()
    recorded: Recorded | None = None

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
            **more: `left_hand`, `plan_view`, `columns`, `origin`, `findings`, `recorded`, as in the class.

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
            columns.must_be_numbers(getattr(self, label), self.s, f"{self.name}: {label}")
        if np.any(self.left < self.right - 1e-9):
            at = int(np.argmin(self.left - self.right))
            over = f"the right edge is {self.right[at] - self.left[at]:.3f} m left of the left edge"
            raise RoadError(f"{self.name}: the borders cross at s = {self.s[at]:.1f} m: {over}")
        for lane in (*self.lanes, *filter(None, [self.drive])):
            lane.must_lie_within(self.right, self.left, self.s, self.name)
        for values, label, unit in ((self.friction, "friction", ""), (self.speed_limit, "speed limit", " m/s")):
            if not np.all(values > 0.0):
                at = int(np.argmin(values > 0.0))
                raise RoadError(f"{self.name}: {label} at s = {self.s[at]:.1f} m is {values[at]}{unit}, expected more than 0")

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
        """Refuse, with a RoadError, to write a road that nobody could drive along its stations: readers would turn it round."""
        if all(lane.direction < 0 for lane in self.lanes):
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
            right, left = (lane := self.driving_lane()).right, lane.left
        elif extent == "own":
            own = [lane for lane in self.lanes if lane.direction >= 0] + ([] if self.drive is None else [self.drive])
            right, left = covered(own or [self.driving_lane()], self.s, closed=self.closed)
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
        # wrapped by rounding to just before a station is still at it
        passed = np.searchsorted(self.s, self._wrap(s) + 1e-9, side="right") - 1
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
        """The same road in the other direction; a closed road keeps its start, elements are lost. A posted limit covers the same ground."""
        turn = partial(columns.turned, closed=self.closed)
        return replace(
            self,
            reference=backwards(self.reference),
            s=columns.turned_stations(self.s, self.length, closed=self.closed),
            right=turn(-self.left),
            left=turn(-self.right),
            height=turn(self.height),
            speed_limit=columns.turned_limits(self.speed_limit, closed=self.closed),
            lanes=tuple(lane.opposite(turn) for lane in self.lanes[::-1]),
            bank=turn(-self.bank),
            friction=turn(self.friction),
            drive=None if self.drive is None or self.drive.direction > 0 else self.drive.opposite(turn),
            plan_view=(),
            columns={name: turn(columns.from_the_other_end(name, values)) for name, values in self.columns.items()},
            recorded=None,
        )

    def __getitem__(self, stretch: slice) -> Road:
        """`road[s0:s1]`: the stretch between two stations in m, with new stations from 0; on a closed road it may lead over the start.

        Raises:
            RoadError: a step, or stations that are not on the road or in the wrong order.
        """
        at = columns.stations_of(stretch, self.s, self.length, closed=self.closed, name=self.name)
        start, end = float(at[0]), float(at[-1])
        made = self.laid_along(part_of(self.reference, start, end), at - start, at)
        return replace(made, recorded=self.recorded and self.recorded.between(start, end))

    def resampled(self, spacing: float) -> Road:
        """The same road with data at most `spacing` (m) apart, evenly; the reference is drawn anew through the new points.

        Where limits change between two stations the lower one counts from the earlier station on.

        Raises:
            RoadError: a spacing not positive, or too small (five million points).
        """
        at = columns.even_stations(spacing, self.length, closed=self.closed, name=self.name)
        curve = PlanarCurve.through(self.reference.position(at), closed=self.closed)
        made = self.laid_along(curve, curve.breaks_s[: len(at)], at)
        return replace(made, speed_limit=read_only(np.minimum(made.speed_limit, columns.lowest_between(self.speed_limit, self.s, at, self.length))))

    def laid_along(self, curve: PlanarCurve, s: Floats, at: Floats) -> Road:
        """What this road has at its stations `at` (k,), laid along `curve` at the stations `s` (k,) of that, all in m."""
        read = partial(columns.read_at, s=self.s, at=at, period=self.length if self.closed else None)
        return replace(
            self,
            reference=curve,
            s=read_only(s),
            right=read(self.right),
            left=read(self.left),
            height=read_only(self.height_at(at)),
            speed_limit=read_only(self.speed_limit_at(at)),
            lanes=tuple(lane for lane in (lane.read(read) for lane in self.lanes) if not np.isnan(lane.right).all()),
            bank=read(self.bank),
            friction=read(self.friction),
            drive=None if self.drive is None else self.drive.read(read),
            plan_view=(),
            columns={name: read(values) for name, values in self.columns.items()},
            recorded=self.recorded and self.recorded.laid(at, s),
        )

    @cached_property
    def _height(self) -> PchipInterpolator:
        return columns.monotone(self.height, self.s, self.length if self.closed else None)

    def _wrap(self, s: ArrayLike) -> Floats:
        s = np.asarray(s, dtype=np.float64)
        return np.mod(s, self.length) if self.closed else np.clip(s, 0.0, self.length)
