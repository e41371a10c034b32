"""The carriageway of an OpenDRIVE road: its stations, the lanes that are linked from section to section, the edges around them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...borders import narrowed_at
from ...errors import RoadError
from ...lane import Lane
from .records import DRIVABLE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .geometry import RoadShape, SectionShape
    from .records import LaneRecord

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

#: Where the cross-section changes at once, edges and lanes do so within this stretch, on the wider side, m.
AT_ONCE = 0.01


class Stations(NamedTuple):
    """Where a road is described; at a section's start there is one station more, just inside it.

    Attributes:
        s: (n,) stations, m.
        rows: (n,) row of the shape that holds there.
        sections: (n,) index of the section that holds there.
    """

    s: Floats
    rows: Ints
    sections: Ints


def stations_of(shape: RoadShape) -> Stations:
    """The stations of the road from its start to its end."""
    s, rows, sections = [], [], []
    for index, section in enumerate(shape.sections):
        inner = np.arange(section.first, section.last + (index == len(shape.sections) - 1))
        at = shape.s[inner]
        if index and len(inner) > 1 and at[1] - at[0] > 2.0 * AT_ONCE:
            inner, at = np.insert(inner, 1, inner[0]), np.insert(at, 1, at[0] + AT_ONCE)
        s.append(at)
        rows.append(inner)
        sections.append(np.full(len(inner), index))
        if index + 1 < len(shape.sections) and at[-1] < shape.s[section.last] - 2.0 * AT_ONCE:
            s.append(np.array([shape.s[section.last] - AT_ONCE]))
            rows.append(np.array([section.last]))
            sections.append(np.array([index]))
    return Stations(np.concatenate(s), np.concatenate(rows), np.concatenate(sections))


def linked_lanes(shape: RoadShape, stations: Stations, along: int) -> tuple[list[Lane], tuple[Floats, Floats]]:
    """Lanes that are linked from section to section, and the edges of the carriageway that holds those that lead `along`."""
    _, rows, sections = stations
    count = len(rows)
    chains: list[tuple[LaneRecord, Floats, Floats]] = []
    open_chains: dict[int, int] = {}
    right_edge, left_edge = np.full(count, np.inf), np.full(count, -np.inf)
    for index, section in enumerate(shape.sections):
        here = np.flatnonzero(sections == index)
        began: dict[int, int] = {}
        borders = borders_at(shape, section, rows[here])
        group = _carriageway(section, along)
        for at in group:
            lane = section.lanes[at]
            chain = next(
                (open_chains[number] for number in lane.predecessors if number in open_chains and _same(chains[open_chains[number]][0], lane)), None
            )
            if chain is None or chain in began.values():
                chain = len(chains)
                chains.append((lane, np.full(count, np.nan), np.full(count, np.nan)))
            began[lane.id] = chain
            chains[chain][1][here], chains[chain][2][here] = borders[at], borders[at + 1]
        open_chains = began
        if group:
            right_edge[here], left_edge[here] = borders[group[0]], borders[group[-1] + 1]
    if np.isinf(right_edge).any():
        at = int(np.argmax(np.isinf(right_edge)))
        raise RoadError(f"no drivable lane that leads on at s = {shape.s[rows[at]]:.1f} m, expected one from start to end")
    edges = narrowed_at(right_edge, left_edge, np.flatnonzero(np.diff(sections)) + 1)
    right_edge, left_edge = edges
    lanes = [
        Lane(lane.direction, np.clip(right, right_edge, left_edge), np.clip(left, right_edge, left_edge), lane.kind, str(lane.id))
        for lane, right, left in chains
    ]
    return sorted(lanes, key=lambda lane: float(np.nanmean(lane.right + lane.left))), edges


def borders_at(shape: RoadShape, section: SectionShape, rows: Ints) -> Floats:
    """(lanes + 1, k) borders of a section's lanes at some of its rows, m to the left in the plane: banked lanes are narrower seen from above."""
    return section.borders[:, rows - section.first] * np.cos(shape.bank[rows])


def _same(before: LaneRecord, lane: LaneRecord) -> bool:
    """Whether a lane goes on as the other: a link across the centre line or against the traffic joins two lanes, it continues neither."""
    return before.direction == lane.direction and before.id * lane.id > 0


def _carriageway(section: SectionShape, along: int) -> list[int]:
    """Indices of the drivable lanes that lie side by side with the outermost one that leads `along`, in one piece."""
    lanes = section.lanes
    drivable = [lane.kind in DRIVABLE or (lane.width is not None and not lane.width.starts) for lane in lanes]
    wanted = [k for k, lane in enumerate(lanes) if drivable[k] and lane.direction in (0, along)]
    if not wanted:
        return []
    # prefer a lane for through traffic to a ramp beside a barrier
    first = next((k for k in wanted if lanes[k].kind == "driving"), wanted[0])
    low = high = first
    while low > 0 and drivable[low - 1]:
        low -= 1
    while high + 1 < len(lanes) and drivable[high + 1]:
        high += 1
    return list(range(low, high + 1))
