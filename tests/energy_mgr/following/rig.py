"""Roads to follow, and a rigid car in the plane whose wheels give what is demanded after a lag: Newton's laws, nothing of the laws under test."""

import math
from types import SimpleNamespace

import numpy as np
from scipy.special import fresnel

from energy_mgr import Trajectory
from energy_mgr.motion import MotionDemand, VehicleState

DT = 0.004
#: s; from demand to force ahead, aside and yaw moment
LAGS = (0.01, 0.04, 0.04)


def straight(length=200.0, v=10.0, **more) -> Trajectory:
    s = np.linspace(0.0, length, round(length / 2.0) + 1)
    return Trajectory.along(s, s, 0 * s, 0 * s, 0 * s, np.broadcast_to(v, s.shape), **more)


def arc(radius=60.0, length=200.0, v=10.0, **more) -> Trajectory:
    """Along +x from the origin, to the left for a positive radius."""
    s = np.linspace(0.0, length, round(length / 2.0) + 1)
    angle = s / radius
    x, y = radius * np.sin(angle), radius * (1 - np.cos(angle))
    return Trajectory.along(s, x, y, angle, np.full(len(s), 1 / radius), np.broadcast_to(v, s.shape), **more)


def circle(radius=30.0, count=96, v=10.0, **more) -> Trajectory:
    """Closed, counter-clockwise from (0, -radius) along +x."""
    angle = np.linspace(0.0, 2 * np.pi, count + 1)
    x, y = radius * np.sin(angle), -radius * np.cos(angle)
    x[-1], y[-1] = x[0], y[0]
    return Trajectory.along(radius * angle, x, y, angle, np.full(count + 1, 1 / radius), np.full(count + 1, v), closed=True, **more)


def clothoid(sharpness=5e-4, length=100.0, v=10.0) -> Trajectory:
    s = np.linspace(0.0, length, 101)
    unit = np.sqrt(np.pi / sharpness)
    y, x = fresnel(s / unit)
    return Trajectory.along(s, x * unit, y * unit, 0.5 * sharpness * s**2, sharpness * s, np.full(len(s), v))


def eight(size=40.0, count=400, v=8.0) -> Trajectory:
    """Closed lemniscate of Gerono that crosses itself at the origin."""
    fine = np.linspace(0.0, 2 * np.pi, 200001)

    def derivatives(u):
        return size * np.cos(u), size * np.cos(2 * u), -size * np.sin(u), -2 * size * np.sin(2 * u)

    speed = np.hypot(*derivatives(fine)[:2])
    way = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(fine))))
    s = np.linspace(0.0, way[-1], count + 1)
    u = np.interp(s, way, fine)
    dx, dy, ddx, ddy = derivatives(u)
    x, y, psi = size * np.sin(u), 0.5 * size * np.sin(2 * u), np.unwrap(np.arctan2(dy, dx))
    kappa = (dx * ddy - dy * ddx) / np.hypot(dx, dy) ** 3
    x[-1], y[-1], kappa[-1] = x[0], y[0], kappa[0]
    return Trajectory.along(s, x, y, psi, kappa, np.full(count + 1, v), closed=True, name="eight")


def at_rest(x=0.0, y=0.0, psi=0.0) -> VehicleState:
    return VehicleState(x, y, psi, 0.0, 0.0, 0.0)


def there_and_stop(length=60.0, accelerate=2.0, cruise=8.0, grade=0.0) -> Trajectory:
    """From rest to rest."""
    s = np.linspace(0.0, length, 31)
    v = np.minimum(np.minimum(np.sqrt(2 * accelerate * s), np.sqrt(2 * accelerate * (length - s))), cruise)
    return Trajectory.along(s, s, 0 * s, 0 * s, 0 * s, v, z=grade * s)


def beside(trajectory: Trajectory, s: float, e_y: float = 0.0, e_psi: float = 0.0, v: float | None = None) -> VehicleState:
    """A car at an offset from station `s`, moving where it points."""
    p = trajectory.point(s)
    x, y = p.x - e_y * math.sin(p.psi), p.y + e_y * math.cos(p.psi)
    v = p.v if v is None else v
    return VehicleState(x, y, p.psi + e_psi, v, 0.0, p.kappa * v)


def drive(follower, state, vehicle, duration, *, lags=LAGS, push=(0.0, 0.0, 0.0), noise=None, slope=0.0, most=None, stop=None):
    """Drives for `duration` seconds; returns arrays of e_y, e_psi, v, s, demands and what was done, one row a period.

    `push` are accelerations that nobody told the law of; `noise` is (generator, sigma of place in m); `most` limits what the wheels give (m/s^2).
    """
    mass, spin = vehicle.chassis.mass_kg, vehicle.effective_mass / vehicle.chassis.mass_kg - 1.0
    r = vehicle.resistance
    x, y, psi, vx, vy, yaw = state[:6]
    given = list(push) if lags is None else None
    rows = []
    for _ in range(round(duration / DT)):
        seen = VehicleState(x, y, psi, vx, vy, yaw, friction=state.friction)
        if noise is not None:
            seen = seen._replace(x=x + noise[0].normal(0, noise[1]), y=y + noise[0].normal(0, noise[1]))
        out = follower.step(seen, DT)
        demand = out.demand
        if most is not None:
            demand = MotionDemand(*(min(max(value, -most), most) for value in demand))
            follower.achieved(demand)
        if given is None:
            weight, share = 9.81, 1 / math.sqrt(1 + slope**2)
            given = [weight * slope * share, yaw * vx, 0.0]
        true = follower.trajectory.point(out.at.s)
        off = -(x - true.x) * math.sin(true.psi) + (y - true.y) * math.cos(true.psi)
        rows.append((off, out.at.e_psi, vx, out.at.s, *demand, out.done, out.supervised, x, y, vy, yaw))
        if stop is not None and stop(rows[-1]):
            break
        for k in range(4):  # four Euler steps a period
            h = DT / 4
            for j, lag in enumerate(lags if lags is not None else (None,) * 3):
                given[j] = demand[j] if lag is None else given[j] + h * (demand[j] - given[j]) / lag
            drag = 0.5 * r.air_density_kgpm3 * r.drag_coefficient * r.frontal_area_m2 * vx * abs(vx) / mass
            w = abs(vx) * 3.6 / 100
            rolling = 9.81 * (r.rolling_0 + r.rolling_1 * w + r.rolling_4 * w**4) * math.tanh(vx / 0.02)
            force = given[0] - drag - rolling - 9.81 * slope / math.sqrt(1 + slope**2) + push[0]
            dvx = (force + yaw * vy) / (1 + spin)
            dvy, dr = given[1] + push[1] - yaw * vx, given[2] + push[2]
            x += h * (vx * math.cos(psi) - vy * math.sin(psi))
            y += h * (vx * math.sin(psi) + vy * math.cos(psi))
            psi += h * yaw
            vx, vy, yaw = vx + h * dvx, vy + h * dvy, yaw + h * dr
            del k
    names = ("e_y", "e_psi", "v", "s", "a_x", "a_y", "yaw", "done", "supervised", "x", "y", "v_y", "yaw_rate")
    return SimpleNamespace(**dict(zip(names, np.array(rows, dtype=float).T, strict=True)), out=out)
