"""Energy, time and limits of a drive as second-order cones, linearised about a profile where they are not convex.

Variables per station are e = v^2/2 and u <= v, per interval the force F, z >= |F|, the time t and the resistive loss y. With v' = (u0 + u1)/2:

    t v' >= ds                    time                            (cone)
    y v' >= (z + delta)^2         losses that grow with force     (cone)
    u^2 <= 2 e                    kinetic energy                  (cone)

The losses of M1 per interval, n t (P0 + a |tau| + b tau^2) with tau = F / (n rho), are exactly

    b / (n rho^2) ds y + n (P0 - b d^2) t + (a - 2 b d) / rho |F| t,      delta = n rho d

for any d. With d = a / 2b the last term vanishes and all is convex in (F, v') as it stands, provided that P0 >= a^2 / 4b, as for most drives. Where
that fails d = sqrt(P0 / b) makes the middle term vanish and the last one, a product, is linearised. Everything that u appears in falls with u, hence
u = v and t, y are tight at the optimum. What else is not convex is small: rolling resistance and eddy currents through the mean speed, and the power
limit. They are linearised about the profile, the power limit from within. The copper loss of field weakening (cars with `drive.weakening`) is in no
term.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from powertrain.energy.balance import balance
from powertrain.energy.motor import copper_factor, gear_factor, inverter_factor
from powertrain.energy.resistance import drag_force, rolling_force, slope_force

from ...errors import SolverError
from .cones import ConeProgramme

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from ..bounds.speed_limits import SpeedLimits

    Floats = NDArray[np.float64]


class ConeModel:
    """The cone programme on scaled variables, about one profile.

    Args:
        limits: what bounds the speed.
        about: (n,) speeds to linearise about, m/s.
        journey_time: allowed time, s.

    Attributes:
        exact: whether the last solution meets the solver's full tolerances.
    """

    def __init__(self, limits: SpeedLimits, about: Floats, journey_time: float) -> None:
        self.limits, self.n = limits, len(limits.s)
        self.v_scale = float(np.max(limits.v_max))
        self.e_scale, self.f_scale = 0.5 * self.v_scale**2, limits.vehicle.effective_mass
        self.t_scale = limits.ds / self.v_scale
        n = self.n
        self.e, self.u = np.arange(n), np.arange(n, 2 * n)
        self.z, self.y, self.t = (np.arange(2 * n + k * (n - 1), 2 * n + (k + 1) * (n - 1)) for k in range(3))
        self.cones = ConeProgramme(5 * n - 3)
        self.v, self.exact = about, False
        # about standstill the slope of v over v^2/2, which is 1/v, is unbounded; a floor only makes the linearisation there coarser
        self.per_v = 1.0 / np.maximum(about, 0.05 * self.v_scale)
        self.force = self._force()
        self._ends_and_bounds()
        self._accelerations_and_forces()
        self._cones(journey_time)
        self._journey_time = journey_time

    def solve(self) -> Floats:
        """The speeds (n,) of least energy on this model.

        Raises:
            SolverError: Clarabel found none.
        """
        solution, self.exact = self.cones.solve(self.objective())
        limits = self.limits
        if solution is None:
            raise SolverError(f"{limits.name}: the cone solver found no speed profile of {self._journey_time:.2f} s")
        e = np.clip(solution[self.e] * self.e_scale, 0.0, limits.energy_max)
        if limits.closed:
            e[0] = e[-1] = min(e[0], e[-1])
        return np.sqrt(2.0 * e)

    def model_error(self, v: Floats) -> float:
        """By how much energy this linear model is wrong about the profile `v`, J: the terms that it linearises, added without signs."""
        vehicle, ds = self.limits.vehicle, self.limits.ds
        e, mean = 0.5 * v**2, 0.5 * (v[:-1] + v[1:])
        by0, by1, constant = self.force
        true = balance(vehicle, ds, v[:-1], v[1:], np.diff(self.limits.z)).force
        eddy0, eddy1, rest = self._mean_speed(np.full(self.n - 1, self._eddy_force()))
        mean_about = 0.5 * (self.v[:-1] + self.v[1:])
        product, gap = self._product(), np.abs(true) - np.abs(self._force_about())
        late = ds / mean - ds / mean_about
        eddy = eddy0 * e[:-1] + eddy1 * e[1:] + rest - self._eddy_force() * (mean - mean_about)
        linear = np.abs(by0 * e[:-1] + by1 * e[1:] + constant - true) + np.abs(eddy)
        return float(np.sum(linear * ds + product * np.abs(gap * late)))

    def _force_about(self) -> Floats:
        """Force of each interval in the profile that the model is about, N."""
        return np.asarray(balance(self.limits.vehicle, self.limits.ds, self.v[:-1], self.v[1:], np.diff(self.limits.z)).force)

    def _split(self) -> float:
        """d of the module's description: by how much torque is shifted before it is squared, Nm."""
        vehicle = self.limits.vehicle
        b = copper_factor(vehicle)
        return min(inverter_factor(vehicle) / (2.0 * b), float(np.sqrt(vehicle.drive.inverter_constant_w / b)))

    def _product(self) -> float:
        """What is left of the loss that grows with |F| t, per newton and second."""
        vehicle = self.limits.vehicle
        return (inverter_factor(vehicle) - 2.0 * copper_factor(vehicle) * self._split()) / vehicle.motor_ratio

    def _eddy_force(self) -> float:
        """Eddy-current loss per metre and mean speed, Ns/m."""
        return self.limits.vehicle.drive.motor_count * self.limits.vehicle.drive.eddy_nms * self.limits.vehicle.motor_ratio**2

    def _mean_speed(self, slope_of: Floats) -> tuple[Floats, Floats, Floats]:
        """A function f of the mean speed, linear in e about the profile: coefficients of e0, e1 given df/dv, and what to add to f there."""
        by0, by1 = 0.5 * slope_of * self.per_v[:-1], 0.5 * slope_of * self.per_v[1:]
        return by0, by1, -(by0 * 0.5 * self.v[:-1] ** 2 + by1 * 0.5 * self.v[1:] ** 2)

    def _force(self) -> tuple[Floats, Floats, Floats]:
        """Force of each interval in N as coefficients of e0, e1 (m^2/s^2) and a constant."""
        vehicle, ds = self.limits.vehicle, self.limits.ds
        mean = 0.5 * (self.v[:-1] + self.v[1:])
        rolling = rolling_force(vehicle, mean)
        by0, by1, rest = self._mean_speed(_slope(lambda v: rolling_force(vehicle, v), mean))
        inertia, drag = vehicle.effective_mass / ds, drag_force(vehicle, 1.0)
        constant = rolling + rest + slope_force(vehicle, np.diff(self.limits.z) / ds)
        return by0 + drag - inertia, by1 + drag + inertia, constant

    def _ends_and_bounds(self) -> None:
        e, u, limits = self.e, self.u, self.limits
        bound = limits.energy_max
        inner = np.arange(self.n)
        if limits.closed:
            self.cones.equal([(e[:1], 1.0), (e[-1:], -1.0)], np.zeros(1))
            self.cones.equal([(u[:1], 1.0), (u[-1:], -1.0)], np.zeros(1))
        else:
            inner, ends = inner[1:-1], np.array([0, self.n - 1])
            self.cones.equal([(e[ends], 1.0)], bound[ends] / self.e_scale)
            self.cones.equal([(u[ends], 1.0)], np.sqrt(2.0 * bound[ends]) / self.v_scale)
        self.cones.at_most([(e[inner], 1.0)], bound[inner] / self.e_scale)
        # u^2 <= e in scaled variables
        self.cones.rotated(np.zeros(len(inner)), [(u[inner], 1.0)], [(e[inner], 1.0)], np.zeros(len(inner)), [], np.ones(len(inner)))

    def _accelerations_and_forces(self) -> None:
        e0, e1, limits = self.e[:-1], self.e[1:], self.limits
        steep = self.e_scale / limits.ds
        most, least = limits.acceleration, limits.deceleration
        every = np.ones(self.n - 1)
        self.cones.at_most([(e1, steep / most), (e0, -steep / most)], every)
        self.cones.at_most([(e0, steep / least), (e1, -steep / least)], every)
        by0, by1, constant = self.force
        for sign in (1.0, -1.0):
            parts = [(e0, sign * by0 * self.e_scale / self.f_scale), (e1, sign * by1 * self.e_scale / self.f_scale), (self.z, -1.0)]
            self.cones.at_most(parts, -sign * constant / self.f_scale)
        for end, v in ((e0, self.v[:-1]), (e1, self.v[1:])):
            self._force_limit(end, v)

    def _force_limit(self, end: NDArray[np.intp], v: Floats) -> None:
        """Driving and recuperating force at one end of the intervals, by torque and by power, where they can bind at all."""
        limits, vehicle = self.limits, self.limits.vehicle
        p, gain = vehicle.drive, vehicle.drive.motor_count * vehicle.motor_ratio
        fastest = np.sqrt(2.0 * np.maximum(limits.energy_max[1:], limits.energy_max[:-1]))
        most = vehicle.effective_mass * limits.acceleration + limits.resistance(fastest, 1)
        least = vehicle.effective_mass * limits.deceleration - limits.resistance(0.0 * fastest, -1)
        flat, moving = np.zeros_like(v), np.maximum(v, 1e-3)
        for sign, extreme, torque, power in (
            (1.0, most, p.torque_max_nm, p.power_max_w),
            (-1.0, least, p.regen_torque_max_nm, p.regen_power_max_w),
        ):
            self._force_rows(sign, end, v, np.flatnonzero(extreme > gain * torque), flat + gain * torque, flat)
            by_power = np.flatnonzero((extreme > p.motor_count * power / fastest) & (v > 0.0))
            # P/v is convex in e, so its tangent lies below it: the linearised limit is on the safe side
            self._force_rows(sign, end, v, by_power, p.motor_count * power / moving, -p.motor_count * power / moving**3)

    def _force_rows(self, sign: float, end: NDArray[np.intp], v: Floats, at: NDArray[np.intp], bound: Floats, bound_by: Floats) -> None:
        """sign * force at one end of the intervals `at` at most `bound` + `bound_by` (e - v^2/2)."""
        if not len(at):
            return
        limits, vehicle, v = self.limits, self.limits.vehicle, v[at]
        rolling_by = _slope(lambda x: rolling_force(vehicle, x), v) / np.maximum(v, 0.05 * self.v_scale)
        fixed = rolling_force(vehicle, v) - rolling_by * 0.5 * v**2 + slope_force(vehicle, limits.slope_against(1 if sign > 0 else -1)[at])
        own = sign * (2.0 * drag_force(vehicle, 1.0) + rolling_by) - bound_by[at]
        inertia = sign * vehicle.effective_mass / limits.ds[at]
        room = bound[at] - bound_by[at] * 0.5 * v**2 - sign * fixed
        scale = self.e_scale / self.f_scale
        parts = [(self.e[1:][at], inertia * scale), (self.e[:-1][at], -inertia * scale), (end[at], own * scale)]
        self.cones.at_most(parts, room / self.f_scale)

    def _cones(self, journey_time: float) -> None:
        mean = [(self.u[:-1], 0.5), (self.u[1:], 0.5)]
        every = np.zeros(self.n - 1)
        self.cones.rotated(every + self._delta() / self.f_scale, [(self.z, 1.0)], [(self.y, 1.0)], every, mean, every)
        self.cones.rotated(every + 1.0, [], [(self.t, 1.0)], every, mean, every)
        # one row over all intervals, divided by their number to stay of order one
        share = 1.0 / (self.n - 1)
        mean = float(np.mean(self.t_scale))
        self.cones.total_at_most(self.t, share * self.t_scale / mean, journey_time / mean * share)

    def _delta(self) -> float:
        vehicle = self.limits.vehicle
        return self._split() * vehicle.drive.motor_count * vehicle.motor_ratio

    def objective(self) -> Floats:
        """Energy over e, y and t, in units of effective mass times the mean interval."""
        vehicle, ds = self.limits.vehicle, self.limits.ds
        count, ratio, share = vehicle.drive.motor_count, vehicle.motor_ratio, ds / np.mean(ds)
        q = np.zeros(5 * self.n - 3)
        # the change of kinetic energy is given by the ends, so inertia is left out: its large terms would only cancel
        inertia = vehicle.effective_mass / ds
        by0, by1 = self.force[0] + inertia, self.force[1] - inertia
        eddy0, eddy1, _ = self._mean_speed(np.full(self.n - 1, self._eddy_force()))
        np.add.at(q, self.e[:-1], (by0 + eddy0) * self.e_scale * share)
        np.add.at(q, self.e[1:], (by1 + eddy1) * self.e_scale * share)
        b = copper_factor(vehicle)
        q[self.y] = b / (count * ratio**2) * self.f_scale**2 / self.v_scale * share
        price = count * max(vehicle.drive.inverter_constant_w - b * self._split() ** 2, 0.0)
        q[self.t] = (price + self._product() * np.abs(self._force_about())) * self.t_scale / float(np.mean(ds))
        q[self.z] = (self._product() * 2.0 / (self.v[:-1] + self.v[1:]) + gear_factor(vehicle)) * self.f_scale * share
        return q / self.f_scale


def _slope(function: Callable[[Floats], Floats], v: Floats) -> Floats:
    """Derivative of a polynomial of degree four by speed, exact to rounding (complex step)."""
    step = 1e-30
    return np.imag(function(v + 1j * step)) / step  # pyright: ignore[reportArgumentType]
