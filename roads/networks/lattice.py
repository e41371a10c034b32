"""The graph that ways are sought in: places on links that something begins or ends at, and the drives and changes of lane between them.

A change of lane is an edge from the place where it begins at the earliest to the place where it then ends, `LEAST_CHANGE` further on and
perhaps some links later: who comes to a lane sooner can do all that who comes later can. So a way in this graph has room for all its changes.
"""

from __future__ import annotations

import itertools
from bisect import bisect_left, bisect_right, insort
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..errors import RoadError
from .ground import SAME
from .shortest import shortest

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from .ground import Ground, Landing, Side

    Floats = NDArray[np.float64]

#: A change of lane costs as much as this way at the average price of the network, m; it keeps routes from weaving.
CHANGE_WAY = 20.0
#: Speed where no limit is posted, m/s.
UNPOSTED = 50.0 / 3.6
#: Lanes that one change after the other can lead across.
MOST_LANES = 30
#: The graph takes a zero for no edge.
FREE = 1e-12


class Way(NamedTuple):
    """A way through the lattice: what it costs, its places (link, share), and the landing of the change that leads to each, None for a drive."""

    cost: float
    places: list[tuple[str, float]]
    changes: list[Landing | None]


def prices_of(ground: Ground, cost: str | Callable[[Floats, Floats, Floats], float]) -> dict[str, float]:
    """What each link costs from its beginning to its end.

    Raises:
        RoadError: an unknown cost, or one that is not a number.
    """
    if not callable(cost) and cost not in ("length", "time"):
        raise RoadError(f"cost {cost!r} is unknown, expected length, time or a function")
    found = {}
    for name in ground.spans:
        link = ground.links[name]
        if cost == "length":
            found[name] = link.length
            continue
        s = link.stations
        limit = link.limit_at(s)
        if callable(cost):
            found[name] = float(cost(s, link.centre[:, 2], limit))
        else:
            found[name] = float(np.sum(np.diff(s) / np.where(np.isfinite(limit[:-1]), limit[:-1], UNPOSTED)))
        if np.isnan(found[name]):
            raise RoadError(f"cost of lane {name} is not a number")
    return found


class Lattice:
    """The graph of one network and cost."""

    def __init__(self, ground: Ground, cost: str | Callable[[Floats, Floats, Floats], float]) -> None:
        self.ground = ground
        self.prices = prices_of(ground, cost)
        total = sum(ground.lengths[name] for name in self.prices)
        self.change = CHANGE_WAY * sum(map(abs, self.prices.values())) / max(total, 1e-9)
        self.places: list[tuple[str, float]] = []
        self._rows: dict[tuple[str, float], int] = {}
        self._on: dict[str, list[tuple[float, int]]] = {}
        self._edges: dict[tuple[int, int], float] = {}
        self._changes: dict[tuple[int, int], Landing] = {}
        for name, spans in ground.spans.items():
            for span in spans:
                for share in span:
                    self._row(name, share)
        for name, share, side in self._starts():
            self._add_changes(name, share, side)
        self._add_drives()
        pairs = np.array(list(self._edges), dtype=np.intp).reshape(-1, 2)
        self._begins, self._ends = pairs[:, 0], pairs[:, 1]
        self._weights = np.array(list(self._edges.values()))

    def _row(self, name: str, share: float) -> int:
        row = self._rows.get((name, share))
        if row is None:
            row = self._rows[name, share] = len(self.places)
            self.places.append((name, share))
            insort(self._on.setdefault(name, []), (share, row))
        return row

    def _put(self, begin: int, end: int, weight: float) -> None:
        self._edges[begin, end] = min(weight if weight != 0.0 else FREE, self._edges.get((begin, end), np.inf))

    def _starts(self) -> list[tuple[str, float, Side]]:
        """Where a change may begin that could not begin before: the lanes begin to lie side by side, or one is come to by another way."""
        found: list[tuple[str, float, Side]] = []
        ground = self.ground
        for name in ground.spans:
            for side in ("left", "right"):
                other = ground.beside(name, side)
                if other is None:
                    continue
                for low, _ in ground.common(name, other):
                    if low > 0.0 or not self._goes_on(name, other, side):
                        found.append((name, low, side))
        return found

    def _goes_on(self, name: str, other: str, side: Side) -> bool:
        """Whether every way onto `name` comes from a lane that has the same neighbour, who leads on to `other`."""
        before = self.ground.entering.get(name, [])
        return bool(before) and all(
            (beside := self.ground.beside(link, side)) is not None
            and other in self.ground.onward[beside]
            and (spans := self.ground.common(link, beside)) != []
            and spans[-1][1] == 1.0
            for link in before
        )

    def _add_changes(self, name: str, share: float, side: Side) -> None:
        """All changes to one side, one after the other, that can begin here."""
        waiting = [(name, share, MOST_LANES)]
        while waiting:
            here, at, left = waiting.pop()
            begin = self._row(here, at)
            for landing in self.ground.landings(here, at, side):
                end = self._row(landing.name, landing.share)
                if (begin, end) not in self._changes and left:
                    self._changes[begin, end] = landing
                    self._put(begin, end, self.change_cost(landing, at))
                    waiting.append((landing.name, landing.share, left - 1))

    def change_cost(self, landing: Landing, share: float) -> float:
        """Of a change that begins at a share of its first link: the way along the lanes that are left, and the change itself."""
        way, last = 0.0, len(landing.lanes) - 1
        for k, (name, _) in enumerate(landing.lanes):
            way += self.prices[name] * ((landing.share if k == last else 1.0) - (share if k == 0 else 0.0))
        return way + self.change

    def _add_drives(self) -> None:
        ground = self.ground
        for name, spans in ground.spans.items():
            for low, high in spans:
                on = [item for item in self._on[name] if low <= item[0] <= high]
                for (a, begin), (b, end) in itertools.pairwise(on):
                    self._put(begin, end, self.prices[name] * (b - a))
        for name, others in ground.onward.items():
            for other in others:
                self._put(self._rows[name, 1.0], self._rows[other, 0.0], FREE)

    def way(self, begins: list[tuple[str, float]], goals: list[tuple[str, float]], without: frozenset[tuple[str, str]] = frozenset()) -> Way | None:
        """The cheapest way from one of `begins` to one of `goals` (link, share), not going from lane to lane as in `without`; None: there is none.

        Raises:
            RoadError: a cost that falls without end on a way round.
        """
        query = _Query(self)
        for name, share in begins:
            query.begin_at(name, share)
        for name, share in goals:
            query.end_at(name, share)
        return query.answer(without)

    def next_on(self, name: str, share: float) -> tuple[float, int] | None:
        """The first place from `share` on in the same span of a link."""
        high = next((b for a, b in self.ground.spans[name] if a - SAME <= share <= b + SAME), None)
        on = self._on.get(name, [])
        k = bisect_left(on, (share - SAME, -1))
        return on[k] if high is not None and k < len(on) and on[k][0] <= high + SAME else None

    def last_on(self, name: str, share: float) -> tuple[float, int] | None:
        """The last place up to `share` in the same span of a link."""
        low = next((a for a, b in self.ground.spans[name] if a - SAME <= share <= b + SAME), None)
        on = self._on.get(name, [])
        k = bisect_right(on, (share + SAME, len(self.places))) - 1
        return on[k] if low is not None and k >= 0 and on[k][0] >= low - SAME else None


class _Query:
    """The lattice with the places that one way begins and ends at."""

    def __init__(self, lattice: Lattice) -> None:
        self.lattice = lattice
        self.places = list(lattice.places)
        # the two places that all begin from and end at
        self.source, self.sink = self._add("", 0.0), self._add("", 1.0)
        self.edges: dict[tuple[int, int], float] = {}
        self.changes: dict[tuple[int, int], Landing] = {}
        self.mine: list[int] = []

    def _add(self, name: str, share: float) -> int:
        self.places.append((name, share))
        return len(self.places) - 1

    def begin_at(self, name: str, share: float) -> None:
        lattice = self.lattice
        first = self._start(name, share)
        if first is None:
            return
        self.edges[self.source, first] = FREE
        for side in ("left", "right"):
            waiting = [(name, share, first, MOST_LANES)]
            while waiting:
                here, at, begin, left = waiting.pop()
                for landing in lattice.ground.landings(here, at, side) if left else ():
                    end = self._start(landing.name, landing.share)
                    if end is not None:
                        self.edges[begin, end] = lattice.change_cost(landing, at)
                        self.changes[begin, end] = landing
                        waiting.append((landing.name, landing.share, end, left - 1))

    def _start(self, name: str, share: float) -> int | None:
        """A place of this query, led on to the lattice."""
        following = self.lattice.next_on(name, share)
        if following is None:
            return None
        row = self._add(name, share)
        self.mine.append(row)
        self.edges[row, following[1]] = self.lattice.prices[name] * (following[0] - share) or FREE
        return row

    def end_at(self, name: str, share: float) -> None:
        lattice = self.lattice
        before = lattice.last_on(name, share)
        if before is None:
            return
        goal = self._add(name, share)
        self.edges[goal, self.sink] = FREE
        self.edges[before[1], goal] = lattice.prices[name] * (share - before[0]) or FREE
        for row in self.mine:
            link, at = self.places[row]
            if link == name and at < share - SAME and _same_span(lattice, name, at, share):
                self.edges[row, goal] = lattice.prices[name] * (share - at) or FREE

    def answer(self, without: frozenset[tuple[str, str]]) -> Way | None:
        lattice = self.lattice
        own = np.array(list(self.edges), dtype=np.intp).reshape(-1, 2)
        begins, ends = np.append(lattice._begins, own[:, 0]), np.append(lattice._ends, own[:, 1])
        weights = np.append(lattice._weights, list(self.edges.values()))
        if without:
            good = np.array([not self._uses(begin, end, without) for begin, end in zip(begins.tolist(), ends.tolist(), strict=True)])
            begins, ends, weights = begins[good], ends[good], weights[good]
        found = shortest(len(self.places), begins, ends, weights, self.source, lattice.ground.network.path)
        distance, before = found
        if not np.isfinite(distance[self.sink]):
            return None
        rows = [self.sink]
        while rows[-1] != self.source:
            rows.append(int(before[rows[-1]]))
        rows = rows[-2:0:-1]
        changes = [None, *(self.changes.get(pair) or lattice._changes.get(pair) for pair in itertools.pairwise(rows))]
        return Way(float(distance[self.sink]), [self.places[row] for row in rows], changes)

    def _uses(self, begin: int, end: int, without: frozenset[tuple[str, str]]) -> bool:
        landing = self.changes.get((begin, end)) or self.lattice._changes.get((begin, end))
        if landing is None:
            return (self.places[begin][0], self.places[end][0]) in without
        # a change goes from lane to lane on both of its lanes
        passed = [(a, b) for first, after in zip(landing.lanes, landing.lanes[1:], strict=False) for a, b in zip(first, after, strict=True)]
        return any(pair in without for pair in (*passed, *landing.lanes))


def _same_span(lattice: Lattice, name: str, first: float, last: float) -> bool:
    return any(low - SAME <= first and last <= high + SAME for low, high in lattice.ground.spans[name])
