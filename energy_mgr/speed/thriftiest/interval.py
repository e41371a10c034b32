"""Energy, time and constraints of one interval between two stations with exact derivatives, evaluated for all intervals at once.

Unknown per interval are v^2/2 at both ends, z >= |F|, the magnitude of the motors' force, and q, the force of the friction brakes. The energy is that
of `powertrain.energy.balance`, on symbols; only |F|, which is not smooth, is replaced by z. Everything is scaled to order one.
"""

from __future__ import annotations

from copy import copy
from typing import TYPE_CHECKING, Any, NamedTuple

import msgspec
import numpy as np

from powertrain import driving_resistance
from powertrain.energy.balance import balance
from powertrain.energy.motor import gear_factor, inverter_factor
from powertrain.symbolic import ca

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..bounds.forces import ForceLimit
    from ..bounds.speed_limits import SpeedLimits

    Floats = NDArray[np.float64]

#: What is added to v^2/2 under a root, scaled: a car at rest has a derivative then.
_REST = 1e-16
#: A price on |F|, scaled, for cars without any loss that grows with it; 1e-9 of the energy of driving.
_LEAST_PRICE = 1e-9


class Values(NamedTuple):
    """Per interval (N,): scaled energy, time in s, rows (N, k) that must not be positive."""

    energy: Floats
    time: Floats
    rows: Floats


class Slopes(NamedTuple):
    """Derivatives per interval by (e0, e1, z, q).

    Attributes:
        energy: (N, 4).
        time: (N, 2) by e0 and e1.
        rows: (N, k, 4).
        hessian: (N, 4, 4) of energy, price times time and rows times multipliers.
    """

    energy: Floats
    time: Floats
    rows: Floats
    hessian: Floats


class IntervalModel:
    """The intervals of some limits.

    Attributes:
        limits: what is modelled.
        energy_scale: v^2/2 of the unknown 1, m^2/s^2.
        force_scale: force of the unknown 1, N.
        unit: energy of the scaled energy 1, J.
        forces: the bounds on force that can bind anywhere; each has two rows, for both ends of the intervals.
        braking: whether friction brakes are among the unknowns.
    """

    #: Rows before those of `forces`: acceleration, deceleration, F <= z, -F <= z.
    FIRST = 4

    def __init__(self, limits: SpeedLimits, *, every: bool = False) -> None:
        """With `every` bounds on force stay that cannot bind now; they may later (`on`)."""
        self.limits = limits
        self._written: tuple[Any, Any] | None = None
        self.energy_scale = float(np.max(limits.energy_max))
        self.force_scale = limits.vehicle.effective_mass
        self.unit = self.force_scale * self.energy_scale
        self.braking = limits.brake > 0.0
        self.forces = tuple(limit for limit in limits.forces if every or _can_bind(limits, limit))
        self.rows = self.FIRST + 2 * len(self.forces) + (2 if self.braking else 0)
        self._spread(limits)

    def on(self, limits: SpeedLimits) -> IntervalModel:
        """The same model on a stretch of its limits (`SpeedLimits.stretch`), without writing its functions anew."""
        other = copy(self)
        kept = {id(limit) for limit in self.forces}
        other.forces = tuple(new for old, new in zip(self.limits.forces, limits.forces, strict=True) if id(old) in kept)
        other.limits = limits
        other._spread(limits)
        return other

    def _spread(self, limits: SpeedLimits) -> None:
        """Take over what varies along the way."""
        self.count = len(limits.ds)
        rows = [1.0 / limits.acceleration, 1.0 / limits.deceleration, limits.slope_against(1), limits.slope_against(-1)]
        rows += [np.broadcast_to(x, (self.count,)) for limit in self.forces for x in limit.data]
        self._data = np.ascontiguousarray(np.column_stack([limits.ds, np.diff(limits.z), *rows]))
        if self._written is None:
            self._written = self._functions(self._data.shape[1])
        self._values, self._slopes = (function.map(self.count) for function in self._written)

    def values(self, unknown: Floats) -> Values:
        """Energy, time, rows at unknowns (N, 4)."""
        energy, time, rows = self._called(self._values, [unknown, self._data], [1, 1, self.rows])
        return Values(energy[:, 0], time[:, 0], rows)

    def slopes(self, unknown: Floats, multipliers: Floats, price: Floats, weight: float = 1.0) -> Slopes:
        """Derivatives at unknowns (N, 4) with multipliers (N, k) of the rows, price (N,) per second and weight of the energy."""
        given = [unknown, self._data, multipliers, price[:, None], np.full((self.count, 1), weight)]
        energy, time, rows, hessian = self._called(self._slopes, given, [4, 2, 4 * self.rows, 16])
        return Slopes(energy, time, rows.reshape(self.count, 4, self.rows).transpose(0, 2, 1), hessian.reshape(self.count, 4, 4))

    def _called(self, function: Any, given: list[Floats], sizes: list[int]) -> list[Floats]:
        # CasADi stores columns one after the other, one per interval: a C-ordered array with intervals first is the same in memory
        call, run = function.buffer()
        inputs = [np.ascontiguousarray(array, dtype=np.float64) for array in given]
        outputs = [np.empty((self.count, size)) for size in sizes]
        for at, array in enumerate(inputs):
            call.set_arg(at, memoryview(array))  # pyright: ignore[reportArgumentType]
        for at, array in enumerate(outputs):
            call.set_res(at, memoryview(array))  # pyright: ignore[reportArgumentType]
        run()
        return outputs

    def _functions(self, size: int) -> tuple[Any, Any]:
        """Values and derivatives of one interval with `size` data."""
        unknown, data = ca.SX.sym("unknown", 4), ca.SX.sym("data", size)
        multipliers, price, weight = ca.SX.sym("multipliers", self.rows), ca.SX.sym("price"), ca.SX.sym("weight")
        energy, time, rows = self._expressions(unknown, data)
        lagrangian = weight * energy + price * time + ca.dot(multipliers, rows)
        hessian, _ = ca.hessian(lagrangian, unknown)
        slopes = [ca.gradient(energy, unknown), ca.gradient(time, unknown)[:2], ca.jacobian(rows, unknown), hessian]
        values = ca.Function("values", [unknown, data], ca.cse([energy, time, rows]))
        derivatives = ca.Function("slopes", [unknown, data, multipliers, price, weight], ca.cse([ca.densify(x) for x in slopes]))
        return values, derivatives

    def _expressions(self, unknown: Any, data: Any) -> tuple[Any, Any, Any]:
        limits, vehicle = self.limits, self.limits.vehicle
        e0, e1 = (self.energy_scale * (unknown[k] + _REST) for k in range(2))
        v0, v1, z, brake = np.sqrt(2.0 * e0), np.sqrt(2.0 * e1), unknown[2] * self.force_scale, unknown[3] * self.force_scale
        ds, dz = data[0], data[1]
        smooth = msgspec.structs.replace(vehicle, drive=msgspec.structs.replace(vehicle.drive, inverter_per_current_wpa=0.0, gear_efficiency=1.0))
        found = balance(smooth, ds, v0, v1, dz, brake if self.braking else 0.0)
        per_force = inverter_factor(vehicle) / vehicle.motor_ratio * found.time + gear_factor(vehicle) * ds
        # the change of kinetic energy is given by the ends; its large terms would only cancel
        energies = [energy for name, energy in found.energies.items() if name != "kinetic"]
        energy = (sum(energies) + z * (per_force + _LEAST_PRICE * ds)) / self.unit
        gain = (e1 - e0) / ds
        rows = [gain * data[2] - 1.0, -gain * data[3] - 1.0, (found.force - z) / self.force_scale, (-found.force - z) / self.force_scale]
        at = 6
        for limit in self.forces:
            own = tuple(data[at + k] for k in range(len(limit.data)))
            at += len(limit.data)
            for v in (v0, v1):
                force = vehicle.effective_mass * gain + driving_resistance(vehicle, v, data[4 if limit.sign > 0 else 5])
                force = force + brake if limit.of == "motors" and self.braking else force
                rows.append(limit.excess(vehicle, force, v, own))
        if self.braking:
            rows += [-unknown[3], unknown[3] - limits.brake / self.force_scale]
        return energy, found.time, ca.vertcat(*rows)


def _can_bind(limits: SpeedLimits, limit: ForceLimit) -> bool:
    """Whether a bound on force is tighter anywhere than what the bounds on speed and acceleration leave."""
    if limit.of == "tyres" or (limit.sign < 0 and limits.brake > 0.0):
        return True
    fastest = np.sqrt(2.0 * np.maximum(limits.energy_max[1:], limits.energy_max[:-1]))
    if limit.sign > 0:
        most = limits.vehicle.effective_mass * limits.acceleration + limits.resistance(fastest, 1)
    else:
        most = limits.vehicle.effective_mass * limits.deceleration - limits.resistance(np.zeros_like(fastest), -1)
    return bool(np.any(limit.ceiling(limits.vehicle, fastest, limit.data) < most))
