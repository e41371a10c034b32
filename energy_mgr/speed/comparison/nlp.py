"""The energy-optimal speed as a nonlinear programme on the true, non-convex losses, through CasADi and IPOPT: the reference for `eco`.

The same stations, limits and energy balance (`powertrain.energy.balance`, evaluated on symbols). Unknown are the speeds at the stations and per
interval p >= max(F, 0), the pulling part of the motors' force F, and q, the force of the friction brakes where there are any. |F|, which is not
smooth, is written 2 p - F, exact at the optimum because loss grows with p. Of the bounds on force only those are rows that can bind in an interval.
"""

from __future__ import annotations

import time
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from powertrain import driving_resistance
from powertrain.energy.balance import balance
from powertrain.energy.motor import gear_factor, inverter_factor
from powertrain.symbolic import ca

from ...errors import PlanningError, SolverError
from ..checks import TIME_TOLERANCE, check_profile, check_times, station_number
from ..fastest.forward_backward import fastest_profile, friction_braking, refuse_too_early
from ..result import SpeedProfile
from .nlp_blocks import Block, Local, assembled

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..bounds.forces import ForceLimit
    from ..bounds.speed_limits import SpeedLimits

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

_FORCE_SCALE, _ENERGY_SCALE = 1e3, 1e4
#: Speeds that are not fixed stay above this, m/s: at rest time has no derivative.
_LEAST_SPEED = 1e-3
#: Stands for a bound on acceleration that is none, m/s^2.
_FREE = 1e3
#: The iteration starts from this part of the fastest speeds at most.
_INSIDE = 0.98
_OPTIONS = {"print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes", "ipopt.max_iter": 1000}


def nlp_profile(limits: SpeedLimits, journey_time: float, *, tolerance: float = 1e-8) -> SpeedProfile:
    """The profile of least energy that arrives within `journey_time` in s, by IPOPT; jerk and windows are kept too.

    Where arriving earlier costs less energy than crawling, the profile arrives earlier and its status is `solved early`.

    Args:
        limits: what bounds the speed.
        journey_time: allowed time, s.
        tolerance: IPOPT's, on the scaled optimality conditions.

    Raises:
        InfeasibleError: the time is shorter than the least possible one; or the car cannot pass a slope.
        SolverError: IPOPT did not converge, as where windows or jerk leave no profile, or what it found breaks a limit.
        PlanningError: a time out of range.
    """
    started = time.perf_counter()
    if not 0.0 < journey_time < 1e7:
        raise PlanningError(f"{limits.name}: arrival time {journey_time} s, expected more than 0 and less than 1e7 s")
    fastest = fastest_profile(limits)
    refuse_too_early(limits.name, journey_time, fastest.journey_time)
    programme = _Programme(limits, max(journey_time, fastest.journey_time))
    answer, stats = programme.solved(fastest.v * min(fastest.journey_time / journey_time, _INSIDE), tolerance)
    if not stats["success"]:
        how = f"{stats['return_status']} after {stats['iter_count']} iterations"
        raise SolverError(f"{limits.name}: IPOPT ended with {how}; method eco solves the same problem")
    v, brake = programme.found(np.array(answer["x"]).ravel())
    check_profile(limits, v, brake)
    check_times(limits, v, journey_time)
    # the last row is "time over the time allowed <= 1"
    price = float(np.array(answer["lam_g"]).ravel()[-1]) * _ENERGY_SCALE / journey_time
    milliseconds = 1e3 * (time.perf_counter() - started)
    profile = SpeedProfile(limits.s, v, "solved", int(stats["iter_count"]), milliseconds, brake=brake, method="nlp", price=price)
    return profile if profile.journey_time > journey_time - TIME_TOLERANCE else replace(profile, status="solved early")


class _Programme:
    """The programme of some limits."""

    def __init__(self, limits: SpeedLimits, journey_time: float) -> None:
        self.limits, self.journey_time = limits, journey_time
        self.intervals = len(limits.ds)
        # on circuits the last station is the first
        self.speeds = self.intervals + (0 if limits.closed else 1)
        self.braking = limits.brake > 0.0
        self.size = self.speeds + self.intervals * (2 if self.braking else 1)
        self.station = np.arange(self.intervals + 1) % self.speeds
        ends = [*(station_number(limits, window.s) for window in limits.windows), self.intervals]
        self.until = (np.arange(self.intervals) < np.array(ends)[:, None]) / journey_time
        self.blocks = self._interval_blocks()
        if np.isfinite(limits.jerk) and self.intervals > 1:
            self.blocks.append(self._jerk_block())

    def solved(self, guess: Floats, tolerance: float) -> tuple[dict[str, Any], dict[str, Any]]:
        """IPOPT's answer from speeds `guess` (n,), and its statistics."""
        limits = self.limits
        problem, derivatives = assembled(self.blocks, self.size)
        solver = ca.nlpsol("speed", "ipopt", problem, {**_OPTIONS, **derivatives, "ipopt.tol": tolerance})
        force = balance(limits.vehicle, limits.ds, guess[:-1], guess[1:], np.diff(limits.z)).force / _FORCE_SCALE
        local = [np.maximum(force, 0.0) + 0.1, *([np.full(self.intervals, 0.01)] if self.braking else [])]
        lower, upper = self._bounds()
        earliest = [*(window.earliest for window in limits.windows), 0.0]
        latest = [*(window.latest for window in limits.windows), self.journey_time]
        answer = solver(
            x0=np.concatenate([guess[: self.speeds], *local]),
            lbx=lower,
            ubx=upper,
            lbg=np.concatenate([*(block.low.ravel("F") for block in self.blocks), np.array(earliest) / self.journey_time]),
            ubg=np.concatenate([*(block.high.ravel("F") for block in self.blocks), np.array(latest) / self.journey_time]),
        )
        return answer, solver.stats()

    def found(self, x: Floats) -> tuple[Floats, Floats | None]:
        """Speeds (n,) and forces of the friction brakes (n-1,) of a solution."""
        v = np.clip(x[: self.speeds][self.station], 0.0, np.sqrt(2.0 * self.limits.energy_max))
        needed = friction_braking(self.limits, v)
        if needed is None:
            return v, None
        brake = x[self.size - self.intervals :] * _FORCE_SCALE
        # what the barrier leaves of a brake that is not used is no braking
        return v, np.maximum(np.where(brake > 1e-4 * _FORCE_SCALE, brake, 0.0), needed)

    def _bounds(self) -> tuple[Floats, Floats]:
        limits = self.limits
        bound = np.sqrt(2.0 * limits.energy_max)[: self.speeds]
        fixed = bound <= 0.0
        if limits.closed:
            bound[0] = min(bound[0], np.sqrt(2.0 * limits.energy_max[-1]))
        else:
            fixed[[0, -1]] = True
        lower = [np.where(fixed, bound, np.minimum(_LEAST_SPEED, bound)), np.zeros(self.size - self.speeds)]
        upper = [bound, np.full(self.intervals, np.inf)]
        if self.braking:
            upper.append(np.full(self.intervals, limits.brake / _FORCE_SCALE))
        return np.concatenate(lower), np.concatenate(upper)

    def _interval_blocks(self) -> list[Block]:
        """A block for every set of bounds on force that can bind together."""
        limits = self.limits
        binding = np.array([_can_bind(limits, limit) for limit in limits.forces], dtype=bool).reshape(len(limits.forces), self.intervals)
        kinds, kind = np.unique(binding, axis=1, return_inverse=True)
        used = [[limit for limit, on in zip(limits.forces, column, strict=True) if on] for column in kinds.T]
        return [self._interval_block(forces, np.flatnonzero(kind.ravel() == k)) for k, forces in enumerate(used)]

    def _interval_block(self, forces: list[ForceLimit], at: Ints) -> Block:
        limits = self.limits
        slopes = [limits.slope_against(1), limits.slope_against(-1)]
        data = [limits.ds, np.diff(limits.z), *slopes, *(np.broadcast_to(x, limits.ds.shape) for limit in forces for x in limit.data)]
        local = self._interval(forces, len(data))
        low, high = np.full((local.rows.shape[0], len(at)), -np.inf), np.zeros((local.rows.shape[0], len(at)))
        low[0], high[0] = -np.minimum(limits.deceleration, _FREE)[at], np.minimum(limits.acceleration, _FREE)[at]
        low[1], high[1] = 0.0, np.inf
        own = np.arange(self.speeds, self.size).reshape(-1, self.intervals)[:, at]
        columns = np.vstack([self.station[at], self.station[at + 1], own])
        return Block.of(local, columns, np.array(data)[:, at], low, high, self.until[:, at])

    def _interval(self, forces: list[ForceLimit], known: int) -> Local:
        """One interval on symbols: acceleration, p - F, then two rows per bound on force."""
        vehicle = self.limits.vehicle
        unknown, data = ca.SX.sym("unknown", 4 if self.braking else 3), ca.SX.sym("data", known)
        v0, v1, pull, brake = unknown[0], unknown[1], unknown[2] * _FORCE_SCALE, unknown[3] * _FORCE_SCALE if self.braking else 0.0
        ds, dz = data[0], data[1]
        smooth = msgspec.structs.replace(vehicle, drive=msgspec.structs.replace(vehicle.drive, inverter_per_current_wpa=0.0, gear_efficiency=1.0))
        found = balance(smooth, ds, v0, v1, dz, brake)
        per_force = inverter_factor(vehicle) / vehicle.motor_ratio * found.time + gear_factor(vehicle) * ds
        # the change of kinetic energy is given by the ends; its large terms would only cancel
        energy = sum(part for name, part in found.energies.items() if name != "kinetic") + (2.0 * pull - found.force) * per_force
        gain = (v1**2 - v0**2) / (2.0 * ds)
        rows, at = [gain, unknown[2] - found.force / _FORCE_SCALE], 4
        for limit in forces:
            own = tuple(data[at + k] for k in range(len(limit.data)))
            at += len(own)
            for v in (v0, v1):
                wheels = vehicle.effective_mass * gain + driving_resistance(vehicle, v, data[2 if limit.sign > 0 else 3])
                rows.append(limit.excess(vehicle, wheels + (brake if limit.of == "motors" else 0.0), v, own))
        return Local(unknown, data, energy / _ENERGY_SCALE, found.time, ca.vertcat(*rows))

    def _jerk_block(self) -> Block:
        """Speed times the change of acceleration, at stations with an interval on both sides (on circuits all of them), stop lines apart."""
        limits = self.limits
        middle = np.arange(0 if limits.closed else 1, self.intervals)
        middle = middle[limits.energy_max[middle] > 0.0]
        before = (middle - 1) % self.intervals
        unknown, data = ca.SX.sym("unknown", 3), ca.SX.sym("data", 2)
        v0, v, v1 = (unknown[k] for k in range(3))
        change = (v1**2 - v**2) / (2.0 * data[1]) - (v**2 - v0**2) / (2.0 * data[0])
        nothing, jerk = ca.SX(0.0), v * change / (0.5 * (data[0] + data[1]))
        columns = np.vstack([self.station[before], self.station[middle], self.station[middle + 1]])
        bound = np.full((1, len(middle)), limits.jerk)
        local = Local(unknown, data, nothing, nothing, jerk)
        return Block.of(local, columns, np.array([limits.ds[before], limits.ds[middle]]), -bound, bound, np.zeros((len(self.until), len(middle))))


def _can_bind(limits: SpeedLimits, limit: ForceLimit) -> NDArray[np.bool_]:
    """(n-1,) where a bound on force is tighter than what the bounds on speed and acceleration leave (the answer is checked all the same)."""
    if limit.of == "tyres" or (limit.sign < 0 and limits.brake > 0.0):
        return np.ones(len(limits.ds), dtype=bool)
    fastest = np.sqrt(2.0 * np.maximum(limits.energy_max[1:], limits.energy_max[:-1]))
    most = limits.vehicle.effective_mass * (limits.acceleration if limit.sign > 0 else limits.deceleration)
    binds = np.zeros(len(fastest), dtype=bool)
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        v = share * fastest
        binds |= limit.ceiling(limits.vehicle, v, limit.data) < most + limit.sign * limits.resistance(v, limit.sign)
    return binds
