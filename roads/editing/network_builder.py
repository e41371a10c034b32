"""Put a network together from roads and the ways through its junctions.

town = NetworkBuilder("town")
town.road("1", RoadBuilder("arm", (40, 0), 0.0).straight(100).elements(), limit=14)
...
town.write("town.xodr")
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import RoadError
from ..formats.opendrive.records import NOTHING, Connection, Cubics, LaneRecord, OpenDrive, RoadEnd, RoadRecord, SectionRecord
from ..formats.opendrive.writer import write_records
from ..geometry.plan_view import Cubic

if TYPE_CHECKING:
    from collections.abc import Sequence
    from os import PathLike

    from ..geometry.plan_view import Element

#: A road and one of its ends, `start` or `end`.
End = tuple[str, str]


class NetworkBuilder:
    """Collects roads and connections; right-hand traffic, one lane section per road."""

    def __init__(self, name: str) -> None:
        self._drive = OpenDrive(name, "1.6", "")
        self._connections: dict[str, list[Connection]] = {}

    def road(
        self,
        identity: str,
        elements: Sequence[Element],
        *,
        right: Sequence[tuple[float, float]] = ((3.5, 3.5),),
        left: Sequence[tuple[float, float]] = ((3.5, 3.5),),
        limit: float = np.inf,
        junction: str = "-1",
    ) -> None:
        """Add a road.

        Args:
            identity: its id.
            elements: its reference line; each begins where the one before ends.
            right: width at the start and at the end of each lane that leads along the stations, from the middle outwards, m.
            left: as `right`, of the lanes that lead the other way.
            limit: speed limit, m/s.
            junction: id of the junction that the road leads through.

        Raises:
            RoadError: an id used twice, or no elements.
        """
        if identity in self._drive.roads or not elements:
            raise RoadError(f"{self._drive.name}: road {identity!r} is there already or has no elements, expected new roads with elements")
        starts = np.concatenate([[0.0], np.cumsum([element.length for element in elements])])
        length = float(starts[-1])
        sides = [tuple(_lane(sign * (k + 1), -sign, widths, length) for k, widths in enumerate(lanes)) for sign, lanes in ((1, left), (-1, right))]
        section = SectionRecord(0.0, length, sides[0], sides[1])
        speeds = ((0.0, float(limit)),) if np.isfinite(limit) else ()
        self._drive.roads[identity] = RoadRecord(
            identity,
            identity,
            length,
            junction,
            False,
            tuple(elements),
            starts[:-1],
            NOTHING,
            NOTHING,
            NOTHING,
            (section,),
            speeds,
            None,
            None,
            identity,
        )

    def enters(self, junction: str, end: End) -> None:
        """The road end `end` lies at `junction`."""
        self._set_end(end, RoadEnd("junction", junction, ""))

    def connect(self, junction: str, begin: End, via: str, goal: End, lanes: tuple[int, int, int]) -> None:
        """A way through `junction`: from the road end `begin` along road `via` (from its start to its end) to the road end `goal`.

        `lanes` are the lane numbers on the three roads.
        """
        self._set_end((via, "start"), RoadEnd("road", *begin))
        self._set_end((via, "end"), RoadEnd("road", *goal))
        self._connections.setdefault(junction, []).append(Connection(begin[0], via, "start", ((lanes[0], lanes[1]),)))
        road = self._drive.roads[via]
        section = road.sections[0]
        linked = tuple(replace(lane, predecessors=(lanes[0],), successors=(lanes[2],)) if lane.id == lanes[1] else lane for lane in section.right)
        self._drive.roads[via] = replace(road, sections=(replace(section, right=linked),))

    def _set_end(self, end: End, other: RoadEnd) -> None:
        identity, which = end
        if identity not in self._drive.roads or which not in ("start", "end"):
            raise RoadError(f"{self._drive.name}: no {which} of road {identity!r}, expected start or end of one of {', '.join(self._drive.roads)}")
        road = self._drive.roads[identity]
        self._drive.roads[identity] = replace(road, **{"predecessor" if which == "start" else "successor": other})

    def write(self, path: str | PathLike[str]) -> None:
        """Write the network as OpenDRIVE.

        Raises:
            RoadError: the file cannot be written.
        """
        self._drive.junctions.update({identity: tuple(ways) for identity, ways in self._connections.items()})
        write_records(self._drive, Path(path))


def _lane(number: int, direction: int, widths: tuple[float, float], length: float) -> LaneRecord:
    """The width goes over from the one to the other smoothly, without slope at the ends."""
    first, last = widths
    row = (first, 0.0, 3.0 * (last - first) / length**2, -2.0 * (last - first) / length**3)
    return LaneRecord(number, "driving", direction, Cubics((0.0,), (row,)), None, (), (), (), "")


def bridging(start: tuple[float, float, float], end: tuple[float, float, float]) -> Cubic:
    """A cubic from one place and heading (x, y in m, rad) to another: what joins two roads in a junction."""
    x, y, heading = start
    gap = complex(end[0] - x, end[1] - y) * np.exp(-1j * heading)
    turn = np.exp(1j * (end[2] - heading))
    pull = abs(gap) * (1.0 + 0.1 * abs(np.angle(turn)))
    # Hermite's cubic in p from 0 to 1
    rows = [0.0, pull, 3.0 * gap - pull * (2.0 + turn), pull * (1.0 + turn) - 2.0 * gap]
    u, v = (tuple(float(getattr(np.complex128(row), part)) for row in rows) for part in ("real", "imag"))
    made = Cubic(x, y, heading, 1.0, u, v, 1.0, "arc")  # pyright: ignore[reportArgumentType]
    return made.by_arc_length()
