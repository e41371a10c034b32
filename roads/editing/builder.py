"""Put a road together from straights, clothoids and arcs.

    road = RoadBuilder("test").straight(80).bend(15, np.radians(90), blend=10).straight(60).build()

The curvature is piecewise linear over arc length; headings are integrated exactly, positions by Gauss-Legendre quadrature per step, to about
1e-12 m for steps of 1 m.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Self

import numpy as np

from ..errors import RoadError
from ..geometry.plan_view import Clothoid
from ..road import Road

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)

#: Two lanes of 3.5 m with the divider as reference, right-hand traffic.
TWO_LANES = ((1, -3.5, 0.0), (-1, 0.0, 3.5))


class RoadBuilder:
    """Collects elements of a reference curve; every method that adds one returns the builder."""

    def __init__(self, name: str, start: tuple[float, float] = (0.0, 0.0), heading: float = 0.0) -> None:
        self._name = name
        self._start = start
        self._heading = heading
        self._stations = [0.0]
        self._curvatures: list[tuple[float, float]] = []
        self._limits: list[tuple[float, float]] = []

    @property
    def length(self) -> float:
        """Arc length so far, m."""
        return self._stations[-1]

    def clothoid(self, length: float, start: float, end: float) -> Self:
        """A piece of `length` (m) whose curvature runs linearly from `start` to `end` (1/m, positive left)."""
        if not (length > 0.0 and np.isfinite([length, start, end]).all()):
            raise RoadError(f"{self._name}: element of length {length} m with curvature {start} to {end} 1/m, expected a positive length")
        self._stations.append(self.length + length)
        self._curvatures.append((start, end))
        return self

    def straight(self, length: float) -> Self:
        """A straight of `length` m."""
        return self.clothoid(length, 0.0, 0.0)

    def arc(self, radius: float, angle: float) -> Self:
        """An arc of `radius` (m) that turns by `angle` (rad, positive left)."""
        return self.clothoid(radius * abs(angle), np.sign(angle) / radius, np.sign(angle) / radius)

    def bend(self, radius: float, angle: float, blend: float) -> Self:
        """A bend that turns by `angle` (rad, positive left): clothoid of length `blend` (m), arc of `radius` (m), clothoid.

        Raises:
            RoadError: the two clothoids alone would turn further than `angle`.
        """
        kappa = np.sign(angle) / radius
        arc_length = radius * abs(angle) - blend
        if arc_length < 0.0:
            raise RoadError(
                f"{self._name}: clothoids of {blend} m turn by {blend / radius:.3f} rad at radius {radius} m, more than {abs(angle):.3f} rad"
            )
        self.clothoid(blend, 0.0, kappa)
        if arc_length > 0.0:
            self.clothoid(arc_length, kappa, kappa)
        return self.clothoid(blend, kappa, 0.0)

    def roundabout(self, entry: float, ring: float, angle: float, blend: float) -> Self:
        """Through a roundabout in right-hand traffic: right onto the ring, left along it, right off it.

        Args:
            entry: radius of the bends at entry and exit, m.
            ring: radius of the driven ring, m.
            angle: how far the road goes round the ring, rad; entry and exit turn back so that the heading changes by
                `angle` minus a right angle.
            blend: length of each clothoid, m.
        """
        swerve = np.pi / 4
        return self.bend(entry, -swerve, blend).bend(ring, angle, blend).bend(entry, -swerve, blend)

    def limit(self, speed: float) -> Self:
        """Post a speed limit (m/s) from here on."""
        self._limits.append((self.length, speed))
        return self

    def build(
        self,
        *,
        spacing: float = 1.0,
        lanes: Sequence[tuple[int, float, float]] = TWO_LANES,
        height: Callable[[Floats], Floats] | None = None,
        closed: bool = False,
    ) -> Road:
        """Make the road.

        Args:
            spacing: longest distance of its points, m.
            lanes: (direction, right offset, left offset) from right to left, m; the outer ones are the road's edges.
            height: m over stations (n,); flat where not given.
            closed: the end joins the start.

        Raises:
            RoadError: no elements, or a closed road whose end is more than 1 mm or 1e-4 rad away from its start.
        """
        if not self._curvatures:
            raise RoadError(f"{self._name}: no elements, expected at least one")
        s, points, heading = self._integrate(spacing)
        if closed:
            gap = np.hypot(*(points[-1] - points[0]))
            turn = (heading - self._heading + np.pi) % (2 * np.pi) - np.pi
            if gap > 1e-3 or abs(turn) > 1e-4:
                raise RoadError(f"{self._name}: the end misses the start by {gap:.4f} m and {turn:.5f} rad, expected 0.001 m and 0.0001 rad")
            s, points = s[:-1], points[:-1]
        limit = np.full(len(s), np.inf)
        for start, speed in self._limits:
            limit[s >= start - 1e-9] = speed
        return Road.from_points(
            self._name,
            points,
            lanes[0][1],
            lanes[-1][2],
            closed=closed,
            height=0.0 if height is None else height(s),
            speed_limit=limit,
            lane_edges=lanes,
            plan_view=self.elements(),
        )

    def end(self) -> tuple[tuple[float, float], float]:
        """Place (x, y) in m and heading in rad where the elements so far end."""
        last = self.elements()[-1]
        (place,), (heading,) = last.at(np.array([last.length]))
        return (float(place[0]), float(place[1])), float(heading)

    def elements(self) -> tuple[Clothoid, ...]:
        """What the reference has been drawn with so far."""
        found, (x, y), heading = [], self._start, self._heading
        for length, (start, end) in zip(np.diff(self._stations).tolist(), self._curvatures, strict=True):
            element = Clothoid(float(x), float(y), float(heading), length, float(start), float(end))
            (end_point,), (end_heading,) = element.at(np.array([length]))
            (x, y), heading = end_point, end_heading
            found.append(element)
        return tuple(found)

    def _integrate(self, spacing: float) -> tuple[Floats, Floats, float]:
        """Stations, points and the end heading."""
        stations = np.array(self._stations)
        first, last = np.array(self._curvatures).T
        parts = np.maximum(np.ceil(np.diff(stations) / spacing - 1e-9), 1).astype(int)
        s = np.concatenate([[0.0], *(np.linspace(a, b, n + 1)[1:] for a, b, n in zip(stations[:-1], stations[1:], parts, strict=True))])
        element = np.repeat(np.arange(len(parts)), parts)
        rate = (last - first) / np.diff(stations)
        heading_at = self._heading + np.concatenate([[0.0], np.cumsum(0.5 * (first + last) * np.diff(stations))])
        step = np.diff(s)
        local = (s[:-1] - stations[element])[:, None] + 0.5 * step[:, None] * (1.0 + _NODES)
        psi = heading_at[element][:, None] + first[element][:, None] * local + 0.5 * rate[element][:, None] * local**2
        moves = 0.5 * step[:, None] * np.column_stack([np.cos(psi) @ _WEIGHTS, np.sin(psi) @ _WEIGHTS])
        points = np.vstack([[0.0, 0.0], np.cumsum(moves, axis=0)]) + np.array(self._start)
        return s, points, float(heading_at[-1])
