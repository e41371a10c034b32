"""Drive cycles: energy of a car that follows speeds over time, standing included.

The same resistances and losses as everywhere; what recuperation cannot take, the friction brakes do. The auxiliaries draw their power all the time,
through the DC/DC converter, and motors that stand still draw their inverters' constant loss.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..description.sections import Electrics
from ..drive.supply import converter_input
from ..errors import VehicleError
from ..vehicle import GRAVITY, Vehicle
from .motor import force_limits, motor_losses
from .resistance import drag_force, rolling_force

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CycleLedger:
    """The account of a drive cycle.

    Attributes:
        distance: m.
        duration: s.
        energy: drawn from the battery, J.
        components: energy in J by where it goes; they add up to `energy`.
        missed: largest speed in m/s by which the car's limits would have it fall behind; its energy is that of the cycle all the same.
        power: (n-1,) mean power at the battery's terminals during each interval, W, negative when it is charged; read-only.
    """

    distance: float
    duration: float
    energy: float
    components: dict[str, float]
    missed: float
    power: Floats

    @property
    def consumption(self) -> float:
        """Energy per distance, J/m."""
        return self.energy / self.distance

    def range(self, battery_energy: float) -> float:
        """How far `battery_energy` (J) goes, m."""
        return battery_energy / self.consumption


class Demand(NamedTuple):
    """What a cycle takes, interval by interval.

    Attributes:
        dt: (n-1,) durations, s.
        mean: (n-1,) mean speeds, m/s.
        components: by name (n-1,) mean powers drawn from the battery, W.
        short: (n-1,) speed by which the car falls behind in the interval, m/s.
    """

    dt: Floats
    mean: Floats
    components: dict[str, Floats]
    short: Floats

    def ledger(self) -> CycleLedger:
        """The account over all intervals."""
        power = np.sum(list(self.components.values()), axis=0)
        power.setflags(write=False)
        energy = {name: float(np.sum(value * self.dt)) for name, value in self.components.items()}
        distance, duration = float(np.sum(self.mean * self.dt)), float(np.sum(self.dt))
        return CycleLedger(distance, duration, sum(energy.values()), energy, float(np.max(self.short)), power)


def drive_cycle(vehicle: Vehicle, t: ArrayLike, v: ArrayLike, slope: ArrayLike = 0.0) -> CycleLedger:
    """The account of following speeds `v` (m/s) at times `t` (s) on slopes dz/ds (one, or one per interval).

    Constant acceleration in between, as in `drive_energy`.

    Raises:
        VehicleError: arrays that are not of one length, not finite, times that do not increase, speeds that are negative or no car's, or a cycle
            that stands throughout.
    """
    return cycle_demand(vehicle, t, v, slope).ledger()


def cycle_demand(vehicle: Vehicle, t: ArrayLike, v: ArrayLike, slope: ArrayLike = 0.0) -> Demand:
    """The powers behind `drive_cycle`, which says what the arguments are and what is raised."""
    t, v = np.asarray(t, dtype=np.float64), np.asarray(v, dtype=np.float64)
    if t.ndim != 1 or t.shape != v.shape or len(t) < 2:
        raise VehicleError(f"a cycle needs at least two times and as many speeds, found shapes {t.shape} and {v.shape}")
    slope = np.asarray(slope, dtype=np.float64)
    if slope.shape not in ((), (len(t) - 1,)):
        raise VehicleError(f"a cycle of {len(t)} times with slopes of shape {slope.shape}, expected one slope, or one per interval")
    slope = np.broadcast_to(slope, (len(t) - 1,))
    good = np.isfinite(t[1:]) & np.isfinite(t[:-1]) & np.isfinite(v[1:] + v[:-1]) & np.isfinite(slope)
    good &= (t[1:] > t[:-1]) & (v[1:] >= 0.0) & (v[:-1] >= 0.0)
    if not np.all(good) or not np.any(v > 0.0):
        at = int(np.argmin(good))
        raise VehicleError(
            f"cycle between rows {at} and {at + 1}: t {t[at]:g} to {t[at + 1]:g} s, v {v[at]:g} to {v[at + 1]:g} m/s, expected increasing times and "
            f"speeds that are not negative and not all zero"
        )
    with np.errstate(over="ignore", invalid="ignore"):  # found below
        demand = _driven(vehicle, np.diff(t), v, slope)
    good = np.all(np.isfinite(list(demand.components.values())), axis=0)
    if not np.all(good):
        at = int(np.argmin(good))
        raise VehicleError(f"cycle between rows {at} and {at + 1}: v {v[at]:g} to {v[at + 1]:g} m/s takes no finite power, expected speeds of a car")
    return demand


def _driven(vehicle: Vehicle, dt: Floats, v: Floats, slope: Floats) -> Demand:
    mean = 0.5 * (v[1:] + v[:-1])
    way = {
        "rolling": rolling_force(vehicle, mean) * (mean > 0.0),
        "drag": drag_force(vehicle, 0.5 * (v[1:] ** 2 + v[:-1] ** 2)),
        "slope": vehicle.chassis.mass_kg * GRAVITY * slope,
    }
    power = {name: force * mean for name, force in way.items()}
    power["kinetic"] = 0.5 * vehicle.effective_mass * (v[1:] ** 2 - v[:-1] ** 2) / dt
    return _with_losses(vehicle, dt, mean, power)


def _with_losses(vehicle: Vehicle, dt: Floats, mean: Floats, power: dict[str, Floats]) -> Demand:
    wheel = np.sum(list(power.values()), axis=0)
    moving = np.maximum(mean, 1e-9)
    drive, regen = force_limits(vehicle, mean)
    driven = np.maximum(wheel, -regen * mean)
    power["brake"] = driven - wheel
    count, ratio = vehicle.drive.motor_count, vehicle.motor_ratio
    losses = motor_losses(vehicle, np.where(mean > 0.0, driven / (moving * count * ratio), 0.0), mean * ratio)
    power |= {name: np.broadcast_to(count * loss, mean.shape) for name, loss in losses._asdict().items()}
    if vehicle.electrics is not None:
        electrics: Electrics = vehicle.electrics
        power["auxiliary"] = np.full_like(mean, float(converter_input(electrics, electrics.auxiliary_w)))
    short = np.maximum(wheel - drive * mean, 0.0) / (vehicle.effective_mass * moving) * dt
    return Demand(dt, mean, power, short)
