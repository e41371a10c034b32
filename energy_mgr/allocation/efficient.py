"""Our allocator: one strictly convex QP per period, with the true curvature of the losses and every limit of the car in it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from powertrain.symbolic import ca

from ..motion import MotionDemand
from .compiled import Compiled
from .layout import NO_FAULTS, Layout
from .programme import Programme, Weights
from .qp import DenseQP
from .situation import Allocation, Situation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from powertrain import Vehicle

    from .effectiveness import TyreKind

    Floats = NDArray[np.float64]

#: A demand missed by more than this (m/s^2, rad/s^2) counts as limited.
MET = 0.02


class EfficientAllocator:
    """Least losses for the demand, within actuators, grip and battery; see `energy_mgr.allocation.programme`."""

    def __init__(
        self,
        vehicle: Vehicle,
        *,
        cost: str = "physical",
        tyre: TyreKind = "own",
        weights: Weights | None = None,
        lead: float | None = None,
        dt: float = 0.004,
    ) -> None:
        """The allocator of a car.

        Args:
            vehicle: the car.
            cost: `physical` (true losses), `heuristic` or `blended`.
            tyre: `own`, `load` or `linear`; see `Model`.
            weights: what matters how much.
            lead: s; see `Programme`.
            dt: the period, s; the price of moving a command is for one of 4 ms and grows as the period falls.

        Raises:
            VehicleError: the description lacks a section that the double-track model needs.
            PlanningError: a word that is none of these.
        """
        self.layout = Layout(vehicle)
        self.programme = Programme(self.layout, cost, tyre, paced(weights or Weights(), dt), lead)
        self._qp = DenseQP(self.layout.size, self.programme.rows)
        self._writer = written(self.programme, self._qp)
        self._inputs = self._writer.arguments[0]
        self._finisher = finisher(self.layout, self._inputs, *self._writer.results[5:])
        self._packed = Packed(self.layout)

    def allocate(self, now: Situation) -> Allocation:
        """As `Allocator.allocate`."""
        demand = now.demand
        self._packed.fill(self._inputs, now)
        self._writer.run()
        answer = self._qp.solve()
        if not answer.solved:
            # once more from a cold start: a workspace can have gone bad
            self._qp.forget()
            answer = self._qp.solve()
        # after a failure z is zero: the last command, as far as it is allowed
        self._finisher.arguments[-1][:] = answer.z
        self._finisher.run()
        command, given = self._finisher.results[0][:, 0].copy(), MotionDemand(*self._finisher.results[1][:, 0].tolist())
        if not answer.solved:
            return Allocation(command, given, "held", answer.residual, answer.iterations)
        return Allocation(command, given, met(self.layout, given, demand), answer.residual, answer.iterations)

    def compile_c(self) -> None:
        """Turn the writing of the programme into machine code; see `Compiled.compile_c`.

        Raises:
            VehicleError: there is no C compiler, or it refused.
        """
        self._writer.compile_c()

    def snapshot(self) -> tuple[float, ...]:
        """As `Allocator.snapshot`: nothing, but the next solve begins cold, here and where this is restored."""
        self._qp.forget()
        return ()

    def restore(self, memory: tuple[float, ...]) -> None:
        """As `Allocator.restore`."""
        self._qp.forget()


def paced(weights: Weights, dt: float) -> Weights:
    """`weights` for a period of `dt` (s): the price of a rate is the same, whatever the period."""
    share = 0.004 / dt
    return replace(
        weights, torque_rate=weights.torque_rate * share, steering_rate=weights.steering_rate * share, brake_rate=weights.brake_rate * share
    )


def met(layout: Layout, given: MotionDemand, demand: MotionDemand) -> str:
    """Status of an answer that gives `given` where `demand` was asked for; of a car with one steered axle nobody can ask a yaw acceleration."""
    missed = max(abs(given[0] - demand[0]), abs(given[1] - demand[1]))
    if layout.both_axles:
        missed = max(missed, abs(given[2] - demand[2]))
    return "solved" if missed <= MET else "limited"


def written(programme: Programme, qp: DenseQP) -> Compiled:
    """The compiled writer of the numbers of `qp` from one row of inputs; its further results are those of the programme."""
    inputs = ca.SX.sym("inputs", sum(symbol.numel() for symbol in programme.symbols.values()))
    made = programme.at(inputs)
    return Compiled("allocation", [inputs], made, results_in=qp.numbers)


def finisher(layout: Layout, inputs: Floats, motion: Floats, effect: Floats, low: Floats, high: Floats) -> Compiled:
    """From z to the command, within its bounds to the last digit and not only to the solver's tolerance, and the motion expected of it."""
    n = layout.size
    shared = [inputs[:, None], motion, effect, low, high]
    row, b, B, least, most = (ca.SX.sym("shared", *array.shape) for array in shared)
    z, scale = ca.SX.sym("z", n), ca.DM(layout.scale)
    command = np.fmin(np.fmax(row[:n] + scale * z, least), most)
    return Compiled("finish", [row, b, B, least, most, z], [command, b + B @ ((command - row[:n]) / scale)], shared)


class Packed:
    """A situation as one row of numbers, in the order of a programme's symbols."""

    def __init__(self, layout: Layout) -> None:
        """For a car with `layout`."""
        self._layout, self._faults, self._size = layout, NO_FAULTS, layout.size
        self._shares = layout.packed(NO_FAULTS)
        #: how many numbers there are
        self.count = layout.size + 16 + len(self._shares)

    def fill(self, inputs: Floats, now: Situation) -> None:
        """Write `now` into `inputs`."""
        if now.faults is not self._faults:
            self._faults, self._shares = now.faults, self._layout.packed(now.faults)
        n, window = self._size, (now.power_min, now.power_max)
        inputs[:n] = now.before
        inputs[n : n + 16] = (*now.state[3:], *now.demand, *window, *now.wheel_speeds, now.dt)
        inputs[n + 16 :] = self._shares
