"""What a step of the receding horizon takes and gives."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal

from roads import PlanarCurve

if TYPE_CHECKING:
    from roads.geometry.cubic import PiecewiseCubic


@dataclass(frozen=True)
class PathState:
    """Where a car is: place (m), heading (rad) and curvature of its way (1/m)."""

    x: float
    y: float
    psi: float
    kappa: float = 0.0


StepStatus = Literal["solved", "kept", "blocked", "lost"]


@dataclass(frozen=True, eq=False)
class PathStep:
    """The path in force after a step.

    Attributes:
        status: `solved`: planned anew, or nothing new to plan. `kept`: the last path, still proven to its end. `blocked`: the last path, proven
        only to
            `clear_to`, ahead of the place where a border cuts it. `lost`: no proven path from where the car is.
        s: the car's station as it was understood, m; on a circuit counted on.
        pieces: the path from a little behind the car to `clear_to` over the road's station (on a circuit counted on). None if `lost`.
        clear_to: station to which the path is proven to keep its clearance, m.
        reason: why it was not planned anew; empty if it was.
        iterations: QPs solved.
        cost: cost of the window, in units of the objective; nan if not solved.
        milliseconds: processor time of the step.
    """

    status: StepStatus
    s: float
    pieces: PiecewiseCubic | None
    clear_to: float
    reason: str
    iterations: int
    cost: float
    milliseconds: float

    @cached_property
    def curve(self) -> PlanarCurve | None:
        """The path as a curve."""
        return None if self.pieces is None else PlanarCurve.of_pieces(self.pieces)
