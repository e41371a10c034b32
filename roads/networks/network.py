"""A road network: lanes that lead on to lanes, and the route through them from A to B."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

from ..errors import RoadError
from ..findings import Finding, Findings
from .ground import Ground
from .links import LinkMap
from .routing import shown

if TYPE_CHECKING:
    from collections.abc import Callable

    from ..road import Road
    from .finding import Finder
    from .links import Link
    from .routing import Cost, Place, Step


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
        return self._finder.alone(identity)

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
        return self._finder.find(name or f"{self.name}: {shown(start)} to {shown(goal)}", start, goal, cost)[1]

    def steps(self, start: Place, goal: Place, *, cost: Cost = "length") -> list[list[Step]]:
        """The way of `route` lane by lane: stretches that follow each other, each with the lanes that are changed along it.

        A change that leads over several cross-sections is listed in each of them.

        Raises:
            RoadError: as `route`.
        """
        return self._finder.find(f"{self.name}: {shown(start)} to {shown(goal)}", start, goal, cost)[0].steps()

    def nearest(self, x: float, y: float) -> tuple[str, float, float]:
        """The link whose centre line is closest to (x, y): its id, the distance along it and the distance from it, m.

        Raises:
            RoadError: a position that is not finite, or a network without usable links.
        """
        return self._map.nearest(x, y)

    @cached_property
    def _finder(self) -> Finder:
        from .finding import Finder  # brings SciPy with it, which takes longer than reading a network

        return Finder(self._ground)

    @cached_property
    def _ground(self) -> Ground:
        return Ground(self._map)

    @cached_property
    def _map(self) -> LinkMap:
        return LinkMap(self.path, self.links, self.lengths)

    def check(self) -> list[Finding]:
        """All findings: those of reading, and of making every link and every road.

        A road that cannot be made is an error; a link from lane to lane that nobody can drive is a warning.
        """
        found = Findings(list(self.findings))
        for link in self.links.values():
            try:
                _ = link.length
            except RoadError as error:
                found.error(error)
        barred = dict.fromkeys(refused.reason for refused in self._ground.refused.values() if not refused.narrow)
        for reason in barred | dict.fromkeys(self._ground.unfit.values()):
            found.warn(self.path, f"{reason}; nobody is led there")
        tapers = sum(refused.narrow for refused in self._ground.refused.values())
        if tapers:
            found.note(self.path, "links that lead through the narrow end of a lane beside others are driven as changes of lane", tapers)
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


def _some(ids: list[str], most: int = 12) -> str:
    return ", ".join(ids[:most]) + (f", ... ({len(ids)} in all)" if len(ids) > most else "")
