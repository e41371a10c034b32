"""Junctions: roads that connect the lanes at the ends of streets."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np

from .curves import Pose, joined, wrapped
from .records import Connection, End, Gate, Junction, Lane, Section, Street, Town, Width
from .streets import KINDS

#: Lanes that a junction leads from and to.
FOR_CARS = ("driving", "entry", "exit", "onRamp", "offRamp")
Pairs = list[tuple[Gate, Gate]]


def gates(road: Street, contact: str) -> tuple[list[Gate], list[Gate]]:
    """Lanes that lead out of the road at that end, and into it, from the middle outwards."""
    section, at = road.end_section(contact)
    ref = pose_at(road, contact)
    made: list[list[Gate]] = []
    for side, lanes in ((-1, section.right), (1, section.left)):
        rows, aside = [], road.offset(section.s + at)
        leads_out = (side < 0) == (contact == "end")
        for k, lane in enumerate(lanes):
            pose = ref.moved(0.0, aside)
            pose = pose if side < 0 else pose.turned()
            width = lane.width(at)
            aside += side * width
            if lane.kind in FOR_CARS and width > 2.5:
                rows.append(Gate(road.id, contact, side * (k + 1), pose, width, road.heights[contact == "end"]))
        made.append(rows)
        if leads_out:
            out = len(made) - 1
    return made[out], made[1 - out]


def pose_at(road: Street, contact: str) -> Pose:
    """Where the reference line begins or ends, in its direction."""
    if contact == "start":
        return road.elements[0].start
    last = road.elements[-1]
    return end_of(last)


def end_of(element) -> Pose:
    from scipy.integrate import quad

    kind, numbers, length = element.kind, element.numbers, element.length
    if kind in ("line", "arc", "spiral"):
        first, last = (0.0, 0.0) if kind == "line" else (numbers[0], numbers[-1])

        def turn(s: float) -> float:
            return first * s + 0.5 * (last - first) / length * s * s

        x, y = (quad(lambda s, f=f: f(turn(s)), 0.0, length, epsabs=1e-12, limit=200)[0] for f in (np.cos, np.sin))
        return element.start.moved(x, y).turned(turn(length))
    if kind == "poly3":
        _, _, c, d = numbers
        u = np.linspace(0.0, length, 20001)
        way = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(u), np.diff(c * u**2 + d * u**3)))])
        end = float(np.interp(length, way, u))
        return element.start.moved(end, c * end**2 + d * end**3).turned(float(np.arctan(2 * c * end + 3 * d * end**2)))
    p = length if numbers[8] else 1.0
    u, v = (row[0] + row[1] * p + row[2] * p**2 + row[3] * p**3 for row in (numbers[:4], numbers[4:8]))
    du, dv = (row[1] + 2 * row[2] * p + 3 * row[3] * p**2 for row in (numbers[:4], numbers[4:8]))
    return element.start.moved(u, v).turned(float(np.arctan2(dv, du)))


def usual(ways_in: list[Gate], ways_out: list[Gate]) -> Pairs:
    """Left from the inner lane, right from the outer one, straight on from the outer ones; no turning back."""
    turn = wrapped(ways_out[0].pose.hdg - ways_in[0].pose.hdg)
    if abs(turn) > 2.6:
        return []
    if turn > 0.6:
        both = len(ways_in) > 2 and len(ways_out) > 1
        return list(zip(ways_in[: 1 + both], ways_out[: 1 + both], strict=True))
    if turn < -0.6:
        return [(ways_in[-1], ways_out[-1])]
    through = ways_in[1:] if len(ways_in) > 2 else ways_in
    count = min(len(through), len(ways_out))
    return list(zip(through[-count:], ways_out[-count:], strict=True))


def cross(town: Town, ports: list[tuple[str, str]], rng: np.random.Generator, choose: Callable[[list[Gate], list[Gate]], Pairs] = usual) -> Junction:
    """A junction of the road ends `ports` (road, contact), with a connecting road for each way that `choose` gives."""
    junction = Junction(f"{100 + len(town.junctions)}")
    town.junctions.append(junction)
    sides = [gates(town.roads[road], contact) for road, contact in ports]
    for road, contact in ports:
        end = End("junction", junction.id)
        if contact == "start":
            town.roads[road].before = end
        else:
            town.roads[road].after = end
    for k, (ways_in, _) in enumerate(sides):
        for j, (_, ways_out) in enumerate(sides):
            if k == j or not ways_in or not ways_out:
                continue
            pairs = choose(ways_in, ways_out)
            if len(pairs) > 1 and rng.random() < 0.5 and _together(pairs):
                _connect(town, junction, pairs, rng)
            else:
                for pair in pairs:
                    _connect(town, junction, [pair], rng)
    return junction


def _together(pairs: Pairs) -> bool:
    """Lanes side by side that stay side by side."""
    numbers = [[gate.number for gate in side] for side in zip(*pairs, strict=True)]
    return all(abs(b - a) == 1 for row in numbers for a, b in itertools.pairwise(row))


def _connect(town: Town, junction: Junction, pairs: Pairs, rng: np.random.Generator) -> None:
    (first, last), backwards, centred = pairs[0], rng.random() < 0.3, len(pairs) == 1 and rng.random() < 0.3
    a, b = first.pose, last.pose
    if centred:
        a, b = a.moved(0.0, -0.5 * first.width), b.moved(0.0, -0.5 * last.width)
    if backwards:
        a, b = b.turned(), a.turned()
    elements = joined(a, b, str(rng.choice(KINDS)))
    if elements is None:
        return
    length = sum(element.length for element in elements)
    sign = 1 if backwards else -1
    lanes = []
    for k, (one, other) in enumerate(pairs):
        ends = (other, one) if backwards else (one, other)
        lanes.append(Lane(f"way {k}", "driving", [_eased(ends[0].width, ends[1].width, length)], [ends[0].number], [ends[1].number]))
    section = Section(0.0, lanes if backwards else [], [] if backwards else lanes)
    identity = f"{len(town.roads) + 1000}"
    ends = (last, first) if backwards else (first, last)
    road = Street(identity, elements, [section], junction.id, heights=(ends[0].height, ends[1].height))
    road.before, road.after = (End("road", end.road, end.contact) for end in ends)
    if centred:
        a0, b0 = -sign * 0.5 * ends[0].width, -sign * 0.5 * ends[1].width
        road.offsets = [_eased(a0, b0, length)]
    town.roads[identity] = road
    ways = [(pair[0].number, sign * (k + 1)) for k, pair in enumerate(pairs)]
    junction.connections.append(Connection(first.road, identity, "end" if backwards else "start", ways))


def _eased(a: float, b: float, length: float) -> Width:
    return (0.0, a, 0.0, 3.0 * (b - a) / length**2, -2.0 * (b - a) / length**3)
