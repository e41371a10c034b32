"""Links, the lanes that a network consists of, and the nearest one to a place."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..borders import way_along
from ..errors import RoadError

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray
    from scipy.spatial import cKDTree

    Floats = NDArray[np.float64]

#: Places at which the links are looked up, at most.
MOST_SAMPLES = 1_000_000


@dataclass(eq=False)
class Link:
    """One lane between two places where lanes begin or end, seen in its direction of travel.

    Attributes:
        id: unique in the network: `road/section/lane` in OpenDRIVE, the lanelet's id in CommonRoad and Lanelet2, the lane's id in SUMO.
        road: id of the road it belongs to.
        kind: what it is for: driving, entry, exit, ...
        shape: makes left and right border, (n, 3) each, point by point beside each other, m.
        successors: ids of the links that begin where this one ends.
        left: id of the neighbour to the left with the same direction; None where there is none.
        right: as `left`.
        beside: ids of all drivable lanes of the same cross-section that lie side by side with this one, from right to left, itself included.
        against: whether each of `beside` leads the other way.
        limits: (from, speed): limit in m/s from that distance (m) along the link on, or along its reference; inf where none is posted.
        reference: where limits count along a line beside the link, makes the distance along that of the borders' points, (n,), m.
        left_hand: traffic keeps left.
        at_ends: whether it begins where its road begins, and ends where it ends, both as it is driven.
        exact: the borders' points lie on a curve, close enough together; else they are corners of a polyline.
    """

    id: str
    road: str
    kind: str
    shape: Callable[[], tuple[Floats, Floats]]
    successors: list[str] = field(default_factory=list)
    left: str | None = None
    right: str | None = None
    beside: tuple[str, ...] = ()
    against: tuple[bool, ...] = ()
    limits: tuple[tuple[float, float], ...] = ((0.0, np.inf),)
    reference: Callable[[], Floats] | None = None
    left_hand: bool = False
    at_ends: tuple[bool, bool] = (True, True)
    exact: bool = False

    @cached_property
    def borders(self) -> tuple[Floats, Floats]:
        """Left and right border, (n, 3) each, m."""
        return self.shape()

    @cached_property
    def centre(self) -> Floats:
        """(n, 3) centre line, m."""
        left, right = self.borders
        return 0.5 * (left + right)

    @cached_property
    def stations(self) -> Floats:
        """(n,) distance along the centre line in plan, m."""
        return way_along(self.centre)

    @cached_property
    def widths(self) -> Floats:
        """(n,) widths, m: on the surface where heights are exact (a banked lane is narrower seen from above), else in plan."""
        left, right = self.borders
        return np.linalg.norm((left - right)[:, : 3 if self.exact else 2], axis=1)

    @property
    def end_widths(self) -> tuple[float, float]:
        """Width at its beginning and at its end, m."""
        return float(self.widths[0]), float(self.widths[-1])

    @property
    def length(self) -> float:
        """m"""
        return float(self.stations[-1])

    def limit_at(self, s: Floats) -> Floats:
        """Posted limit in m/s at distances `s` along the link."""
        starts, speeds = np.array(self.limits).T
        if self.reference is not None and len(starts) > 1:
            s = np.interp(s, self.stations, self.reference())
        return speeds[np.clip(np.searchsorted(starts, s + 1e-9, side="right") - 1, 0, len(starts) - 1)]


@dataclass(frozen=True, eq=False)
class LinkMap:
    """The links of one file: what ways are sought in and roads are made of.

    Attributes:
        path: the file, for messages.
        links: by id.
        lengths: length of every road, m, by its id.
    """

    path: str
    links: dict[str, Link]
    lengths: dict[str, float]

    def nearest(self, x: float, y: float) -> tuple[str, float, float]:
        """The link whose centre line is closest to (x, y): its id, the distance along it and the distance from it, m.

        Raises:
            RoadError: a position that is not finite, or no usable links.
        """
        if not (abs(x) < 1e9 and abs(y) < 1e9):
            raise RoadError(f"{self.path}: position ({x}, {y}), expected finite numbers below 1e9")
        tree, along, owners, spacing = self._samples
        _, at = tree.query([x, y])
        link = self.links[owners[int(at)]]
        s, distance = _foot(link, float(along[int(at)]), np.array([x, y]), spacing)
        return link.id, s, distance

    @cached_property
    def _samples(self) -> tuple[cKDTree, Floats, list[str], float]:
        """Places on all centre lines, how far along their links they lie, whose they are, and their spacing, m."""
        from scipy.spatial import cKDTree  # slow to import, and most networks are never asked for the nearest link

        points, owners = [], []
        lengths: dict[str, float] = {}
        for name, link in self.links.items():
            with suppress(RoadError):
                lengths[name] = link.length
        # lanes may be far longer than their road
        spacing = max(1.0, sum(lengths.values()) / MOST_SAMPLES)
        for name, length in lengths.items():
            link = self.links[name]
            s = np.linspace(0.0, length, max(int(length / spacing), 1) + 1)
            points.append(np.column_stack([np.interp(s, link.stations, link.centre[:, axis]) for axis in (0, 1)] + [s]))
            owners += [name] * len(s)
        if not points:
            raise RoadError(f"{self.path}: no usable lane")
        table = np.concatenate(points)
        return cKDTree(table[:, :2]), table[:, 2], owners, spacing


def _foot(link: Link, about: float, point: Floats, spacing: float) -> tuple[float, float]:
    """The foot of `point` on the centre line near `about` (m)."""
    line, s = link.centre[:, :2], link.stations
    low = max(int(np.searchsorted(s, about - 2.0 * spacing)) - 1, 0)
    high = min(int(np.searchsorted(s, about + 2.0 * spacing)) + 1, len(s) - 1)
    a, move = line[low:high], np.diff(line[low : high + 1], axis=0)
    share = np.clip(np.sum((point - a) * move, axis=1) / np.maximum(np.sum(move**2, axis=1), 1e-12), 0.0, 1.0)
    distance = np.hypot(*(a + share[:, None] * move - point).T)
    best = int(np.argmin(distance))
    return float(s[low + best] + share[best] * (s[low + best + 1] - s[low + best])), float(distance[best])
