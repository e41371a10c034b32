"""Roads, sections and lanes of a town before they are written; right-hand traffic, mirrored while writing where traffic keeps left."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from .curves import Element, Pose

#: A cubic from a station on: sOffset, a, b, c, d.
Width = tuple[float, float, float, float, float]


@dataclass
class Lane:
    """One lane of one section; lanes of one `key` that follow each other are linked."""

    key: str
    kind: str
    widths: list[Width]
    before: list[int] = field(default_factory=list)
    after: list[int] = field(default_factory=list)
    more: str = ""

    def width(self, at: float) -> float:
        offset, a, b, c, d = [row for row in self.widths if row[0] <= at + 1e-12][-1]
        t = at - offset
        return a + b * t + c * t**2 + d * t**3

    def starting(self, at: float) -> Lane:
        """The same lane in a section that begins `at` further on."""
        rows = [row for row in self.widths if row[0] <= at + 1e-12]
        (_offset, a, b, c, d), t = rows[-1], at - rows[-1][0]
        first = (0.0, a + b * t + c * t**2 + d * t**3, b + 2 * c * t + 3 * d * t**2, c + 3 * d * t, d)
        return replace(self, widths=[first] + [(row[0] - at, *row[1:]) for row in self.widths[len(rows) :]])


@dataclass
class Section:
    """Lanes from station `s` on, `left` and `right` from the middle outwards."""

    s: float
    left: list[Lane]
    right: list[Lane]

    def sides(self) -> tuple[list[Lane], list[Lane]]:
        return self.left, self.right

    def starting(self, s: float) -> Section:
        return Section(s, *([lane.starting(s - self.s) for lane in side] for side in self.sides()))


@dataclass
class End:
    kind: str
    id: str
    contact: str = ""


@dataclass
class Street:
    id: str
    elements: list[Element]
    sections: list[Section]
    junction: str = "-1"
    offsets: list[Width] = field(default_factory=list)
    heights: tuple[float, float] = (0.0, 0.0)
    before: End | None = None
    after: End | None = None
    more: str = ""

    @property
    def length(self) -> float:
        return sum(element.length for element in self.elements)

    def offset(self, s: float) -> float:
        rows = [row for row in self.offsets if row[0] <= s]
        if not rows:
            return 0.0
        start, a, b, c, d = rows[-1]
        t = s - start
        return a + b * t + c * t**2 + d * t**3

    def link_sections(self) -> None:
        """Links from section to section between lanes of one key."""
        for one, other in zip(self.sections, self.sections[1:], strict=False):
            for sign, here, there in ((1, one.left, other.left), (-1, one.right, other.right)):
                number = {lane.key: sign * (k + 1) for k, lane in enumerate(there)}
                for _k, lane in enumerate(here):
                    lane.after = [number[lane.key]] if lane.key in number else []
                number = {lane.key: sign * (k + 1) for k, lane in enumerate(here)}
                for lane in there:
                    lane.before = [number[lane.key]] if lane.key in number else []

    def end_section(self, contact: str) -> tuple[Section, float]:
        """The section at that end, and the distance of the end from its beginning."""
        if contact == "start":
            return self.sections[0], 0.0
        return self.sections[-1], self.length - self.sections[-1].s


@dataclass
class Gate:
    """One lane at the end of a road: driven into the junction there or out of it; `pose` is that of its left border as it is driven."""

    road: str
    contact: str
    number: int
    pose: Pose
    width: float
    height: float


@dataclass
class Connection:
    incoming: str
    road: str
    contact: str
    lanes: list[tuple[int, int]]


@dataclass
class Junction:
    id: str
    connections: list[Connection] = field(default_factory=list)


@dataclass
class Town:
    name: str
    roads: dict[str, Street] = field(default_factory=dict)
    junctions: list[Junction] = field(default_factory=list)
    left_hand: bool = False
