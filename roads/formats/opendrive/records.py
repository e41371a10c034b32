"""What an OpenDRIVE file says, as plain records, before any geometry is evaluated."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ...geometry.plan_view import Element

    Floats = NDArray[np.float64]

#: Lane types that an ordinary car may drive on (ASAM OpenDRIVE 1.8, section 11.7).
DRIVABLE = frozenset(
    {"driving", "entry", "exit", "onRamp", "offRamp", "connectingRamp", "slipLane", "mwyEntry", "mwyExit", "bidirectional", "roadWorks"}
)


@dataclass(frozen=True, eq=False)
class Cubics:
    """A piecewise cubic of a station: `a + b d + c d^2 + e d^3`, `d` counted from each record's start.

    Attributes:
        starts: stations where records start, increasing; before the first one the value is zero.
        rows: coefficients a, b, c, e of each record.
    """

    starts: tuple[float, ...]
    rows: tuple[tuple[float, ...], ...]

    def __call__(self, s: Floats) -> Floats:
        """Values at stations `s`."""
        if not self.starts:
            return np.zeros_like(s)
        if len(self.starts) == 1:
            a, b, c, e = self.rows[0]
            if b == 0.0 == c == e:
                value = np.full(s.shape, a)
            else:
                d = s - self.starts[0]
                value = a + (b + (c + e * d) * d) * d
        else:
            index = np.searchsorted(self.starts, s, side="right") - 1
            d = s - np.array(self.starts)[index]
            a, b, c, e = np.array(self.rows).T[:, index]
            value = a + (b + (c + e * d) * d) * d
        return value if self.starts[0] <= s[0] else np.where(s < self.starts[0], 0.0, value)

    @property
    def is_flat(self) -> bool:
        """True where every record is a straight line."""
        return not any(row[2] or row[3] for row in self.rows)


NOTHING = Cubics((), ())


@dataclass(frozen=True, eq=False)
class LaneRecord:
    """One lane of one section; `width` or `border` is None where the other one rules. Speeds and frictions: (station, m/s or share)."""

    id: int
    kind: str
    direction: int
    width: Cubics | None
    border: Cubics | None
    predecessors: tuple[int, ...]
    successors: tuple[int, ...]
    speeds: tuple[tuple[float, float], ...]
    place: str
    frictions: tuple[tuple[float, float], ...] = ()

    def limits(self, start: float, end: float, of_road: tuple[tuple[float, float], ...]) -> list[tuple[float, float]]:
        """(station, m/s) from `start` to `end`: the lane's own limits where it has begun to have one, before that those of its road."""
        marks = {start} | {at for at, _ in (*self.speeds, *of_road) if start < at < end}
        found = []
        for mark in sorted(marks):
            own = [speed for at, speed in self.speeds if at <= mark + 1e-9]
            road = [speed for at, speed in of_road if at <= mark + 1e-9]
            found.append((mark, own[-1] if own else road[-1] if road else np.inf))
        return found


@dataclass(frozen=True, eq=False)
class SectionRecord:
    """Lanes between two stations: `left` from the middle outwards (ids 1, 2, ...), `right` likewise (-1, -2, ...).

    `number` counts the sections of the road in its file; those that are too short to count are missing among them.
    """

    start: float
    end: float
    left: tuple[LaneRecord, ...]
    right: tuple[LaneRecord, ...]
    number: int = 0

    def lane(self, number: int) -> LaneRecord | None:
        """The lane with that id, None where there is none."""
        side = self.left if number > 0 else self.right
        return side[abs(number) - 1] if 0 < abs(number) <= len(side) else None

    @property
    def lanes(self) -> tuple[LaneRecord, ...]:
        """All lanes, from right to left."""
        return self.right[::-1] + self.left


@dataclass(frozen=True)
class RoadEnd:
    """What a road is linked to at one end."""

    kind: str
    id: str
    contact: str


@dataclass(frozen=True, eq=False)
class RoadRecord:
    """One road."""

    id: str
    name: str
    length: float
    junction: str
    left_hand: bool
    elements: tuple[Element, ...]
    starts: Floats
    elevation: Cubics
    superelevation: Cubics
    lane_offset: Cubics
    sections: tuple[SectionRecord, ...]
    speeds: tuple[tuple[float, float], ...]
    predecessor: RoadEnd | None
    successor: RoadEnd | None
    place: str
    #: Numbers that others know lanes at the road's start and end by, with those of the lanes that are there; None: their own.
    at_start: dict[int, tuple[int, ...]] | None = None
    at_end: dict[int, tuple[int, ...]] | None = None

    def known_as(self, number: int, *, end: bool) -> tuple[int, ...]:
        """The lanes at one end of the road that others call `number`."""
        names = self.at_end if end else self.at_start
        return (number,) if names is None else names.get(number, ())


@dataclass(frozen=True)
class Connection:
    """A way through a junction: from the incoming road's lanes to those of the connecting road."""

    incoming: str
    connecting: str
    contact: str
    lanes: tuple[tuple[int, int], ...]


@dataclass(frozen=True, eq=False)
class OpenDrive:
    """The file."""

    name: str
    version: str
    geo_reference: str
    roads: dict[str, RoadRecord] = field(default_factory=dict)
    junctions: dict[str, tuple[Connection, ...]] = field(default_factory=dict)
