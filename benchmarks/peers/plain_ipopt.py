"""The least-energy speed as one writes it down in CasADi at first: all stations at once, derivatives left to CasADi, solved by IPOPT.

The same stations, limits and losses as `energy_mgr.speed.comparison.nlp`, which gives IPOPT the derivatives of one interval mapped over all.
"""

from __future__ import annotations

import msgspec
import numpy as np

from energy_mgr import SpeedLimits
from energy_mgr.speed import SpeedProfile, fastest_profile
from powertrain import driving_resistance
from powertrain.energy.balance import balance
from powertrain.energy.motor import gear_factor, inverter_factor
from powertrain.symbolic import ca


def plain_profile(limits: SpeedLimits, journey_time: float) -> SpeedProfile:
    """Least energy within `journey_time` s on limits of the kinds `Posted`, `Lateral`, `Comfort`, `Motors`."""
    n, bound, guess = len(limits.s), np.sqrt(2.0 * limits.energy_max), fastest_profile(limits)
    lower = np.full(n, 1e-3)
    if not limits.closed:
        lower[[0, -1]] = bound[[0, -1]]
    v, size = ca.SX.sym("v", n), ca.SX.sym("size", n - 1)
    energy, rows, low, high = _written(limits, journey_time, v, size)
    options = {"print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes", "ipopt.tol": 1e-8}
    solver = ca.nlpsol("speed", "ipopt", {"x": ca.vertcat(v, size), "f": energy / 1e4, "g": rows}, options)
    first = guess.v * min(guess.journey_time / journey_time, 0.98)
    answer = solver(x0=np.append(first, np.ones(n - 1)), lbx=np.append(lower, np.zeros(n - 1)), ubx=np.append(bound, np.full(n - 1, np.inf)),
                    lbg=low, ubg=high)  # fmt: skip
    stats = solver.stats()
    assert stats["success"], stats["return_status"]
    return SpeedProfile(limits.s, np.clip(np.array(answer["x"]).ravel()[:n], 0.0, bound), "solved", int(stats["iter_count"]), np.nan, method="plain")


def _written(limits, journey_time, v, size):
    """Energy, rows and their bounds; `size` is the magnitude of the motors' force in kN."""
    vehicle, ds, dz = limits.vehicle, ca.DM(limits.ds), ca.DM(np.diff(limits.z))
    # losses by |F| are put on `size`
    smooth = msgspec.structs.replace(vehicle, drive=msgspec.structs.replace(vehicle.drive, inverter_per_current_wpa=0.0, gear_efficiency=1.0))
    found = balance(smooth, ds, v[:-1], v[1:], dz)
    per_force = inverter_factor(vehicle) / vehicle.motor_ratio * found.time + gear_factor(vehicle) * ds
    energy = ca.sum1(sum(found.energies.values())) + ca.sum1(1e3 * size * per_force)
    gain = (v[1:] ** 2 - v[:-1] ** 2) / (2.0 * ds)
    one, far = np.ones(len(limits.ds)), np.full(len(limits.ds), np.inf)
    rows = [
        (gain, -limits.deceleration, limits.acceleration),
        (size - found.force / 1e3, 0.0 * one, far),
        (size + found.force / 1e3, 0.0 * one, far),
        (ca.sum1(found.time) / journey_time, np.zeros(1), np.ones(1)),
    ]
    motors, ratio = vehicle.drive, vehicle.drive.motor_count * vehicle.motor_ratio
    for end in (v[:-1], v[1:]):
        force = vehicle.effective_mass * gain + driving_resistance(vehicle, end, dz / ds)
        for row, low, high, scale in (
            (force, ratio * motors.regen_torque_max_nm, ratio * motors.torque_max_nm, 1e3),
            (force * end, motors.motor_count * motors.regen_power_max_w, motors.motor_count * motors.power_max_w, 1e4),
        ):
            rows.append((row / scale, -low / scale * one, high / scale * one))
    if limits.closed:
        rows.append((v[0] - v[-1], np.zeros(1), np.zeros(1)))
    return energy, ca.vertcat(*(row for row, _, _ in rows)), np.concatenate([low for _, low, _ in rows]), np.concatenate([high for *_, high in rows])
