"""A primal-dual interior-point method for programmes along a chain of stations (`chain`).

Slacks on all inequalities, exact second derivatives, separate steps to the boundary for unknowns and multipliers, a barrier that shrinks once its own
problem is solved (Nocedal and Wright, Numerical Optimization, ch. 19). `starts` makes the first iterate, `newton` the steps.
"""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from . import starts
from .chain import Chain
from .iterate import Iterate, Solution, longest
from .newton import Equations, change, direction

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .iterate import State

    Floats = NDArray[np.float64]

_ITERATIONS = 150
#: The barrier shrinks by the second factor once all residuals are below the first times the barrier.
_CENTRED, _SHRINK = 50.0, 0.1
_BACKTRACKS = 12


class ChainProgramme(Chain):
    """A programme with the method that solves it."""

    def start(self, x: Floats, *, price: float = 1e-3, barrier: float = 1.0) -> Iterate:
        """A first iterate about speeds, with multipliers for complementarity `barrier`."""
        return starts.about(self, x, price=price, barrier=barrier)

    def again(self, found: Iterate, barrier: float) -> Iterate:
        """A first iterate from the solution of a neighbouring programme."""
        return starts.again(self, found, barrier)

    def solve(self, start: Iterate, *, tolerance: float = 1e-9, gap: float = 1e-7, until: float = np.inf) -> Solution:
        """Iterate until the residual of stationarity is below `tolerance` and complementarity below `gap` of the objective, or until the clock
        (`time.perf_counter`) passes `until`.
        """
        # a start far from any solution may overflow; such steps are not finite and end the search
        with np.errstate(all="ignore"):
            return _iterated(self, start, tolerance, gap, until)


def _iterated(chain: Chain, start: Iterate, tolerance: float, gap: float, until: float) -> Solution:
    at, barrier, count = start, np.inf, 0
    state = chain.state(at.x, at.local, at.slack, at.late, at.jerk_slack)
    shift, residual = 0.0, np.inf
    for count in range(_ITERATIONS):
        if perf_counter() > until:
            break
        slopes = chain.slopes(at)
        gradient, local_gradient = chain.gradient(at, slopes)
        products = chain.products(at)
        average = float(np.mean(products))
        scale = max(1.0, float(np.max(at.price, initial=0.0)))
        residual = max(float(np.max(np.abs(gradient))), float(np.max(np.abs(local_gradient)))) / scale
        moved = max(float(np.sum(np.abs(chain.weight * state.values.energy + chain.prices(at.price) * state.values.time))), 1e-9)
        if residual < tolerance and float(np.sum(products)) < gap * moved and state.infeasible < 1e-9:
            return Solution(at, residual, count, True)
        last = 0.1 * gap * moved / len(products)
        if barrier == np.inf:
            barrier = max(average, last)
        while barrier > last and max(residual, state.infeasible, float(np.max(np.abs(products - barrier)))) < _CENTRED * barrier:
            barrier = max(_SHRINK * barrier, last)
        given = Equations(chain, at, state, slopes, gradient, local_gradient, barrier)
        step, shift = direction(given, shift)
        if step is None:
            break
        moved_on = _moved(chain, at, state, change(given, step), barrier)
        if moved_on is None:
            break
        at, state = moved_on
    return Solution(at, residual, count + 1, False)


def _moved(chain: Chain, at: Iterate, state: State, step: Iterate, barrier: float) -> tuple[Iterate, State] | None:
    """The next iterate: as far along the step as the boundary lets, shortened until the merit allows it; None where nothing does."""
    keep, free = max(0.99, 1.0 - barrier), chain.free
    own, room = np.where(free, at.x, 1.0), chain.room(at.x)
    unknowns = [(at.slack, step.slack), (own, step.x), (room, -step.x), (at.late, step.late), (at.jerk_slack, step.jerk_slack)]
    duals = [(at.dual, step.dual), (at.low[free], step.low[free]), (at.high[free], step.high[free]), (at.price, step.price)]
    length = primal = min(longest(value, by, keep) for value, by in unknowns)
    back = min(longest(value, by, keep) for value, by in [*duals, (at.jerk_dual, step.jerk_dual)])
    merit = chain.merit(at.x, state, at.slack, at.late, at.jerk_slack, barrier)
    for attempt in range(_BACKTRACKS):
        x, local, slack, late, jerk_slack = (
            getattr(at, name) + length * getattr(step, name) for name in ("x", "local", "slack", "late", "jerk_slack")
        )
        new = chain.state(x, local, slack, late, jerk_slack)
        value = chain.merit(x, new, slack, late, jerk_slack, barrier)
        if np.isfinite(value) and _acceptable(merit, state.infeasible, value, new.infeasible, length):
            made = Iterate(
                x, local, slack, at.dual + back * step.dual, at.low + back * step.low, at.high + back * step.high, late,
                at.price + back * step.price, at.ring + length * step.ring, jerk_slack, at.jerk_dual + back * step.jerk_dual,
            )  # fmt: skip
            return made, new
        length = min(primal, 1e-3) if attempt == _BACKTRACKS - 2 else 0.5 * length
    return None


def _acceptable(merit: float, infeasible: float, value: float, new: float, length: float) -> bool:
    """Whether a trial improves the merit or the infeasibility, or is feasible to rounding with a merit that is no worse to rounding."""
    if new > 1e3 * max(infeasible, 1e-4):
        return False
    return value <= merit + 1e-9 * max(abs(merit), 1.0) or new <= (1.0 - 1e-4 * length) * infeasible
