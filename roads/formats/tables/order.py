"""Rows of a table that break its order: their station, their time or their place contradicts those of the rows beside them.

Loggers end a file with a row of their own, receivers lose a place, people paste a row twice. Such a row is found by asking whether the rows
before and after it go on without it; what is counted in other units, backwards or from another origin is in order as long as it counts the way.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...findings import Finding

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Place = Callable[[int], str]

#: Stations follow the way if no more than this share of the steps breaks it, or so few of at most a third; else they say nothing about rows.
_MOST_BREAK, _FEW_BREAK = 0.1, 6
#: A step's station may differ from its way by this share of it, and by this share of the usual step (chords are shorter than what they cut off).
_SHARE, _USUAL = 0.3, 0.3
#: So many rows in a row are left out, and only out of tables of so many rows.
_LONGEST_RUN, _FEWEST = 3, 8
#: A place is far off where it is so many local steps from both neighbours, and these no more than so many from each other; and at least so many m.
_FAR, _NEAR, _LEAST = 10.0, 3.0, 1.0
#: Breaks of order that are named one by one.
_NAMED = 5


class Order(NamedTuple):
    """Which rows (n,) to keep, and what was found."""

    keep: NDArray[np.bool_]
    findings: list[Finding]


def in_order(points: Floats, stations: Floats | None, times: Floats | None, place: Place) -> Order:
    """Look at the rows of a driven line.

    Args:
        points: (n, 2) places, m.
        stations: (n,) what should count the way, in any unit and direction.
        times: (n,) what should never go back.
        place: names a row.
    """
    found = Order(np.ones(len(points), dtype=bool), [])
    if len(points) < _FEWEST:
        return found
    if stations is not None:
        found = _by_station(points, stations, place)
    if times is not None:
        rest = np.flatnonzero(found.keep)
        late = _by_time(points[rest], times[rest], lambda row: place(int(rest[row])))
        found.keep[rest[~late.keep]] = False
        found.findings.extend(late.findings)
    rest = np.flatnonzero(found.keep)
    far = by_place(points[rest], lambda row: place(int(rest[row])))
    found.keep[rest[~far.keep]] = False
    return Order(found.keep, found.findings + far.findings)


def by_place(points: Floats, place: Place) -> Order:
    """Leave out single places far off a line that goes on without them; at the ends, where nothing tells, they are named only."""
    keep = np.ones(len(points), dtype=bool)
    if len(points) < _FEWEST:
        return Order(keep, [])
    steps = _way(points)
    findings: list[Finding] = []
    skip = np.hypot(*(points[2:] - points[:-2]).T)
    for row in (np.flatnonzero(np.minimum(steps[:-1], steps[1:]) > np.maximum(_FAR / _NEAR * skip, _LEAST)) + 1).tolist():
        local = float(np.median(np.concatenate([steps[max(row - 6, 0) : row - 1], steps[row + 1 : row + 6]])))
        away = float(min(steps[row - 1], steps[row]))
        if away > _FAR * local and skip[row - 1] <= _NEAR * local and keep[row - 1]:
            keep[row] = False
            words = f"its place lies {away:z.1f} m off the rows beside it, which are {skip[row - 1]:z.1f} m apart: the row is left out"
            findings.append(Finding("warning", place(row), f"{words}; expected a line without jumps"))
    for row, step, others in ((0, steps[0], steps[1:]), (len(points) - 1, steps[-1], steps[:-1])):
        usual = float(np.max(others))
        if step > max(_FAR * usual, _LEAST):
            words = f"its place lies {step:z.1f} m from the next one of the line, the others at most {usual:z.1f} m: it is used"
            findings.append(Finding("warning", place(row), f"{words}; is the row part of the road?"))
    return Order(keep, _few(findings))


def _by_station(points: Floats, stations: Floats, place: Place) -> Order:
    steps, counted = _way(points), np.diff(stations)
    moved = steps > 1e-6
    scale = float(np.median(counted[moved] / steps[moved])) if moved.any() else 0.0
    slack = _USUAL * abs(scale) * float(np.median(steps)) + _grain(stations)

    def off(way: Floats | float, by: Floats | float) -> Floats | float:
        return abs(by - scale * way) - _SHARE * abs(scale) * way - slack

    good = np.asarray(off(steps, counted)) <= 0.0
    if scale == 0.0 or _unordered(good):
        first = int(np.argmin(good))
        words = f"its stations do not count the way between the rows: at {np.count_nonzero(~good)} of {len(good)} steps they contradict it, the first"
        words += f" here by {counted[first]:g} for {steps[first]:.3g} m; they are not used, expected the distance along the line in m"
        return Order(np.ones(len(points), dtype=bool), [Finding("warning", place(first + 1), words)])

    def follows(a: int, b: int) -> bool:
        return bool(off(float(np.hypot(*(points[b] - points[a]))), float(stations[b] - stations[a])) <= 0.0)

    bad, jumps = _breaks(good, follows)
    keep, findings = np.ones(len(points), dtype=bool), _scale_words(scale, place)
    for row in sorted(bad):
        beside = row - 1 if row else row + 1
        words = f"its station {stations[row]:g} is {abs(stations[row] - stations[beside]):g} from that of the row beside it, its place "
        words += f"{np.hypot(*(points[row] - points[beside])):.3g} m"
        if _fits(points, row, bad):
            findings.append(Finding("warning", place(row), f"{words}: the place is used, since it lies between its neighbours"))
            continue
        keep[row] = False
        again = row == len(points) - 1 and float(np.hypot(*(points[row] - points[0]))) < 1e-6
        words += ": the row is left out; expected the distance along the line" if not again else ": it repeats the first row and is left out"
        findings.append(Finding("note" if again else "warning", place(row), words))
    for row in jumps:
        words = f"the station jumps by {counted[row]:g} where the place moves by {steps[row]:.3g} m; stations are not used, the places are"
        findings.append(Finding("warning", place(row + 1), words))
    return Order(keep, _few(findings))


def _scale_words(scale: float, place: Place) -> list[Finding]:
    if 0.9 < scale < 1.1:
        return []
    what = "decreases along the rows" if -1.1 < scale < -0.9 else f"counts {scale:.4g} for each metre between the rows"
    return [Finding("note", place(0), f"column s {what}; it is not used, expected the distance along the line in m")]


def _by_time(points: Floats, times: Floats, place: Place) -> Order:
    keep = np.ones(len(times), dtype=bool)
    forward = np.diff(times) >= 0.0
    if len(times) < _FEWEST or _unordered(forward):
        return Order(keep, [])
    bad, _ = _breaks(forward, lambda a, b: bool(times[b] >= times[a]))
    findings = []
    for row in sorted(bad):
        words = f"its time {times[row]:g} s breaks the order of the rows beside it"
        if _fits(points, row, bad):
            findings.append(Finding("warning", place(row), f"{words}: the place is used, since it lies between its neighbours"))
        else:
            keep[row] = False
            findings.append(Finding("warning", place(row), f"{words}: the row is left out; expected times that never go back"))
    return Order(keep, _few(findings))


def _unordered(good: NDArray[np.bool_]) -> bool:
    return int(np.count_nonzero(~good)) > max(_MOST_BREAK * len(good), min(_FEW_BREAK, len(good) / 3))


def _breaks(good: NDArray[np.bool_], follows: Callable[[int, int], bool]) -> tuple[set[int], list[int]]:
    """Rows without which the others go on, and the steps that stay broken; `good` (n - 1,) tells of each step whether it is in order."""
    last = len(good)
    bad: set[int] = set()
    jumps: list[int] = []
    for k in np.flatnonzero(~good).tolist():
        if k in bad or k + 1 in bad:
            continue
        for run in range(1, _LONGEST_RUN + 1):
            after, before = range(k + 1, k + run + 1), range(k - run + 1, k + 1)
            if (k + run < last and follows(k, k + run + 1)) or k + run == last:
                bad.update(after)
                break
            if (k - run >= 0 and k - run not in bad and follows(k - run, k + 1)) or k - run == -1:
                bad.update(before)
                break
        else:
            jumps.append(k)
    return bad, jumps


def _fits(points: Floats, row: int, bad: set[int]) -> bool:
    """Whether the place of a row in the middle lies between its neighbours."""
    if row in (0, len(points) - 1) or {row - 1, row + 1} & bad:
        return False
    a, b, c = points[row - 1 : row + 2]
    way, chord = float(np.hypot(*(b - a)) + np.hypot(*(c - b))), float(np.hypot(*(c - a)))
    return way <= (1.0 + _SHARE) * chord


def _way(points: Floats) -> Floats:
    return np.hypot(*np.diff(points, axis=0).T)


def _grain(stations: Floats) -> float:
    """What the stations are rounded to, at most 1."""
    for grain in (1.0, 0.1, 0.01):
        if np.all(np.abs(stations / grain - np.round(stations / grain)) < 1e-6 * np.maximum(np.abs(stations / grain), 1.0)):
            return grain
    return 0.0


def _few(findings: list[Finding]) -> list[Finding]:
    """The first ones, and how many more there are."""
    if len(findings) <= _NAMED:
        return findings
    more = len(findings) - _NAMED
    last = findings[_NAMED - 1]
    return [*findings[: _NAMED - 1], Finding(last.severity, last.place, f"{last.message} (and {more} more rows after it)")]
