"""The fastest profile in plain Python: station by station, bisection in every interval, nothing of the package's forces or passes."""

from dataclasses import dataclass
from math import cos, sin, sqrt

import numpy as np

from powertrain import Vehicle, driving_resistance, force_limits, motor_losses
from powertrain.energy.motor import copper_factor, gear_factor, inverter_factor
from powertrain.vehicle import GRAVITY

#: The package rounds the corner of the grip ellipse by this share of the weight, to the safe side.
CORNER = 0.01


@dataclass
class Slow:
    """What bounds the drive, in plain numbers; lists have one value per station (bound on speed) or interval."""

    vehicle: Vehicle
    s: list[float]
    z: list[float]
    v_max: list[float]
    up: float
    down: float
    closed: bool = False
    brake: float = 0.0
    give: float | None = None
    take: float | None = None
    auxiliary: float = 0.0
    #: per interval: friction, curvature, bank; with the shares of the weight that drive and brake
    grip: list[tuple[float, float, float]] | None = None
    shares: tuple[float, float] = (1.0, 1.0)

    def profile(self) -> np.ndarray | None:
        """(n,) speeds; None where the car halts on the way or an end is not reached."""
        e = [0.5 * v * v for v in self.v_max]
        if self.closed:
            e[0] = e[-1] = min(e[0], e[-1])
        top = list(e)
        for _ in range(400):
            before = list(e)
            for k in range(len(e) - 1):
                e[k + 1] = self._most(e[k], e[k + 1], k, 1)
            for k in reversed(range(len(e) - 1)):
                e[k] = self._most(e[k + 1], e[k], k, -1)
            if self.closed:
                e[0] = e[-1] = min(e[0], e[-1])
            if max(abs(a - b) for a, b in zip(e, before, strict=True)) < 1e-13 * max(top):
                break
        halted = any(a <= 1e-6 * b for a, b in zip(e[1:-1], top[1:-1], strict=True) if b > 0.0)
        short = not self.closed and (sqrt(2 * top[0]) - sqrt(2 * e[0]) > 1e-5 or sqrt(2 * top[-1]) - sqrt(2 * e[-1]) > 1e-5)
        return None if halted or short else np.sqrt(2.0 * np.array(e))

    def _most(self, known: float, bound: float, k: int, sign: int) -> float:
        """Largest v^2/2 up to `bound` at the other end of interval `k`, `known` given at the one that a pass comes from."""
        if self._keeps(known, bound, k, sign):
            return bound
        low, high = 0.0, bound
        if not self._keeps(known, 0.0, k, sign):
            return 0.0
        for _ in range(70):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self._keeps(known, middle, k, sign) else (low, middle)
        return low

    def _keeps(self, known: float, sought: float, k: int, sign: int) -> bool:
        ds = self.s[k + 1] - self.s[k]
        rate = (sought - known) / ds
        if rate > (self.up if sign > 0 else self.down):
            return False
        slope = (self.z[k + 1] - self.z[k]) / ds
        for e in (known, sought):
            v = sqrt(2.0 * e)
            wheels = self.vehicle.effective_mass * rate + sign * float(driving_resistance(self.vehicle, v, slope))
            if not (self._motors(wheels, v, sign) and self._tyres(wheels, v, k, sign)):
                return False
        return True

    def _motors(self, wheels: float, v: float, sign: int) -> bool:
        drive, regen = force_limits(self.vehicle, float(v))
        motors = wheels - (self.brake if sign < 0 else 0.0)
        if motors > (drive if sign > 0 else regen):
            return False
        most = self.give if sign > 0 else self.take
        if most is None or motors <= 0.0:
            return True
        return self._electric(motors, max(v, 0.1), sign) <= most

    def _electric(self, force: float, v: float, sign: int) -> float:
        """Power out of the battery for driving, into it for braking with `force`; braking never gives more than at the vertex."""
        car = self.vehicle
        count, ratio = car.drive.motor_count, car.motor_ratio
        if sign < 0:
            vertex = (v * (1.0 - gear_factor(car)) - inverter_factor(car) / ratio) / (2.0 * copper_factor(car) / (count * ratio**2))
            force = min(force, max(vertex, 0.0))
        losses = count * sum(motor_losses(car, force / (count * ratio), v * ratio))
        return force * v + losses + self.auxiliary if sign > 0 else force * v - losses - self.auxiliary

    def _tyres(self, wheels: float, v: float, k: int, sign: int) -> bool:
        if self.grip is None:
            return True
        mu, kappa, bank = self.grip[k]
        bend = kappa * v * v / GRAVITY
        across, most = bend * cos(bank) + sin(bank), mu * (cos(bank) - bend * sin(bank))
        along = wheels / (self.vehicle.chassis.mass_kg * GRAVITY * self.shares[0 if sign > 0 else 1])
        positive = 0.5 * (along + sqrt(along**2 + CORNER**2))
        return positive**2 + across**2 <= most**2
