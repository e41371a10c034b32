"""From times at scattered places to one drive along the line: where the car was, how fast, and where it stood."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..geometry.curve import read_only
from ..recorded import Recorded
from .spline import Smoother, cross_validated

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]

#: Slower for at least this long is a stop: m/s, s.
STILL, SHORTEST_STOP = 0.5, 3.0
#: A gap in time of at least this, and so many typical steps, over which it hardly moved is a stop, s; it begins and ends at once, within s.
_PAUSE, _PAUSE_STEPS, _AT_ONCE = 5.0, 5.0, 0.5
#: Fewer places of a stretch give one speed.
_FEW = 8
#: A table whose speeds between two rows are below this tells of no drive, m/s.
_SLOWEST = 1e-3
#: Speeds and times of a table agree if the ways that they tell do by this share.
_AGREED = 0.05
#: No more times describe a drive, and none closer than this, s.
_MOST_TIMES, _CLOSEST = 50_000, 0.5


def recorded_drive(t: Floats, u: Floats, speed: Floats | None, length: float) -> Recorded | None:
    """The drive along a line of `length` (m); None where nothing moved.

    A receiver that does not record while it stands leaves a gap in time: what is before and after it is fitted apart, with a stop between.

    Args:
        t: (n,) times, increasing, s.
        u: (n,) stations of the recorded places on the line, m, with their noise.
        speed: (n,) recorded speeds, m/s; None: from the places alone.
        length: of the line, m.
    """
    if len(t) < 3 or length <= 0.0 or float(t[-1] - t[0]) <= 0.0:
        return None
    t = t - t[0]
    typical = float(np.median(np.diff(t)))
    step = max(typical, _CLOSEST, float(len(t)) * typical / _MOST_TIMES)
    gaps = np.flatnonzero((np.diff(t) > max(_PAUSE, _PAUSE_STEPS * typical)) & (np.abs(np.diff(u)) < STILL * np.diff(t)))
    times, speeds, stations = [], [], []
    for part in np.split(np.arange(len(t)), gaps + 1):
        if times:
            # it comes to a halt and sets off at once: nothing is known of how
            times.append(np.array([times[-1][-1] + _AT_ONCE, t[part[0]] - _AT_ONCE]))
            speeds.append(np.zeros(2))
            stations.append(np.full(2, u[part[0]]))
        grid, v = _fitted(t[part], u[part], None if speed is None else speed[part], step)
        times.append(grid)
        speeds.append(v)
        stations.append(np.interp(grid, t[part], u[part]))
    return _from_speeds(np.concatenate(times), np.concatenate(speeds), np.concatenate(stations), length)


def _fitted(t: Floats, u: Floats, speed: Floats | None, step: float) -> tuple[Floats, Floats]:
    """Times of an even grid and speeds there, of a stretch without gaps in time."""
    if len(t) < 2:
        return t, np.zeros(1)
    grid = np.linspace(t[0], t[-1], max(int(np.ceil((t[-1] - t[0]) / step)), 1) + 1)
    if speed is not None:
        return grid, np.maximum(np.interp(grid, t, speed), 0.0)
    if len(t) < _FEW:
        return grid, np.full(len(grid), max(float(u[-1] - u[0]), 0.0) / float(t[-1] - t[0]))
    weight = np.ones(len(t))
    smoother = Smoother(t, u[:, None], step, 3, weight)
    fit = smoother.fit(cross_validated(t, u[:, None], step, 3, weight, lenient=True))
    return grid, np.maximum(fit(grid, 1)[:, 0], 0.0)


def from_columns(s: Floats, t: Floats | None, v: Floats | None) -> Recorded | None:
    """The drive that a table of stations with exact times, or speeds, tells; None where it stands all the time or goes back."""
    if v is not None and t is None:
        mean = 0.5 * (v[1:] + v[:-1])
        if np.any(v < 0.0) or np.any(mean < _SLOWEST):
            return None
        t = np.concatenate([[0.0], np.cumsum(np.diff(s) / mean)])
    if t is None or len(t) < 2 or np.any(np.diff(t) <= 0.0) or np.any(np.diff(s) < 0.0):
        return None
    ds, dt = np.diff(s), np.diff(t)
    told = None if v is None else float(np.sum(0.5 * (v[1:] + v[:-1]) * dt))
    if v is None or told is None or not abs(told - float(s[-1] - s[0])) <= _AGREED * float(s[-1] - s[0]):
        # speeds that cover another way than the places do are not those of this drive
        pace = np.gradient(s, t)
        still = np.append(ds <= 0.0, False) | np.append(False, ds <= 0.0)
        pace = np.where(still, 0.0, pace)
    else:
        pace = v
    return Recorded(read_only(t - t[0]), read_only(s - s[0]), read_only(np.maximum(pace, 0.0)))


def _from_speeds(t: Floats, v: Floats, u: Floats, length: float) -> Recorded | None:
    """Speeds, stops set to zero, led through the stations of the stops and of both ends."""
    still = _lasting(v < STILL, t)
    v = np.where(still, 0.0, v)
    way = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])
    if way[-1] <= 0.0:
        return None
    # while it stands the mean of its places is where it stands; both ends are those of the line
    edges = np.flatnonzero(np.diff(np.concatenate([[False], still, [False]]).astype(int)))
    marks = [(a, float(np.median(u[a:b]))) for a, b in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)]
    known, target = [0.0], [0.0]
    for a, place in marks:
        if way[a] > known[-1] + 1.0 and target[-1] < place < length and way[-1] - way[a] > 1.0:
            known.append(float(way[a]))
            target.append(place)
    known.append(float(way[-1]))
    target.append(length)
    piece = np.clip(np.searchsorted(known, way, side="right") - 1, 0, len(known) - 2)
    factor = (np.diff(target) / np.diff(known))[piece]
    return Recorded(read_only(t), read_only(np.clip(np.interp(way, known, target), 0.0, length)), read_only(v * factor))


def _lasting(slow: Bools, t: Floats) -> Bools:
    """`slow` (k,) where it lasts."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], slow, [False]]).astype(int)))
    found = np.zeros(len(slow), dtype=bool)
    for a, b in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        if t[b - 1] - t[a] >= SHORTEST_STOP:
            found[a:b] = True
    return found
