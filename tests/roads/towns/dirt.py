"""What towns from outside suffer from: sections of micrometres, steps, links that are missing or lie."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .records import Lane, Section, Street, Town

#: Lengths of sections that nobody meant, m.
SLIPS = (0.0, 1e-7, 1e-4, 0.003, 0.02, 0.3)


def slip(road: Street, at: float, size: float, *, renumbered: bool = False) -> None:
    """A section of `size` m at station `at`; where `renumbered`, a lane of no width within it moves the numbers of all others."""
    index = max(k for k, section in enumerate(road.sections) if section.s <= at)
    section = road.sections[index]
    tiny = section.starting(at)
    if renumbered:
        for side in tiny.sides():
            if side:
                side.insert(0, Lane("ghost", "none", [(0.0, 0.0, 0.0, 0.0, 0.0)]))
    new = [tiny]
    if at > section.s:
        new.insert(0, section)
    if at + size < road.length - 1e-9:
        new.append(section.starting(at + size))
    road.sections[index : index + 1] = new
    road.link_sections()


def slips(road: Street, rng: np.random.Generator, *, ends: bool) -> None:
    """One or two such sections; with `ends` also first or last in the road, where their numbers are those that the junction names."""
    for _ in range(int(rng.integers(1, 3))):
        size = float(rng.choice(SLIPS))
        starts = [section.s for section in road.sections] + [road.length]
        k = int(np.argmax(np.diff(starts)))
        at = starts[k] + float(rng.uniform(0.2, 0.8)) * (starts[k + 1] - starts[k])
        kind = rng.random()
        # the piece between must be long enough to be one
        if starts[k + 1] - starts[k] < 4.0:
            continue
        if kind < 0.2:
            at = 0.0
        elif kind < 0.4:
            at = road.length - size
        if at in (0.0, road.length - size) and any(abs(section.s - at) < 1.0 for section in road.sections[1:]):
            continue
        slip(road, at, size, renumbered=(ends or 0.0 < at < road.length - size) and rng.random() < 0.5)


def step(road: Street, rng: np.random.Generator) -> None:
    """The whole cross-section jumps aside by half a metre where a section begins, and stays there to within the road's end."""
    inner = [section.s for section in road.sections[1:] if 5.0 < section.s < road.length - 25.0]
    if inner:
        at, by = float(rng.choice(inner)), float(rng.uniform(-0.6, 0.6))
        back = road.length - at - 2.0
        road.offsets += [(0.0, 0.0, 0.0, 0.0, 0.0), (at, by, 0.0, -3.0 * by / back**2, 2.0 * by / back**3), (at + back, 0.0, 0.0, 0.0, 0.0)]


def lies(town: Town, rng: np.random.Generator, share: float) -> None:
    """Links that are missing or contradict the geometry, and lanes of no friction, each on that share of the roads."""
    for road in list(town.roads.values()):
        if rng.random() < share:
            _lane_lies(road, rng)
        if rng.random() < share and road.junction != "-1" and road.after is not None:
            road.after = replace(road.after, contact="start" if road.after.contact == "end" else "end")
        if rng.random() < share:
            lanes = [lane for section in road.sections for side in section.sides() for lane in side]
            lanes[int(rng.integers(len(lanes)))].more += '<material sOffset="0" friction="0"/>'
        if rng.random() < share and road.junction != "-1":
            _lone_taper(road)
    for junction in town.junctions:
        for connection in junction.connections:
            if rng.random() >= share:
                continue
            kind, k = int(rng.integers(3)), int(rng.integers(len(connection.lanes)))
            if kind == 0:
                del connection.lanes[k]
            elif kind == 1:
                connection.lanes[k] = (connection.lanes[k][0], -connection.lanes[k][1])
            else:
                connection.road = str(rng.choice(list(town.roads)))


def _lane_lies(road: Street, rng: np.random.Generator) -> None:
    sections: list[Section] = road.sections
    section = sections[int(rng.integers(len(sections)))]
    sides = [side for side in section.sides() if side]
    side = sides[int(rng.integers(len(sides)))]
    lane = side[int(rng.integers(len(side)))]
    kind = int(rng.integers(4))
    if kind == 0:
        lane.after, lane.before = [], []
    elif kind == 1:
        lane.after = [-number for number in lane.after]
    elif kind == 2:
        lane.after = [number + (2 if number > 0 else -2) for number in lane.after]
    else:
        lane.before = [9 if number > 0 else -9 for number in lane.before]


def _lone_taper(road: Street) -> None:
    """A connecting road of one lane that opens from nothing."""
    lanes = [lane for section in road.sections for side in section.sides() for lane in side]
    if len(road.sections) == 1 and len(lanes) == 1:
        width, over = lanes[0].width(0.0), 0.4 * road.length
        rest = lanes[0].starting(over)
        a = rest.widths[0][1]
        lanes[0].widths = [(0.0, 0.0, 0.0, 3.0 * a / over**2, -2.0 * a / over**3), (over, *rest.widths[0][1:])]
        assert width > 2.0
