"""Where a careful driver gets to: a plain search over cells of half a metre, against which routes are judged.

They drive along lanes at least 2 m wide, from the end of one onto a linked one that begins within 3 m and 0.7 rad, and change to a neighbour of the
same direction over 12 m where both are wide. A lane that narrows is left or entered beside; one without neighbours is driven as it is.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from .strips import CELL, Strip

#: A change of lane counts as much as this way, m; the router says the same of itself.
CHANGE = 20.0


@dataclass(frozen=True)
class Driver:
    """Limits; `bold` takes what the definition leaves open as allowed."""

    width: float
    gap: float
    turn: float
    change: float
    bold: bool


#: Just within the limits and just beyond them: what the one cannot and the other can is on the border.
CAREFUL = Driver(2.0 * 1.01, 3.0 - 0.2, 0.7 - 0.02, 12.0 * 1.01 + 0.2, bold=False)
BOLD = Driver(2.0 * 0.99, 3.0 + 0.2, 0.7 + 0.02, 12.0 * 0.99 - 0.2 - CELL, bold=True)


class Reach:
    """Which lanes' ends are reached from which lanes' beginnings by one driver."""

    def __init__(self, strips: dict[str, Strip], driver: Driver) -> None:
        self.strips, self.driver = strips, driver
        self.real = {name: strip for name, strip in strips.items() if not strip.tiny}
        counts = np.array([len(strip.left) for strip in self.real.values()])
        self.first = dict(zip(self.real, (np.cumsum(counts) - counts).tolist(), strict=True))
        self.total = int(counts.sum())
        self.wide = {name: strip.width >= driver.width for name, strip in self.real.items()}
        self.open = {name: self.wide[name] | self._alone(strip) for name, strip in self.real.items()}
        self.onward = {name: [other for other in self.following(strip) if self._meet(strip, other)] for name, strip in self.real.items()}
        self.seen: dict[str, np.ndarray] = {}

    def _alone(self, strip: Strip) -> np.ndarray:
        """Where (n,) a narrow lane has no neighbour; the bold do not count neighbours that are narrow themselves."""
        sides = [side for side in (strip.on_left, strip.on_right) if side is not None]
        if self.driver.bold:
            return ~np.any([self.wide[side] for side in sides], axis=0) if sides else np.ones(len(strip.left), dtype=bool)
        return np.full(len(strip.left), not sides)

    def following(self, strip: Strip) -> list[Strip]:
        """Strips that follow, across those that count as nothing."""
        found: dict[str, Strip] = {}
        todo, known = [strip], {strip.name}
        while todo:
            here = todo.pop()
            for name in here.ahead + (here.hinted if self.driver.bold else []):
                other = self.strips[name]
                if other.tiny and name not in known:
                    todo.append(other)
                elif not other.tiny:
                    found[name] = other
                known.add(name)
        return list(found.values())

    def _meet(self, one: Strip, other: Strip) -> bool:
        gap = np.hypot(*(other.centre[0] - one.centre[-1]))
        turn = abs((other.heading[0] - one.heading[1] + np.pi) % (2.0 * np.pi) - np.pi)
        return bool(gap <= self.driver.gap and turn <= self.driver.turn and self.open[one.name][-1] and self.open[other.name][0])

    @cached_property
    def graph(self) -> csr_array:
        """Ways of m from cell to cell; a change counts `CHANGE` m more."""
        edges: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
        for name, strip in self.real.items():
            is_open, first = self.open[name], self.first[name]
            along = np.flatnonzero(is_open[:-1] & is_open[1:])
            edges.append((first + along, first + along + 1, np.diff(strip.way)[along]))
            after = np.array([self.first[other.name] for other in self.onward[name]], dtype=np.intp)
            edges.append((np.full(len(after), first + len(is_open) - 1), after, np.zeros(len(after))))
            for side in ("on_left", "on_right"):
                edges += [self._changes(run) for run in self._runs(strip, side, 0.0)]
        a, b, way = (np.concatenate(column) for column in zip(*edges, strict=True))
        # csgraph takes a zero for no edge; of several changes that end in one cell the first counts
        order = np.unique(a.astype(np.int64) * self.total + b, return_index=True)[1]
        return csr_array((np.maximum(way[order], 1e-9), (a[order], b[order])), shape=(self.total, self.total))

    def _runs(self, strip: Strip, side: str, beyond: float) -> Iterator[list[tuple[Strip, Strip]]]:
        """Pairs of neighbours that lead on side by side, from `strip` on as far as a change may reach."""
        beside = getattr(strip, side)
        if beside is None:
            return
        pair = strip, self.strips[beside]
        far = beyond + min(one.way[-1] for one in pair)
        led_on = False
        if beyond == 0.0 or far < 3.0 * self.driver.change:
            for one in self.onward[strip.name]:
                after = getattr(one, side)
                if after in [other.name for other in self.onward[beside]] and (self.driver.bold or one.road == strip.road):
                    for rest in self._runs(one, side, max(far, 1e-9) if beyond else 1e-9):
                        led_on = True
                        yield [pair, *rest]
        if not led_on:
            yield [pair]

    def _changes(self, run: list[tuple[Strip, Strip]]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Nodes of the first pair's own lane from which one may change, nodes of the other lane where that ends, and what it counts, m."""
        ways, nodes, wide = [[], []], [[], []], []
        for pair in run:
            for k, strip in enumerate(pair):
                ways[k].append(strip.way + (ways[k][-1][-1] if ways[k] else 0.0))
                nodes[k].append(self.first[strip.name] + np.arange(len(strip.left)))
            wide.append(self.wide[pair[0].name] & self.wide[pair[1].name])
        one, other = (np.concatenate(way) for way in ways)
        bad = np.append(0, np.cumsum(~np.concatenate(wide)))
        here, there = (np.concatenate(node) for node in nodes)
        starts = np.arange(len(run[0][0].left))
        reach = [np.searchsorted(way, way[starts] + self.driver.change - 1e-9) for way in (one, other)]
        stop = np.minimum(*reach) if self.driver.bold else np.maximum(*reach)
        good = stop < len(one)
        good[good] = bad[stop[good] + 1] == bad[starts[good]]
        return here[starts[good]], there[stop[good]], np.full(np.count_nonzero(good), self.driver.change + CHANGE)

    def cost(self, start: str, goal: str) -> float:
        """Least way from the beginning of lane `start` to the end of lane `goal`, m, with what changes count; inf where there is none."""
        if start not in self.seen:
            self.seen[start] = dijkstra(self.graph, indices=self.first[start])
        if not (self.open[start][0] and self.open[goal][-1]):
            return float("inf")
        return float(self.seen[start][self.first[goal] + len(self.real[goal].left) - 1])

    def connects(self, start: str, goal: str) -> bool:
        """Whether from the beginning of lane `start` the end of lane `goal` is reached."""
        return self.cost(start, goal) < float("inf")


class Judge:
    """Says whether two lanes are connected: True, False, or None where that hangs on the limits (or on beginning or ending in a taper)."""

    def __init__(self, strips: dict[str, Strip]) -> None:
        self.strips = strips
        self.careful, self.bold = Reach(strips, CAREFUL), Reach(strips, BOLD)

    def __call__(self, start: str, goal: str) -> bool | None:
        if not (self.careful.open[start][0] and self.careful.open[goal][-1]):
            return None
        if self.careful.connects(start, goal):
            return True
        return None if self.bold.connects(start, goal) else False
