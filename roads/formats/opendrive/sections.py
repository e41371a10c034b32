"""Lane sections of an OpenDRIVE road; those too short to drive on are crossed: what they link is linked across them."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

from ..xml import Place, children, only
from .lanes import side_of
from .records import Cubics, LaneRecord, SectionRecord

if TYPE_CHECKING:
    from collections.abc import Iterable

    from ...findings import Findings
    from ..xml import Node

    #: Numbers of the lanes that lead on from each lane, by its number.
    Leads = dict[int, tuple[int, ...]]

#: Shorter sections are no place to drive on, m: what writers leave where records of different kinds begin a rounding apart.
SHORTEST = 0.05
#: Stations that differ by less agree, m.
MEET = 1e-3


class Sections(NamedTuple):
    """The sections of one road, and by which numbers others know its lanes at its start and end (None: their own)."""

    sections: tuple[SectionRecord, ...]
    at_start: Leads | None
    at_end: Leads | None


def sections_of(node: Node, nodes: list[Node], place: Place, findings: Findings, length: float, *, left_hand: bool) -> Sections:
    """The lane sections of one road, from its beginning to `length`.

    Raises:
        RoadError: no section, sections in the wrong order, or lanes that cannot be used.
    """
    if not nodes:
        raise place.error(node, f"id {node.get('id')!r} has no laneSection, expected at least one")
    starts = [place.number(section, "s") for section in nodes]
    if abs(starts[0]) > MEET:
        findings.warn(place.at(nodes[0]), f"first laneSection starts at s = {starts[0]:g} m, expected 0; its lanes are taken from 0 on")
    starts[0] = 0.0
    for section, start, after in zip(nodes, starts, starts[1:], strict=False):
        if after < start - MEET:
            raise place.error(section, f"starts at s = {start:g} m, expected before {after:g} m, where the next one is")
    found = []
    for number, (section, start, end) in enumerate(zip(nodes, starts, [*starts[1:], length], strict=True)):
        parts = children(section)
        left, right = (side_of(only(parts, side), place, findings, start, sign, left_hand=left_hand) for side, sign in (("left", 1), ("right", -1)))
        found.append(SectionRecord(start, min(end, length), left, right, number))
    kept = [section for section in found if section.end - section.start >= SHORTEST]
    if not kept:
        # the whole road is no longer than this
        kept = [max(found, key=lambda section: section.end - section.start)]
    for section, record in zip(nodes, found, strict=True):
        if record not in kept:
            findings.warn(place.at(section), f"laneSection of length {record.end - record.start:g} m is skipped, lanes are linked across it")
    return _crossed(found, [record.number for record in kept], length) if len(kept) < len(found) else Sections(tuple(found), None, None)


def _crossed(every: list[SectionRecord], kept: list[int], length: float) -> Sections:
    """The sections of the numbers `kept`, over the whole road, linked across those between them."""
    made = [every[number] for number in kept]
    ends = [*(section.start for section in made[1:]), length]
    made = [replace(section, end=end) for section, end in zip(made, ends, strict=True)]
    made[0] = _from(made[0], 0.0)
    for k, (number, after) in enumerate(pairwise(kept)):
        if after > number + 1:
            leads = _composed(every[number : after + 1])
            made[k] = _relinked(made[k], "successors", leads)
            made[k + 1] = _relinked(made[k + 1], "predecessors", _turned(leads))
    at_start = at_end = None
    if kept[0] > 0:
        at_start = _composed(every[: kept[0] + 1])
        made[0] = _relinked(made[0], "predecessors", _through(_turned(at_start), every[0], "predecessors"))
    if kept[-1] < len(every) - 1:
        onward = _composed(every[kept[-1] :])
        at_end = _turned(onward)
        made[-1] = _relinked(made[-1], "successors", _through(onward, every[-1], "successors"))
    return Sections(tuple(made), at_start, at_end)


def _composed(chain: list[SectionRecord]) -> Leads:
    """From the lanes of the first section to those of the last one that they lead on to; a link that one side states counts."""
    leads: Leads = {lane.id: (lane.id,) for lane in chain[0].lanes}
    for before, after in pairwise(chain):
        stated = {lane.id: list(lane.successors) for lane in before.lanes}
        for lane in after.lanes:
            for number in lane.predecessors:
                stated.get(number, []).append(lane.id)
        there = {lane.id for lane in after.lanes}
        leads = {begin: _once(last for number in numbers for last in stated[number] if last in there) for begin, numbers in leads.items()}
    return leads


def _through(leads: Leads, section: SectionRecord, side: str) -> Leads:
    """What the lanes of `section`, which `leads` leads to, are linked to at the road's end."""
    beyond: Leads = {lane.id: getattr(lane, side) for lane in section.lanes}
    return {begin: _once(last for number in numbers for last in beyond[number]) for begin, numbers in leads.items()}


def _turned(leads: Leads) -> Leads:
    found: dict[int, list[int]] = {}
    for begin, numbers in leads.items():
        for number in numbers:
            found.setdefault(number, []).append(begin)
    return {number: tuple(begins) for number, begins in found.items()}


def _once(numbers: Iterable[int]) -> tuple[int, ...]:
    return tuple(dict.fromkeys(numbers))


def _relinked(section: SectionRecord, side: str, leads: Leads) -> SectionRecord:
    left, right = (tuple(replace(lane, **{side: leads.get(lane.id, ())}) for lane in lanes) for lanes in (section.left, section.right))
    return replace(section, left=left, right=right)


def _from(section: SectionRecord, start: float) -> SectionRecord:
    """The section from an earlier start on, with what holds where it began."""
    if section.start == start:
        return section

    def earlier(lane: LaneRecord) -> LaneRecord:
        width, border = (None if cubics is None else _led_back(cubics, section.start, start) for cubics in (lane.width, lane.border))
        speeds, frictions = (tuple((start if at <= section.start else at, value) for at, value in values) for values in (lane.speeds, lane.frictions))
        return replace(lane, width=width, border=border, speeds=speeds, frictions=frictions)

    return replace(section, start=start, left=tuple(map(earlier, section.left)), right=tuple(map(earlier, section.right)))


def _led_back(cubics: Cubics, begin: float, start: float) -> Cubics:
    """The first record from `start` on, where it held from `begin`: the same value all the way, so that no cubic runs off."""
    if not cubics.starts or cubics.starts[0] > begin or begin <= start:
        return cubics
    return Cubics((start, *cubics.starts), ((cubics.rows[0][0], 0.0, 0.0, 0.0), *cubics.rows))
