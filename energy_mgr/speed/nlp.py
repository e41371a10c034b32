"""The energy-optimal speed as a nonlinear programme with the true, non-convex losses, through CasADi and IPOPT: the reference for `eco`.

The same stations, limits and energy balance (`powertrain.balance`, evaluated on symbols); only |tau|, which is not smooth, is written with its
positive and negative part as variables, exact at the optimum because loss grows with both.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from powertrain import driving_resistance
from powertrain.balance import balance
from powertrain.motor import gear_factor, inverter_factor
from powertrain.symbolic import ca

from ..errors import SolverError
from .forward_backward import scaled_profile
from .result import SpeedProfile

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .limits import SpeedLimits

    Floats = NDArray[np.float64]


def nlp_profile(limits: SpeedLimits, journey_time: float, *, tolerance: float = 1e-8) -> SpeedProfile:
    """The profile of least energy that arrives within `journey_time` in s, by IPOPT from the scaled profile (V2).

    Raises:
        InfeasibleError: the time is too short.
        SolverError: IPOPT did not converge.
    """
    guess = scaled_profile(limits, journey_time)
    started = time.perf_counter()
    vehicle, ds, n = limits.vehicle, limits.ds, len(limits.s)
    v, pull, push = ca.SX.sym("v", n), ca.SX.sym("pull", n - 1), ca.SX.sym("push", n - 1)
    smooth = msgspec.structs.replace(vehicle, drive=msgspec.structs.replace(vehicle.drive, inverter_per_current_wpa=0.0, gear_efficiency=1.0))
    found = balance(smooth, ds, v[:-1], v[1:], ca.DM(np.diff(limits.z)))
    force_scale, energy_scale = 1e3, 1e4
    per_force = inverter_factor(vehicle) / vehicle.motor_ratio
    energy = ca.sum1(sum(found.energies.values())) + ca.sum1((pull + push) * force_scale * (per_force * found.time + gear_factor(vehicle) * ds))
    gain = (v[1:] ** 2 - v[:-1] ** 2) / (2 * ds)
    rows: list[tuple[Any, float, float]] = [
        (found.force / force_scale - pull + push, 0.0, 0.0),
        (gain, -limits.deceleration, limits.acceleration),
        (ca.sum1(found.time) / journey_time, 0.0, 1.0),
    ]
    drive, total = vehicle.drive, vehicle.drive.motor_count * vehicle.motor_ratio
    slope = ca.DM(np.diff(limits.z) / ds)
    for end in (v[:-1], v[1:]):
        force = vehicle.effective_mass * gain + driving_resistance(vehicle, end, slope)
        rows.append((force / force_scale, -total * drive.regen_torque_max_nm / force_scale, total * drive.torque_max_nm / force_scale))
        most, least = drive.motor_count * drive.power_max_w, -drive.motor_count * drive.regen_power_max_w
        rows.append((force * end / 1e4, least / 1e4, most / 1e4))
    if limits.closed:
        rows.append((v[0] - v[-1], 0.0, 0.0))
    v_max = np.sqrt(2.0 * limits.energy_max)
    fixed = np.zeros(n, dtype=bool)
    if not limits.closed:
        fixed[[0, -1]] = True
    lower = np.where(fixed, v_max, 1e-3)
    size = 2 * (n - 1)
    variables = ca.vertcat(v, pull, push)
    options = {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes", "ipopt.tol": tolerance, "ipopt.max_iter": 1000}
    solver = ca.nlpsol("speed", "ipopt", {"x": variables, "f": energy / energy_scale, "g": ca.vertcat(*(row for row, _, _ in rows))}, options)
    force = balance(vehicle, ds, guess.v[:-1], guess.v[1:], np.diff(limits.z)).force / force_scale
    answer = solver(
        x0=np.concatenate([guess.v, np.maximum(force, 0.0), np.maximum(-force, 0.0)]),
        lbx=np.concatenate([lower, np.zeros(size)]),
        ubx=np.concatenate([v_max, np.full(size, np.inf)]),
        lbg=np.concatenate([np.full(row.shape[0], low) for row, low, _ in rows]),
        ubg=np.concatenate([np.full(row.shape[0], high) for row, _, high in rows]),
    )
    stats: dict[str, Any] = solver.stats()
    if not stats["success"]:
        raise SolverError(f"{limits.name}: IPOPT ended with {stats['return_status']}")
    speeds = np.clip(np.array(answer["x"]).ravel()[:n], 0.0, v_max)
    return SpeedProfile(limits.s, speeds, "solved", int(stats["iter_count"]), 1e3 * (time.perf_counter() - started))
