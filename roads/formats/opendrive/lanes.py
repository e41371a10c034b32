"""Lanes of an OpenDRIVE road: sections, widths, limits, links."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..xml import Place, children, only
from .records import DRIVABLE, NOTHING, Cubics, LaneRecord, SectionRecord

if TYPE_CHECKING:
    from ...findings import Findings
    from ..xml import Node

UNITS = {"m/s": 1.0, "km/h": 1.0 / 3.6, "mph": 0.44704, "": 1.0}
#: Shorter sections are taken as slips of a rounding writer and skipped; stations that differ by less than `MEET` agree, m.
SHORTEST, MEET = 1e-6, 1e-3
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


def sections_of(node: Node, nodes: list[Node], place: Place, findings: Findings, length: float, *, left_hand: bool) -> tuple[SectionRecord, ...]:
    """The lane sections of one road, from its beginning to `length`."""
    if not nodes:
        raise place.error(node, f"id {node.get('id')!r} has no laneSection, expected at least one")
    starts = [place.number(section, "s") for section in nodes]
    if abs(starts[0]) > MEET:
        findings.warn(place.at(nodes[0]), f"first laneSection starts at s = {starts[0]:g} m, expected 0; its lanes are taken from 0 on")
    starts[0] = 0.0
    found = []
    for section, start, end in zip(nodes, starts, [*starts[1:], length], strict=True):
        if end < start - MEET:
            raise place.error(section, f"starts at s = {start:g} m, expected before {end:g} m, where the next one or the road's end is")
        if end - start < SHORTEST:
            findings.warn(place.at(section), f"laneSection of length {end - start:g} m is skipped")
            continue
        parts = children(section)
        left, right = (_side(only(parts, side), place, findings, start, sign, left_hand) for side, sign in (("left", 1), ("right", -1)))
        found.append(SectionRecord(start, end, left, right))
    return tuple(found)


def _side(node: Node | None, place: Place, findings: Findings, start: float, sign: int, left_hand: bool) -> tuple[LaneRecord, ...]:
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
    speeds = [(start + place.number(speed, "sOffset", 0.0), speed_of(speed, place, findings)) for speed in parts.get("speed", [])]
    frictions = [
        (start + place.number(node, "sOffset", 0.0), place.number(node, "friction")) for node in parts.get("material", []) if node.get("friction")
    ]
    if any(friction <= 0.0 for _, friction in frictions):
        raise place.error(node, f"friction is {min(friction for _, friction in frictions):g}, expected more than 0")
    ends = [(end.tag, int(place.number(end, "id"))) for link in parts.get("link", []) for end in link]
    return LaneRecord(
        number,
        kind,
        direction,
        cubics_of(widths, place, "sOffset", start) if widths or not borders else None,
        cubics_of(borders, place, "sOffset", start) if borders and not widths else None,
        tuple(lane for tag, lane in ends if tag == "predecessor"),
        tuple(lane for tag, lane in ends if tag == "successor"),
        tuple(sorted((at, limit) for at, limit in speeds if limit is not None)),
        place.at(node),
        tuple(sorted(frictions)),
    )


def speed_of(node: Node, place: Place, findings: Findings) -> float | None:
    """m/s; inf where there is no limit; None where the file does not know one."""
    word, unit = node.get("max", "").strip(), node.get("unit", "").strip()
    if word == "no limit":
        return np.inf
    if word == "undefined":
        return None
    if unit not in UNITS:
        raise place.error(node, f"unit is {unit!r}, expected m/s, km/h or mph")
    value = place.float(node, "max", word) * UNITS[unit]
    if value <= 0.0:
        # writers put 0 where they know no limit; a limit of 0 would close the road
        findings.warn(place.at(node), f"speed limit of {word} {unit or 'm/s'} is taken as unknown, expected more than 0")
        return None
    return value
