"""Limits put together from plain arrays, without a road and a path, and a plain re-evaluation of them: tools of the tests beside it."""

from collections.abc import Callable, Sequence
from itertools import pairwise

import msgspec
import numpy as np

from energy_mgr.speed import SpeedLimits
from energy_mgr.speed.bounds.parts import Part, standard_parts
from energy_mgr.speed.bounds.stations import Ground, Samples, stations
from powertrain import Vehicle, load_vehicle

Floats = np.ndarray
Along = float | Callable[[Floats], Floats]

ROMO, VAN = load_vehicle("romo"), load_vehicle("van")


def along(value: Along, s: Floats) -> Floats:
    """A number, or a function of the way, at places `s`."""
    return np.broadcast_to(np.asarray(value(s) if callable(value) else value, dtype=np.float64), s.shape).copy()


def ground(
    s: Floats, *, kappa: Along = 0.0, height: Along = 0.0, bank: Along = 0.0, friction: Along = 1.0, posted: Along = 20.0, closed: bool = False
) -> Ground:
    """What lies along a way with stations `s`, sampled twenty times per interval."""
    dense = np.unique(np.concatenate([np.linspace(a, b, 21) for a, b in pairwise(s)]))
    samples = Samples(dense, along(kappa, dense), along(bank, dense), along(friction, dense), along(posted, dense))
    return Ground(s, along(height, s), along(bank, s), closed, samples)


def bare(vehicle: Vehicle, lie: Ground, start_speed: float = 0.0, end_speed: float = 0.0) -> SpeedLimits:
    """Limits that know only the car's top speed."""
    count = len(lie.s)
    free = np.full(count - 1, np.inf)
    return SpeedLimits(
        vehicle, "rig", lie, {"car": np.full(count, vehicle.limits.speed_max_mps)}, free, free, start_speed=start_speed, end_speed=end_speed
    )


def limits_of(
    vehicle: Vehicle = ROMO, length: float = 200.0, step: float = 5.0, *, extra: Sequence[Part] = (), parts: Sequence[Part] | None = None,
    start_speed: float = 0.0, end_speed: float = 0.0, through: Sequence[float] = (), s: Floats | None = None,
    kappa: Along = 0.0, height: Along = 0.0, bank: Along = 0.0, friction: Along = 1.0, posted: Along = 20.0, closed: bool = False,
) -> SpeedLimits:  # fmt: skip
    """Limits of a car along a way given by numbers or functions."""
    used = [*(standard_parts() if parts is None else parts), *extra]
    if s is None:
        s = stations("rig", length, step, [*through, *(mark for part in used for mark in part.stations)])
    lie = ground(s, kappa=kappa, height=height, bank=bank, friction=friction, posted=posted, closed=closed)
    limits = bare(vehicle, lie, start_speed, end_speed)
    for part in used:
        limits = part.added(limits)
    return limits.checked()


def changed(vehicle: Vehicle, **sections: dict[str, float]) -> Vehicle:
    """A car with other numbers: `changed(ROMO, drive={"power_max_w": 4e3})`."""
    made = {name: msgspec.structs.replace(getattr(vehicle, name), **values) for name, values in sections.items()}
    return msgspec.structs.replace(vehicle, **made)


def driven_share(vehicle: Vehicle) -> float:
    """Share of the weight at rest on the driven wheels, by statics."""
    assert vehicle.body is not None
    front, rear, arm = vehicle.body.front_axle_m, vehicle.body.rear_axle_m, vehicle.body.front_axle_m + vehicle.body.rear_axle_m
    left_front, _, left_rear, _ = vehicle.drive.driven_wheels
    return left_front * rear / arm + left_rear * front / arm
