"""What bounds the speed along a path, put together from small parts (`energy_mgr.speed.bounds.parts`), each a function over the way.

Bounds at a station hold for the whole of the two intervals beside it, bounds on force at both ends of an interval. Since speed squared is linear
between stations, a profile that keeps them at the stations keeps them everywhere between.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np

from powertrain import driving_resistance

from ...errors import InfeasibleError, PlanningError
from .stations import Ground

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from powertrain import Vehicle

    from .forces import ForceLimit

    Floats = NDArray[np.float64]


#: Stands for a bound on acceleration that is none, m/s^2.
UNLIMITED = 1e3


class Window(NamedTuple):
    """When a station may be passed, as for a light that is green for a while: times in s from the start."""

    s: float
    earliest: float = 0.0
    latest: float = np.inf


@dataclass(frozen=True, eq=False)
class Limits:
    """Bounds on speed, acceleration, force and time along a path; `SpeedLimits` puts them together.

    Attributes:
        vehicle: the car.
        name: of the road, for messages.
        ground: what lies along the path.
        speeds: bounds on speed by name, (n,) each, m/s.
        acceleration: (n-1,) largest, m/s^2.
        deceleration: (n-1,) largest, m/s^2, positive.
        forces: bounds on forces.
        brake: largest force of the friction brakes, N; zero where they are not used.
        jerk: largest magnitude, m/s^3.
        windows: when stations may be passed.
        start_speed: m/s, on open roads.
        end_speed: m/s, on open roads.
    """

    vehicle: Vehicle
    name: str
    ground: Ground
    speeds: Mapping[str, Floats]
    acceleration: Floats
    deceleration: Floats
    forces: tuple[ForceLimit, ...] = ()
    brake: float = 0.0
    jerk: float = np.inf
    windows: tuple[Window, ...] = ()
    start_speed: float = 0.0
    end_speed: float = 0.0
    scalable: tuple[str, ...] = field(default=("posted", "car"), repr=False)

    def checked(self) -> Self:
        """These limits, if they make sense.

        Raises:
            PlanningError: a speed at the start or end above a limit, a bound that is not a number or negative; named with its station.
        """
        for name, bound in self.speeds.items():
            good = bound >= 0.0
            if not np.all(good):
                at = int(np.argmin(good))
                raise PlanningError(f"{self.name}: speed limit `{name}` is {bound[at]:g} m/s at s = {self.s[at]:.1f} m, expected 0 or more")
        for what, bound in (("acceleration", self.acceleration), ("deceleration", self.deceleration)):
            if not np.all(bound > 0.0):
                at = int(np.argmin(bound > 0.0))
                raise PlanningError(f"{self.name}: {what} limit is {bound[at]:g} m/s^2 at s = {self.s[at]:.1f} m, expected more than 0")
        still = np.flatnonzero((self.energy_max[1:] <= 0.0) & (self.energy_max[:-1] <= 0.0))
        if len(still):
            at = int(still[0])
            name = self.binding(at + 1 if at + 2 < len(self.s) else at)
            raise InfeasibleError(
                f"{self.name}: limit `{name}` is 0 m/s all the way from s = {self.s[at]:.1f} to {self.s[at + 1]:.1f} m, expected more than 0 "
                "at one of them"
            )
        for end, speed, at in (("start", self.start_speed, 0), ("end", self.end_speed, -1)):
            if not self.closed and not 0.0 <= speed <= self.v_max[at]:
                raise PlanningError(
                    f"{self.name}: {end} speed {speed:g} m/s at s = {self.s[at]:.1f} m, expected 0 to {self.v_max[at]:.2f} m/s there "
                    f"(limit `{self.binding(at)}`)"
                )
        return self

    @property
    def s(self) -> Floats:
        """(n,) stations, m."""
        return self.ground.s

    @property
    def z(self) -> Floats:
        """(n,) heights, m."""
        return self.ground.z

    @property
    def bank(self) -> Floats:
        """(n,) superelevation, rad."""
        return self.ground.bank

    @property
    def closed(self) -> bool:
        """The end speed equals the start speed, both free."""
        return self.ground.closed

    @cached_property
    def ds(self) -> Floats:
        """(n-1,) distances of the stations, m."""
        return np.diff(self.s)

    @cached_property
    def slope(self) -> Floats:
        """(n-1,) dz/ds."""
        return np.diff(self.z) / self.ds

    @cached_property
    def v_max(self) -> Floats:
        """(n,) bound on speed, m/s."""
        return np.min(list(self.speeds.values()), axis=0)

    def binding(self, at: int) -> str:
        """Name of the limit that bounds the speed at station number `at`."""
        return min(self.speeds, key=lambda name: float(self.speeds[name][at]))

    @cached_property
    def energy_max(self) -> Floats:
        """(n,) bound on v^2/2 in m^2/s^2, with start and end speeds of open roads put in."""
        bound = 0.5 * self.v_max**2
        if self.closed:
            bound[0] = bound[-1] = min(bound[0], bound[-1])
        else:
            bound[0], bound[-1] = 0.5 * self.start_speed**2, 0.5 * self.end_speed**2
        return bound

    def slope_against(self, sign: int) -> Floats:
        """(n-1,) the slope in each interval that asks most of driving (+1) or of braking (-1); from station to station (0)."""
        return self.slope if self.ground.slopes is None or sign == 0 else self.ground.slopes[0 if sign > 0 else 1]

    def resistance(self, v: Floats, sign: int = 0) -> Floats:
        """(n-1,) driving resistance at speeds `v` where an interval asks most of driving (+1) or of braking (-1), or on its mean slope (0), N."""
        return driving_resistance(self.vehicle, v, self.slope_against(sign))

    def ceiling(self, v: Floats, sign: int) -> Floats:
        """(n-1,) largest acceleration (+1) or deceleration (-1) in m/s^2 that the forces allow at speeds `v` (n-1,); negative where they cannot
        hold the speed."""
        force = np.full_like(v, np.inf)
        brake = self.brake if sign < 0 else 0.0
        for limit in self.forces:
            if limit.sign == sign:
                most = limit.ceiling(self.vehicle, v, limit.data, smooth=True)
                force = np.minimum(force, most + (brake if limit.of == "motors" else 0.0))
        return (force - sign * self.resistance(v, sign)) / self.vehicle.effective_mass

    def stretch(self, s: float, last: int, start_speed: float, end_speed: float, t: float = 0.0) -> Self:
        """The limits from `s` (m) to station number `last`, entered with `start_speed` at `t` (s) and left with `end_speed` (m/s).

        The first station is at `s` itself; where the next one is closer than a quarter of its interval, it is left out and the one after it takes
        over its bound on speed.
        """
        first = int(np.clip(np.searchsorted(self.s, s, side="right") - 1, 0, last - 2))
        # a stop line stays however close it is
        skip = self.s[first + 1] - s < 0.25 * self.ds[first] and self.v_max[first + 1] > 0.0
        at = np.concatenate([[first], np.arange(first + (2 if skip else 1), last + 1)])
        rows = np.concatenate([[first + (1 if skip else 0)], at[1:-1]])
        slopes = None if self.ground.slopes is None else self.ground.slopes[:, rows]
        ground = Ground(np.append(s, self.s[at[1:]]), self.z[at], self.bank[at], False, self.ground.samples, slopes)
        ground.z[0] = np.interp(s, self.s, self.z)
        speeds = {name: bound[at] for name, bound in self.speeds.items()}
        if skip:
            for name, bound in self.speeds.items():
                speeds[name][1] = min(speeds[name][1], bound[first + 1])
        windows = tuple(Window(w.s, max(w.earliest - t, 0.0), w.latest - t) for w in self.windows if s < w.s <= self.s[last])
        return replace(
            self, ground=ground, speeds=speeds, acceleration=self.acceleration[rows], deceleration=self.deceleration[rows],
            forces=tuple(_cut(limit, rows) for limit in self.forces), windows=windows, start_speed=start_speed, end_speed=end_speed,
        )  # fmt: skip

    def scaled(self, factor: float) -> Self:
        """The limits with posted speeds and accelerations times `factor` (V2); bends and given end speeds stay."""
        speeds = {name: bound * factor if name in self.scalable else bound for name, bound in self.speeds.items()}
        slower = replace(self, speeds=speeds, acceleration=self.acceleration * factor, deceleration=self.deceleration * factor)
        return replace(slower, start_speed=min(self.start_speed, float(slower.v_max[0])), end_speed=min(self.end_speed, float(slower.v_max[-1])))


def _cut(limit: ForceLimit, rows: NDArray[np.intp]) -> ForceLimit:
    """A bound on force on some of its intervals."""
    arrays = {one.name: getattr(limit, one.name)[rows] for one in fields(limit) if isinstance(getattr(limit, one.name), np.ndarray)}  # pyright: ignore[reportArgumentType]
    return replace(limit, **arrays) if arrays else limit  # pyright: ignore[reportArgumentType]
