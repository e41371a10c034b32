"""What all windows of a receding horizon have in common: the road, the bound on curvature, the solver, how closely borders are kept."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from roads import Road

    from ..solvers.backends import Piqp
    from .strip import Strip

#: Control points between knots, at least, and by how much the borders are drawn in, m: more than for a plan made once, to fail the proof seldom.
CONTROL_POINTS, TIGHTER = 6, 2e-3
#: Solves and proofs per step; steps that promise less than this fraction of the cost end a solve.
ROUNDS, TOLERANCE = 6, 1e-5
#: Shortest window, in segments.
SHORTEST = 4


class Terms(NamedTuple):
    """What a window is planned on.

    Attributes:
        road: where to drive.
        strip: the road as it is now.
        curvature_max: bound on the curvature, 1/m.
        qp: solves the QPs of windows that follow each other.
    """

    road: Road
    strip: Strip
    curvature_max: float
    qp: Piqp


class Clock(NamedTuple):
    """Processor time since a step began, at `started` s, against its budget in ms."""

    started: float
    budget_ms: float

    @property
    def spent_ms(self) -> float:
        """Since the step began, ms."""
        return 1e3 * (time.process_time() - self.started)

    @property
    def left_ms(self) -> float:
        """Of the budget, ms; below zero once it is spent."""
        return self.budget_ms - self.spent_ms
