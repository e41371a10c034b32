"""Where OpenDRIVE roads and their lanes are: cross-sections at stations dense enough for a tenth of a millimetre between them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ...errors import RoadError
from ...geometry.plan_view import LONGEST_STEP, PlanView

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from .records import Cubics, LaneRecord, RoadRecord, SectionRecord

    Floats = NDArray[np.float64]

#: Linear interpolation of offsets and heights between stations is off by no more, m.
SAG = 1e-4
#: And of banks, rad: a tenth of a millimetre ten metres from the reference line.
SAG_BANK = 1e-5
#: Most stations of one road and of one file; more would be a slip in it.
MOST_STATIONS, MOST_OF_ALL = 250_000, 2_000_000
#: A sample of the reference line gives way to a station that something begins at, within this distance, m.
NEAR = 1e-3
#: Stations that things begin at are one within this distance, m.
SAME = 1e-5


@dataclass(frozen=True, eq=False)
class SectionShape:
    """Cross-sections of one lane section.

    Attributes:
        first: index of its first station among the road's.
        last: index of its last station.
        lanes: from right to left.
        borders: (k + 1, n) offsets of the k lanes' borders from right to left, m.
        places: (k + 1, n, 3) the borders in space, m.
    """

    first: int
    last: int
    lanes: tuple[LaneRecord, ...]
    borders: Floats
    places: Floats


class RoadShape:
    """Stations, reference line, height, bank and borders of one road.

    Attributes:
        record: what the file says.
        s: (n,) stations, m: starts of all records and sections among them.
        points: (n, 2) reference line, m.
        heading: (n,) rad.
    """

    def __init__(self, record: RoadRecord, s: Floats, points: Floats, heading: Floats) -> None:
        self.record = record
        self.s, self.points, self.heading = s, points, heading

    @cached_property
    def height(self) -> Floats:
        """(n,) height of the reference line, m."""
        return self.record.elevation(self.s)

    @cached_property
    def bank(self) -> Floats:
        """(n,) superelevation, rad, positive where the left side is higher."""
        return self.record.superelevation(self.s)

    @cached_property
    def sections(self) -> list[SectionShape]:
        """Cross-sections by lane section."""
        return [self._section(section) for section in self.record.sections]

    def _section(self, section: SectionRecord) -> SectionShape:
        first, last = np.searchsorted(self.s, [section.start - SAME, section.end - SAME]).tolist()
        last = min(last, len(self.s) - 1)
        s = self.s[first : last + 1]
        offset = self.record.lane_offset(s)
        if len(self.record.lane_offset.starts) > 1:
            # where a record begins at the section's end, the section still ends with the one before
            offset[-1] = self.record.lane_offset(s[-1:] - 1e-9)[0]
        borders = np.empty((len(section.lanes) + 1, len(s)))
        middle = len(section.right)
        borders[middle] = offset
        for k, lane in enumerate(section.right):
            borders[middle - k - 1] = _outer(lane, -1.0, s, borders[middle - k])
        for k, lane in enumerate(section.left):
            borders[middle + k + 1] = _outer(lane, 1.0, s, borders[middle + k])
        return SectionShape(first, last, section.lanes, borders, self._places(slice(first, last + 1), borders))

    def _places(self, index: slice, offset: Floats) -> Floats:
        """(k, n, 3) points at lateral offsets (k, n) from the reference line at the stations `index`, on the banked road."""
        made = np.empty((*offset.shape, 3))
        made[:, :, 2] = self.height[index]
        aside = offset
        if self.record.superelevation.starts:
            aside = offset * np.cos(self.bank[index])
            made[:, :, 2] += offset * np.sin(self.bank[index])
        made[:, :, 0] = self.points[index, 0] - aside * np.sin(self.heading[index])
        made[:, :, 1] = self.points[index, 1] + aside * np.cos(self.heading[index])
        return made


class Shapes:
    """The shapes of all roads of a file, made together when the first one is asked for."""

    def __init__(self, records: dict[str, RoadRecord]) -> None:
        self._records = records

    def __getitem__(self, identity: str) -> RoadShape:
        """The shape of one road.

        Raises:
            RoadError: a road that needs too many stations.
        """
        shapes = self._made
        if identity not in shapes:
            road = self._records[identity]
            raise RoadError(
                f"{road.place}: road {identity} needs too many stations for its length and curvature, expected fewer than {MOST_STATIONS}"
            )
        return shapes[identity]

    @cached_property
    def _made(self) -> dict[str, RoadShape]:
        roads, left = [], float(MOST_OF_ALL)
        for road in self._records.values():
            need = _stations_needed(road)
            if need <= min(left, MOST_STATIONS):
                roads.append(road)
                left -= need
        return _shapes(roads) if roads else {}


def _stations_needed(road: RoadRecord) -> float:
    """About how many stations a road takes."""
    cubics = [road.elevation, road.superelevation, road.lane_offset]
    cubics += [cubic for section in road.sections for lane in section.lanes if (cubic := lane.width or lane.border) is not None]
    bent = sum(_counts(cubic, road.length, SAG_BANK if cubic is road.superelevation else SAG) for cubic in cubics if not cubic.is_flat)
    view = road.length / LONGEST_STEP
    # an ordinary road cannot need many: only long ones and those of many elements are looked at closely
    if len(road.elements) > 500 or road.length > 1e4:
        each = PlanView(road.elements, np.ones(len(road.elements), dtype=bool))
        view = float(np.sum(each.length / each.steps())) + 2.0 * len(road.elements)
    return view + bent + sum(len(cubic.starts) for cubic in cubics)


def _counts(cubics: Cubics, end: float, sag: float) -> float:
    ends = [*cubics.starts[1:], max(end, cubics.starts[-1])]
    return sum((stop - start) * _finest(row, stop - start, sag) for start, stop, row in zip(cubics.starts, ends, cubics.rows, strict=True))


def _finest(row: tuple[float, ...], length: float, sag: float) -> float:
    """Stations per metre that linear interpolation of a cubic needs."""
    bend = max(abs(2.0 * row[2]), abs(2.0 * row[2] + 6.0 * row[3] * length))
    return (bend / (8.0 * sag)) ** 0.5


def _shapes(roads: list[RoadRecord]) -> dict[str, RoadShape]:
    counts = np.array([len(road.elements) for road in roads])
    owner = np.repeat(np.arange(len(roads)), counts)
    follows = np.append(False, owner[1:] == owner[:-1])
    view = PlanView([element for road in roads for element in road.elements], follows)
    starts = np.concatenate([road.starts for road in roads])
    index, along = view.samples()
    marks = [mark for k, road in enumerate(roads) for mark in _marks(road, k)]
    fixed_owner = np.repeat([k for k, _ in marks], [len(mark) for _, mark in marks])
    s, owner_of_s = _merged(np.concatenate([mark for _, mark in marks]), fixed_owner, along + starts[index], owner[index])
    ends = np.searchsorted(owner_of_s, np.arange(len(roads) + 1))
    element = _elements_at(s, ends, starts, np.concatenate([[0], np.cumsum(counts)]))
    points, heading = view.at(element, np.clip(s - starts[element], 0.0, view.length[element]))
    return {
        road.id: RoadShape(road, s[a:b], points[a:b], heading[a:b]) for road, a, b in zip(roads, ends[:-1].tolist(), ends[1:].tolist(), strict=True)
    }


def _elements_at(s: Floats, ends: NDArray[np.intp], starts: Floats, bounds: NDArray[np.intp]) -> NDArray[np.intp]:
    """The element that each station lies on."""
    element = np.empty(len(s), dtype=np.intp)
    for a, b, low, high in zip(ends[:-1].tolist(), ends[1:].tolist(), bounds[:-1].tolist(), bounds[1:].tolist(), strict=True):
        if high - low == 1:
            element[a:b] = low
        else:
            element[a:b] = low + np.maximum(np.searchsorted(starts[low:high], s[a:b], side="right") - 1, 0)
    return element


def _merged(fixed: Floats, fixed_owner: NDArray[np.intp], free: Floats, free_owner: NDArray[np.intp]) -> tuple[Floats, NDArray[np.intp]]:
    """Stations of all roads in order, each once; the fixed ones stay exactly, free ones give way to them."""
    fixed, fixed_owner = _apart(fixed, fixed_owner, np.zeros(len(fixed), dtype=bool), SAME)
    is_free = np.append(np.zeros(len(fixed), dtype=bool), np.ones(len(free), dtype=bool))
    return _apart(np.append(fixed, free), np.append(fixed_owner, free_owner), is_free, NEAR)


def _apart(s: Floats, owner: NDArray[np.intp], free: NDArray[np.bool_], least: float) -> tuple[Floats, NDArray[np.intp]]:
    """In order, without those closer than `least` to the one before; of a pair a free one goes, of two alike the second."""
    order = np.lexsort((free, s, owner))
    s, owner, free = s[order], owner[order], free[order]
    while True:
        same = (np.diff(owner) == 0) & (np.diff(s) < least)
        drop = np.zeros(len(s), dtype=bool)
        drop[1:] = same & (free[1:] | ~free.any())
        drop[:-1] |= same & free[:-1] & ~free[1:]
        if not drop.any():
            return s, owner
        s, owner, free = s[~drop], owner[~drop], free[~drop]


def _marks(road: RoadRecord, k: int) -> Iterator[tuple[int, Floats]]:
    """Stations where something begins, and between the starts of cubics as many as linear interpolation needs."""
    last = road.length
    yield k, np.array([section.start for section in road.sections] + [last])
    limits = [start for start, _ in road.speeds] + [start for section in road.sections for lane in section.lanes for start, _ in lane.speeds]
    if limits:
        yield k, np.clip(limits, 0.0, last)
    for cubics, sag in ((road.elevation, SAG), (road.superelevation, SAG_BANK), (road.lane_offset, SAG)):
        if cubics.starts:
            yield k, _spread(cubics, last, last, sag)
    for section in road.sections:
        for lane in section.lanes:
            cubics = lane.width or lane.border
            if cubics is not None and cubics.starts and (len(cubics.starts) > 1 or not cubics.is_flat or min(cubics.starts) > section.start):
                yield k, _spread(cubics, section.end, last)


def _spread(cubics: Cubics, end: float, last: float, sag: float = SAG) -> Floats:
    starts = [start for start in cubics.starts if 0.0 <= start <= min(end, last)]
    if cubics.is_flat:
        return np.array(starts)
    marks = [np.array(starts)]
    for start, stop, (_, _, c, d) in zip(cubics.starts, [*cubics.starts[1:], end], cubics.rows, strict=True):
        low, high = max(start, 0.0), min(stop, end)
        if high <= low:
            continue
        bend = max(abs(2.0 * c + 6.0 * d * (low - start)), abs(2.0 * c + 6.0 * d * (high - start)))
        count = min((high - low) * np.sqrt(bend / (8.0 * sag)), 2.0 * MOST_STATIONS)
        if count > 1.0:
            marks.append(np.linspace(low, high, int(np.ceil(count)) + 1))
    return np.concatenate(marks)


def _outer(lane: LaneRecord, sign: float, s: Floats, inner: Floats) -> Floats:
    if lane.border is not None:
        return lane.border(s)
    if lane.width is None or not lane.width.starts:
        return inner
    return inner + sign * np.maximum(lane.width(s), 0.0)
