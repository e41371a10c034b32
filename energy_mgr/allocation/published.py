"""The published allocators: two QPs in a row (A1), and one that weighs demand against cost (3.30).

Both linearise the effectiveness at the last command (3.31), leave the friction brakes alone, know actuator limits and rates and nothing of grip or
battery, and take their cost from A2 or A3. The demand is absolute: Delta v = demand - b(u_0, v), as in (3.32).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from powertrain.symbolic import ca

from ..motion import MotionDemand
from .compiled import Compiled
from .costs import Parabola, blended, checked_cost, heuristic, published_physical
from .effectiveness import Model, TyreKind
from .efficient import Packed, finisher, met
from .layout import Layout
from .programme import racks
from .qp import DenseQP
from .situation import Allocation, Situation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from powertrain import Vehicle

    Floats = NDArray[np.float64]

#: Step 1 has rank 3 in as many unknowns as there are actuators: this much curvature, relative to the scaled demand's, makes it strictly convex.
_REGULAR = 1e-7
#: W_v: importance of a_x, a_y and yaw acceleration. Not published; the yaw acceleration counts as in the reconstruction.
WEIGHTS = (1.0, 1.0, 1.5)
#: gamma in (3.30), kW per squared m/s^2. Not published.
GAMMA = 1000.0
#: Price of angles that differ on an axle with a rack, against one m/s^2.
_TIE = 1e3
_KW = 1e3


class _Published:
    """What both share: the symbols, the compiled numbers, the memory of the last steering increments."""

    def __init__(self, vehicle: Vehicle, cost: str, tyre: TyreKind, dt: float) -> None:
        self.layout = Layout(vehicle)
        self._cost, self._dt = checked_cost(cost), dt
        self._model = Model(self.layout, tyre)
        self._packed = Packed(self.layout)
        self._turned = np.zeros(len(self.layout.steered))

    def _symbols(self) -> tuple[Any, Any, dict[str, Any]]:
        """Inputs as `Packed` orders them, the last increments, and what follows from both."""
        layout, n = self.layout, self.layout.size
        row, turned = ca.SX.sym("row", self._packed.count), ca.SX.sym("turned", len(layout.steered))
        u, state, demand, speeds, dt = row[:n], row[n : n + 6], row[n + 6 : n + 9], row[n + 11 : n + 15], row[n + 15]
        wheels = self._model.wheels(ca.vertsplit(u), ca.vertsplit(state))
        motion, scale = ca.vertcat(*self._model.motion(wheels)), ca.DM(layout.scale)
        box = layout.box(ca.vertsplit(u), ca.vertsplit(speeds), dt, ca.vertsplit(row[n + 16 :]))
        low, high = (ca.vertcat(*[0.0 if k in range(layout.brakes.start, layout.brakes.stop) else b for k, b in enumerate(side)]) for side in box)
        cost = self._parabola(u, wheels, layout.motor_speeds([wheel.spin for wheel in wheels]), turned)
        found = {
            "motion": motion,
            "effect": ca.jacobian(motion, u) @ ca.diag(scale),
            "low": low,
            "high": high,
            "least": (low - u) / scale,
            "most": (high - u) / scale,
            "wanted": demand - motion,
            "bend": np.fmax(ca.vertcat(*cost.curvature) * scale**2 / _KW, 1e-3),
            "slope": ca.vertcat(*cost.gradient) * scale / _KW,
            "weights": ca.DM([1.0, 1.0, WEIGHTS[2] * (1.0 if layout.both_axles else 0.1)]),
        }
        return row, turned, found

    def _parabola(self, u: Any, wheels: Any, speeds: Any, turned: Any) -> Parabola:
        if self._cost == "heuristic":
            return heuristic(self.layout, u, wheels)
        physical = published_physical(self.layout, u, wheels, speeds, turned, self._dt)
        return physical if self._cost == "physical" else blended(physical, heuristic(self.layout, u, wheels))

    def _finished(self, now: Situation, finish: Compiled, z: Floats, residual: float, iterations: int) -> Allocation:
        finish.arguments[-1][:] = z
        finish.run()
        command, given = finish.results[0][:, 0].copy(), MotionDemand(*finish.results[1][:, 0].tolist())
        self._turned = (command - now.before)[self.layout.steers]
        return Allocation(command, given, "held" if residual == np.inf else met(self.layout, given, now.demand), residual, iterations)

    def snapshot(self) -> tuple[float, ...]:
        """As `Allocator.snapshot`: the last steering increments."""
        self._forget()
        return tuple(self._turned.tolist())

    def restore(self, memory: tuple[float, ...]) -> None:
        """As `Allocator.restore`."""
        self._forget()
        self._turned = np.array(memory)

    def _forget(self) -> None:
        raise NotImplementedError


class TwoStepAllocator(_Published):
    """A1: first the nearest attainable motion (3.43), then the cheapest command that gives it (3.44).

    In the robust reading: step 1 is made strictly convex by a little curvature, and step 2 always runs, with the motion that step 1 attained.
    """

    def __init__(self, vehicle: Vehicle, *, cost: str = "heuristic", tyre: TyreKind = "linear", dt: float = 0.004) -> None:
        """The allocator of a car; arguments as in `EfficientAllocator`, and the period `dt` (s) of the physical cost.

        Raises:
            VehicleError: the description lacks a section that the double-track model needs.
            PlanningError: a word that is none of these.
        """
        super().__init__(vehicle, cost, tyre, dt)
        n = self.layout.size
        self._first, self._second = DenseQP(n, 0), DenseQP(n, 3, equal=(0, 1, 2))
        row, turned, s = self._symbols()
        weighted = ca.diag(s["weights"]) @ s["effect"]
        apart, tie = racks(self.layout, row[:n], _TIE)
        hessian = 2.0 * weighted.T @ weighted + _REGULAR * ca.DM.eye(n) + tie
        none = ca.DM.zeros(n, 0)
        first = [hessian, -2.0 * weighted.T @ (s["weights"] * s["wanted"]) + apart, none, s["least"], s["most"]]
        rest = [s[name] for name in ("motion", "effect", "low", "high", "bend", "slope")]
        self._run = Compiled("two_step", [row, turned], [*first, *rest], results_in=self._first.numbers)
        self._finish = finisher(self.layout, self._run.arguments[0], *self._run.results[5:9])

    def allocate(self, now: Situation) -> Allocation:
        """As `Allocator.allocate`."""
        run, second = self._run, self._second
        self._packed.fill(run.arguments[0], now)
        run.arguments[1][:] = self._turned
        run.run()
        first = self._first.solve()
        if not first.solved:
            return self._finished(now, self._finish, np.zeros(self.layout.size), np.inf, 0)
        effect, bend, slope = run.results[6], run.results[9], run.results[10]
        h, f, at, lower, upper = second.numbers
        h[:], f[:], at[:] = np.diag(bend[:, 0]), slope, effect.T
        attained = effect @ first.z
        lower[:, 0], upper[:, 0] = np.append(run.results[3][:, 0], attained), np.append(run.results[4][:, 0], attained)
        answer = second.solve()
        if not answer.solved:
            # every actuator that matters is at its bound: what step 1 found is all there is
            return self._finished(now, self._finish, first.z, first.residual, first.iterations)
        return self._finished(now, self._finish, answer.z, max(first.residual, answer.residual), first.iterations + answer.iterations)

    def _forget(self) -> None:
        self._first.forget()
        self._second.forget()


class WeightedAllocator(_Published):
    """(3.30): one QP, cost plus half of gamma times the squared miss of the demand."""

    def __init__(self, vehicle: Vehicle, *, cost: str = "heuristic", tyre: TyreKind = "linear", dt: float = 0.004, gamma: float = GAMMA) -> None:
        """The allocator of a car; arguments as in `TwoStepAllocator`, and gamma in kW per (m/s^2)^2.

        Raises:
            VehicleError: the description lacks a section that the double-track model needs.
            PlanningError: a word that is none of these.
        """
        super().__init__(vehicle, cost, tyre, dt)
        self._qp = DenseQP(self.layout.size, 0)
        row, turned, s = self._symbols()
        weighted = ca.diag(s["weights"]) @ s["effect"]
        apart, tie = racks(self.layout, row[: self.layout.size], gamma * _TIE)
        hessian = ca.diag(s["bend"]) + gamma * weighted.T @ weighted + tie
        gradient = s["slope"] - gamma * weighted.T @ (s["weights"] * s["wanted"]) + apart
        numbers = [hessian, gradient, ca.DM.zeros(self.layout.size, 0), s["least"], s["most"]]
        rest = [s[name] for name in ("motion", "effect", "low", "high")]
        self._run = Compiled("weighted", [row, turned], [*numbers, *rest], results_in=self._qp.numbers)
        self._finish = finisher(self.layout, self._run.arguments[0], *self._run.results[5:9])

    def allocate(self, now: Situation) -> Allocation:
        """As `Allocator.allocate`."""
        self._packed.fill(self._run.arguments[0], now)
        self._run.arguments[1][:] = self._turned
        self._run.run()
        answer = self._qp.solve()
        return self._finished(now, self._finish, answer.z, answer.residual if answer.solved else np.inf, answer.iterations)

    def _forget(self) -> None:
        self._qp.forget()
