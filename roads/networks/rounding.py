"""Corners of a line that is driven, rounded so that a car can steer round them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..borders import way_along
from ..geometry.curve import PlanarCurve

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

#: Bends tighter than this are rounded where they can be, m; what is rounded has at least the second one.
TIGHT, ROUNDED = 2.6, 4.0
#: Corners of a polyline turn by more than this, rad, between pieces longer than this, m: what turns less is a curve drawn in pieces.
TURN, LEG = 0.35, 3.0
#: A corner is rounded from the first to the second distance before and after it, m, and cut off by no more than the third.
LEAST, REACH, OFF = 0.1, 25.0, 2.4
#: Directions before and after a corner are those of stretches of at most this length, m.
STRETCH = 1.0
#: Tight places closer than this are one corner, m.
ONE = 2.0
#: Sharp bends that turn the line by less than this are unevenness of its points, rad.
SLIGHT = 0.01
#: Points of a rounded corner are so close, m.
FINE = 0.25


def rounded(line: Floats, *, again: bool = False) -> Floats:
    """`line` (n, 2 + k) with corners that the spline through its points would turn too sharply drawn anew; further columns are led along.

    What cannot be rounded stays as it is; `again` takes corners that are close to each other as one, and cuts them off by more.
    """
    one, off = (3.0 * ONE, 2.0 * OFF) if again else (ONE, OFF)
    for begin, end in _tight(line, one)[::-1]:
        made = _corner(line, begin, end, off)
        if made is not None:
            line = made
    return line


def with_corners(line: Floats) -> Floats:
    """`line` with further points beside its corners, at doubling distances, so that the spline through them does not swing out of the legs."""
    step = np.diff(line[:, :2], axis=0)
    length = np.hypot(*step.T)
    turn = np.abs(np.arctan2(step[:-1, 0] * step[1:, 1] - step[:-1, 1] * step[1:, 0], np.sum(step[:-1] * step[1:], axis=1)))
    corner = np.concatenate([[False], turn > TURN, [False]])
    marks = [np.arange(len(line), dtype=np.float64)]
    doubling = 2.0 ** np.arange(20) - 0.5
    for k in np.flatnonzero(length > LEG).tolist():
        reach = doubling[doubling < 0.5 * length[k]] / length[k]
        if corner[k]:
            marks.append(k + reach)
        if corner[k + 1]:
            marks.append(k + 1.0 - reach)
    if len(marks) == 1:
        return line
    at = np.unique(np.concatenate(marks))
    return np.column_stack([np.interp(at, marks[0], column) for column in line.T])


def _tight(line: Floats, one: float) -> list[tuple[float, float]]:
    """Stretches of the line, m along it, that its spline turns too sharply on."""
    curve = PlanarCurve.through(line[:, :2])
    s = curve.breaks_s
    shares = np.array([0.02, 0.25, 0.5, 0.75, 0.98])
    at = (s[:-1, None] + np.diff(s)[:, None] * shares).ravel()
    kappa = np.abs(curve.curvature(at))
    # the turn on the way that each place stands for
    turn = kappa * np.repeat(np.diff(s) / len(shares), len(shares))
    sharp = np.flatnonzero(kappa > 1.0 / TIGHT)
    # along the polyline
    along = np.interp(at[sharp], s, way_along(line))
    groups = np.split(np.arange(len(sharp)), np.flatnonzero(np.diff(along) > one) + 1)
    return [(float(along[part[0]]), float(along[part[-1]])) for part in groups if turn[sharp[part]].sum() > SLIGHT]


def _corner(line: Floats, begin: float, end: float, most: float) -> Floats | None:
    """The line with a smooth turn instead of the corner from `begin` to `end` (m along it); None where none is better."""
    s = way_along(line)
    best: tuple[float, Floats, float, float] | None = None
    for pad in np.geomspace(LEAST, REACH, 36).tolist():
        low, high = max(begin - pad, 0.0), min(end + pad, float(s[-1]))
        turn = _turn(line, s, low, high, min(STRETCH, 2.0 * pad))
        if turn is None:
            continue
        sharpest, made, off = turn
        if off > most:
            break
        if best is None or sharpest < best[0]:
            best = sharpest, made, low, high
        if sharpest <= 1.0 / ROUNDED:
            break
    if best is None or best[0] > _sharpest(line, s, begin, end):
        return None
    _, made, low, high = best
    return np.vstack([line[s < low - 0.5 * FINE], made, line[s > high + 0.5 * FINE]])


def _turn(line: Floats, s: Floats, low: float, high: float, stretch: float) -> tuple[float, Floats, float] | None:
    """A smooth turn from `low` to `high`: its sharpest curvature, 1/m, its points, and how far it lies off the line, m."""
    ends = _at(line, s, np.array([low, high]))
    # directions from outside the turn, at the line's ends from inside
    outside = low - stretch if low > stretch else min(low + stretch, high)
    first = np.sign(low - outside) * _unit(ends[0] - _at(line, s, np.array([outside]))[0])
    outside = high + stretch if high < s[-1] - stretch else max(high - stretch, low)
    last = np.sign(outside - high) * _unit(_at(line, s, np.array([outside]))[0] - ends[1])
    chord = ends[1, :2] - ends[0, :2]
    far = float(np.hypot(*chord))
    angle = abs(float(np.arctan2(first[0] * last[1] - first[1] * last[0], first @ last)))
    if far < 1e-3 or angle > 3.0:
        return None
    # the handles of a circle's arc
    handle = far * (2.0 / 3.0 * np.tan(0.25 * angle) / np.sin(0.5 * angle) if angle > 1e-3 else 1.0 / 3.0)
    count = max(int(far / FINE), 8)
    u = np.linspace(0.0, 1.0, count + 1)[:, None]
    a, b, c, d = ends[0, :2], ends[0, :2] + handle * first, ends[1, :2] - handle * last, ends[1, :2]
    place = (1 - u) ** 3 * a + 3 * (1 - u) ** 2 * u * b + 3 * (1 - u) * u**2 * c + u**3 * d
    rate = 3 * (1 - u) ** 2 * (b - a) + 6 * (1 - u) * u * (c - b) + 3 * u**2 * (d - c)
    bend = 6 * (1 - u) * (c - 2 * b + a) + 6 * u * (d - 2 * c + b)
    speed = np.hypot(*rate.T)
    if speed.min() < 1e-2 * far:
        return None
    kappa = np.abs(rate[:, 0] * bend[:, 1] - rate[:, 1] * bend[:, 0]) / speed**3
    old = _at(line, s, np.linspace(low, high, 41))
    off = float(np.max(np.min(np.hypot(*(old[:, None, :2] - place[None]).transpose(2, 0, 1)), axis=1)))
    run = way_along(place)
    rest = _at(line, s, low + (high - low) * run / run[-1])
    rest[:, :2] = place
    return float(kappa.max()), rest, off


def _sharpest(line: Floats, s: Floats, begin: float, end: float) -> float:
    """The sharpest curvature from `begin` to `end` as the line is, 1/m."""
    low, high = max(np.searchsorted(s, begin) - 20, 0), min(np.searchsorted(s, end) + 20, len(s) - 1)
    curve = PlanarCurve.through(line[low : high + 1, :2])
    ends = np.interp([begin, end], s[low : high + 1], curve.breaks_s)
    at = np.linspace(float(ends[0]), float(ends[1]), max(int((ends[1] - ends[0]) / 0.01), 40))
    return float(np.max(np.abs(curve.curvature(at))))


def _at(line: Floats, s: Floats, where: Floats) -> Floats:
    return np.column_stack([np.interp(where, s, column) for column in line.T])


def _unit(move: Floats) -> Floats:
    return move[:2] / max(float(np.hypot(move[0], move[1])), 1e-12)
