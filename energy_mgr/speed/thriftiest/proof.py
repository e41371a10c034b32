"""A proven lower bound on the energy of all profiles within limits, from the multipliers of a solution (weak duality).

The Lagrangian at any multipliers that are not negative bounds the energy from below once it is minimised over all speeds within their bounds. That
minimum is had in closed form after every term has been replaced by one below it that touches it at the solution:

    |F| >= sigma F                                                    -1 <= sigma <= 1
    (|F| + d)^2 / v' >= 2 zeta (|F| + d) - zeta^2 v'                  a square over a positive number is convex
    roll(v'), price / v' >= their tangents in v'                      convex
    force limits: ceiling(v) <= c0 + c2 v^2                           `ForceLimit.majorant`

with v' the mean speed of an interval. What is left is p_i v_i^2/2 + b_i v_i, summed over the stations. Losses that are left out (field weakening)
are not negative, bounds that are left out (jerk, battery power) only allow more: both lower the bound, never raise it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from powertrain.energy.balance import balance
from powertrain.energy.motor import copper_factor, gear_factor, inverter_factor
from powertrain.energy.resistance import drag_force, rolling_force, slope_force

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from ..bounds.speed_limits import SpeedLimits
    from .chain import Chain
    from .iterate import Iterate

    Floats = NDArray[np.float64]


def lower_bound(limits: SpeedLimits, programme: Chain, found: Iterate, fastest: Floats, v: Floats, journey_time: float) -> float:
    """Energy in J that no profile within `limits` undercuts that arrives within `journey_time` (and within the windows).

    Args:
        limits: what bounds the speed.
        programme: what was solved.
        found: its solution, for the multipliers; any others give a bound too, a weaker one.
        fastest: (n,) speeds that no profile within the limits passes, m/s.
        v: (n,) speeds of the solution, m/s, where the terms are touched.
        journey_time: s.
    """
    return _Bound(limits, programme, found, fastest, np.maximum(v, 1e-6)).value(journey_time)


class _Bound:
    def __init__(self, limits: SpeedLimits, programme: Chain, found: Iterate, fastest: Floats, v: Floats) -> None:
        self.limits, self.programme, self.found = limits, programme, found
        self.fastest, self.v, self.mean = fastest, v, 0.5 * (v[1:] + v[:-1])
        count = len(limits.ds)
        #: coefficients of e at both ends, of v at both ends, per interval, and a constant
        self.by_e, self.by_v, self.constant = np.zeros((count, 2)), np.zeros((count, 2)), np.zeros(count)
        self.by_brake = np.zeros(count)

    def value(self, journey_time: float) -> float:
        """The bound, J."""
        limits = self.limits
        price, fixed = self._prices(journey_time)
        self._energy(price)
        self._comfort()
        self._forces()
        e, b = np.zeros(len(self.v)), np.zeros(len(self.v))
        e[:-1] += self.by_e[:, 0]
        e[1:] += self.by_e[:, 1]
        b[:-1] += self.by_v[:, 0]
        b[1:] += self.by_v[:, 1]
        if limits.closed:
            e[0], b[0] = e[0] + e[-1], b[0] + b[-1]
            e, b = e[:-1], b[:-1]
        high = self.fastest[: len(e)]
        inner = np.clip(np.where(e > 0.0, -b / np.where(e > 0.0, e, 1.0), np.where(0.5 * e * high + b < 0.0, high, 0.0)), 0.0, high)
        at = np.where(self.programme.fixed[: len(e)], high, inner)
        brake = np.minimum(self.by_brake, 0.0) * limits.brake
        energy = limits.energy_max
        kinetic = 0.0 if limits.closed else limits.vehicle.effective_mass * (energy[-1] - energy[0])
        return float(np.sum(0.5 * e * at**2 + b * at) + np.sum(self.constant) + np.sum(brake) - fixed + kinetic)

    def _prices(self, journey_time: float) -> tuple[Floats, float]:
        """Price of a second in each interval, W, and the sum of all multipliers times their times, J."""
        programme, unit = self.programme, self.programme.model.unit
        multipliers = unit * self.found.price / np.array([row.bound for row in programme.deadlines])
        idle = self.limits.vehicle.drive.motor_count * self.limits.vehicle.drive.inverter_constant_w
        price, fixed = np.full(len(self.mean), unit * programme.price), unit * programme.price * journey_time
        for keep_early in (True, False):
            price, fixed = np.full(len(self.mean), unit * programme.price), unit * programme.price * journey_time
            for row, multiplier in zip(programme.deadlines, multipliers, strict=True):
                if row.sign > 0 or keep_early:
                    price[: row.intervals] += row.sign * multiplier
                    fixed += row.sign * multiplier * row.bound
            if np.all(price + idle >= 0.0):
                break
        return price, fixed

    def _energy(self, price: Floats) -> None:
        limits, vehicle, ds, mean = self.limits, self.limits.vehicle, self.limits.ds, self.mean
        p, count, ratio = vehicle.drive, vehicle.drive.motor_count, vehicle.motor_ratio
        dual, model = self.found.dual, self.programme.model
        brake = self.found.local[:, 1] * model.force_scale if model.braking else np.zeros_like(ds)
        force = np.asarray(balance(vehicle, ds, self.v[:-1], self.v[1:], np.diff(limits.z), brake).force)
        beta, alpha = copper_factor(vehicle) / (count * ratio**2), inverter_factor(vehicle) / ratio
        seconds = price + count * p.inverter_constant_w
        shift = np.minimum(alpha / (2.0 * beta), np.sqrt(np.maximum(seconds, 0.0) / beta))
        zeta = (np.abs(force) + shift) / mean
        # what the square does not take of the loss that grows with |F|: |F| / v' is at least |F| over the largest v'
        high = 0.5 * (self.fastest[1:] + self.fastest[:-1])
        weight = 2.0 * beta * zeta + gear_factor(vehicle) + (alpha - 2.0 * beta * shift) / np.maximum(high, 1e-6)
        z_rows = dual[:, 2] + dual[:, 3]
        sign = np.where(z_rows > 0.0, (dual[:, 2] - dual[:, 3]) / np.where(z_rows > 0.0, z_rows, 1.0), 0.0)
        kink = alpha / mean + gear_factor(vehicle)
        sigma = (2.0 * beta * force / mean + kink * sign) / np.maximum(weight, 1e-12)
        sigma = np.clip(sigma, -1.0, 1.0)
        self._force(weight * sigma * ds)
        slope = slope_force(vehicle, limits.slope)
        drag = drag_force(vehicle, 1.0) * ds
        self.by_e += drag[:, None]
        iron = count * ratio * (p.hysteresis_nm + p.friction_nm)
        self.constant += ds * (slope + iron + 2.0 * beta * zeta * shift)
        self.by_brake += ds
        rest = seconds - beta * shift**2
        eddy = count * p.eddy_nms * ratio**2 - beta * zeta**2
        rolling, by_rolling = self._rolling(1.0 + weight * sigma, mean, high)
        by = by_rolling + eddy - rest / mean**2
        self.by_v += 0.5 * (ds * by)[:, None]
        self.constant += ds * (rolling + 2.0 * rest / mean)

    def _rolling(self, weight: Floats, v: Floats, high: Floats) -> tuple[Floats, Floats]:
        """A line in speed, value at rest and slope, below weight times the rolling resistance from 0 to `high`, touching it at `v` if it can."""
        vehicle = self.limits.vehicle
        rest = rolling_force(vehicle, np.zeros_like(v))
        chord = (rolling_force(vehicle, high) - rest) / np.maximum(high, 1e-6)
        tangent = _slope(lambda x: rolling_force(vehicle, x), v)
        convex = weight >= 0.0
        return weight * np.where(convex, rolling_force(vehicle, v) - tangent * v, rest), weight * np.where(convex, tangent, chord)

    def _force(self, weight: Floats) -> None:
        """Add weight times the force of the intervals, rolling resistance apart."""
        limits, vehicle = self.limits, self.limits.vehicle
        inertia, drag = vehicle.effective_mass / limits.ds, drag_force(vehicle, 1.0)
        self.by_e += (weight * drag)[:, None] + (weight * inertia)[:, None] * np.array([-1.0, 1.0])
        self.constant += weight * slope_force(vehicle, limits.slope)
        self.by_brake += weight

    def _comfort(self) -> None:
        """Add the rows of acceleration and deceleration times their multipliers."""
        unit, limits = self.programme.model.unit, self.limits
        up, down = (unit * self.found.dual[:, k] / bound for k, bound in ((0, limits.acceleration), (1, limits.deceleration)))
        self.by_e += ((up - down) / limits.ds)[:, None] * np.array([-1.0, 1.0])
        self.constant -= unit * (self.found.dual[:, 0] + self.found.dual[:, 1])

    def _forces(self) -> None:
        """Add the rows of the force limits, as lines above their ceilings."""
        limits, vehicle, model = self.limits, self.limits.vehicle, self.programme.model
        gain = np.diff(self.v**2) / (2.0 * limits.ds)
        brake = self.found.local[:, 1] * model.force_scale if model.braking else 0.0
        for k, limit in enumerate(model.forces):
            for end in range(2):
                v = self.v[end : len(self.v) - 1 + end]
                high = self.fastest[end : len(self.v) - 1 + end]
                line = limit.majorant(vehicle, v, high, limit.data)
                if line is None:
                    continue
                force = vehicle.effective_mass * gain + limits.resistance(v, limit.sign) + (brake if limit.of == "motors" else 0.0)
                by = _slope_force(lambda f, limit=limit, v=v: limit.excess(vehicle, f, v, limit.data), force)
                weight = model.unit * self.found.dual[:, model.FIRST + 2 * k + end] * np.abs(by)
                self._end(end, limit.sign, weight, v, high, motors=limit.of == "motors")
                self.constant -= weight * line[0]
                self.by_e[:, end] -= 2.0 * weight * line[1]

    def _end(self, end: int, sign: int, weight: Floats, v: Floats, high: Floats, *, motors: bool) -> None:
        """Add sign times weight times the force at one end of the intervals."""
        weight = sign * weight
        limits, vehicle = self.limits, self.limits.vehicle
        inertia = vehicle.effective_mass / limits.ds
        self.by_e += (weight * inertia)[:, None] * np.array([-1.0, 1.0])
        self.by_e[:, end] += 2.0 * weight * drag_force(vehicle, 1.0)
        line, by = self._rolling(weight, v, high)
        self.by_v[:, end] += by
        self.constant += line + weight * slope_force(vehicle, limits.slope_against(sign))
        if motors:
            self.by_brake += weight


def _slope(function: Callable[[Any], Any], v: Floats) -> Floats:
    """Derivative of a polynomial by speed, exact to rounding (complex step)."""
    return np.imag(function(v + 1e-30j)) / 1e-30


def _slope_force(function: Callable[[Floats], Floats], force: Floats) -> Floats:
    return (function(force + 1.0) - function(force - 1.0)) / 2.0
