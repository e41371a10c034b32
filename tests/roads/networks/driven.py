"""What is wrong with a route, judged by strips that were read independently."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

import roads
from roads import Road, RoadError

from .reachable import Judge
from .strips import Strip

#: A route begins and ends within this distance of its lanes' middles, m.
ENDS = 0.3
#: The strip to be driven lies within lanes but for this, m; where lanes miss each other at a joint, that is drawn out over as much way around it, m.
ASIDE, DRAWN_OUT = 0.3, 40.0
#: A route is no longer than a careful driver's way with what changes count, but for this factor and this length, m: cells are half a metre.
LONGER, CELLS = 1.01, 5.0
#: No reference turns more within a metre, rad; borders jagged by as many metres over one turn it by as much more.
TURN = 1.0 / 2.5


def named(network: roads.Network, strips: dict[str, Strip]) -> dict[str, str]:
    """The link's id of every strip that is worth driving; sections that count as nothing may or may not have numbers."""
    kept: dict[str, list[str]] = {}
    for name, strip in strips.items():
        if name.count("/") == 2 and strip.way[-1] >= 1e-6:
            row = kept.setdefault(strip.road, [])
            if (section := name.split("/")[1]) not in row:
                row.append(section)
    found: dict[str, str] = {}
    for name, link in network.links.items():
        parts = name.split("/")
        order = kept.get(link.road, []) if len(parts) == 3 else []
        other = f"{parts[0]}/{order[int(parts[1])]}/{parts[2]}" if len(parts) == 3 and int(parts[1]) < len(order) else name
        for candidate in (name, other):
            strip = strips.get(candidate)
            if strip is not None and not strip.tiny and np.max(np.abs(link.centre[[0, -1], :2] - strip.centre[[0, -1]])) < 0.05:
                found[candidate] = name
                break
    return found


class Town(NamedTuple):
    """A file as the package reads it and as it is read here."""

    network: roads.Network
    strips: dict[str, Strip]
    judge: Judge
    names: dict[str, str]
    ground: Ground


def opened(path: Path, strips: dict[str, Strip], rough: float = 0.0) -> Town:
    """Read a file; borders in it are jagged by `rough` m."""
    network, judge = roads.read_network(path), Judge(strips)
    return Town(network, strips, judge, named(network, strips), Ground(strips, judge, rough))


def fault_of(town: Town, start: str, goal: str) -> str | None:
    """What is wrong with the route from the beginning of strip `start` to the end of strip `goal`; None where all is well (or both is right)."""
    verdict = town.judge(start, goal)
    try:
        road = town.network.route(town.names[start], town.names[goal])
    except RoadError as error:
        return f"not routed: {error}".replace(f"{town.network.path}: ", "") if verdict else None
    if verdict is False:
        return "routed, but not connected"
    if verdict and road.length > LONGER * town.judge.careful.cost(start, goal) + CELLS:
        return f"is {road.length:.0f} m long, {town.judge.careful.cost(start, goal):.0f} m with changes would do"
    return town.ground.fault(road, town.strips[start], town.strips[goal])


def _spread(slack: dict[str, float], strip: Strip, following: dict[str, list[Strip]], gap: float, left: float = DRAWN_OUT) -> None:
    """Lanes within `left` m of a joint where lanes miss each other by `gap` m may be left by as much."""
    slack[strip.name] = max(slack[strip.name], gap)
    if strip.way[-1] < left:
        for other in following[strip.name]:
            _spread(slack, other, following, gap, left - max(float(strip.way[-1]), 0.05))


class Ground:
    """Where one may drive, cell by cell."""

    def __init__(self, strips: dict[str, Strip], judge: Judge, rough: float) -> None:
        self.aside, self.turn = ASIDE + rough, TURN + rough
        self.strips = [strip for strip in strips.values() if not strip.tiny]
        slack = dict.fromkeys((strip.name for strip in self.strips), 0.0)
        after = judge.bold.onward
        before: dict[str, list[Strip]] = {name: [] for name in after}
        for name, onward in after.items():
            for other in onward:
                before[other.name].append(strips[name])
        for name, onward in after.items():
            for other in onward:
                # where a lane begins from no width, its width is drawn out too
                gap = 1.2 * float(np.hypot(*(other.centre[0] - strips[name].centre[-1])))
                if gap > 0.01:
                    _spread(slack, other, after, gap)
                    _spread(slack, strips[name], before, gap)
        # who changes lanes takes it along
        shared = {}
        for name, strip in strips.items():
            sides = [side for side in (strip.on_left, strip.on_right) if side in slack]
            shared[name] = max([slack.get(name, 0.0), *(slack[side] for side in sides)])
        slack = shared
        self.slack = np.concatenate([np.full(len(strip.left) - 1, slack[strip.name]) for strip in self.strips])

    @cached_property
    def cells(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Beginnings and ends of the middles (n, 2), widths there."""
        begin, end = (np.concatenate([strip.centre[part] for strip in self.strips]) for part in (slice(None, -1), slice(1, None)))
        widths = [np.concatenate([strip.width[part] for strip in self.strips]) for part in (slice(None, -1), slice(1, None))]
        return begin, end, *widths

    @cached_property
    def tree(self):
        from scipy.spatial import cKDTree

        return cKDTree(0.5 * (self.cells[0] + self.cells[1]))

    def holds(self, places: np.ndarray, heading: np.ndarray) -> np.ndarray:
        """Whether each place (n, 2) lies in a lane that leads about that way."""
        begin, end, first, last = self.cells
        _, near = self.tree.query(places, k=min(40, len(begin)))
        move = end[near] - begin[near]
        long = np.maximum(np.hypot(move[..., 0], move[..., 1]), 1e-9)
        unit = move / long[..., None]
        off = places[:, None] - begin[near]
        along = np.sum(off * unit, axis=-1)
        aside = np.abs(unit[..., 0] * off[..., 1] - unit[..., 1] * off[..., 0])
        share = np.clip(along / long, 0.0, 1.0)
        room = 0.5 * ((1.0 - share) * first[near] + share * last[near]) + self.aside + self.slack[near]
        same = unit[..., 0] * np.cos(heading)[:, None] + unit[..., 1] * np.sin(heading)[:, None] > np.cos(1.0)
        return np.any((along > -self.aside) & (along < long + self.aside) & (aside < room) & same, axis=1)

    def fault(self, road: Road, start: Strip, goal: Strip) -> str | None:
        ends = road.reference.position(np.array([0.0, road.length]))
        off = np.hypot(*(ends - np.array([start.centre[0], goal.centre[-1]])).T)
        if np.max(off) > ENDS + self.aside - ASIDE:
            return f"begins {off[0]:.2f} m and ends {off[1]:.2f} m from where it should"
        if road.length < np.hypot(*(ends[1] - ends[0])) - 1e-6:
            return "shorter than the straight line"
        s = np.linspace(0.0, road.length, max(int(road.length / 0.1), 10) + 1)
        heading = np.unwrap(road.reference.heading(s))
        window = max(round(1.0 / (s[1] - s[0])), 1)
        turn = np.abs(heading[window:] - heading[:-window]) if len(s) > window else np.abs(np.diff(heading[[0, -1]]))
        if len(turn) and np.max(turn) > self.turn:
            at = int(np.argmax(turn))
            return f"turns {turn[at]:.2f} rad within a metre at s = {s[at]:.1f} of {road.length:.1f} m"
        lane = road.driving_lane()
        at = np.linspace(0.0, road.length, max(int(road.length), 2) + 1)
        right, left = (np.interp(at, road.s, side) for side in (lane.right, lane.left))
        inset = np.minimum(0.05, 0.4 * (left - right))
        place, normal, way = road.reference.position(at), road.reference.normal(at), road.reference.heading(at)
        for side, offset in (("right border", right + inset), ("left border", left - inset), ("reference", np.zeros(len(at)))):
            good = self.holds(place + offset[:, None] * normal, way)
            if not good.all():
                k = int(np.argmin(good))
                x, y = place[k] + offset[k] * normal[k]
                return f"{side} outside of lanes that lead on at s = {at[k]:.1f} of {road.length:.1f} m, ({x:.1f}, {y:.1f}), {np.sum(~good)} places"
        return None
