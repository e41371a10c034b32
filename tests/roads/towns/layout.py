"""A whole town: crossings on a grid, roundabouts, dead ends, and a motorway with ramps north of it."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from .crossings import Pairs, cross
from .curves import Element, Pose, joined
from .dirt import lies, slips, step
from .records import End, Gate, Town
from .streets import KINDS, Wish, drawn, street, wished

#: Distance of crossings, m.
BLOCK = 120.0


def town(rng: np.random.Generator, columns: int = 3, rows: int = 2, *, dirt: float = 0.04, ramps: bool = False, left_hand: bool = False) -> Town:
    """A town of so many crossings; `dirt` is the share of roads with links that lie (0: all is as it should be, sections of no length apart)."""
    made = _Made(rng, Town("town", left_hand=left_hand), dirt)
    places = {(i, j): BLOCK * np.array([i, j]) + rng.uniform(-7.0, 7.0, 2) for i in range(columns) for j in range(rows)}
    arms: dict[tuple[int, int], list[tuple[float, tuple[int, int] | None]]] = {key: [] for key in places}
    for (i, j), place in places.items():
        for other in ((i + 1, j), (i, j + 1)):
            if other in places:
                heading = float(np.arctan2(*(places[other] - place)[::-1]))
                arms[i, j].append((heading + rng.uniform(-0.1, 0.1), other))
                arms[other].append((heading + np.pi + rng.uniform(-0.1, 0.1), (i, j)))
        for outside, heading in ((i == 0, np.pi), (i == columns - 1, 0.0), (j == 0, -0.5 * np.pi)):
            if outside and rng.random() < 0.5:
                arms[i, j].append((heading + rng.uniform(-0.1, 0.1), None))
    exits = {(0, rows - 1), (columns - 1, rows - 1)} if ramps else set()
    for key in exits:
        arms[key].append((0.5 * np.pi, key))
    nodes = {key: _Node(made, places[key], arms[key], float(rng.uniform(0.0, 6.0))) for key in places}
    for key, node in nodes.items():
        open_arms = [k for k, (_, other) in enumerate(node.arms) if other is None]
        looped = len(open_arms) == 2 and not node.is_round and rng.random() < 0.6 and made.loop(node, *open_arms)
        for k, (_, other) in enumerate(node.arms):
            if looped and k in open_arms:
                continue
            if other is None:
                made.dead_end(node, k)
            elif other > key:
                made.between(node, k, nodes[other], [name for _, name in nodes[other].arms].index(key))
    if ramps:
        made.motorway(nodes[min(exits)], nodes[max(exits)])
    for node in nodes.values():
        node.close()
    made.finish()
    return made.town


class _Node:
    """A crossing or a roundabout; `ends` are the roads at its arms once they are there."""

    def __init__(self, made: _Made, place: np.ndarray, arms: list, height: float) -> None:
        self.made, self.place, self.height = made, place, height
        self.arms = sorted(arms, key=lambda arm: arm[0] % (2.0 * np.pi))
        angles = np.array([angle % (2.0 * np.pi) for angle, _ in self.arms])
        apart = np.diff(np.append(angles, angles[0] + 2.0 * np.pi)) if len(angles) else np.zeros(0)
        self.is_round = bool(len(angles) > 2 and np.min(apart) > 1.3 and made.rng.random() < 0.35)
        self.lanes = int(made.rng.integers(1, 3)) if self.is_round else 0
        self.radius = float(made.rng.uniform(14.0, 19.0))
        straight = len(angles) == 2 and abs(apart[0] - np.pi) < 0.3
        self.reach = self.radius + 3.5 * self.lanes + 17.0 if self.is_round else 3.0 if straight else float(made.rng.uniform(20.0, 27.0))
        self.ends: dict[int, tuple[str, str]] = {}

    def pose(self, k: int) -> Pose:
        """Of arm `k`, away from the middle."""
        return Pose(float(self.place[0]), float(self.place[1]), float(self.arms[k][0])).moved(self.reach)

    def close(self) -> None:
        """Make the junctions, when all streets are there."""
        town, rng = self.made.town, self.made.rng
        if not self.is_round:
            cross(town, [self.ends[k] for k in sorted(self.ends)], rng)
            return
        ring, half = [], 0.55
        for k, (angle, _) in enumerate(self.arms):
            after = self.arms[(k + 1) % len(self.arms)][0]
            turn = (after - angle) % (2.0 * np.pi) - 2.0 * half
            start = Pose(float(self.place[0]), float(self.place[1]), float(angle + half)).moved(self.radius).turned(0.5 * np.pi)
            arc = Element(start, float(turn * self.radius), "arc", (1.0 / self.radius,))
            ring.append(self.made.add([arc], Wish(self.lanes, 0), (self.height, self.height)))
        for k in range(len(self.arms)):
            cross(town, [(ring[k - 1], "end"), (ring[k], "start"), self.ends[k]], rng)


class _Made:
    def __init__(self, rng: np.random.Generator, made: Town, dirt: float) -> None:
        self.rng, self.town, self.dirt = rng, made, dirt

    def add(self, elements: list[Element], wish: Wish, heights: tuple[float, float] = (0.0, 0.0)) -> str:
        identity = f"{len(self.town.roads)}"
        road = street(identity, elements, wish, self.rng, heights)
        self.town.roads[identity] = road
        if self.rng.random() < 0.2:
            step(road, self.rng)
        if self.rng.random() < 0.4:
            slips(road, self.rng, ends=True)
        return identity

    def between(self, node: _Node, k: int, other: _Node, j: int) -> None:
        """A street from one crossing to another, in one piece or two."""
        wish = wished(self.rng, one_way=self.rng.random() < 0.15)
        if self.rng.random() < 0.5:
            node, k, other, j = other, j, node, k
        elements = drawn(node.pose(k), other.pose(j).turned(), self.rng)
        assert elements is not None
        cut = len(elements) // 2
        if cut == 0 or self.rng.random() < 0.6 or wish.inner == ("bidirectional",):
            road = self.add(elements, wish, (node.height, other.height))
            node.ends[k], other.ends[j] = (road, "start"), (road, "end")
            return
        middle = elements[cut].start
        height = 0.5 * (node.height + other.height)
        if self.rng.random() < 0.4 and self._seam(node, k, other, j, middle, wish):
            return
        one = self.add(elements[:cut], replace(wish, opens=("", wish.opens[1]), ends=(wish.ends[0], False)), (node.height, height))
        node.ends[k] = (one, "start")
        if self.rng.random() < 0.5 and not wish.inner and (back := drawn(other.pose(j), middle.turned(), self.rng)) is not None:
            far = replace(wish, right=wish.left, left=wish.right, opens=("", wish.opens[0]), ends=(wish.ends[1], False))
            two = self.add(back, far, (other.height, height))
            other.ends[j] = (two, "start")
            self._follow(one, two, "end")
        else:
            two = self.add(elements[cut:], replace(wish, opens=(wish.opens[0], ""), ends=(False, wish.ends[1])), (height, other.height))
            other.ends[j] = (two, "end")
            self._follow(one, two, "start")

    def _seam(self, node: _Node, k: int, other: _Node, j: int, middle: Pose, wish: Wish) -> bool:
        """The street in two with a junction of a few metres between them, as towns drawn tile by tile have them."""
        gap = float(self.rng.uniform(1.5, 4.0))
        first = joined(node.pose(k), middle.moved(-gap), str(self.rng.choice(KINDS)))
        last = joined(middle.moved(gap), other.pose(j).turned(), str(self.rng.choice(KINDS)))
        if first is None or last is None:
            return False
        height = 0.5 * (node.height + other.height)
        one = self.add(first, wish, (node.height, height))
        two = self.add(last, wish, (height, other.height))
        node.ends[k], other.ends[j] = (one, "start"), (two, "end")
        cross(self.town, [(one, "end"), (two, "start")], self.rng)
        return True

    def _follow(self, one: str, two: str, contact: str) -> None:
        """Road `one` ends where the other road has its `contact`; lanes of one key are linked."""
        first, second = self.town.roads[one], self.town.roads[two]
        first.after = End("road", two, contact)
        turned = -1 if contact == "end" else 1
        here, there = first.sections[-1], second.end_section(contact)[0]
        if contact == "end":
            second.after = End("road", one, "end")
        else:
            second.before = End("road", one, "end")
        for sign, mine in ((1, here.left), (-1, here.right)):
            theirs = there.left if sign * turned > 0 else there.right
            number = {lane.key: sign * turned * (k + 1) for k, lane in enumerate(theirs)}
            for k, lane in enumerate(mine):
                lane.after = [number[lane.key]] if lane.key in number else []
                for other in theirs:
                    if other.key == lane.key:
                        setattr(other, "after" if contact == "end" else "before", [sign * (k + 1)])

    def dead_end(self, node: _Node, k: int) -> None:
        start = node.pose(k)
        elements = drawn(start, start.moved(float(self.rng.uniform(45.0, 70.0)), float(self.rng.uniform(-8.0, 8.0))), self.rng)
        assert elements is not None
        node.ends[k] = (self.add(elements, wished(self.rng), (node.height, node.height)), "start")

    def loop(self, node: _Node, k: int, j: int) -> bool:
        """A street out of one arm of a crossing and back into another one of the same; False where it would be too tight."""
        ways = [node.pose(k), node.pose(k).moved(45.0), node.pose(j).moved(45.0).turned(), node.pose(j).turned()]
        between = 0.5 * (node.arms[k][0] + node.arms[j][0]) % (2.0 * np.pi)
        if abs(np.cos(between - node.arms[k][0])) < 0.5 or np.cos(between - node.arms[k][0]) < 0.0:
            return False
        far = Pose(float(node.place[0]), float(node.place[1]), float(between)).moved(110.0)
        # clockwise or not, as the second arm lies
        side = np.sign(np.sin(node.arms[j][0] - node.arms[k][0]))
        ways.insert(2, far.turned(0.5 * np.pi * side))
        parts = [joined(a, b, str(self.rng.choice(KINDS))) for a, b in itertools.pairwise(ways)]
        if None in parts:
            return False
        wish = replace(wished(self.rng), inner=())
        road = self.add([element for part in parts for element in part or []], wish, (node.height, node.height))
        node.ends[k], node.ends[j] = (road, "start"), (road, "end")
        return True

    def motorway(self, leave: _Node, join: _Node) -> None:
        """East along the north of the town: an exit to one crossing, an entry from another."""
        y = max(leave.place[1], join.place[1]) + 130.0
        exit_x, entry_x = float(leave.place[0] - 75.0), float(join.place[0] + 75.0)
        lanes = Wish(2, 0)

        def along(a: float, b: float, wish: Wish) -> str:
            return self.add([Element(Pose(a, float(y), 0.0), b - a, "line")], wish)

        first = along(exit_x - 160.0, exit_x, replace(lanes, opens=("outer", ""), kind="exit"))
        second = along(exit_x + 20.0, entry_x, lanes)
        third = along(entry_x + 20.0, entry_x + 190.0, replace(lanes, ends=(True, False), kind="entry"))
        down = Pose(exit_x + 24.0, float(y) - 12.0, -0.4)
        up = Pose(entry_x - 4.0, float(y) - 12.0, 0.4)
        (k,), (j,) = ([k for k, (angle, _) in enumerate(node.arms) if angle == 0.5 * np.pi] for node in (leave, join))
        ramps = [drawn(down, leave.pose(k).turned(), self.rng), drawn(join.pose(j), up, self.rng)]
        assert ramps[0] is not None
        assert ramps[1] is not None
        off, on = self.add(ramps[0], Wish(1, 0), (0.0, leave.height)), self.add(ramps[1], Wish(1, 0), (join.height, 0.0))
        leave.ends[k], join.ends[j] = (off, "end"), (on, "start")

        def ways(ways_in: list[Gate], ways_out: list[Gate]) -> Pairs:
            if off == ways_out[0].road or on == ways_in[0].road:
                return [(ways_in[-1], ways_out[-1])]
            return list(zip(ways_in, ways_out, strict=False))

        cross(self.town, [(first, "end"), (second, "start"), (off, "start")], self.rng, ways)
        cross(self.town, [(second, "end"), (third, "start"), (on, "end")], self.rng, ways)

    def finish(self) -> None:
        for road in self.town.roads.values():
            if road.junction != "-1" and self.rng.random() < 0.3:
                slips(road, self.rng, ends=False)
        if self.dirt:
            lies(self.town, self.rng, self.dirt)
