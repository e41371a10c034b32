"""The path in force: what a receding horizon remembers from step to step."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..problem.spline import PER_KNOT

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from roads.geometry.cubic import PiecewiseCubic

    from .step import PathState
    from .strip import Strip

    Floats = NDArray[np.float64]

#: A car this far beside its plan, or turned against it by this much, starts a plan of its own, m and rad.
_OFF_PLAN, _TURNED = 0.3, 0.1
#: What could not be proven is kept clear of by this much, m.
_CLEAR = 0.5


class Plan(NamedTuple):
    """The path in force.

    Attributes:
        pieces: the path over unwrapped stations.
        proven_from: station from which it is proven, m.
        proven_to: station to which it is proven, m.
        version: of the borders that it is proven against.
        first_knot: where the window begins that was planned last.
        x: variables of that window.
        converged: whether planning the same window again would change nothing.
    """

    pieces: PiecewiseCubic
    proven_from: float
    proven_to: float
    version: int
    first_knot: int
    x: Floats
    converged: bool

    @property
    def start(self) -> float:
        """Station where it begins, m."""
        return float(self.pieces.breaks[0])

    @property
    def end(self) -> float:
        """Station where it ends, m."""
        return float(self.pieces.breaks[-1])

    @property
    def is_whole(self) -> bool:
        """True if it is proven to its end."""
        return self.proven_to == self.end

    @property
    def last_knot(self) -> int:
        """Where the window ends that was planned last."""
        return self.first_knot + len(self.x) // PER_KNOT - 1

    def carries(self, s: float, state: PathState) -> bool:
        """True if the car at station `s` is where the path leads."""
        place, first = (value[0] for value in self.pieces(np.array([s]), 1))
        across = (first[0] * (state.y - place[1]) - first[1] * (state.x - place[0])) / float(np.hypot(*first))
        turn = np.arctan2(first[1], first[0]) - state.psi
        return bool(abs(across) <= _OFF_PLAN and abs(np.arctan2(np.sin(turn), np.cos(turn))) <= _TURNED)


class Planned(NamedTuple):
    """A plan that is new, the QPs that it took, and its cost."""

    plan: Plan
    iterations: int
    cost: float


def proven_again(plan: Plan | None, s: float, strip: Strip, curvature_max: float) -> Plan | None:
    """The plan, proven anew where borders have changed or the car is before what was proven; None where it does not reach."""
    if plan is None or not plan.start <= s <= plan.end:
        return None
    if plan.version == strip.version and s >= plan.proven_from:
        return plan
    found = strip.prover(s, plan.end).prove(plan.pieces, curvature_max, start=s, end=plan.end)
    ends = [float(values[0]) for values in (found.where, found.bends) if len(values)]
    clear = max(min(ends) - _CLEAR, s) if ends else plan.end
    return plan._replace(proven_from=s, proven_to=clear, version=strip.version)
