"""The line that was driven, out of scattered places: a curve that changes its bend as little as the places allow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..errors import RoadError
from ..geometry.curve import PlanarCurve
from .spline import Smoother, cross_validated, noise_of, within

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

#: Noise below this leaves the points as they are, m.
QUIET = 0.05
#: Anchors are this many times the noise apart, and at least this many typical steps: a step from one to the next then has a direction.
_NOISES, _STEPS = 4.0, 1.5
#: Distance of the curve's knots: this share of the distance of the places, within these bounds, m.
_SHARE, _CLOSEST, _WIDEST = 0.5, 1.0, 10.0
#: Rounds of finding where along the curve each place lies.
_ROUNDS = 3
#: Of a circuit the places up to this way before the start and after the end are wound on, m.
_WRAP = 300.0
#: A line that is longer than the way along the anchors by this factor swings about.
_LONGEST = 1.3


@dataclass(frozen=True, eq=False)
class Line:
    """A smoothed line.

    Attributes:
        points: (m, 2) places along it, m.
        station: (n,) where along it each recorded place lies, m; not always increasing.
        off: (n,) how far from it, m, positive to the left.
        noise: standard deviation of the recorded places across the line, m.
    """

    points: Floats
    station: Floats
    off: Floats
    noise: float


@dataclass(frozen=True, eq=False)
class Anchors:
    """Places far enough apart for a direction.

    Attributes:
        places: (k, 2) means of the places that belong to each, m.
        owner: (n,) the anchor of each place.
    """

    places: Floats
    owner: Ints

    @property
    def station(self) -> Floats:
        """(k,) distance along the polyline of the anchors, m."""
        return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(self.places, axis=0).T))])


def apart(points: Floats, step: float) -> float:
    """How far apart anchors lie, m."""
    return max(_NOISES * noise_of(points), _STEPS * step, _CLOSEST)


def anchors(points: Floats, distance: float) -> Anchors:
    """Anchors of `points` (n, 2) that are left when the next place is `distance` (m) away from the first one of theirs."""
    owner = np.zeros(len(points), dtype=np.intp)
    begin, number = 0, 0
    while True:
        # looked for in pieces, so that a long way costs its length
        at, size = begin + 1, 64
        while at < len(points):
            far = np.flatnonzero(np.hypot(*(points[at : at + size] - points[begin]).T) >= distance)
            if len(far):
                at += int(far[0])
                break
            at, size = at + size, 2 * size
        owner[begin:at] = number
        if at >= len(points):
            break
        begin, number = at, number + 1
    count = np.bincount(owner)
    places = np.column_stack([np.bincount(owner, points[:, axis]) / count for axis in range(2)])
    return Anchors(places, owner)


def smoothed_line(points: Floats, step: float, accuracy: float | None, *, closed: bool) -> Line | None:
    """The line through `points` (n, 2); None where there is too little to tell noise from a way.

    Args:
        points: recorded places in their order, m.
        step: typical distance from place to place, m.
        accuracy: root mean square distance of the places from the line, m; None: the smoothness that foretells places best.
        closed: whether the last place is followed by the first.
    """
    lead = 0
    if closed:
        way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
        reach = min(_WRAP, 0.4 * float(way[-1]))
        lead, tail = len(points) - int(np.searchsorted(way, way[-1] - reach)), int(np.searchsorted(way, reach)) + 1
        points = np.vstack([points[len(points) - lead :], points, points[:tail]])
        inner = slice(lead, len(points) - tail)
    else:
        inner = slice(0, len(points))
    found = anchors(points, apart(points, step))
    if len(found.places) < 4:
        return None
    u = _along(points, found)
    spacing = float(np.clip(_SHARE * max(step, found.station[-1] / len(points)), _CLOSEST, _WIDEST))
    off = np.zeros(len(points))
    curve = PlanarCurve.through(_distinct(found.places))
    lam = 0.0
    for number in range(_ROUNDS):
        weight = _evened(u, found.station[-1] / len(found.places))
        smoother = Smoother(u, points, spacing, 3, weight, sharp=True)
        if accuracy is None and number < _ROUNDS - 1:
            lam = cross_validated(u, points, spacing, 3, weight, sharp=True)
        fit = smoother.fit(lam) if accuracy is None else within(smoother, accuracy)
        start, end = float(np.min(u)), float(np.max(u))
        fine = np.linspace(start, end, max(int(np.ceil((end - start) / min(spacing, 5.0))), 3) + 1)
        curve = PlanarCurve.through(_distinct(fit(fine)))
        if curve.length > _LONGEST * float(found.station[-1]) + 10.0 * spacing:
            asked = "" if accuracy is None else f" within {accuracy:g} m"
            raise RoadError(
                f"no smooth line leads along the places{asked}: it would be {curve.length:.0f} m long, they are {found.station[-1]:.0f} m"
            )
        near = (u - start) / (end - start) * curve.length
        u, off = curve.project(points, near)
    return _cut(curve, u, off, inner, spacing, closed=closed)


def _cut(curve: PlanarCurve, u: Floats, off: Floats, inner: slice, spacing: float, *, closed: bool) -> Line:
    """The line from the first recorded place to the last; of a circuit to where the first one comes again."""
    first = float(u[inner.start]) if closed else float(np.min(u))
    last = float(u[inner.stop]) if closed else float(np.max(u))
    count = max(int(np.ceil((last - first) / min(spacing, 5.0))), 3)
    s = np.linspace(first, last, count + 1)
    points = curve.position(s[:-1] if closed else s)
    spread = off[inner]
    return Line(points, u[inner] - first, spread, float(np.sqrt(np.mean(spread**2))))


def _distinct(points: Floats) -> Floats:
    """Places without near repetitions."""
    keep = np.append(True, np.hypot(*np.diff(points, axis=0).T) > 1e-6)
    return points[keep]


def _along(points: Floats, found: Anchors) -> Floats:
    """Where (n,) along the polyline of the anchors each place lies: on one of the pieces about its own anchor; beyond the ends straight on."""
    pieces = len(found.places) - 1
    station = found.station
    best, u = np.full(len(points), np.inf), np.zeros(len(points))
    for shift in (-2, -1, 0, 1):
        k = np.clip(found.owner + shift, 0, pieces - 1)
        a, move = found.places[k], found.places[k + 1] - found.places[k]
        length = np.maximum(np.hypot(*move.T), 1e-9)
        along = np.sum((points - a) * move, axis=1) / length
        along = np.clip(along, np.where(k == 0, -np.inf, 0.0), np.where(k == pieces - 1, np.inf, length))
        distance = np.hypot(*(a + (along / length)[:, None] * move - points).T)
        nearer = distance < best
        best, u = np.where(nearer, distance, best), np.where(nearer, station[k] + along, u)
    return u


def _evened(u: Floats, window: float) -> Floats:
    """Weights (n,) that let a place where the car stood count no more than others: by how many lie about it."""
    cell = np.floor((u - float(np.min(u))) / max(window, 1e-6)).astype(np.intp)
    count = np.bincount(cell)
    return np.minimum(1.0, float(np.median(count[count > 0])) / count[cell])
