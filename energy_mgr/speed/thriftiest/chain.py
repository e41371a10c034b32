"""A programme along a chain of stations: what is minimised, what bounds it, and both with their derivatives at an iterate.

minimise   sum_i f_i(x_i, x_{i+1}, l_i)                energy of the intervals, l_i their own unknowns
subject to c_i(x_i, x_{i+1}, l_i) <= 0                 rows of the intervals (`IntervalModel`)
           j_i(x_{i-1}, x_i, x_{i+1}) <= 0             jerk
           sum_{i < m} t_i(x_i, x_{i+1}) <= T, >= T    times of arrival: few dense rows
           0 <= x <= bound,  x_0 = x_n on circuits
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from .iterate import State

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from ..bounds.jerk import JerkModel
    from .interval import IntervalModel, Slopes
    from .iterate import Deadline, Iterate

    Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Chain:
    """A programme; see the module.

    Attributes:
        model: the intervals.
        bound: (n,) upper bounds of x; zero or equal to `fixed` where x is held.
        fixed: (n,) where x is held at its bound.
        deadlines: on sums of time.
        price: of every second, scaled; (N,) or one number.
        weight: of the energy; zero for least time.
        jerk: rows over three stations.
    """

    model: IntervalModel
    bound: Floats
    fixed: NDArray[np.bool_]
    deadlines: Sequence[Deadline]
    price: float = field(default=0.0, kw_only=True)
    weight: float = field(default=1.0, kw_only=True)
    jerk: JerkModel | None = field(default=None, kw_only=True)

    # -- what follows from what is given ----------------------------------------------------------------------------------------------

    @cached_property
    def free(self) -> NDArray[np.bool_]:
        """(n,) where x is not held."""
        return ~self.fixed

    @cached_property
    def closed(self) -> bool:
        """Whether x_0 = x_n is to be kept: where both ends of a circuit are held, they are held at the same speed."""
        return self.model.limits.closed and not bool(self.fixed[0])

    @cached_property
    def locals(self) -> int:
        """How many unknowns of its own an interval has."""
        return 2 if self.model.braking else 1

    @cached_property
    def within(self) -> Floats:
        """(m, N) 1 where an interval counts for a deadline."""
        count = self.model.count
        return np.array([np.arange(count) < row.intervals for row in self.deadlines], dtype=np.float64).reshape(-1, count)

    @cached_property
    def signs(self) -> Floats:
        """(m,) of the deadlines."""
        return np.array([row.sign for row in self.deadlines], dtype=np.float64)

    @cached_property
    def times(self) -> Floats:
        """(m,) of the deadlines, s."""
        return np.array([row.bound for row in self.deadlines])

    # -- values -----------------------------------------------------------------------------------------------------------------------

    def unknown(self, x: Floats, local: Floats) -> Floats:
        """(N, 4) unknowns per interval."""
        return np.column_stack([x[:-1], x[1:], local])

    def excess(self, time: Floats) -> Floats:
        """(m,) by how much the intervals' times (N,) miss the deadlines, as shares of these."""
        return self.signs * (self.within @ time - self.times) / self.times

    def jerks(self, x: Floats) -> Floats:
        """(N - 1, 2) rows of the jerk; none without a limit on it."""
        return self.jerk.values(x) if self.jerk else np.zeros((0, 2))

    def state(self, x: Floats, local: Floats, slack: Floats, late: Floats, jerk_slack: Floats) -> State:
        """The values at some unknowns, and by how much these and the slacks miss the equations between them."""
        values = self.model.values(self.unknown(x, local))
        jerk, excess = self.jerks(x), self.excess(values.time)
        infeasible = np.sum(np.abs(values.rows + slack)) + np.sum(np.abs(excess + late)) + np.sum(np.abs(jerk + jerk_slack))
        ring = abs(x[0] - x[-1]) if self.closed else 0.0
        return State(values, jerk, excess, float(infeasible + ring))

    def room(self, x: Floats) -> Floats:
        """(n,) distance to the upper bounds, never zero by rounding; 1 where x is held."""
        return np.where(self.free, np.maximum(self.bound - x, 1e-16), 1.0)

    def prices(self, price: Floats) -> Floats:
        """(N,) scaled price of a second in each interval, from the deadlines' multipliers (m,)."""
        return self.price + (self.signs * price / self.times) @ self.within

    def products(self, at: Iterate) -> Floats:
        """Slacks times multipliers, of all inequalities one after the other."""
        room = self.room(at.x)[self.free]
        parts = [(at.slack * at.dual).ravel(), at.late * at.price, (at.jerk_slack * at.jerk_dual).ravel()]
        return np.concatenate([*parts, (at.x * at.low)[self.free], room * at.high[self.free]])

    def merit(self, x: Floats, state: State, slack: Floats, late: Floats, jerk_slack: Floats, barrier: float) -> float:
        """Energy and priced time, and the barrier of all slacks."""
        room = self.room(x)
        logs = np.sum(np.log(slack)) + np.sum(np.log(late)) + np.sum(np.log(jerk_slack)) + np.sum(np.log(room)) + np.sum(np.log(x[self.free]))
        return float(self.weight * np.sum(state.values.energy) + self.price * np.sum(state.values.time) - barrier * logs)

    # -- derivatives ------------------------------------------------------------------------------------------------------------------

    def slopes(self, at: Iterate) -> Slopes:
        """Derivatives of the intervals, the second ones of their Lagrangian."""
        return self.model.slopes(self.unknown(at.x, at.local), at.dual, self.prices(at.price), self.weight)

    def gradient(self, at: Iterate, slopes: Slopes) -> tuple[Floats, Floats]:
        """Gradient of the Lagrangian by x (n,) and by the local unknowns (N, locals)."""
        own = self.weight * slopes.energy + np.matmul(at.dual[:, None, :], slopes.rows)[:, 0, :]
        own[:, :2] += self.prices(at.price)[:, None] * slopes.time
        gradient = -at.low + at.high
        gradient[:-1] += own[:, 0]
        gradient[1:] += own[:, 1]
        if self.jerk:
            self.jerk.add_gradient(gradient, at.x, at.jerk_dual)
        if self.closed:
            gradient[0] += at.ring
            gradient[-1] -= at.ring
        return np.where(self.free, gradient, 0.0), own[:, 2 : 2 + self.locals]
