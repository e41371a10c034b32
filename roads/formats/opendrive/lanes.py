"""Lanes of an OpenDRIVE road: widths, limits, links."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..xml import Place, children
from .records import DRIVABLE, NOTHING, Cubics, LaneRecord

if TYPE_CHECKING:
    from ...findings import Findings
    from ..xml import Node

UNITS = {"m/s": 1.0, "km/h": 1.0 / 3.6, "mph": 0.44704, "": 1.0}
#: Most lanes on one side of a section.
MOST_LANES = 100


def cubics_of(nodes: list[Node], place: Place, key: str, shift: float = 0.0) -> Cubics:
    """Records of one quantity; `key` names their station, which is counted from `shift`."""
    if not nodes:
        return NOTHING
    starts: list[float] = []
    rows: list[tuple[float, ...]] = []
    keys = (key, "a", "b", "c", "d")
    for node in nodes:
        start, *row = place.numbers(node, keys)
        start = 0.0 if abs(start) < 1e-6 else start
        if starts and start + shift < starts[-1]:
            raise place.error(node, f"{key} goes back by {starts[-1] - start - shift:g} m, expected increasing stations")
        if starts and start + shift == starts[-1]:
            # of several records at one station the last one counts
            starts.pop()
            rows.pop()
        starts.append(start + shift)
        rows.append(tuple(row))
    return Cubics(tuple(starts), tuple(rows))


def side_of(node: Node | None, place: Place, findings: Findings, start: float, sign: int, *, left_hand: bool) -> tuple[LaneRecord, ...]:
    """The lanes on one side (+1 left, -1 right) of a section that starts at `start`, from the middle outwards to the last drivable one.

    Raises:
        RoadError: lanes without sound ids or records.
    """
    if node is None:
        return ()
    nodes = children(node).get("lane", [])
    # lanes beyond the outermost drivable one move no border that matters: pavements, kerbs and verges are left unread
    last = max((k for k, lane in enumerate(_by_distance(nodes, sign)) if lane.get("type") in DRIVABLE), default=-1)
    lanes: dict[int, LaneRecord] = {}
    for lane in _by_distance(nodes, sign)[: last + 1]:
        record = _lane(lane, place, findings, start, sign, left_hand)
        if record.id in lanes:
            raise place.error(lane, f"id {record.id} is used twice in its section, expected each once")
        lanes[record.id] = record
    ordered = [lanes.get(sign * number) for number in range(1, len(lanes) + 1)]
    if None in ordered or len(lanes) > MOST_LANES:
        expected = f"{sign} to {sign * len(lanes)}"
        raise place.error(node, f"has lanes {', '.join(map(str, sorted(lanes)))[:80]}, expected {expected} without gaps and at most {MOST_LANES}")
    return tuple(record for record in ordered if record is not None)


def _by_distance(nodes: list[Node], sign: int) -> list[Node]:
    """Lanes from the middle outwards; the left ones stand in files the other way round."""
    if len(nodes) < 2:
        return nodes
    try:
        return sorted(nodes, key=lambda lane: sign * int(lane.get("id", "")))
    except ValueError:
        return nodes


def _lane(node: Node, place: Place, findings: Findings, start: float, sign: int, left_hand: bool) -> LaneRecord:
    word = place.word(node, "id")
    try:
        number = int(word)
    except ValueError:
        number = 0
    if number * sign <= 0 or len(word) > 9:
        raise place.error(node, f"id is {word[:20]!r}, expected a {'positive' if sign > 0 else 'negative'} whole number on this side")
    kind = node.get("type", "none")
    direction = -sign if not left_hand else sign
    if node.get("direction") == "reversed":
        direction = -direction
    elif node.get("direction") == "both" or kind == "bidirectional":
        direction = 0
    parts = children(node)
    widths, borders = parts.get("width", []), parts.get("border", [])
    if kind in DRIVABLE and not widths and not borders:
        findings.warn(place.at(node), f"lane {number} has neither width nor border, width 0 assumed")
    speeds = [
        (start + (place.optional(speed, "sOffset", 0.0, findings) or 0.0), speed_of(speed, place, findings)) for speed in parts.get("speed", [])
    ]
    return LaneRecord(
        number,
        kind,
        direction,
        cubics_of(widths, place, "sOffset", start) if widths or not borders else None,
        cubics_of(borders, place, "sOffset", start) if borders and not widths else None,
        _linked(parts, "predecessor", place, findings),
        _linked(parts, "successor", place, findings),
        tuple(sorted((at, limit) for at, limit in speeds if limit is not None)),
        place.at(node),
        _frictions(parts.get("material", []), place, findings, start),
    )


def _linked(parts: dict[str, list[Node]], tag: str, place: Place, findings: Findings) -> tuple[int, ...]:
    ends = [place.optional(end, "id", None, findings) for link in parts.get("link", []) for end in link if end.tag == tag]
    return tuple(int(number) for number in ends if number is not None)


def _frictions(nodes: list[Node], place: Place, findings: Findings, start: float) -> tuple[tuple[float, float], ...]:
    """(station, share of dry asphalt); values that no surface has are left out."""
    found = []
    for node in nodes:
        if not node.get("friction"):
            continue
        at, friction = place.optional(node, "sOffset", 0.0, findings), place.optional(node, "friction", None, findings)
        if friction is not None and friction <= 0.0:
            findings.warn(place.at(node), f"friction is {friction:g}, expected more than 0; the lane is read without it")
        elif at is not None and friction is not None:
            found.append((start + at, friction))
    return tuple(sorted(found))


def speed_of(node: Node, place: Place, findings: Findings) -> float | None:
    """m/s; inf where there is no limit; None where the file does not know one."""
    word, unit = node.get("max", "").strip(), node.get("unit", "").strip()
    if word == "no limit":
        return np.inf
    if word == "undefined":
        return None
    value = place.optional(node, "max", None, findings)
    if value is None:
        return None
    if unit not in UNITS:
        findings.warn(place.at(node), f"speed limit has the unit {unit[:20]!r} and is taken as unknown, expected m/s, km/h or mph")
        return None
    value *= UNITS[unit]
    if value <= 0.0:
        # writers put 0 where they know no limit; a limit of 0 would close the road
        findings.warn(place.at(node), f"speed limit of {word} {unit or 'm/s'} is taken as unknown, expected more than 0")
        return None
    return value
