"""What lies along a path, looked up densely and gathered at stations."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from roads.geometry.curve import curvature_of

from ...errors import PlanningError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from roads import Road

    from ...path import Path

    Floats = NDArray[np.float64]

#: Curvature and posted limits are looked up this densely, m, and at least so often per piece of the path.
_LOOK, _LEAST_SAMPLES = 0.1, 32
#: How far a slope inside an interval counts beyond the mean one.
_KINK = 0.02
#: Samples of the paths that are in use; a path that nobody holds any more takes them along.
_SAMPLED: WeakKeyDictionary[Path, tuple[Floats, Floats]] = WeakKeyDictionary()
#: Stations closer than this to one that is asked for give way to it, as a share of the step.
_CLOSE = 0.25


@dataclass(frozen=True, eq=False)
class Samples:
    """The path looked at densely.

    Attributes:
        s: (m,) places on the path, m.
        kappa: (m,) curvature, 1/m.
        bank: (m,) rad.
        friction: (m,) share of dry asphalt.
        posted: (m,) limit, m/s.
    """

    s: Floats
    kappa: Floats
    bank: Floats
    friction: Floats
    posted: Floats


@dataclass(frozen=True, eq=False)
class Ground:
    """What lies along a path.

    Attributes:
        s: (n,) stations, m.
        z: (n,) heights, m.
        bank: (n,) superelevation, rad, positive where the left side is higher.
        closed: a circuit; the last station is the first again.
        samples: the same looked at densely.
        slopes: (2, n-1) largest and least slope dz/ds found anywhere in each interval, at most 2 % off its mean (kinks of height data count for no
            more, else a car could not drive over one with constant acceleration); None: the mean ones.
    """

    s: Floats
    z: Floats
    bank: Floats
    closed: bool
    samples: Samples
    slopes: Floats | None = None

    def least_beside(self, values: Floats) -> Floats:
        """(n,) at each station the least of the sampled `values` (m,) in the two intervals beside it."""
        least = self.least_within(values)
        before = np.concatenate([least[-1:] if self.closed else least[:1], least])
        after = np.concatenate([least, least[:1] if self.closed else least[-1:]])
        return np.minimum(before, after)

    def least_within(self, values: Floats) -> Floats:
        """(n-1,) the least of the sampled `values` (m,) in each interval; a sample just outside bounds it too."""
        interval = np.clip(np.searchsorted(self.s, self.samples.s, side="right") - 1, 0, len(self.s) - 2)
        least = np.full(len(self.s) - 1, np.inf)
        np.minimum.at(least, interval, values)
        np.minimum.at(least, interval[1:], values[:-1])
        np.minimum.at(least, interval[:-1], values[1:])
        return least


def ground_along(road: Road, path: Path, step: float, through: Sequence[float] = ()) -> Ground:
    """What lies along `path`, at stations at most `step` (m) apart, among which are those in `through`.

    Raises:
        PlanningError: a step out of range, a station that is not on the path.
    """
    length = path.curve.length
    if not 0.01 <= step <= 1000.0:
        raise PlanningError(f"{road.name}: {step} m between stations, expected 0.01 to 1000 m")
    s = stations(road.name, length, step, through)
    at, kappa = _curvature_samples(path)
    across = path.road_station(at)
    samples = Samples(at, kappa, road.bank_at(across), road.friction_at(across), road.speed_limit_at(across))
    own = path.road_station(s)
    ground = Ground(s, road.height_at(own), road.bank_at(own), road.closed, samples)
    if np.ptp(ground.z) == 0.0:
        return ground
    height = road.height_at(across)
    rise = np.diff(height) / np.maximum(np.diff(at), 1e-9)
    long = np.diff(at) > 1e-6
    interval = np.clip(np.searchsorted(s, at, side="right") - 1, 0, len(s) - 2)
    slopes = np.array([np.diff(ground.z) / np.diff(s)] * 2)
    for ends in (interval[:-1][long], interval[1:][long]):
        np.maximum.at(slopes[0], ends, rise[long])
        np.minimum.at(slopes[1], ends, rise[long])
    mean = np.diff(ground.z) / np.diff(s)
    return replace(ground, slopes=np.clip(slopes, mean - _KINK, mean + _KINK))


def stations(name: str, length: float, step: float, through: Sequence[float]) -> Floats:
    """(n,) stations from 0 to `length`, at most `step` apart and evenly between the ones asked for.

    Raises:
        PlanningError: a station asked for is not on the path.
    """
    for station in through:
        if not 0.0 <= station <= length:
            raise PlanningError(f"{name}: station {station:g} m asked for, expected 0 to {length:.1f} m")
    marks = np.unique(np.concatenate([[0.0, length], np.asarray(through, dtype=np.float64)]))
    # marks closer than a part of the step would make intervals that no solver likes; the ends of the path stay
    keep = np.append(True, np.diff(marks) > min(_CLOSE * step, 0.1))
    if not keep[-1]:
        keep[-1] = True
        keep[np.flatnonzero(keep)[-2]] = np.sum(keep) == 2
    marks = marks[keep]
    least = 4 if len(marks) == 2 else 2
    pieces = [np.linspace(a, b, max(int(np.ceil((b - a) / step)), least) + 1)[:-1] for a, b in pairwise(marks)]
    return np.append(np.concatenate(pieces), length)


def _curvature_samples(path: Path) -> tuple[Floats, Floats]:
    """As `_sampled`, once for each path: many cars and requests drive the same one."""
    if path not in _SAMPLED:
        for values in (found := _sampled(path)):
            values.setflags(write=False)
        _SAMPLED[path] = found
    return _SAMPLED[path]


def _sampled(path: Path) -> tuple[Floats, Floats]:
    """Stations and curvatures along the path, dense enough that a peak between two samples is less than 0.1 % higher.

    Samples are equally spaced over the parameter of each piece. Knots are among them, since curvature has kinks there; where knots lie close on the
    path because normals of the road run together, curvature changes fastest and the samples lie as close.
    """
    curve = path.curve
    breaks = curve.pieces.breaks
    parts = np.maximum(np.ceil(np.diff(curve.breaks_s) / _LOOK).astype(int), _LEAST_SAMPLES)
    piece = np.repeat(np.arange(len(parts)), parts)
    part = np.arange(len(piece)) - np.repeat(np.cumsum(parts) - parts, parts)
    u = np.append(breaks[piece] + np.diff(breaks)[piece] * part / parts[piece], breaks[-1])
    return curve.station(u), curvature_of(curve.pieces, u)
