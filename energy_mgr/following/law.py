"""What all tracking laws share: their interface, the car's motion in path coordinates, driving resistances, and the speed law."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from powertrain.energy.resistance import drag_force, rolling_force, slope_force

from ..motion import MotionDemand
from .projected import DOMAIN_MIN

if TYPE_CHECKING:
    from powertrain import Vehicle

    from ..motion import VehicleState
    from .projected import Projected

#: m/s; below this speed rolling resistance is fed forward in part, so that a standing car asks for none
_ROLLS = 0.1
#: m before the end of an open path from which the car just stops
STOP_ZONE = 0.02
#: 1/s; how briskly it does
_STOP_RATE = 8.0


class TrackingLaw(Protocol):
    """From where the car is beside its path to what the wheels shall give it.

    Attributes:
        supervised: the last demand was held back by a limit of the law.
    """

    supervised: bool

    def demand(self, state: VehicleState, at: Projected, dt: float) -> MotionDemand:
        """The demand for the coming period of `dt` seconds."""
        ...

    def achieved(self, demand: MotionDemand, given: MotionDemand) -> None:
        """What the allocator could reach of the last demand; without a call all of it is taken to be given."""
        ...

    def adapt(self, lean: float, pace: float) -> None:
        """Go on with a car that has stuck steering: turned by `lean` (rad) to the right of its course, at the share `pace` of the speed."""
        ...

    def reset(self) -> None:
        """Forget everything that was learnt while driving."""
        ...

    def snapshot(self) -> tuple[Any, ...]:
        """All of the law's state."""
        ...

    def restore(self, snapshot: tuple[Any, ...]) -> None:
        """Go back to a `snapshot`."""
        ...


class Course(NamedTuple):
    """The car's motion in path coordinates.

    Attributes:
        cos, sin: of the heading error.
        ahead, aside: velocity of the centre of gravity along the tangent and the normal of the path, m/s.
        kappa, kappa_rate: of the path; zero beyond its ends, which go on straight.
        room: 1 - kappa e_y, at least `DOMAIN_MIN`.
        sdot: speed of the station, m/s.
    """

    cos: float
    sin: float
    ahead: float
    aside: float
    kappa: float
    kappa_rate: float
    room: float
    sdot: float

    @classmethod
    def of(cls, state: VehicleState, at: Projected) -> Course:
        """Of the car at `at`."""
        cos, sin = math.cos(at.e_psi), math.sin(at.e_psi)
        ahead, aside = at.ahead, state.v_x * sin + state.v_y * cos
        kappa, rate = (0.0, 0.0) if at.end else (at.point.kappa, at.kappa_rate)
        room = max(1.0 - kappa * at.e_y, DOMAIN_MIN)
        return cls(cos, sin, ahead, aside, kappa, rate, room, ahead / room)

    def yaw_feed(self, e_y: float, a_ahead: float) -> float:
        """d(kappa sdot)/dt, rad/s^2, while the speed along the tangent changes by `a_ahead` (m/s^2)."""
        s_rate = (a_ahead + (self.kappa_rate * self.sdot * e_y + self.kappa * self.aside) * self.sdot) / self.room
        return self.kappa_rate * self.sdot**2 + self.kappa * s_rate


class Resistances:
    """Adds to wanted accelerations what the wheels have to give beyond them: drag, rolling, slope, bank, and the spin of wheels and rotors."""

    def __init__(self, vehicle: Vehicle) -> None:
        self._vehicle = vehicle
        self._mass = vehicle.chassis.mass_kg
        self._drag, self._weight = drag_force(vehicle, 1.0) / self._mass, slope_force(vehicle, 1.0) / self._mass
        self._spin = vehicle.effective_mass / self._mass - 1.0

    def demand(self, a_x: float, a_y: float, yaw: float, state: VehicleState, at: Projected) -> MotionDemand:
        """The demand that gives the centre of gravity `a_x`, `a_y` (m/s^2, along the car's axes) and the car `yaw` (rad/s^2).

        Wheels spin with d v_x/dt = a_x + r v_y. Slope and bank are those of the path, turned into the car's axes; weight counts by the sine.
        """
        v_x, fast = state.v_x, abs(state.v_x)
        rolls = limited((v_x + _ROLLS * a_x) / _ROLLS, 1.0)
        against = self._drag * v_x * fast + rolls * rolling_force(self._vehicle, fast) / self._mass
        # most places are level
        uphill_x, uphill_y = self._uphill(at) if at.point.slope or at.point.bank else (0.0, 0.0)
        return MotionDemand(a_x + self._spin * (a_x + state.yaw_rate * state.v_y) + against + uphill_x, a_y + uphill_y, yaw)

    def _uphill(self, at: Projected) -> tuple[float, float]:
        """What carries the weight on the slope and the bank of the path, along the car's axes, m/s^2."""
        slope, across = at.point.slope, math.tan(limited(at.point.bank, 1.2))
        weight = self._weight / math.sqrt(1.0 + slope**2 + across**2)
        cos, sin = math.cos(at.e_psi), math.sin(at.e_psi)
        return weight * (slope * cos + across * sin), weight * (across * cos - slope * sin)


def limited(value: float, most: float) -> float:
    """`value`, between -most and most."""
    # twice as quick as min and max, and called twenty times a period
    return most if value > most else -most if value < -most else value


def scheduled(fastest: float, speed: float, length: float) -> float:
    """A pole, 1/s: `fastest`, but at low speed no more than one per `length` (m) driven, so that a standing car asks for nothing."""
    pole = abs(speed) / length
    return fastest if pole > fastest else pole


def speed_demand(at: Projected, speed: float, gain: float, correction: float) -> float:
    """Wanted change of speed along the path, m/s^2, from stations alone: no clock.

    While braking the feed-forward is v dv_ref/ds = a v/v_ref, with which e = v - v_ref decays as exp(-gain t) exactly, down to a stop at the end of
    a profile with v^2 linear in s. The plain `a` would drive e apart there as soon as v_ref < |a|/gain. While accelerating it is `a`: the error
    decays faster, and a car at rest where v_ref = 0 starts.

    Args:
        speed: along the path, m/s.
        gain: 1/s.
        correction: largest acceleration that the error may ask for, m/s^2.
    """
    wanted, feed = at.speed
    if at.to_go <= STOP_ZONE:
        return limited(-_STOP_RATE * speed, max(correction, abs(feed)))
    if feed < 0.0:
        feed *= min(max(speed / max(wanted, 0.01), 0.0), 1.5)
    return feed + limited(gain * (wanted - speed), correction)
