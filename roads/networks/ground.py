"""Where a careful driver can drive in a network: how far each lane is wide enough, which links meet, and where lanes lie side by side.

A driver keeps to lanes of at least `NARROW`, goes from lane to lane where they meet within `GAP` and about the same direction, and needs
`LEAST_CHANGE` for each change to a neighbour. Directions are those of a stretch: borders of surveyed lanes often turn at their last segment.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from ..errors import RoadError
from .ends import CORNER, NOTHING, between, ends_of, on_the_spot

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .links import Link, LinkMap

    Floats = NDArray[np.float64]
    #: Shares of a link's length, from and to.
    Span = tuple[float, float]

Side = Literal["left", "right"]

#: Lanes that follow each other may begin this far from where the one before ends, m, and turn by so much, rad.
GAP, KINK = 3.0, 0.7
#: A lane whose end is cut so obliquely that less than this share of it lies across has no width there.
SLANT = 0.35
#: A lane beside others is not driven where it is narrower, m.
NARROW = 2.0
#: A change of lane takes at least this way, m.
LEAST_CHANGE = 12.0
#: Shares of a length that agree; and what is added to widths before they are compared, m.
SAME, ROUNDING = 1e-9, 1e-6
#: Cross-sections that one change leads over, at most.
MOST_SECTIONS = 400

ACROSS: dict[Side, Side] = {"left": "right", "right": "left"}


class Refused(NamedTuple):
    """A link from lane to lane that nobody can drive, and why; `narrow` where one of them is too narrow there for a car."""

    reason: str
    narrow: bool


class Landing(NamedTuple):
    """Where a change of lane can end at the earliest: on which link, at which share; the lanes from and to of every cross-section passed."""

    name: str
    share: float
    lanes: tuple[tuple[str, str], ...]


class Ground:
    """What can be driven of the links of a network. Every question is worked out when it is first asked."""

    def __init__(self, network: LinkMap) -> None:
        self.network = network
        self.links = network.links
        self._common: dict[tuple[str, str], list[Span]] = {}

    @cached_property
    def lengths(self) -> dict[str, float]:
        """Length of every link whose geometry is sound, m."""
        found = {}
        for name, link in self.links.items():
            try:
                found[name] = link.length
            except RoadError:
                continue
        return found

    @cached_property
    def spans(self) -> dict[str, list[Span]]:
        """Where each link that counts is wide enough, as shares of its length; a lane with none beside it is driven as it is."""
        return {name: self._spans(self.links[name]) for name, length in self.lengths.items() if length >= NOTHING}

    @cached_property
    def unfit(self) -> dict[str, str]:
        """Links that turn round on the spot, which no car does, with what they do: on any way onto them and off them."""
        return on_the_spot(self.links, self.lengths, self.ends)

    @cached_property
    def ends(self) -> dict[str, Floats]:
        """The ends of each link with sound geometry, see `ends_of`."""
        return ends_of(self.links, self.lengths)

    def _spans(self, link: Link) -> list[Span]:
        if link.id in self.unfit:
            return []
        if link.left is None and link.right is None:
            return [(0.0, 1.0)]
        over = link.widths + ROUNDING - NARROW
        if over.min() >= 0.0:
            return [(0.0, 1.0)]
        if over.max() < 0.0:
            return []
        share = link.stations / link.length
        flips = np.flatnonzero((over[1:] >= 0.0) != (over[:-1] >= 0.0))
        marks = share[flips] + (share[flips + 1] - share[flips]) * over[flips] / (over[flips] - over[flips + 1])
        ends = np.concatenate([[0.0] if over[0] >= 0.0 else [], marks, [1.0] if over[-1] >= 0.0 else []])
        return [(low, high) for low, high in ends.reshape(-1, 2).tolist() if (high - low) * link.length >= NOTHING]

    @cached_property
    def onward(self) -> dict[str, tuple[str, ...]]:
        """Links that can be driven onto from the end of each, those that count as nothing passed over."""
        return self._joints[0]

    @cached_property
    def refused(self) -> dict[tuple[str, str], Refused]:
        """Links from lane to lane of the file that nobody can drive."""
        return self._joints[1]

    @cached_property
    def entering(self) -> dict[str, list[str]]:
        """Links that can be driven from onto the beginning of each."""
        found: dict[str, list[str]] = {}
        for name, others in self.onward.items():
            for other in others:
                found.setdefault(other, []).append(name)
        return found

    def after(self, name: str) -> list[str]:
        """Links that count and that the file says follow `name`, those between passed over."""
        found: dict[str, None] = {}
        seen: set[str] = set()
        waiting = list(self.links[name].successors[::-1])
        while waiting:
            other = waiting.pop()
            if other in seen or other not in self.lengths:
                continue
            seen.add(other)
            if other in self.spans:
                found[other] = None
            else:
                waiting += self.links[other].successors[::-1]
        return list(found)

    @cached_property
    def _joints(self) -> tuple[dict[str, tuple[str, ...]], dict[tuple[str, str], Refused]]:
        pairs = [(name, other) for name in self.spans for other in self.after(name)]
        onward: dict[str, list[str]] = {name: [] for name in self.spans}
        refused: dict[tuple[str, str], Refused] = {}
        if not pairs:
            return dict.fromkeys(onward, ()), refused
        gap, kink, most = self._misses(pairs)
        for (name, other), far, turn, limit in zip(pairs, gap.tolist(), kink.tolist(), most.tolist(), strict=True):
            narrow = self._narrow_end(name, other)
            if far > GAP or turn > limit:
                where = f"lane {other} begins {far:.2f} m and {turn:.2f} rad away from the end of {name}"
                refused[name, other] = Refused(f"{where}, expected at most {GAP} m and {limit} rad", narrow=False)
            elif narrow is not None:
                refused[name, other] = Refused(narrow, narrow=True)
            else:
                onward[name].append(other)
        return {name: tuple(others) for name, others in onward.items()}, refused

    def _narrow_end(self, name: str, other: str) -> str | None:
        for which, at, verb in ((name, 1, "ends"), (other, 0, "begins")):
            spans = self.spans[which]
            if which in self.unfit:
                return self.unfit[which]
            _, _, x, y, u, v = self.ends[which][at]
            if not self.links[which].exact and abs(x * u + y * v) < SLANT * np.hypot(x, y) * np.hypot(u, v):
                return f"lane {which} {verb} along the line from border to border, expected across it"
            if not spans or spans[-at][at] != float(at):
                width = self.links[which].end_widths[at]
                return f"lane {which} {verb} {width:.2f} m wide beside others, expected at least {NARROW:g} m"
        return None

    def _misses(self, pairs: list[tuple[str, str]]) -> tuple[Floats, Floats, Floats]:
        """By how much (m) and by which turn (rad) pairs of links miss each other, and the most that such links may turn."""
        row = {name: k for k, name in enumerate(self.ends)}
        ends = np.array(list(self.ends.values()))
        before, after = (ends[[row[pair[k]] for pair in pairs]] for k in (0, 1))
        gap = np.hypot(*(after[:, 0, :2] - before[:, 1, :2]).T)
        by_chord, by_normal = (between(before[:, 1, k : k + 2], after[:, 0, k : k + 2]) for k in (2, 4))
        exact = np.array([self.links[name].exact and self.links[other].exact for name, other in pairs])
        return gap, np.where(exact, np.fmin(by_chord, by_normal), by_chord), np.where(exact, KINK, CORNER)

    def beside(self, name: str, side: Side) -> str | None:
        """The neighbour on that side, None where there is none that counts."""
        link = self.links[name]
        other = link.left if side == "left" else link.right
        return other if other in self.spans and other != name else None

    def common(self, name: str, other: str) -> list[Span]:
        """Where two neighbours are both wide enough, as shares of their lengths."""
        key = (name, other) if name < other else (other, name)
        if key not in self._common:
            both = [(max(a, c), min(b, d)) for a, b in self.spans[name] for c, d in self.spans[other]]
            self._common[key] = [(low, high) for low, high in both if high - low > SAME]
        return self._common[key]

    def mean_length(self, name: str, other: str) -> float:
        """Of two neighbours, m."""
        return 0.5 * (self.lengths[name] + self.lengths[other])

    def side_by_side_after(self, name: str, other: str, side: Side) -> list[tuple[str, str]]:
        """Pairs of neighbours that `name` and its neighbour `other` lead on to side by side, wide enough from their beginning."""
        return [
            (a, b)
            for a in self.onward[name]
            for b in self.onward[other]
            if self.beside(a, side) == b and (spans := self.common(a, b)) and spans[0][0] == 0.0
        ]

    def landings(self, name: str, share: float, side: Side, need: float = LEAST_CHANGE) -> list[Landing]:
        """Where a change to the neighbour on `side` that begins at a share of a link ends after `need` m; empty where it has no room."""
        found: list[Landing] = []
        first = self.beside(name, side)
        waiting = [] if first is None else [(name, first, share, need, ())]
        while waiting:
            here, other, low, left, passed = waiting.pop()
            high = next((b for a, b in self.common(here, other) if a - SAME <= low <= b), None)
            if high is None:
                continue
            length = self.mean_length(here, other)
            lanes = (*passed, (here, other))
            if (high - low) * length >= left - ROUNDING:
                found.append(Landing(other, min(low + left / length, high), lanes))
            elif high == 1.0 and len(lanes) < MOST_SECTIONS:
                rest = left - (high - low) * length
                waiting += [(a, b, 0.0, rest, lanes) for a, b in self.side_by_side_after(here, other, side)]
        return found
