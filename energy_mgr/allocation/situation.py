"""What every allocator takes and gives, and the interface that all of them share."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from ..motion import MotionDemand, VehicleState
from .layout import NO_FAULTS, Faults

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .layout import Layout

    Floats = NDArray[np.float64]


class Situation(NamedTuple):
    """One control period.

    Attributes:
        state: how the car moves.
        demand: what it shall do.
        before: (n,) commands of the period before, in the order of the layout.
        wheel_speeds: of the four wheels, rad/s.
        faults: what actuators cannot do.
        power_min, power_max: what the battery can take (negative) and give beside the auxiliaries, W.
        dt: the period, s.
        ahead: demands at later times with what the car will do then, for allocators that look ahead; others pass over it.
    """

    state: VehicleState
    demand: MotionDemand
    before: Floats
    wheel_speeds: Sequence[float]
    faults: Faults = NO_FAULTS
    power_min: float = -np.inf
    power_max: float = np.inf
    dt: float = 0.004
    ahead: Sequence[Ahead] = ()


class Ahead(NamedTuple):
    """A demand that will come: in how many seconds, and at which speed and yaw rate."""

    time: float
    demand: MotionDemand
    v_x: float
    yaw_rate: float


class Allocation(NamedTuple):
    """The commands and what is known of them.

    Attributes:
        command: (n,) in the order of the layout: Nm, Nm, rad.
        given: the motion that the allocator's model expects of them.
        status: `solved`; `limited`, where actuators, grip or battery do not allow the demand and the closest motion is given; `held`, where no
            answer passed its check and the last command was kept as far as it is allowed.
        residual: largest scaled violation of the optimality conditions; 0 for allocators that solve no QP.
        iterations: of the solver.
    """

    command: Floats
    given: MotionDemand
    status: str
    residual: float
    iterations: int


class Allocator(Protocol):
    """Splits a demand over the actuators; keeps nothing between calls but what makes the next one faster, or what `snapshot` gives."""

    @property
    def layout(self) -> Layout:
        """The actuators."""
        ...

    def allocate(self, now: Situation) -> Allocation:
        """The commands for this period. Never raises on finite numbers; commands always keep the actuators' limits."""
        ...

    def snapshot(self) -> tuple[float, ...]:
        """The memory, as plain numbers; what runs on from here and what is restored from it run alike."""
        ...

    def restore(self, memory: tuple[float, ...]) -> None:
        """Take up what `snapshot` gave."""
        ...
