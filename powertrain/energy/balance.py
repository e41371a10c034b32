"""The quasi-static energy balance of a drive: where every joule goes.

A drive is a row of stations with speeds and heights. Between two stations the acceleration is constant, so speed squared is linear over way; per
interval the force balance and the losses are taken at the mean speed. Motors share the force equally, which is the least-loss split for equal
motors on a straight.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..errors import VehicleError
from .motor import MotorLosses, motor_losses
from .resistance import drag_force, rolling_force, slope_force

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ..vehicle import Vehicle

    Floats = NDArray[np.float64]

#: J
KWH = 3.6e6
#: Where energy goes: three resistances, the friction brakes, five losses, and the change of kinetic energy.
COMPONENTS = ("rolling", "drag", "slope", "brake", "copper", "iron", "inverter", "friction", "gear", "kinetic")


class Interval(NamedTuple):
    """One interval of a drive (or arrays, or symbols of many)."""

    time: Any
    force: Any
    mean_speed: Any
    losses: MotorLosses
    energies: dict[str, Any]


def balance(vehicle: Vehicle, ds: Any, v0: Any, v1: Any, dz: Any, brake: Any = 0.0) -> Interval:
    """Force and energies (J, drawn from the battery, negative when recuperated) of intervals.

    NumPy operations only: floats, arrays and CasADi symbols pass.

    Args:
        vehicle: the car.
        ds: horizontal way, m.
        v0: speed at the start, m/s, not negative.
        v1: speed at the end, m/s, not both zero.
        dz: rise, m.
        brake: force of the friction brakes, N, not negative.
    """
    mean_speed = 0.5 * (v0 + v1)
    time = ds / mean_speed
    energies = {
        "rolling": rolling_force(vehicle, mean_speed) * ds,
        "drag": drag_force(vehicle, 0.5 * (v0**2 + v1**2)) * ds,
        "slope": slope_force(vehicle, dz / ds) * ds,
        "kinetic": 0.5 * vehicle.effective_mass * (v1**2 - v0**2),
        "brake": brake * ds,
    }
    force = (energies["rolling"] + energies["drag"] + energies["slope"] + energies["kinetic"] + energies["brake"]) / ds
    count, ratio = vehicle.drive.motor_count, vehicle.motor_ratio
    losses = motor_losses(vehicle, force / (count * ratio), mean_speed * ratio)
    energies |= {name: count * loss * time for name, loss in losses._asdict().items()}
    return Interval(time, force, mean_speed, losses, energies)


def spoken(component: str) -> str:
    """What tables call a component: friction within the motors is not that of the brakes."""
    return "motor friction" if component == "friction" else component


@dataclass(frozen=True, eq=False)
class Ledger:
    """The account of a drive over its n - 1 intervals.

    Attributes:
        time: (n-1,) duration of each interval, s.
        force: (n-1,) force of the motors at the wheels, N, negative when recuperating.
        power: (n-1,) mean power drawn from the battery, W.
        energy: (n-1,) energy drawn from the battery, J.
        components: energy in J over the whole drive by `COMPONENTS`; they add up to `total`.
    """

    time: Floats
    force: Floats
    power: Floats
    energy: Floats
    components: dict[str, float]

    @property
    def total(self) -> float:
        """Energy drawn from the battery over the drive, J."""
        return float(np.sum(self.energy))

    @property
    def journey_time(self) -> float:
        """Duration of the drive, s."""
        return float(np.sum(self.time))


def drive_energy(vehicle: Vehicle, s: ArrayLike, v: ArrayLike, z: ArrayLike = 0.0, brake: ArrayLike = 0.0) -> Ledger:
    """The account of driving through stations `s` with speeds `v` over heights `z`.

    Args:
        vehicle: the car.
        s: (n,) stations along the horizontal way, m, increasing.
        v: (n,) speeds, m/s, not negative and never zero at two stations in a row.
        z: (n,) heights, m, or one height.
        brake: (n-1,) forces of the friction brakes, N, or one force.

    Raises:
        VehicleError: arrays that break these rules, with the index.
    """
    s, v = np.asarray(s, dtype=np.float64), np.asarray(v, dtype=np.float64)
    z = np.broadcast_to(np.asarray(z, dtype=np.float64), s.shape)
    if s.ndim != 1 or s.shape != v.shape or len(s) < 2:
        raise VehicleError(f"a drive needs at least two stations and as many speeds, found shapes {s.shape} and {v.shape}")
    good = np.isfinite(s[1:]) & np.isfinite(z[1:]) & (np.diff(s) > 0.0) & (v[1:] >= 0.0) & (v[:-1] >= 0.0) & (v[1:] + v[:-1] > 0.0)
    if not np.all(good):
        at = int(np.argmin(good))
        raise VehicleError(
            f"drive between stations {at} and {at + 1}: s {s[at]:g} to {s[at + 1]:g} m, v {v[at]:g} to {v[at + 1]:g} m/s, z {z[at]:g} to "
            f"{z[at + 1]:g} m, expected increasing stations and speeds of which at most one is zero"
        )
    brake = np.broadcast_to(np.asarray(brake, dtype=np.float64), good.shape)
    if not np.all(brake >= 0.0):
        at = int(np.argmin(brake >= 0.0))
        raise VehicleError(f"drive between stations {at} and {at + 1}: friction brakes with {brake[at]:g} N, expected 0 or more")
    found = balance(vehicle, np.diff(s), v[:-1], v[1:], np.diff(z), brake)
    energy = np.sum([found.energies[name] for name in COMPONENTS], axis=0)
    components = {name: float(np.sum(found.energies[name])) for name in COMPONENTS}
    return Ledger(found.time, found.force, energy / found.time, energy, components)
