"""What bounds the speed along a path: posted limits, the car, its passengers.

The bounds at a station hold for the whole of the two intervals beside it. Since speed squared is linear between stations, a profile that keeps
them at the stations keeps the limits everywhere between.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from roads.curve import curvature_of

from ..errors import PlanningError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from powertrain import Vehicle
    from roads import Road

    from ..path import Path

    Floats = NDArray[np.float64]

#: Curvature and posted limits are looked up this densely, m, and at least so often per piece of the path.
_LOOK, _LEAST_SAMPLES = 0.1, 32


@dataclass(frozen=True, eq=False)
class SpeedLimits:
    """Bounds on speed, acceleration and force along a path.

    Attributes:
        vehicle: the car.
        name: of the road, for messages.
        s: (n,) equally spaced stations on the path, m.
        z: (n,) heights, m.
        v_posted: (n,) bound by road and car, m/s.
        v_lateral: (n,) bound by lateral acceleration in bends, m/s.
        acceleration: largest, m/s^2.
        deceleration: largest, m/s^2, positive.
        closed: the end speed equals the start speed, both free.
        start_speed: m/s, on open roads.
        end_speed: m/s, on open roads.
    """

    vehicle: Vehicle
    name: str
    s: Floats
    z: Floats
    v_posted: Floats
    v_lateral: Floats
    acceleration: float
    deceleration: float
    closed: bool
    start_speed: float = 0.0
    end_speed: float = 0.0

    @classmethod
    def along(cls, road: Road, path: Path, vehicle: Vehicle, *, step: float = 2.0, start_speed: float = 0.0, end_speed: float = 0.0) -> SpeedLimits:
        """The limits of `vehicle` on `path` along `road` at stations about `step` (m) apart.

        Raises:
            PlanningError: a start or end speed above the limit there.
        """
        count = max(int(np.ceil(path.curve.length / step)), 4)
        s = np.linspace(0.0, path.curve.length, count + 1)
        at, kappa = _curvature_samples(path)
        own = vehicle.limits
        posted = np.minimum(road.speed_limit_at(path.road_station(at)), own.speed_max_mps)
        lateral = np.sqrt(own.lateral_acceleration_max_mps2 / np.maximum(np.abs(kappa), 1e-6))
        limits = cls(
            vehicle,
            road.name,
            s,
            road.height_at(path.road_station(s)),
            _least_beside(s, at, posted, road.closed),
            _least_beside(s, at, lateral, road.closed),
            own.acceleration_max_mps2,
            own.deceleration_max_mps2,
            road.closed,
            start_speed,
            end_speed,
        )
        for end, speed, at in (("start", start_speed, 0), ("end", end_speed, -1)):
            if not road.closed and not 0.0 <= speed <= limits.v_max[at]:
                raise PlanningError(f"{road.name}: {end} speed {speed:g} m/s, expected 0 to {limits.v_max[at]:.2f} m/s there")
        return limits

    @property
    def ds(self) -> float:
        """Distance of the stations, m."""
        return float(self.s[1] - self.s[0])

    @property
    def v_max(self) -> Floats:
        """(n,) bound on speed, m/s."""
        return np.minimum(self.v_posted, self.v_lateral)

    @property
    def energy_max(self) -> Floats:
        """(n,) bound on v^2/2 in m^2/s^2, with start and end speeds of open roads put in."""
        bound = 0.5 * self.v_max**2
        if not self.closed:
            bound[0], bound[-1] = 0.5 * self.start_speed**2, 0.5 * self.end_speed**2
        return bound

    def scaled(self, factor: float) -> SpeedLimits:
        """The limits with posted speeds and accelerations times `factor` (V2); bends and given end speeds stay."""
        slower = replace(self, v_posted=self.v_posted * factor, acceleration=self.acceleration * factor, deceleration=self.deceleration * factor)
        return replace(slower, start_speed=min(self.start_speed, float(slower.v_max[0])), end_speed=min(self.end_speed, float(slower.v_max[-1])))


def _curvature_samples(path: Path) -> tuple[Floats, Floats]:
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


def _least_beside(s: Floats, at: Floats, values: Floats, closed: bool) -> Floats:
    """At each station of `s` the least of the `values` found `at` stations in the two intervals beside it."""
    interval = np.clip(np.searchsorted(s, at, side="right") - 1, 0, len(s) - 2)
    least = np.full(len(s) - 1, np.inf)
    np.minimum.at(least, interval, values)
    # a sample just outside an interval bounds it too: what lies between the two samples is in both
    np.minimum.at(least, interval[1:], values[:-1])
    np.minimum.at(least, interval[:-1], values[1:])
    before = np.concatenate([least[-1:] if closed else least[:1], least])
    after = np.concatenate([least, least[:1] if closed else least[-1:]])
    return np.minimum(before, after)
