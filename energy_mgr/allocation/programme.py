"""The strictly convex programme of one control period, written once in symbols: losses, demand, rates, grip, battery.

Unknown is the change z = (u - u_before) / scale. The cost in kW is

    losses (a parabola about u_before) + 0.5 z' R z + 0.5 gamma |W (b + B du - demand)|^2

with bounds from the actuators, an octagon inside each wheel's friction circle, and the battery's power between its limits. The demand is soft so
that there is an answer to every demand: with gamma as large as here the cost hardly moves the motion (1e-4 m/s^2), and a demand that cannot be
met is met as nearly as the actuators allow, in the norm of W.

Grip and battery bound forces that the last command may already exceed (friction fell, a charging limit came down). So that the programme always has
an answer, each of these rows is opened as far as the point needs that takes all forces back as fast as the actuators can.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from powertrain.energy.motor import motor_losses
from powertrain.symbolic import ca

from ..errors import PlanningError
from .costs import Parabola, blended, checked_cost, heuristic, true_losses
from .effectiveness import STATES, Model, TyreKind
from .layout import NO_FAULTS

if TYPE_CHECKING:
    from .layout import Layout

#: Programmes are scaled to kW.
_KW = 1e3
#: Sides of the polygon within the friction circle, and its inner radius over that of the circle.
_SIDES = 8
_INNER = float(np.cos(np.pi / _SIDES))
#: What a yaw acceleration counts, of what it does elsewhere, in a car with one steered axle: it follows from the lateral one there.
_ONE_AXLE = 0.1
#: Below this speed in m/s the model overrates the tyres, whose deflection takes a way to build up: demands aside fade, and steering becomes slower,
#: at standstill so many times.
_ROLLING, _HELD = 1.5, 1e3
#: kW per squared 0.1 rad: price of angles that differ on an axle with a rack.
_TIE = 1e7
#: Least curvature of any unknown, kW per scaled unit squared: keeps the programme strictly convex where nothing is lost.
_LEAST = 1e-3
#: Rows are opened by this much more than the retreat needs (share of grip, kW): a set that is one point has no answer that a solver finds.
_ROOM = 1e-4


@dataclass(frozen=True)
class Weights:
    """What the allocator gives importance to.

    Attributes:
        demand: gamma, kW per (m/s^2)^2: how much an unmet demand counts.
        yaw: lever in m that makes yaw accelerations comparable to the others.
        torque_rate: kW per squared share of the largest torque moved in a period: smooths what the demand leaves free, not the demand.
        steering_rate: kW per squared 0.1 rad moved in a period.
        brake_rate: kW per squared share of the largest brake torque moved in a period.
        grip: friction coefficient of a dry road for the friction circle.
    """

    demand: float = 1e4
    yaw: float = 1.5
    torque_rate: float = 20.0
    steering_rate: float = 20.0
    brake_rate: float = 2.0
    grip: float = 1.0

    def __post_init__(self) -> None:
        """Refuse what is no weight.

        Raises:
            PlanningError: a weight that is not positive and finite.
        """
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value > 0.0):
                raise PlanningError(f"allocation weight {name} = {value}, expected a positive number")


class Programme:
    """The numbers of the QP, compiled.

    Attributes:
        rows: how many constraint rows there are: the sides of every wheel's polygon, then the battery's power.
        symbols: by name: the last command, state, demand, the battery's window, wheel speeds, period, packed faults.
        results: expressions of them: H, f, A', lower, upper; b at the last command, B times the scale, smallest and largest command.
    """

    def __init__(
        self,
        layout: Layout,
        cost: str = "physical",
        tyre: TyreKind = "own",
        weights: Weights | None = None,
        lead: float | None = None,
        *,
        smooth: bool = True,
    ) -> None:
        """The programme of a car.

        Args:
            layout: its actuators.
            cost: `physical` (true losses), `heuristic` or `blended`.
            tyre: as in `Model`.
            weights: what matters how much.
            lead: s; slip angles are taken from the motion so much later, since a wheel is turned to where it is asked only then. By default the
                steering's lag.
            smooth: whether the change of commands costs.
        """
        self.layout, self.weights = layout, weights or Weights()
        self._cost, self._model = checked_cost(cost), Model(layout, tyre)
        w = self.weights
        #: what the change of each command in a period costs, kW
        self.rates = np.array([w.torque_rate] * layout.motors + [w.brake_rate] * 4 + [w.steering_rate] * len(layout.steered))
        self._smooth = float(smooth) * self.rates
        self._lead = layout.track.steering.lag_s if lead is None else lead
        n = layout.size
        self.rows = 4 * _SIDES + 1
        names = {"before": n, "state": len(STATES), "demand": 3, "window": 2, "wheel_speeds": 4, "dt": 1, "faults": len(layout.packed(NO_FAULTS))}
        symbols = {name: ca.SX.sym(name, count) for name, count in names.items()}
        self.symbols, self.results = symbols, self._written(**symbols)

    def at(self, row: Any) -> list[Any]:
        """The results as expressions of one row with all symbols' numbers."""
        ends = np.cumsum([symbol.numel() for symbol in self.symbols.values()]).tolist()
        parts = [row[start:end] for start, end in zip([0, *ends[:-1]], ends, strict=True)]
        return list(ca.Function("programme", list(self.symbols.values()), self.results)(*parts))

    def _written(self, before: Any, state: Any, demand: Any, window: Any, wheel_speeds: Any, dt: Any, faults: Any) -> list[Any]:
        layout, w = self.layout, self.weights
        u, scale = before, ca.DM(layout.scale)
        wheels = self._model.wheels(ca.vertsplit(u), self._led(state, demand))
        speeds = layout.motor_speeds([wheel.spin for wheel in wheels])
        motion = ca.vertcat(*self._model.motion(wheels))
        effect = ca.jacobian(motion, u) @ ca.diag(scale)
        cost = self._parabola(u, wheels, speeds)
        rolls = np.fmin(np.fmax(state[0] / _ROLLING, 0.0), 1.0)
        weight = w.demand**0.5 * ca.vertcat(1.0, rolls**4, rolls**4 * w.yaw * (1.0 if layout.both_axles else _ONE_AXLE))
        weighted = ca.diag(weight) @ effect
        bend = ca.vertcat(*cost.curvature) * scale**2 / _KW
        held = ca.DM([0.0] * layout.steers.start + [w.steering_rate * _HELD] * len(layout.steered)) * (1.0 - rolls) ** 2
        apart, tie = racks(layout, u)
        H = ca.diag(np.fmax(bend, _LEAST) + ca.DM(self._smooth) + held) + _gram(weighted) + tie
        f = ca.vertcat(*cost.gradient) * scale / _KW + weighted.T @ (weight * (motion - demand)) + apart
        low, high = layout.box(ca.vertsplit(u), ca.vertsplit(wheel_speeds), dt, ca.vertsplit(faults))
        low, high = (ca.vertcat(*bound) for bound in self._braked(low, high, demand, window, wheel_speeds, faults))
        least, most = (low - u) / scale, (high - u) / scale
        A, below, above = self._rows(u, wheels, speeds, state, window, least, most)
        return [H, f, A.T, ca.vertcat(least, below), ca.vertcat(most, above), motion, effect, low, high]

    def _braked(self, low: list[Any], high: list[Any], demand: Any, window: Any, spins: Any, faults: Any) -> tuple[list[Any], list[Any]]:
        """The bounds with friction brakes held back: they are for what recuperation cannot give, not for where it is late.

        Without this a demand that steps would be met by the brakes until the motors have followed. A car with stuck steering may use its brakes at
        will, to turn by them.
        """
        layout, chassis = self.layout, self.layout.vehicle.chassis
        shares = ca.vertsplit(faults)
        speeds = layout.motor_speeds(ca.vertsplit(spins))
        recuperating = [layout.track.torque_range(speed)[1] * shares[k] for k, speed in enumerate(speeds)]
        torque = sum(torque * gain for torque, gain in zip(recuperating, layout.wheel_torque_per_motor, strict=True))
        spin = np.fmax(ca.sum1(ca.fabs(spins)) / 4.0, 1.0)
        torque = np.fmax(np.fmin(torque, -window[0] / spin), 0.0)
        short = np.fmax(-demand[0] * chassis.mass_kg * chassis.wheel_radius_m - torque, 0.0)
        count = len(layout.steered)
        free = shares[layout.motors + 4 : layout.motors + 4 + count]
        stuck = float(count) - sum(free)
        whole = float(np.sum(layout.upper[layout.brakes]))
        for k in range(layout.brakes.start, layout.brakes.stop):
            # twice its part, so that there is a choice between wheels
            part = 2.0 * float(layout.upper[k]) / max(whole, 1e-9) * (short + stuck * whole)
            high[k] = np.fmax(np.fmin(high[k], part), low[k])
        return low, high

    def _led(self, state: Any, demand: Any) -> list[Any]:
        """The state when the steering will have turned, if the demand is met until then."""
        s = dict(zip(STATES, ca.vertsplit(state), strict=True))
        s["v_y"] = s["v_y"] + self._lead * (demand[1] - s["yaw_rate"] * s["v_x"])
        s["yaw_rate"] = s["yaw_rate"] + self._lead * demand[2]
        return [s[name] for name in STATES]

    def _parabola(self, u: Any, wheels: Any, speeds: Any) -> Parabola:
        real = true_losses(self.layout, u, wheels, speeds)
        if self._cost == "physical":
            return real
        rule = heuristic(self.layout, u, wheels)
        for k in range(self.layout.brakes.start, self.layout.brakes.stop):
            # the heuristic knows no brakes
            rule.gradient[k], rule.curvature[k] = real.gradient[k], real.curvature[k]
        return rule if self._cost == "heuristic" else blended(real, rule)

    def _rows(self, u: Any, wheels: Any, speeds: Any, state: Any, window: Any, least: Any, most: Any) -> tuple[Any, Any, Any]:
        """Rows over z with their lower and upper ends."""
        layout, scale = self.layout, ca.DM(self.layout.scale)
        retreat = self._retreat(u, wheels, least, most)
        friction = state[STATES.index("friction")]
        values, limits = [], []
        for wheel in wheels:
            for k in range(_SIDES):
                angle = 2.0 * np.pi * k / _SIDES
                values.append((float(np.cos(angle)) * wheel.along + float(np.sin(angle)) * wheel.side) / wheel.load)
                limits.append(_INNER * self.weights.grip * friction)
        value = ca.vertcat(*values)
        sides = ca.jacobian(value, u) @ ca.diag(scale)
        above = np.fmax(ca.vertcat(*limits) - value, sides @ retreat + _ROOM)
        power = sum(u[k] * speeds[k] + sum(motor_losses(layout.vehicle, u[k], speeds[k])) for k in range(layout.motors))
        slope = ca.gradient(power, u) * scale
        # power is convex in torque: its tangent is below it, by at most this much within the period
        bend = ca.diag(ca.hessian(power, u)[0]) * scale**2
        excess = 0.5 * ca.sum1(bend * np.fmax(least**2, most**2))
        charging, giving = (window[0] - power) / _KW, (window[1] - power - excess) / _KW
        row = slope.T / _KW
        reached = row @ retreat
        A = ca.vertcat(sides, row)
        below = ca.vertcat(ca.DM([-1e30] * value.numel()), np.fmin(charging, reached - _ROOM))
        return A, below, ca.vertcat(above, np.fmax(giving, reached + _ROOM))

    def _retreat(self, u: Any, wheels: Any, least: Any, most: Any) -> Any:
        """The z that takes all forces back as fast as the actuators can."""
        layout = self.layout
        target = [-u[k] for k in range(layout.brakes.stop)]
        # a wheel pushes aside by its slip angle, which its steering turns back one to one
        target += [-wheels[wheel].alpha for wheel in layout.steered]
        return np.fmin(np.fmax(ca.vertcat(*target) / ca.DM(layout.scale), least), most)


def racks(layout: Layout, u: Any, price: float = _TIE) -> tuple[Any, Any]:
    """Gradient and Hessian of what it costs that wheels joined by a rack are turned differently."""
    gradient, hessian = ca.SX.zeros(layout.size), ca.DM.zeros(layout.size, layout.size)
    for left, right in layout.racks:
        pick = ca.DM.zeros(layout.size)
        pick[left], pick[right] = 1.0, -1.0
        gradient = gradient + price * (u[left] - u[right]) / float(layout.scale[left]) * pick
        hessian = hessian + price * pick @ pick.T
    return gradient, hessian


def _gram(columns: Any) -> Any:
    """columns' columns, every product written once."""
    upper = [[ca.dot(columns[:, i], columns[:, j]) if j >= i else None for j in range(columns.shape[1])] for i in range(columns.shape[1])]
    return ca.vertcat(*(ca.horzcat(*(upper[min(i, j)][max(i, j)] for j in range(columns.shape[1]))) for i in range(columns.shape[1])))
