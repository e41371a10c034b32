"""OpenDRIVE files made dirty without moving a lane: sections cut up, with slivers between them, as editors of town maps leave them."""

from __future__ import annotations

import copy
import random
from pathlib import Path

from lxml import etree

#: Lengths of the slivers, m: nothing, roundings, centimetres, and some that are just long enough to count.
SLIVERS = (0.0, 1e-7, 1e-5, 1e-3, 0.01, 0.04, 0.049, 0.06, 0.3, 1.0)


def cut_up(source: Path, out: Path, seed: int, cuts: int = 3) -> Path:
    """Write `source` with every lane section cut at up to `cuts` places, a sliver at each; ids of lanes and their links stay what they were."""
    rng = random.Random(seed)
    root = etree.parse(source).getroot()
    for road in root.findall("road"):
        lanes = road.find("lanes")
        sections = lanes.findall("laneSection")
        starts = [float(section.get("s")) for section in sections]
        for section, start, end in zip(sections, starts, [*starts[1:], float(road.get("length"))], strict=True):
            marks = []
            for _ in range(rng.randint(1, cuts)):
                at = rng.choice([start, end, rng.uniform(start, end), rng.uniform(start, end)])
                marks += [at, at + rng.choice(SLIVERS)]
            marks = sorted(min(max(mark, start), end) for mark in marks)
            pieces = [_piece(section, mark - start) for mark in [start, *marks]]
            for k, piece in enumerate(pieces):
                _link_inside(piece, first=k == 0, last=k == len(pieces) - 1)
            for piece in pieces[::-1]:
                section.addnext(piece)
            lanes.remove(section)
    etree.ElementTree(root).write(out)
    return out


def _piece(section: etree._Element, shift: float) -> etree._Element:
    """The section from `shift` m on."""
    made = copy.deepcopy(section)
    made.set("s", repr(float(section.get("s")) + shift))
    for lane in made.iter("lane"):
        for tag in ("width", "border"):
            records = lane.findall(tag)
            passed = [record for record in records if float(record.get("sOffset")) <= shift]
            for record in records:
                at = float(record.get("sOffset"))
                if record in passed[:-1]:
                    lane.remove(record)
                elif record in passed:
                    _led_on(record, shift - at)
                else:
                    record.set("sOffset", repr(at - shift))
    return made


def _led_on(record: etree._Element, d: float) -> None:
    a, b, c, e = (float(record.get(key)) for key in "abcd")
    made = (a + (b + (c + e * d) * d) * d, b + (2.0 * c + 3.0 * e * d) * d, c + 3.0 * e * d, e)
    for key, value in zip("abcd", made, strict=True):
        record.set(key, repr(value))
    record.set("sOffset", "0")


def _link_inside(piece: etree._Element, *, first: bool, last: bool) -> None:
    """Lanes lead on to the lane of the same number in the next piece; links to other sections and roads stay at the outermost ones."""
    for lane in piece.iter("lane"):
        if lane.get("id") == "0":
            continue
        link = lane.find("link")
        if link is None:
            link = etree.Element("link")
            lane.insert(0, link)
        for tag, outermost in (("predecessor", first), ("successor", last)):
            if not outermost:
                for old in link.findall(tag):
                    link.remove(old)
                etree.SubElement(link, tag, id=lane.get("id"))
