"""A road network: lanes that lead on to lanes, and the route through them from A to B."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from .borders import way_along
from .errors import RoadError

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from .findings import Finding
    from .road import Road
    from .routing import Cost, Place, Step

    Floats = NDArray[np.float64]


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
        limits: (from, speed): limit in m/s from that distance (m) along the link on; inf where none is posted.
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
    def end_widths(self) -> tuple[float, float]:
        """Width at its beginning and at its end, m."""
        left, right = self.borders
        return tuple(float(np.hypot(*(left[k] - right[k])[:2])) for k in (0, -1))  # pyright: ignore[reportReturnType]

    @property
    def length(self) -> float:
        """m"""
        return float(self.stations[-1])

    def limit_at(self, s: Floats) -> Floats:
        """Posted limit in m/s at distances `s` along the link."""
        starts, speeds = np.array(self.limits).T
        return speeds[np.clip(np.searchsorted(starts, s + 1e-9, side="right") - 1, 0, len(starts) - 1)]


@dataclass(eq=False)
class Network:
    """What `roads.read_network` returns.

    Attributes:
        name: of the file.
        path: the file.
        format: its format in words, with the version.
        links: by id, in the order of the file.
        lengths: length of every road, m, by its id.
        findings: what was noticed while reading.
        builder: makes the `Road` of a road's id, where the format has roads with a cross-section of their own.
        geographic: the projection that the file states for its coordinates, empty where it states none.
    """

    name: str
    path: str
    format: str
    links: dict[str, Link]
    lengths: dict[str, float]
    findings: list[Finding] = field(default_factory=list)
    builder: Callable[[str], Road] | None = None
    geographic: str = ""

    @property
    def roads(self) -> list[str]:
        """Ids of the roads, in the order of the file."""
        return list(self.lengths)

    def road(self, identity: str) -> Road:
        """The road (or lanelet) of that id, in a direction that its lanes lead.

        Raises:
            RoadError: no such road, or one without drivable lanes or sound geometry.
        """
        if identity not in self.lengths:
            raise RoadError(f"{self.path}: no road {identity!r}, expected one of {_some(self.roads)}")
        if self.builder is not None:
            return self.builder(identity)
        return self.route(identity, identity)

    def route(self, start: Place, goal: Place, *, cost: Cost = "length", name: str | None = None) -> Road:
        """The cheapest way from `start` to `goal` as one road whose reference is the middle of the lanes driven.

        Args:
            start: a position (x, y) in m, or the id of a link or of a road (which then is driven from its beginning).
            goal: as `start` (a road is driven to its end).
            cost: `length`, `time` (at the posted limits, 50 km/h where there is none), or a function of (s, height, limit) along a stretch,
                arrays of (n,), that returns what the stretch costs, such as the energy that a car needs; it may be negative.
            name: of the road; default: from start to goal.

        Raises:
            RoadError: no such place, or no way between them.
        """
        from .assembly import assemble

        return assemble(name or f"{self.name}: {_worded(start)} to {_worded(goal)}", self, self.steps(start, goal, cost=cost))

    def steps(self, start: Place, goal: Place, *, cost: Cost = "length") -> list[list[Step]]:
        """The way of `route` lane by lane: stretches that follow each other, each with the lanes that are changed along it."""
        from .routing import find_route

        return find_route(self, start, goal, cost)

    def nearest(self, x: float, y: float) -> tuple[str, float, float]:
        """The link whose centre line is closest to (x, y): its id, the distance along it and the distance from it, m.

        Raises:
            RoadError: a network without usable links.
        """
        from .routing import nearest_link

        return nearest_link(self, x, y)

    def check(self) -> list[Finding]:
        """All findings: those of reading, and of making every link and every road.

        A road that cannot be made is an error; so is a link that stops within the network without leading on, as a warning.
        """
        from .findings import Findings

        found = Findings(list(self.findings))
        for link in self.links.values():
            try:
                _ = link.length
            except RoadError as error:
                found.error(error)
        drivable = {link.road for link in self.links.values()}
        for identity in self.roads if self.builder is not None else []:
            if identity not in drivable:
                found.note(f"{self.path}: road {identity}", "no lane for cars")
                continue
            try:
                self.road(identity)
            except RoadError as error:
                found.error(error)
        return found.all()


def _worded(place: Place) -> str:
    return place if isinstance(place, str) else f"({place[0]:.1f}, {place[1]:.1f})"


def _some(ids: list[str], most: int = 12) -> str:
    return ", ".join(ids[:most]) + (f", ... ({len(ids)} in all)" if len(ids) > most else "")
