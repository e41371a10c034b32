"""What bounds the force along the way: motor torque, motor power, battery power, grip.

Each bound is written once as `excess`, which is at most zero where the bound is kept: NumPy operations only, so that arrays and CasADi symbols pass.
`ceiling` is the same solved for the force, `majorant` a line above the ceiling, for the proof of a least energy (`thriftiest.proof`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Protocol

import numpy as np

from powertrain.energy.motor import copper_factor, gear_factor, inverter_factor, motor_losses
from powertrain.vehicle import GRAVITY

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from powertrain import Vehicle

    Floats = NDArray[np.float64]
    Of = Literal["motors", "tyres"]
    Data = tuple[Any, ...]

#: Below this speed a bound on power is the bound on force at this speed, m/s: power over a vanishing speed bounds nothing.
SLOW = 0.1
#: Rounds the corner between driving and braking on the grip ellipse, as a share of the weight.
_CORNER = 0.01
#: How fast the smooth bound rises where the true one jumps to infinity, relative to speed.
_STEEP = 10.0
#: Stands for a force that nothing bounds, N.
UNBOUND = 1e7


class ForceLimit(Protocol):
    """A bound on the force of the motors or of the tyres.

    Attributes:
        name: what to call it in messages.
        of: whose force.
        sign: +1 for driving, -1 for braking.
        data: what varies along the way: arrays (n-1,), one value per interval.
    """

    name: ClassVar[str]
    of: ClassVar[Of]

    @property
    def sign(self) -> int: ...  # noqa: D102

    @property
    def data(self) -> tuple[Floats, ...]: ...  # noqa: D102

    def excess(self, vehicle: Vehicle, force: Any, v: Any, data: Data) -> Any:
        """At most zero where `force` (N) at speed `v` (m/s) keeps the bound; of order one, without unit."""
        ...

    def ceiling(self, vehicle: Vehicle, v: Any, data: Data, *, smooth: bool = False) -> Any:
        """Largest `sign * force` at speed `v`, N, not negative; with `smooth` a bound without jumps below it."""
        ...

    def majorant(self, vehicle: Vehicle, v: Floats, fastest: Floats, data: Data) -> tuple[Floats, Floats] | None:
        """c0, c2 with `ceiling(u) <= c0 + c2 u^2` for all u from 0 to `fastest`, as close as may be at `v`; None if there is no such line."""
        ...


@dataclass(frozen=True, eq=False)
class Torque:
    """Largest torque of the motors."""

    sign: int
    name: ClassVar[str] = "motor torque"
    of: ClassVar[Of] = "motors"

    @property
    def data(self) -> tuple[Floats, ...]:
        """Nothing varies."""
        return ()

    def _most(self, vehicle: Vehicle) -> float:
        p = vehicle.drive
        return p.motor_count * vehicle.motor_ratio * (p.torque_max_nm if self.sign > 0 else p.regen_torque_max_nm)

    def excess(self, vehicle: Vehicle, force: Any, v: Any, data: Data) -> Any:
        """See `ForceLimit`."""
        return (self.sign * force - self._most(vehicle)) / vehicle.effective_mass

    def ceiling(self, vehicle: Vehicle, v: Any, data: Data, *, smooth: bool = False) -> Any:
        """See `ForceLimit`."""
        return self._most(vehicle) + 0.0 * v

    def majorant(self, vehicle: Vehicle, v: Floats, fastest: Floats, data: Data) -> tuple[Floats, Floats]:
        """See `ForceLimit`."""
        return np.full_like(v, self._most(vehicle)), np.zeros_like(v)


@dataclass(frozen=True, eq=False)
class Power:
    """Largest mechanical power of the motors."""

    sign: int
    name: ClassVar[str] = "motor power"
    of: ClassVar[Of] = "motors"

    @property
    def data(self) -> tuple[Floats, ...]:
        """Nothing varies."""
        return ()

    def _most(self, vehicle: Vehicle) -> float:
        p = vehicle.drive
        return p.motor_count * (p.power_max_w if self.sign > 0 else p.regen_power_max_w)

    def excess(self, vehicle: Vehicle, force: Any, v: Any, data: Data) -> Any:
        """See `ForceLimit`."""
        return (self.sign * force * v - self._most(vehicle)) / max(self._most(vehicle), 1e3)

    def ceiling(self, vehicle: Vehicle, v: Any, data: Data, *, smooth: bool = False) -> Any:
        """See `ForceLimit`."""
        return self._most(vehicle) / np.fmax(v, SLOW)

    def majorant(self, vehicle: Vehicle, v: Floats, fastest: Floats, data: Data) -> tuple[Floats, Floats] | None:
        """See `ForceLimit`: the chord of the smaller of torque and power limit, convex in v^2 beyond the speed where the two meet."""
        torque, power = Torque(self.sign)._most(vehicle), self._most(vehicle)
        if torque <= 0.0 or power <= 0.0:
            return None
        base = power / torque
        top = np.maximum(fastest, base * (1.0 + 1e-9))
        slope = (power / top - torque) / (top**2 - base**2)
        return np.where(fastest > base, torque - slope * base**2, UNBOUND), np.where(fastest > base, slope, 0.0)


@dataclass(frozen=True, eq=False)
class ElectricPower:
    """Largest power at the battery's terminals (B3, A4), auxiliaries included: what it gives (sign +1) or takes (sign -1).

    Attributes:
        sign: +1 or -1.
        power: (n-1,) W.
        auxiliary: drawn all the time, W.
    """

    sign: int
    power: Floats
    auxiliary: float = 0.0
    name: ClassVar[str] = "battery power"
    of: ClassVar[Of] = "motors"

    @property
    def data(self) -> tuple[Floats, ...]:
        """See `ForceLimit`."""
        return (self.power,)

    def drawn(self, vehicle: Vehicle, force: Any, v: Any) -> Any:
        """Power drawn from the battery with `force` (N) at the wheels and speed `v` (m/s), W."""
        p = vehicle.drive
        losses = motor_losses(vehicle, force / (p.motor_count * vehicle.motor_ratio), v * vehicle.motor_ratio)
        return force * v + p.motor_count * sum(losses) + self.auxiliary

    def excess(self, vehicle: Vehicle, force: Any, v: Any, data: Data) -> Any:
        """See `ForceLimit`."""
        return (self.sign * self.drawn(vehicle, force, v) - data[0]) / max(float(np.max(self.power)), 1e3)

    def ceiling(self, vehicle: Vehicle, v: Any, data: Data, *, smooth: bool = False) -> Any:
        """See `ForceLimit`: the root of a quadratic, then Newton steps for what is not quadratic."""
        p, ratio = vehicle.drive, vehicle.motor_ratio
        idle = self.drawn(vehicle, 0.0 * v, v)
        a, b, v = copper_factor(vehicle) / (p.motor_count * ratio**2), inverter_factor(vehicle) / ratio, np.fmax(v, SLOW)
        if self.sign > 0:
            b = b + v * (1.0 + gear_factor(vehicle))
            room = np.fmax(data[0] - idle, 0.0)
            force = 2.0 * room / (b + np.sqrt(b**2 + 4.0 * a * room))
        else:
            b, room = v * (1.0 - gear_factor(vehicle)) - b, np.fmax(data[0] + idle, 0.0)
            root = b**2 - 4.0 * a * room
            # braking harder than at the vertex of the parabola gives back less: where the vertex is allowed, no force is too large
            vertex = np.sqrt(room / a)
            free = vertex * (1.0 + _STEEP * (1.0 - b / np.fmax(2.0 * a * vertex, 1e-9))) if smooth else UNBOUND
            force = np.where((root > 0.0) & (b > 0.0), 2.0 * room / (np.fabs(b) + np.sqrt(np.fmax(root, 0.0))), free)
        return force if p.weakening is None else self._refined(vehicle, force, v, data[0])

    def _refined(self, vehicle: Vehicle, force: Floats, v: Floats, most: Floats) -> Floats:
        for _ in range(4):
            beyond = self.sign * self.drawn(vehicle, self.sign * force, v) - most
            by = self.sign * self.drawn(vehicle, self.sign * (force + 1.0), v) - most - beyond
            step = np.where((by > 1e-3) & (force < UNBOUND), beyond / np.maximum(by, 1e-3), 0.0)
            force = np.fmax(force - step, 0.0)
        return force

    def majorant(self, vehicle: Vehicle, v: Floats, fastest: Floats, data: Data) -> tuple[Floats, Floats] | None:
        """See `ForceLimit`: none, the bound is left out of proofs."""
        return None


@dataclass(frozen=True, eq=False)
class Grip:
    """The friction ellipse of the whole car, with the load that slope of the bank and curvature leave.

    Attributes:
        sign: +1 or -1.
        share: of the weight on the wheels that drive (sign +1) or brake (sign -1).
        friction: (n-1,) friction coefficient.
        kappa: (n-1,) curvature of the path where it asks for most, 1/m.
        bank: (n-1,) rad, positive where the left side is higher.
    """

    sign: int
    share: float
    friction: Floats
    kappa: Floats
    bank: Floats
    name: ClassVar[str] = "grip"
    of: ClassVar[Of] = "tyres"

    @property
    def data(self) -> tuple[Floats, ...]:
        """See `ForceLimit`."""
        return self.friction, self.kappa, self.bank

    def excess(self, vehicle: Vehicle, force: Any, v: Any, data: Data) -> Any:
        """See `ForceLimit`."""
        lateral, most = grip_loads(v, *data)
        share = self.sign * force / (vehicle.chassis.mass_kg * GRAVITY * self.share)
        # the positive part, rounded to the safe side: the other sign has a bound of its own
        positive = 0.5 * (share + np.sqrt(share**2 + _CORNER**2))
        return positive**2 + lateral**2 - most**2

    def ceiling(self, vehicle: Vehicle, v: Any, data: Data, *, smooth: bool = False) -> Any:
        """See `ForceLimit`."""
        lateral, most = grip_loads(v, *data)
        room = np.sqrt(np.fmax(most**2 - lateral**2, 1e-12))
        # inverse of the rounding: p = (f + sqrt(f^2 + c^2)) / 2  <=>  f = p - c^2 / 4p
        return vehicle.chassis.mass_kg * GRAVITY * self.share * np.fmax(room - _CORNER**2 / (4.0 * room), 0.0)

    def majorant(self, vehicle: Vehicle, v: Floats, fastest: Floats, data: Data) -> tuple[Floats, Floats] | None:
        """See `ForceLimit`: the root of a quadratic in v^2 that opens downwards is concave, its tangent lies above."""
        friction, kappa, bank = data
        if np.any(np.cos(bank) <= friction * np.abs(np.sin(bank))):
            return None
        weight = vehicle.chassis.mass_kg * GRAVITY * self.share
        lateral, most = grip_loads(v, *data)
        room = np.sqrt(np.maximum(most**2 - lateral**2, 1e-4))
        by = (-friction * most * np.sin(bank) - lateral * np.cos(bank)) * kappa / GRAVITY / room
        return weight * ((most**2 - lateral**2 + room**2) / (2.0 * room) - by * v**2), weight * by


def grip_loads(v: Any, friction: Any, kappa: Any, bank: Any) -> tuple[Any, Any]:
    """Lateral force and friction times load, both over the weight, at speed `v` (m/s) on a bank (rad)."""
    bend = kappa * v**2 / GRAVITY
    return bend * np.cos(bank) + np.sin(bank), friction * (np.cos(bank) - bend * np.sin(bank))
