"""Where the car is in the coordinates of its path."""

from __future__ import annotations

import math
from bisect import bisect_right
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from ..trajectory.pieces import TrajectoryPoint
from .smooth import SmoothSpeed

if TYPE_CHECKING:
    from ..motion import VehicleState
    from ..trajectory.trajectory import Trajectory

How = Literal["tipi", "newton", "window", "global", "outside"]

#: Least 1 - kappa e_y that anything is divided by; it vanishes at the centre of curvature.
DOMAIN_MIN = 0.2


class Projected(NamedTuple):
    """The car on its path. Errors are car minus path in the path's frame at `s`.

    Attributes:
        s: station, m; counts on over the laps of a closed path.
        e_x: ahead of the point at `s` along its tangent, m; about zero, except beyond the ends, outside the domain and with `tipi`.
        e_y: offset along the path's normal, m, positive to the left.
        e_psi: heading, rad, -pi to pi.
        sdot: speed of the station, m/s.
        ahead: velocity of the centre of gravity along the path's tangent, m/s.
        how: the way that `s` was found.
        point: the trajectory at `s`.
        end: an open path and the car lies before its start or behind its end.
        kappa_rate: change of curvature along the path, 1/m^2.
        to_go: way left to the end of an open path, m; infinite on closed ones.
        v, a: averaged over a short way, see `SmoothSpeed`, m/s and m/s^2.
    """

    s: float
    e_x: float
    e_y: float
    e_psi: float
    sdot: float
    ahead: float
    how: How
    point: TrajectoryPoint[float]
    end: bool = False
    kappa_rate: float = 0.0
    to_go: float = math.inf
    v: float | None = None
    a: float | None = None

    @property
    def speed(self) -> tuple[float, float]:
        """The averaged speed (m/s) and acceleration (m/s^2) that are wanted here; the trajectory's own where nobody averaged."""
        point = self.point
        return (point.v, point.a) if self.v is None or self.a is None else (self.v, self.a)


class Line:
    """A trajectory as a projection uses it: open ends clamp, closed ones wrap, and the curvature has a slope."""

    def __init__(self, trajectory: Trajectory) -> None:
        self.trajectory = trajectory
        self.first, self.last, self.closed = float(trajectory.s[0]), float(trajectory.s[-1]), trajectory.closed
        self.length = self.last - self.first
        self._smooth = SmoothSpeed(trajectory)
        self._stations = trajectory.s.tolist()
        rates = (np.diff(trajectory.kappa) / np.diff(trajectory.s)).tolist()
        # the last station belongs to the interval before it, on closed tracks to the first
        self._rates = [*rates, rates[0] if self.closed else rates[-1]]

    def inside(self, s: float) -> float:
        """`s`, or the nearer end of an open path."""
        return s if self.closed else min(max(s, self.first), self.last)

    def point(self, s: float) -> TrajectoryPoint[float]:
        """The trajectory at `s`, which must be `inside`."""
        return self.trajectory.point(s)

    def distance(self, state: VehicleState) -> float:
        """From the car to the nearest of the trajectory's stations, m."""
        path = self.trajectory
        return math.sqrt(float(np.min((path.x - state.x) ** 2 + (path.y - state.y) ** 2)))

    def kappa_rate(self, s: float) -> float:
        """Mean slope of the curvature over the interval of `s`, 1/m^2."""
        if self.closed and not self.first <= s <= self.last:
            s = self.first + (s - self.first) % self.length
        return self._rates[bisect_right(self._stations, s, 1) - 1]

    def projected(self, state: VehicleState, point: TrajectoryPoint[float], offsets: tuple[float, float], how: How) -> Projected:
        """The car seen from `point` with its `offsets_from` there; `sdot` is that of the exact projection."""
        e_x, e_y = offsets
        e_psi = math.remainder(state.psi - point.psi, math.tau)
        ahead = state.v_x * math.cos(e_psi) - state.v_y * math.sin(e_psi)
        end, s = False, point.s
        if not self.closed:
            end = (s <= self.first and e_x < 0.0) or (s >= self.last and e_x > 0.0)
        sdot = ahead / max(1.0 - point.kappa * e_y, DOMAIN_MIN)
        to_go = math.inf if self.closed else self.last - s
        return Projected(s, e_x, e_y, e_psi, sdot, ahead, how, point, end, self.kappa_rate(s), to_go, *self._smooth.at(s, point.v, point.a))


def offsets_from(point: TrajectoryPoint[float], state: VehicleState) -> tuple[float, float]:
    """Place of the car in the path's frame at `point`: m ahead and m to the left."""
    cos, sin = math.cos(point.psi), math.sin(point.psi)
    dx, dy = state.x - point.x, state.y - point.y
    return dx * cos + dy * sin, dy * cos - dx * sin
