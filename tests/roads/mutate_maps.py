"""Valid maps mutated as trees, not as bytes: sections, lanes, links, junctions and points are moved, repeated, dropped and repointed."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from xml.etree import ElementTree as ET

import numpy as np

from .wounds import lanes, opendrive

Wound = Callable[[ET.Element, np.random.Generator], None]

#: By the root element of a format.
WOUNDS: dict[str, list[Wound]] = {
    "OpenDRIVE": [
        *(opendrive.sections, opendrive.section_stations, opendrive.split_section, opendrive.split_section, opendrive.lane_numbers),
        *(opendrive.lanes_come_and_go, opendrive.lane_kinds, opendrive.widths, opendrive.width_records, opendrive.lane_offsets),
        *(opendrive.lane_links, opendrive.road_links, opendrive.connections, opendrive.whole_roads, opendrive.geometries),
        *(opendrive.shapes, opendrive.heights, opendrive.banks, opendrive.speeds, opendrive.frictions),
    ],
    "commonRoad": [lanes.points, lanes.points, lanes.turned_ends, lanes.references, lanes.whole_lanelets],
    "osm": [lanes.osm_nodes, lanes.osm_ways, lanes.osm_relations],
    "net": [lanes.sumo_lanes, lanes.sumo_links],
}


def mutants(seed: bytes, count: int, rng: np.random.Generator) -> Iterator[tuple[str, bytes]]:
    """Yield `count` mutants of the map `seed`, one to four wounds each, with the wounds' names."""
    original = ET.fromstring(seed)
    wounds = WOUNDS[original.tag]
    for _ in range(count):
        root, names = copy.deepcopy(original), []
        for _ in range(int(rng.integers(1, 5))):
            wound = wounds[int(rng.integers(len(wounds)))]
            names.append(wound.__name__)
            wound(root, rng)
        yield "+".join(names), ET.tostring(root)
