"""The intervals of the joint problem: pieces of the path's spline between stations of the road at which the speed is a variable."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..path.problem.spline import PER_KNOT

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from powertrain import Vehicle
    from roads import Road

    from ..path import CurvatureProblem

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

#: Posted limits are looked up this densely, m.
_LOOK = 0.1
#: Places per interval at which peaks of lateral acceleration are sought, by how much they may pass the bound, and the shortest interval, m.
_DENSE, _PEAK, _SHORTEST = 8, 1.02, 0.25
#: Places per interval: start, middle, end.
PLACES = 3


@dataclass(frozen=True, eq=False)
class Grid:
    """Where path and speed meet. Stations are those of the road, so that posted limits and heights depend on no variable.

    Attributes:
        q: (m + 1,) stations of the road at which the speed is a variable, m.
        columns: (m, 6) indices of the path variables that each interval depends on.
        first: (m, 3, 2, 6) first derivative of the path by the station at start, middle and end, by those variables.
        first_constant: (m, 3, 2) and the part that no variable changes.
        second: (m, 3, 2, 6) second derivative.
        z: (m + 1,) heights, m.
        v_posted: (m + 1,) bound on the speed by road and car, holding for both intervals beside, m/s.
    """

    q: Floats
    columns: Ints
    first: Floats
    first_constant: Floats
    second: Floats
    z: Floats
    v_posted: Floats

    @classmethod
    def of(cls, problem: CurvatureProblem, road: Road, vehicle: Vehicle, parts: Ints) -> Grid:
        """Every piece of the spline in as many equal intervals as `parts` (pieces,) says."""
        spline = problem.spline
        width = np.diff(spline.breaks)
        piece = np.repeat(np.arange(len(parts)), parts)
        share = (np.arange(len(piece)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[piece]
        start = spline.breaks[piece] + share * width[piece]
        q = np.append(start, spline.breaks[-1])
        places = start[:, None] + np.diff(q)[:, None] * np.linspace(0.0, 1.0, PLACES)
        segment = np.repeat(piece, PLACES)
        first, second = (spline.basis(places.ravel(), order, segment) for order in (1, 2))
        return cls(
            q,
            spline.columns[piece],
            first.matrix.reshape(-1, PLACES, 2, 2 * PER_KNOT),
            first.constant.reshape(-1, PLACES, 2),
            second.matrix.reshape(-1, PLACES, 2, 2 * PER_KNOT),
            road.height_at(q),
            _posted(road, vehicle, q),
        )

    @property
    def count(self) -> int:
        """Number of intervals."""
        return len(self.columns)

    @property
    def dq(self) -> Floats:
        """(m,) lengths of the intervals along the road's reference, m."""
        return np.diff(self.q)

    def table(self) -> Floats:
        """(80, m) numbers that `interval.Interval` needs of every interval: `dq`, rise, and the maps onto the path's derivatives."""
        rows = [self.dq[:, None], np.diff(self.z)[:, None]]
        rows += [values.reshape(self.count, -1) for values in (self.first, self.first_constant, self.second)]
        return np.concatenate(rows, axis=1).T

    def derivatives(self, x: Floats) -> tuple[Floats, Floats]:
        """First and second derivative (m, 3, 2) of the path by the station of the road."""
        local = x[self.columns][:, None, :, None]
        return np.matmul(self.first, local)[..., 0] + self.first_constant, np.matmul(self.second, local)[..., 0]

    def lengths(self, x: Floats) -> Floats:
        """(m,) lengths of the path over the intervals by Simpson's rule, m."""
        first, _ = self.derivatives(x)
        return self.dq * (np.hypot(first[..., 0], first[..., 1]) @ np.array([1.0, 4.0, 1.0])) / 6.0

    def curvatures(self, x: Floats) -> Floats:
        """(m, 3) curvature at start, middle and end of the intervals, 1/m."""
        p, b = self.derivatives(x)
        return (p[..., 0] * b[..., 1] - p[..., 1] * b[..., 0]) / np.hypot(p[..., 0], p[..., 1]) ** 3


def equal_parts(problem: CurvatureProblem, step: float) -> Ints:
    """(pieces,) in how many intervals of at most `step` (m) each piece of the spline is cut."""
    return np.maximum(np.ceil(np.diff(problem.spline.breaks) / step - 1e-9).astype(int), 1)


def finer_parts(problem: CurvatureProblem, parts: Ints, x: Floats, square: Floats, bound: float) -> Ints:
    """The parts with those pieces halved in which the lateral acceleration exceeds `bound` (m/s^2) between the places where it is kept.

    On the inside of a tight bend, where normals of the road run together, curvature may peak between two of them.

    Args:
        problem: the spline.
        parts: (pieces,) what was used.
        x: (3n,) the path.
        square: (m + 1,) squared speeds at the stations of the grid, m^2/s^2.
        bound: on lateral acceleration, m/s^2.
    """
    spline = problem.spline
    width = np.diff(spline.breaks)
    piece = np.repeat(np.arange(len(parts)), parts)
    first = np.cumsum(parts) - parts
    inner = (np.arange(_DENSE) + 0.5) / _DENSE
    share = ((np.arange(len(piece)) - first[piece])[:, None] + inner) / parts[piece][:, None]
    segment = np.repeat(piece, _DENSE)
    places = (spline.breaks[piece][:, None] + share * width[piece][:, None]).ravel()
    p, b = (spline.values(spline.basis(places, order, segment), x) for order in (1, 2))
    kappa = (p[:, 0] * b[:, 1] - p[:, 1] * b[:, 0]) / np.hypot(p[:, 0], p[:, 1]) ** 3
    speed = (square[:-1, None] + np.diff(square)[:, None] * inner).ravel()
    beyond = np.zeros(len(parts), dtype=bool)
    np.logical_or.at(beyond, segment, np.abs(kappa) * speed > bound * _PEAK)
    return np.where(beyond & (width > 2.0 * _SHORTEST * parts), 2 * parts, parts)


def _posted(road: Road, vehicle: Vehicle, q: Floats) -> Floats:
    """(m + 1,) least bound in the two intervals beside each station, m/s."""
    count = np.maximum(np.ceil(np.diff(q) / _LOOK).astype(int), 2)
    interval = np.repeat(np.arange(len(count)), count + 1)
    inner = np.arange(len(interval)) - np.repeat(np.cumsum(count + 1) - count - 1, count + 1)
    at = q[interval] + np.diff(q)[interval] * inner / count[interval]
    least = np.full(len(count), np.inf)
    np.minimum.at(least, interval, np.minimum(road.speed_limit_at(at), vehicle.limits.speed_max_mps))
    before = np.concatenate([least[-1:] if road.closed else least[:1], least])
    after = np.concatenate([least, least[:1] if road.closed else least[-1:]])
    return np.minimum(before, after)
