"""A way through a network's lanes: where it begins and ends, the cross-sections it leads along, and how its changes of lane are spread."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Literal

import numpy as np

from ..errors import RoadError
from .ground import ACROSS, NARROW, SAME

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .ground import Ground, Side
    from .lattice import Way
    from .links import Link

    Floats = NDArray[np.float64]

Place = str | tuple[float, float]
Cost = Literal["length", "time"] | Callable[["Floats", "Floats", "Floats"], float]
#: A link and a share of its length.
Spot = tuple[str, float]

#: A position may be this far from the middle of the nearest lane, m.
FAR = 50.0
#: A change of lane takes at most this way, m.
CHANGE = 80.0


@dataclass(frozen=True)
class Step:
    """A stretch of one link: from `start` to `end` (m along it), and whether the next step is a neighbour of the same cross-section."""

    link: Link
    start: float
    end: float


@dataclass(eq=False)
class Stretch:
    """A run of cross-sections that a way leads along.

    Attributes:
        low: where it begins, as a share of its lanes' lengths.
        high: where it ends.
        lanes: the lane driven after that many changes, for those that matter here.
        main: how many changes were made where it begins.
    """

    low: float
    high: float
    lanes: dict[int, str]
    main: int


@dataclass(eq=False)
class Change:
    """One change of lane: the run it may use and the part of that it uses, m along the way."""

    side: Side
    low: float = 0.0
    high: float = 0.0
    begin: float = 0.0
    end: float = 0.0


@dataclass(eq=False)
class Route:
    """A way made ready to be drawn.

    Attributes:
        ground: what it leads through.
        stretches: in order.
        starts: (n + 1,) where each begins and the last one ends, m along the way.
        changes: in order.
    """

    ground: Ground
    stretches: list[Stretch]
    starts: Floats
    changes: list[Change]

    def progress(self, way: Floats) -> Floats:
        """Changes made up to places (m along the way); those under way count in part, smoothly."""
        made = np.zeros(np.shape(way))
        for change in self.changes:
            made += eased(np.clip((way - change.begin) / max(change.end - change.begin, 1e-9), 0.0, 1.0))
        return made

    def tracks(self, k: int) -> range:
        """How many changes were made at the beginning and at the end of a stretch, those under way counted as not made and as made."""
        low, high = self.starts[k] + 1e-6, self.starts[k + 1] - 1e-6
        first = sum(change.end <= low for change in self.changes)
        last = sum(change.begin < high for change in self.changes)
        return range(first, max(first, last) + 1)

    def steps(self) -> list[list[Step]]:
        """Lane by lane: stretches that follow each other, each with the lanes that are changed along it."""
        found = []
        for k, stretch in enumerate(self.stretches):
            links = [self.ground.links[stretch.lanes[track]] for track in self.tracks(k)]
            found.append([Step(link, stretch.low * link.length, stretch.high * link.length) for link in links])
        return found


def eased(share: Floats) -> Floats:
    """From 0 to 1 with two vanishing derivatives at both ends."""
    return share**3 * (10.0 - 15.0 * share + 6.0 * share**2)


def spots_of(ground: Ground, place: Place, end: int) -> list[Spot]:
    """Where `place` may be, `end` 0 for the beginning of a way and 1 for its end: several lanes side by side where it names a road.

    A lane that is named begins and ends where it is wide enough; what counts as nothing stands for what is next to it.

    Raises:
        RoadError: no such place.
    """
    path, links = ground.network.path, ground.links
    if not isinstance(place, str):
        name, s, distance = ground.network.nearest(*place)
        if distance > FAR:
            raise RoadError(
                f"{path}: ({place[0]:.1f}, {place[1]:.1f}) is {distance:.0f} m from the nearest lane {name}, expected at most {FAR:.0f} m"
            )
        return [(name, s / links[name].length)] if name in ground.spans else _at_end(ground, name, end)
    if place in links:
        return _at_end(ground, place, end)
    if place not in ground.network.lengths:
        raise RoadError(f"{path}: no road or lane {place!r}, expected an id such as {', '.join(list(ground.network.lengths)[:6])} or a position x,y")
    own = [link for link in links.values() if link.road == place and link.id in ground.lengths]
    if not own:
        raise RoadError(f"{path}: road {place} has no drivable lane")
    ends = [link for link in own if link.at_ends[end]]
    # a lane that begins or ends in a taper is no place to begin or end
    wide = [link for link in ends if link.end_widths[end] >= NARROW] or ends
    return [spot for link in wide for spot in _at_end(ground, link.id, end)]


def _at_end(ground: Ground, name: str, end: int) -> list[Spot]:
    if name in ground.spans:
        return [(name, ground.spans[name][-end][end])] if ground.spans[name] else []
    if name not in ground.lengths:
        return []
    if end == 0:
        return [(other, 0.0) for other in ground.after(name)]
    return [(other, 1.0) for other in ground.spans if name in ground.links[other].successors]


def around(ground: Ground, place: Place, spots: list[Spot]) -> list[Spot]:
    """The same with all lanes side by side, where `place` is a position."""
    if isinstance(place, str):
        return spots
    found = []
    for name, share in spots:
        link = ground.links[name]
        found += [
            (other, 1.0 - share if against else share) for other, against in zip(link.beside, link.against, strict=True) if other in ground.spans
        ]
    return found


def route_of(ground: Ground, way: Way) -> Route:
    """The cross-sections along a way of the lattice, and its changes of lane spread over the room they have."""
    (name, share), *_ = way.places
    stretches = [Stretch(share, share, {0: name}, 0)]
    changes: list[Change] = []
    marks: list[tuple[int, float, int, float]] = []
    for (before, _), (after, at), landing in zip(way.places, way.places[1:], way.changes[1:], strict=False):
        made = len(changes)
        if landing is None:
            if after != before:
                stretches.append(Stretch(0.0, at, {made: after}, made))
            stretches[-1].high = at
            continue
        first = len(stretches) - 1, stretches[-1].high
        side: Side = next(side for side in ACROSS if ground.beside(landing.lanes[0][0], side) == landing.lanes[0][1])
        for k, (a, b) in enumerate(landing.lanes):
            if k:
                stretches.append(Stretch(0.0, 1.0, {made: a}, made))
            stretches[-1].high = 1.0
            stretches[-1].lanes[made + 1] = b
        stretches[-1].high = landing.share
        changes.append(Change(side))
        marks.append((*first, len(stretches) - 1, landing.share))
    lengths = [(item.high - item.low) * ground.lengths[item.lanes[item.main]] for item in stretches]
    route = Route(ground, stretches, np.concatenate([[0.0], np.cumsum(lengths)]), changes)
    for k, mark in enumerate(marks):
        changes[k].low, changes[k].high = _run(route, k, mark)
    _spread(changes, [_way_to(route, last, end) for _, _, last, end in marks])
    return route


def _run(route: Route, k: int, mark: tuple[int, float, int, float]) -> tuple[float, float]:
    """Where change `k` could begin and end at the most, m along the way: as far as both its lanes lie side by side; they are noted on the way."""
    ground, stretches, side = route.ground, route.stretches, route.changes[k].side
    first, begin, last, end = mark
    while True:
        here, pair = stretches[first], _pair(stretches[first], k)
        low = next((a for a, b in ground.common(*pair) if a - SAME <= begin <= b + SAME), begin)
        if low > 0.0 or here.low > 0.0 or first == 0 or k not in (earlier := stretches[first - 1]).lanes:
            begin = max(low, here.low)
            break
        name = earlier.lanes[k]
        other = ground.beside(name, side)
        if (
            other is None
            or pair not in ground.side_by_side_after(name, other, side)
            or (spans := ground.common(name, other)) == []
            or spans[-1][1] < 1.0
        ):
            begin = 0.0
            break
        earlier.lanes[k + 1] = other
        first, begin = first - 1, 1.0
    while True:
        here, pair = stretches[last], _pair(stretches[last], k)
        high = next((b for a, b in ground.common(*pair) if a - SAME <= end <= b + SAME), end)
        if high < 1.0 or here.high < 1.0 or last + 1 == len(stretches) or k + 1 not in (later := stretches[last + 1]).lanes:
            end = min(high, here.high)
            break
        other = later.lanes[k + 1]
        name = ground.beside(other, ACROSS[side])
        if name is None or (name, other) not in ground.side_by_side_after(*pair, side):
            end = 1.0
            break
        later.lanes[k] = name
        last, end = last + 1, 0.0
    return _way_to(route, first, begin), _way_to(route, last, end)


def _pair(stretch: Stretch, k: int) -> tuple[str, str]:
    return stretch.lanes[k], stretch.lanes[k + 1]


def _way_to(route: Route, k: int, share: float) -> float:
    """Distance along the way of a share of a stretch's lanes, m."""
    stretch = route.stretches[k]
    length = max(stretch.high - stretch.low, SAME)
    return float(route.starts[k] + (route.starts[k + 1] - route.starts[k]) * (share - stretch.low) / length)


def _spread(changes: list[Change], earliest: list[float]) -> None:
    """Changes as long as their runs allow, at the ends of these; those that share a run share its room evenly.

    `earliest` is where each can end at the earliest, m along the way: there is always room for that.
    """
    latest = np.inf
    for k in range(len(changes) - 1, -1, -1):
        change = changes[k]
        change.end = max(min(change.high, latest), earliest[k])
        room = min((change.end - other.low) / (k - j + 1) for j, other in enumerate(changes[: k + 1]))
        change.begin = max(change.end - min(CHANGE, room), change.low, *earliest[max(k - 1, 0) : k])
        latest = change.begin


def names_along(route: Route) -> list[tuple[str, str]]:
    """The links from lane to lane that a route uses, by the stretch that each leads to, from the second one on."""
    found = []
    for k, (before, after) in enumerate(pairwise(route.stretches)):
        track = route.tracks(k).stop - 1
        track = track if track in after.lanes and track in before.lanes else after.main
        found.append((before.lanes[track], after.lanes[track]))
    return found


def shown(place: Place) -> str:
    """A place in words: the id, or (x, y) in m."""
    return place if isinstance(place, str) else f"({place[0]:.1f}, {place[1]:.1f})"
