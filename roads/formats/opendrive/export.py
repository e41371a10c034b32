"""A `Road` as OpenDRIVE records: the elements it was drawn with, or its spline piece by piece as exact cubics."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...errors import RoadError
from ...geometry.plan_view import Cubic
from .records import NOTHING, Cubics, LaneRecord, OpenDrive, RoadEnd, RoadRecord, SectionRecord
from .writer import write_records

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from numpy.typing import NDArray

    from ...geometry.plan_view import Element
    from ...lane import Lane
    from ...road import Road

    Floats = NDArray[np.float64]

#: Records replace data that they miss by no more, m, and rad.
TOLERANCE, BANK = 5e-5, 2e-6
#: Sharper bends are noise, 1/m.
SHARPEST = 2.0
#: A gap between lanes that counts as none, m.
NO_GAP = 1e-4


def write(road: Road, path: Path) -> None:
    """Write `road` as the only one of an OpenDRIVE file.

    Its lane to drive is not written: a reader finds it anew.

    Raises:
        RoadError: gaps between its lanes or beyond them, which OpenDRIVE cannot hold as drivable road; no lane that leads along the stations;
            bends that no reader takes for a road.
    """
    road.must_lead_on(path)
    sharpest = float(np.max(np.abs(road.reference.curvature(np.linspace(0.0, road.length, max(int(4.0 * min(road.length, 1e6)), 100))))))
    if sharpest > SHARPEST:
        raise RoadError(f"{path}: {road.name} bends with a radius of {1.0 / sharpest:.3f} m, expected at least {1.0 / SHARPEST:g} m; smooth it first")
    origin = (
        "" if road.origin is None else f"+proj=tmerc +lat_0={road.origin[0]!r} +lon_0={road.origin[1]!r} +k=1 +x_0=0 +y_0=0 +ellps=WGS84 +units=m"
    )
    write_records(OpenDrive(road.name, "1.6", origin, {"1": record_of(road, path)}), path)


def record_of(road: Road, path: Path | str, identity: str = "1") -> RoadRecord:
    """The record of one road."""
    elements, starts = _elements(road)
    length = float(starts[-1]) + elements[-1].length
    # the file's stations are those of its elements, which differ from the spline's by rounding of the sampling
    s = road.s * (length / road.length)
    if road.closed:
        s = np.append(s, length)
    own = RoadEnd("road", identity, "start"), RoadEnd("road", identity, "end")
    return RoadRecord(
        identity,
        road.name,
        length,
        "-1",
        road.left_hand,
        elements,
        starts,
        _heights(road, s),
        _lines(s, _round(road, road.bank), BANK) if np.any(road.bank) else NOTHING,
        *_cross_sections(road, path, s),
        _speeds(road, s),
        own[1] if road.closed else None,
        own[0] if road.closed else None,
        str(path),
    )


def _round(road: Road, values: Floats) -> Floats:
    """Values at all stations, the first one repeated at the end of a closed road."""
    return np.append(values, values[:1]) if road.closed else values


def _elements(road: Road) -> tuple[tuple[Element, ...], Floats]:
    elements = road.plan_view or tuple(_pieces(road))
    return elements, np.concatenate([[0.0], np.cumsum([element.length for element in elements])[:-1]])


def _pieces(road: Road) -> list[Cubic]:
    curve = road.reference
    h = np.diff(curve.pieces.breaks)
    lengths = np.diff(curve.breaks_s)
    a, b, c, d = curve.pieces.coefficients
    heading = np.arctan2(c[1], c[0])
    turn = np.exp(-1j * heading)
    # powers of p = th / h in the frame of the piece's start
    rows = [np.zeros(len(h), dtype=complex), turn * (c[0] + 1j * c[1]) * h, turn * (b[0] + 1j * b[1]) * h**2, turn * (a[0] + 1j * a[1]) * h**3]
    return [
        Cubic(
            float(d[0, k]),
            float(d[1, k]),
            float(heading[k]),
            float(lengths[k]),
            tuple(float(row[k].real) for row in rows),  # pyright: ignore[reportArgumentType]
            tuple(float(row[k].imag) for row in rows),  # pyright: ignore[reportArgumentType]
            1.0,
            "arc",
        )
        for k in range(len(h))
    ]


def _heights(road: Road, s: Floats) -> Cubics:
    z, slope = _round(road, road.height), road.slope_at(road.s)
    return _hermite(s, z, _round(road, slope)) if np.any(z) else NOTHING


def _hermite(s: Floats, z: Floats, slope: Floats) -> Cubics:
    """As few cubics as keep `TOLERANCE` at all data between their ends."""

    def between(at: int, end: int) -> tuple[float, ...]:
        h = s[end] - s[at]
        rise = (z[end] - z[at]) / h
        return z[at], slope[at], (3.0 * rise - 2.0 * slope[at] - slope[end]) / h, (slope[at] + slope[end] - 2.0 * rise) / h**2

    return _fewest(s, z, between, TOLERANCE)


def _lines(s: Floats, values: Floats, tolerance: float = TOLERANCE) -> Cubics:
    """As few straight records as keep `tolerance` at all data."""

    def between(at: int, end: int) -> tuple[float, ...]:
        return values[at], (values[end] - values[at]) / (s[end] - s[at]), 0.0, 0.0

    return _fewest(s, values, between, tolerance)


def _fewest(s: Floats, values: Floats, between: Callable[[int, int], tuple[float, ...]], tolerance: float) -> Cubics:
    """Records over stretches of data as long as doubling and halving finds; a straight one that goes on with the last is none of its own."""
    starts: list[float] = []
    rows: list[tuple[float, ...]] = []
    at, reach = 0, 1
    while at < len(s) - 1:
        while True:
            end = min(at + reach, len(s) - 1)
            row = tuple(map(float, between(at, end)))
            d = s[at : end + 1] - s[at]
            if reach == 1 or np.max(np.abs(row[0] + (row[1] + (row[2] + row[3] * d) * d) * d - values[at : end + 1])) <= tolerance:
                break
            reach = max(reach // 2, 1)
        if not (rows and _goes_on(rows[-1], row, float(s[at]) - starts[-1])):
            starts.append(float(s[at]))
            rows.append(row)
        at, reach = end, 2 * reach
    return Cubics(tuple(starts), tuple(rows))


def _goes_on(before: tuple[float, ...], row: tuple[float, ...], way: float) -> bool:
    straight = not any((*before[2:], *row[2:]))
    return straight and abs(row[1] - before[1]) <= 1e-12 and abs(row[0] - before[0] - before[1] * way) <= 1e-12


def _speeds(road: Road, s: Floats) -> tuple[tuple[float, float], ...]:
    limit = road.speed_limit
    if not np.any(np.isfinite(limit)):
        return ()
    changes = np.append(0, np.flatnonzero(limit[1:] != limit[:-1]) + 1)
    return tuple((float(s[k]), float(limit[k])) for k in changes)


def _cross_sections(road: Road, path: Path | str, s: Floats) -> tuple[Cubics, tuple[SectionRecord, ...]]:
    """The lane offset and the sections; a section begins wherever a lane begins or ends."""
    lanes = road.lanes
    there = np.array([~np.isnan(_round(road, lane.right)) for lane in lanes])
    begins = np.append(0, np.flatnonzero(np.any(there[:, 1:] != there[:, :-1], axis=0)) + 1)
    ends = [*begins[1:].tolist(), len(s) - 1]
    offset_s, offset_rows = [], []
    sections: list[SectionRecord] = []
    numbers: list[dict[int, int]] = []
    for begin, end in zip(begins.tolist(), ends, strict=True):
        # the last station before a change belongs to the section that ends; its lanes reach the change with their last width
        last = end if end == len(s) - 1 else end - 1
        present = [k for k in range(len(lanes)) if there[k, begin]]
        part = np.arange(begin, last + 1)
        borders = _borders(road, path, present, part, s)
        split = _middle(road, [lanes[k] for k in present])
        stations = s[part] if last == end else np.append(s[part], s[end])
        if last != end:
            borders = np.hstack([borders, borders[:, -1:]])
        if len(stations) < 2:
            raise RoadError(f"{path}: {road.name} has lanes for a single station at s = {s[begin]:.2f} m, expected a stretch")
        line = _lines(stations, borders[split])
        offset_s += line.starts
        offset_rows += line.rows
        right = [
            _record(road, lanes[k], -(split - j), _lines(stations, borders[j + 1] - borders[j]), path) for j, k in enumerate(present) if j < split
        ]
        left = [
            _record(road, lanes[k], j - split + 1, _lines(stations, borders[j + 1] - borders[j]), path) for j, k in enumerate(present) if j >= split
        ]
        sections.append(SectionRecord(float(stations[0]), float(stations[-1]), tuple(left), tuple(right[::-1])))
        numbers.append({k: (j - split if j < split else j - split + 1) for j, k in enumerate(present)})
    offset = NOTHING if not np.any(np.array(offset_rows)) else Cubics(tuple(offset_s), tuple(offset_rows))
    return offset, _linked(sections, numbers, closed=road.closed)


def _borders(road: Road, path: Path | str, present: list[int], part: NDArray[np.intp], s: Floats) -> Floats:
    """Offsets (k + 1, n) of the borders of lanes that lie side by side from edge to edge."""
    rows = [_round(road, road.lanes[k].right)[part] for k in present] + [_round(road, road.lanes[present[-1]].left)[part]] if present else []
    if not rows:
        raise RoadError(f"{path}: {road.name} has no lane at s = {s[part[0]]:.1f} m, expected one")
    before = [_round(road, road.right)[part]] + [_round(road, road.lanes[k].left)[part] for k in present]
    after = [*rows[:-1], _round(road, road.left)[part]]
    for a, b in zip(before, after, strict=True):
        gap = np.abs(a - b)
        # where a cross-section changes at once, edges and lanes differ at that station
        gap[[0, -1]] = 0.0
        if np.max(gap) > NO_GAP:
            at = int(np.argmax(gap))
            raise RoadError(
                f"{path}: {road.name} has {gap[at]:.3f} m beside its lanes at s = {s[part[at]]:.1f} m; "
                "OpenDRIVE holds lanes side by side from edge to edge"
            )
    # OpenDRIVE measures on the banked road, `Road` in plan
    return np.array(rows) / np.cos(_round(road, road.bank)[part])


def _middle(road: Road, lanes: list[Lane]) -> int:
    """How many lanes lie right of the centre lane: those of the direction that traffic on the right side has."""
    usual = -1 if road.left_hand else 1
    return next((k for k, lane in enumerate(lanes) if lane.direction not in (usual, 0)), len(lanes))


def _record(road: Road, lane: Lane, number: int, width: Cubics, path: Path | str) -> LaneRecord:
    return LaneRecord(number, lane.kind, lane.direction, width, None, (), (), (), str(path), _frictions(road))


def _frictions(road: Road) -> tuple[tuple[float, float], ...]:
    """Steps of the road's friction; the same on all lanes."""
    values = road.friction
    if not np.any(values != 1.0):
        return ()
    changes = np.append(0, np.flatnonzero(values[1:] != values[:-1]) + 1)
    return tuple((float(road.s[k]), float(values[k])) for k in changes)


def _within(steps: tuple[tuple[float, float], ...], section: SectionRecord) -> tuple[tuple[float, float], ...]:
    """Steps that lie in the section, and the one that holds where it begins."""
    before = [step for step in steps if step[0] <= section.start]
    first = [(section.start, before[-1][1])] if before else []
    return tuple(first + [step for step in steps if section.start < step[0] < section.end])


def _linked(sections: list[SectionRecord], numbers: list[dict[int, int]], *, closed: bool) -> tuple[SectionRecord, ...]:
    """Sections whose lanes know the lane before and the lane after."""
    made = []
    last = len(sections) - 1
    for k, section in enumerate(sections):
        before = numbers[k - 1] if k else (numbers[-1] if closed else {})
        after = numbers[k + 1] if k < last else (numbers[0] if closed else {})
        owner = {number: lane for lane, number in numbers[k].items()}

        def linked(
            lane: LaneRecord,
            before: dict[int, int] = before,
            after: dict[int, int] = after,
            owner: dict[int, int] = owner,
            section: SectionRecord = section,
        ) -> LaneRecord:
            index = owner[lane.id]
            ends = tuple(tuple([side[index]] if index in side else []) for side in (before, after))
            return LaneRecord(
                lane.id, lane.kind, lane.direction, lane.width, None, ends[0], ends[1], (), lane.place, _within(lane.frictions, section)
            )

        made.append(SectionRecord(section.start, section.end, tuple(map(linked, section.left)), tuple(map(linked, section.right))))
    return tuple(made)
