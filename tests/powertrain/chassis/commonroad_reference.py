"""Double-track and single-track reference manoeuvres with the vehicle models of CommonRoad (package `commonroad-vehicle-models`, BSD-3).

An independent oracle for the chassis models: the multi-body model MB (29 states) and the single-track drift model STD are driven through circles,
step steers and lane changes by a prescribed steering angle and a speed controller. The package is used as it is; what is switched off is switched off
in its parameters (`switched`). Its frame is x forward, y right, z down: steering, yaw rate and lateral acceleration are positive to the same side,
so the planar results equal ours, but left and right wheels trade places, and roll has the opposite sign for the same turn.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root
from vehiclemodels.utils.tire_model import formula_longitudinal
from vehiclemodels.vehicle_dynamics_mb import vehicle_dynamics_mb
from vehiclemodels.vehicle_dynamics_std import vehicle_dynamics_std

Array = NDArray[np.float64]
Model = Literal["mb", "std"]
Signal = Callable[[float], float]

MB_STATES = (
    "x", "y", "steer", "v_x", "yaw", "yaw_rate", "roll", "roll_rate", "pitch", "pitch_rate", "v_y", "z", "v_z",
    "roll_f", "roll_rate_f", "v_y_f", "z_f", "v_z_f", "roll_r", "roll_rate_r", "v_y_r", "z_r", "v_z_r",
    "spin_lf", "spin_rf", "spin_lr", "spin_rr", "slide_f", "slide_r",
)  # fmt: skip
STD_STATES = ("x", "y", "steer", "v", "yaw", "yaw_rate", "beta", "spin_f", "spin_r")
MB = {name: k for k, name in enumerate(MB_STATES)}
STD = {name: k for k, name in enumerate(STD_STATES)}

# an equilibrium leaves these free; each is found from the derivative in the same place of the second tuple
_MB_FREE = (
    "yaw_rate", "roll", "pitch", "v_y", "z", "roll_f", "v_y_f", "z_f", "roll_r", "v_y_r", "z_r",
    "spin_lf", "spin_rf", "spin_lr", "spin_rr", "slide_f", "slide_r",
)  # fmt: skip
_MB_ZERO = (
    "yaw_rate", "roll_rate", "pitch_rate", "v_y", "v_z", "roll_rate_f", "v_y_f", "v_z_f", "roll_rate_r", "v_y_r", "v_z_r",
    "spin_lf", "spin_rf", "spin_lr", "spin_rr", "slide_f", "slide_r",
)  # fmt: skip
# about the size of each unknown, and what brings its equation to order one
_MB_SCALE = np.array([0.1, 0.05, 0.01, 0.5, 0.05, 0.05, 0.5, 0.05, 0.05, 0.5, 0.05, 50.0, 50.0, 50.0, 50.0, 0.05, 0.05])
_MB_WEIGHT = np.array([1.0, 0.1, 0.1, 1.0, 1.0, 0.05, 0.1, 0.02, 0.05, 0.1, 0.02, 1e-3, 1e-3, 1e-3, 1e-3, 1.0, 1.0, 1.0])
GRAVITY = 9.81


@dataclass(frozen=True)
class History:
    """Time histories, all of shape (n,), SI units and rad; `state` is (n, states).

    `lateral_acceleration` is that of the whole mass, side forces over mass; `body_lateral_acceleration` that of MB's sprung mass, which roll swings.
    """

    time: Array
    steer: Array
    speed: Array
    yaw_rate: Array
    lateral_acceleration: Array
    body_lateral_acceleration: Array
    side_slip: Array
    roll: Array
    state: Array


@dataclass(frozen=True)
class Sweep:
    """Steady circles, all of shape (n,)."""

    steer: Array
    speed: Array
    yaw_rate: Array
    lateral_acceleration: Array
    side_slip: Array
    roll: Array
    wheelbase: float

    @property
    def understeer_gradient(self) -> float:
        """Slope of `steer - L/R` over lateral acceleration, rad/(m/s^2), by least squares through all circles."""
        extra = self.steer - self.wheelbase * self.yaw_rate / self.speed
        return float(np.polyfit(self.lateral_acceleration, extra, 1)[0])


def switched(p: Any, *, offsets: bool = True, camber: bool = True, compliance: bool = True) -> Any:
    """A copy of the package's parameters with some effects taken out.

    Args:
        p: parameter object of the package (`parameters_vehicle2()`); it is not changed.
        offsets: keep the shifts of the tyre curves (conicity, ply steer, free-rolling force). They jump with the sign of camber, which makes MB weave
            by itself when it runs straight (1.6 Hz, 0.4 m/s^2 at 20 m/s): take them out for anything that passes through straight ahead.
        camber: keep what camber does to side force; without it the shifts that hang on camber's sign go too.
        compliance: keep the lateral give of the pin joints and tyres; without it they are a hundred times stiffer.
    """
    copy = deepcopy(p)
    if not offsets or not camber:
        for key in ("p_hy1", "p_vy1"):
            setattr(copy.tire, key, 0.0)
    if not offsets:
        for key in ("p_hx1", "p_vx1", "r_hx1", "r_hy1"):
            setattr(copy.tire, key, 0.0)
    if not camber:
        for key in ("p_hy3", "p_vy3", "p_dx3", "p_dy3", "r_vy3"):
            setattr(copy.tire, key, 0.0)
    if not compliance:
        copy.K_ras, copy.K_rad, copy.K_lt = 100.0 * copy.K_ras, 10.0 * copy.K_rad, 0.0
    return copy


def mb_rest(p: Any, v: float) -> Array:
    """State of MB rolling straight ahead with springs, tyres and wheel spin in balance; unstable with the tyre's offsets, see `switched`.

    `init_mb` of the package puts the sprung mass at z = 0 while the axles sink into the tyres, which starts a heave and pitch motion, and lets the
    wheels roll without slip, where the shifts of the tyre curve leave a force.
    """
    x = np.zeros(len(MB_STATES))
    base = p.a + p.b
    load_f, load_r = (p.m_s * p.b / base + p.m_uf) * GRAVITY / 2.0, (p.m_s * p.a / base + p.m_ur) * GRAVITY / 2.0
    x[MB["z_f"]], x[MB["z_r"]] = load_f / p.K_zt, load_r / p.K_zt
    x[MB["pitch"]] = (x[MB["z_r"]] - x[MB["z_f"]]) / base
    x[MB["z"]] = x[MB["z_f"]] + p.a * x[MB["pitch"]]
    x[MB["v_x"]] = v
    for wheel, load in (("spin_lf", load_f), ("spin_rf", load_f), ("spin_lr", load_r), ("spin_rr", load_r)):
        slip = brentq(lambda s, load=load: formula_longitudinal(s, 0.0, load, p.tire), -0.02, 0.02)
        x[MB[wheel]] = v * (1.0 - float(slip)) / p.R_w
    return x


def _mb_guess(p: Any, v: float, steer: float) -> Array:
    x = mb_rest(p, v)
    yaw_rate = v * steer / (p.a + p.b)
    slip = yaw_rate * v / (21.92 * GRAVITY)
    x[MB["steer"]], x[MB["yaw_rate"]], x[MB["v_y"]] = steer, yaw_rate, p.b * yaw_rate - slip * v
    x[MB["v_y_f"]], x[MB["v_y_r"]] = x[MB["v_y"]] + p.a * yaw_rate, x[MB["v_y"]] - p.b * yaw_rate
    x[MB["roll"]] = -0.01 * yaw_rate * v  # to the side MB leans to: the camber offsets jump at zero
    for wheel, arm in (("spin_lf", p.T_f), ("spin_rf", -p.T_f), ("spin_lr", p.T_r), ("spin_rr", -p.T_r)):
        x[MB[wheel]] *= 1.0 + 0.5 * arm * yaw_rate / v
    return x


def mb_equilibrium(p: Any, v: float, steer: float) -> tuple[Array, float]:
    """Steady circle of MB: the state (position and yaw zero) and the acceleration command that holds forward speed `v`.

    Raises:
        RuntimeError: no steady circle was found (beyond the grip of the tyres).
    """
    if steer == 0.0:
        return mb_rest(p, v), 0.0
    x = _mb_guess(p, v, steer)
    free, zero = [MB[n] for n in _MB_FREE], [*(MB[n] for n in _MB_ZERO), MB["v_x"]]

    def residual(y: Array) -> Array:
        trial = x.copy()
        trial[free] = y[:-1] * _MB_SCALE
        return np.asarray(vehicle_dynamics_mb(trial.tolist(), [0.0, y[-1]], p))[zero] * _MB_WEIGHT

    found = root(residual, np.append(x[free] / _MB_SCALE, 0.0), method="hybr", options={"xtol": 1e-12})
    if np.max(np.abs(found.fun)) > 1e-7:
        raise RuntimeError(f"MB: no steady circle at v = {v} m/s, steer = {steer} rad: {found.message} {np.max(np.abs(found.fun))}")
    x[free] = found.x[:-1] * _MB_SCALE
    return x, float(found.x[-1])


def std_equilibrium(p: Any, v: float, steer: float) -> tuple[Array, float]:
    """Steady circle of STD: state and acceleration command, as `mb_equilibrium` (here `v` is the speed along the path).

    Raises:
        RuntimeError: no steady circle was found.
    """
    x = np.zeros(len(STD_STATES))
    x[STD["steer"]], x[STD["v"]] = steer, v
    yaw_rate = v * steer / (p.a + p.b)
    start = np.array([yaw_rate, steer * p.b / (p.a + p.b) - yaw_rate * v / 215.0, v / p.R_w / 50.0, v / p.R_w / 50.0, 0.0])

    def residual(y: Array) -> Array:
        trial = x.copy()
        trial[[STD["yaw_rate"], STD["beta"], STD["spin_f"], STD["spin_r"]]] = y[:4] * (1.0, 1.0, 50.0, 50.0)
        f = vehicle_dynamics_std(trial.tolist(), [0.0, y[4]], p)
        return np.array([f[STD[n]] for n in ("v", "yaw_rate", "beta", "spin_f", "spin_r")])

    found = root(residual, start, method="hybr", options={"xtol": 1e-12})
    if np.max(np.abs(found.fun)) > 1e-6:
        raise RuntimeError(f"STD: no steady circle at v = {v} m/s, steer = {steer} rad: {found.message}")
    x[[STD["yaw_rate"], STD["beta"], STD["spin_f"], STD["spin_r"]]] = found.x[:4] * (1.0, 1.0, 50.0, 50.0)
    return x, float(found.x[4])


def circle(p: Any, model: Model, speed: float, steer: float) -> tuple[float, float, float, float, float]:
    """Steady circle: path speed, yaw rate, lateral acceleration (m/s^2), side slip and roll (rad)."""
    if model == "std":
        x, _ = std_equilibrium(p, speed, steer)
        r = float(x[STD["yaw_rate"]])
        return speed, r, speed * r * float(np.cos(x[STD["beta"]])), float(x[STD["beta"]]), 0.0
    x, _ = mb_equilibrium(p, speed, steer)
    v_x, v_y, r = float(x[MB["v_x"]]), float(x[MB["v_y"]]), float(x[MB["yaw_rate"]])
    return float(np.hypot(v_x, v_y)), r, r * v_x, float(np.arctan2(v_y, v_x)), float(x[MB["roll"]])


def sweep_steer(p: Any, model: Model, speed: float, steers: Array) -> Sweep:
    """Circles at one forward speed over steering angles."""
    rows = np.array([circle(p, model, speed, float(steer)) for steer in steers])
    return Sweep(np.asarray(steers, dtype=np.float64), *rows.T, wheelbase=p.a + p.b)


def steer_for(p: Any, model: Model, speed: float, lateral_acceleration: float) -> float:
    """Steering angle of the steady circle with that lateral acceleration, by the secant method."""
    base = p.a + p.b
    d0, d1 = (share * base * lateral_acceleration / speed**2 for share in (1.0, 1.05))
    a0, a1 = (circle(p, model, speed, d)[2] for d in (d0, d1))
    for _ in range(20):
        if abs(a1 - lateral_acceleration) < 1e-9:
            break
        d0, a0, d1 = d1, a1, d1 + (lateral_acceleration - a1) * (d1 - d0) / (a1 - a0)
        a1 = circle(p, model, speed, d1)[2]
    return d1


def sweep_acceleration(p: Any, model: Model, speed: float, accelerations: Array) -> Sweep:
    """Circles at one speed over lateral accelerations."""
    return sweep_steer(p, model, speed, np.array([steer_for(p, model, speed, float(a)) for a in accelerations]))


def sweep_radius(p: Any, model: Model, radius: float, speeds: Array) -> Sweep:
    """Circles of one radius over speeds (ISO 4138, constant radius); radius = path speed / yaw rate."""
    steers: list[float] = []
    for speed in speeds:
        target = float(speed) ** 2 / radius
        steers.append(steer_for(p, model, float(speed), target))
    rows = np.array([circle(p, model, float(v), d) for v, d in zip(speeds, steers, strict=True)])
    return Sweep(np.array(steers), *rows.T, wheelbase=p.a + p.b)


def simulate(p: Any, model: Model, time: Array, steer: Signal, speed: float, *, gain: float = 4.0, reset: float = 2.0) -> History:
    """Drive the prescribed steering angle from straight running, or from the steady circle of `steer(time[0])`, holding forward speed.

    Args:
        p: parameter object of the package.
        model: "mb" or "std".
        time: stations of the result in s, rising.
        steer: front wheel angle in rad over time; it replaces the package's steering integrator and so its rate limit of 0.4 rad/s.
        speed: forward speed to hold, m/s.
        gain: proportional gain of the speed controller, 1/s; it commands acceleration, which the package turns into drive or brake torque.
        reset: its integral gain, 1/s^2.
    """
    names, rates = (MB, vehicle_dynamics_mb) if model == "mb" else (STD, vehicle_dynamics_std)
    start, hold = (mb_equilibrium if model == "mb" else std_equilibrium)(p, speed, steer(float(time[0])))
    k_v, k_steer = names["v_x" if model == "mb" else "v"], names["steer"]

    def derivative(t: float, y: Array) -> Array:
        x = y[:-1].tolist()
        x[k_steer] = steer(t)
        error = speed - x[k_v]
        f = rates(x, [0.0, hold + gain * error + reset * float(y[-1])], p)
        f[k_steer] = 0.0
        return np.array([*f, error])

    # the side of the tyres' camber offsets jumps at zero roll: short steps keep the integrator honest there
    found = solve_ivp(derivative, (float(time[0]), float(time[-1])), np.append(start, 0.0), "LSODA", time, rtol=1e-7, atol=1e-8, max_step=0.01)
    if not found.success:
        raise RuntimeError(f"{model}: integration stopped at {found.t[-1]} s: {found.message}")
    state = found.y[:-1].T.copy()
    state[:, k_steer] = [steer(float(t)) for t in time]
    change = np.array([derivative(float(t), y)[:-1] for t, y in zip(time, found.y.T, strict=True)])
    return _std_history(time, state, change) if model == "std" else _mb_history(p, time, state, change)


def _std_history(time: Array, state: Array, change: Array) -> History:
    v, beta, r = state[:, STD["v"]], state[:, STD["beta"]], state[:, STD["yaw_rate"]]
    # sideways in the body's axes, as an accelerometer reads it
    a_y = v * (r + change[:, STD["beta"]]) * np.cos(beta) + change[:, STD["v"]] * np.sin(beta)
    return History(time, state[:, STD["steer"]], v, r, a_y, a_y, beta, np.zeros_like(v), state)


def _mb_history(p: Any, time: Array, state: Array, change: Array) -> History:
    v_x, v_y, r = state[:, MB["v_x"]], state[:, MB["v_y"]], state[:, MB["yaw_rate"]]
    body = change[:, MB["v_y"]] + r * v_x
    inertia = p.m_s * change[:, MB["v_y"]] + p.m_uf * change[:, MB["v_y_f"]] + p.m_ur * change[:, MB["v_y_r"]]
    whole = inertia / (p.m_s + p.m_uf + p.m_ur) + r * v_x
    return History(time, state[:, MB["steer"]], np.hypot(v_x, v_y), r, whole, body, np.arctan2(v_y, v_x), state[:, MB["roll"]], state)
