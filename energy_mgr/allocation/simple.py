"""Baselines without a programme: least change of commands, and equal torques with one angle per axle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..motion import MotionDemand
from .effectiveness import Effectiveness, TyreKind
from .efficient import met
from .layout import Layout
from .situation import Allocation, Situation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from powertrain import Vehicle

    Floats = NDArray[np.float64]


#: Combinations of commands that do less than this share of what the strongest one does are not used.
_WEAK = 0.02


class _Direct:
    """Commands straight from the demand, cut to their bounds."""

    def __init__(self, vehicle: Vehicle, tyre: TyreKind) -> None:
        self.layout = Layout(vehicle)
        self._effectiveness = Effectiveness(self.layout, tyre)

    def allocate(self, now: Situation) -> Allocation:
        """As `Allocator.allocate`."""
        layout = self.layout
        motion, jacobian = self._effectiveness(now.before, now.state[3:])
        # one steered axle cannot choose lateral force and yaw moment: the first counts
        weight = np.array([1.0, 1.0, 1.0 if layout.both_axles else 0.1])
        low, high = layout.box(now.before.tolist(), now.wheel_speeds, now.dt, layout.packed(now.faults).tolist())
        step = self._step(now.before, weight[:, None] * jacobian, weight * (np.array(now.demand) - motion))
        step[layout.brakes] = 0.0
        command = np.clip(now.before + step, low, high)
        given = MotionDemand(*(motion + jacobian @ (command - now.before)).tolist())
        return Allocation(command, given, met(layout, given, now.demand), 0.0, 0)

    def _step(self, before: Floats, jacobian: Floats, wanted: Floats) -> Floats:
        raise NotImplementedError

    def snapshot(self) -> tuple[float, ...]:
        """As `Allocator.snapshot`: there is no memory."""
        return ()

    def restore(self, memory: tuple[float, ...]) -> None:
        """As `Allocator.restore`."""


class MinimumNormAllocator(_Direct):
    """The least change of commands, each over its scale, that gives the demand: the pseudo-inverse."""

    def __init__(self, vehicle: Vehicle, *, cost: str = "", tyre: TyreKind = "linear", dt: float = 0.0) -> None:
        """The allocator of a car; it knows neither cost nor period.

        Raises:
            VehicleError: the description lacks a section that the double-track model needs.
            PlanningError: a word that is no kind of tyre.
        """
        super().__init__(vehicle, tyre)
        self._used = np.ones(self.layout.size)
        self._used[self.layout.brakes] = 0.0

    def _step(self, before: Floats, jacobian: Floats, wanted: Floats) -> Floats:
        scale, alike = self.layout.scale * self._used, self.layout.alike
        return scale * (alike @ (np.linalg.pinv((jacobian * scale) @ alike, rcond=_WEAK) @ wanted))


class EqualSplitAllocator(_Direct):
    """All motors give the same torque, the wheels of an axle turn alike."""

    def __init__(self, vehicle: Vehicle, *, cost: str = "", tyre: TyreKind = "linear", dt: float = 0.0) -> None:
        """The allocator of a car; it knows neither cost nor period.

        Raises:
            VehicleError: the description lacks a section that the double-track model needs.
            PlanningError: a word that is no kind of tyre.
        """
        super().__init__(vehicle, tyre)
        layout = self.layout
        groups = [np.zeros(layout.size)]
        groups[0][layout.torques] = layout.scale[0]
        for axle in ((0, 1), (2, 3)):
            column = np.zeros(layout.size)
            for k, wheel in enumerate(layout.steered):
                column[layout.steers.start + k] = layout.scale[layout.steers.start] * (wheel in axle)
            groups += [column] if np.any(column) else []
        self._groups = np.column_stack(groups)

    def _step(self, before: Floats, jacobian: Floats, wanted: Floats) -> Floats:
        groups, layout = self._groups, self.layout
        # what came unequal (a stuck wheel, a start with turned wheels) is brought together first
        target = before.copy()
        target[layout.torques] = np.mean(before[layout.torques])
        for column in groups.T[1:]:
            target[column > 0.0] = np.mean(before[column > 0.0])
        evened = target - before
        share = np.linalg.lstsq(jacobian @ groups, wanted - jacobian @ evened, rcond=None)[0]
        return evened + groups @ share
