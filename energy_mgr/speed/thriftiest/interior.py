"""A primal-dual interior-point method for programmes along a chain of stations.

minimise   sum_i f_i(x_i, x_{i+1}, l_i)                energy of the intervals, l_i their own unknowns
subject to c_i(x_i, x_{i+1}, l_i) <= 0                 rows of the intervals (`IntervalModel`)
           j_i(x_{i-1}, x_i, x_{i+1}) <= 0             jerk
           sum_{i < m} t_i(x_i, x_{i+1}) <= T, >= T    times of arrival: few dense rows
           0 <= x <= bound,  x_0 = x_n on circuits

Slacks on all inequalities, exact second derivatives, separate steps to the boundary for unknowns and multipliers, a barrier that shrinks once its own
problem is solved (Nocedal and Wright, Numerical Optimization, ch. 19). What belongs to one interval is eliminated there; what is left is a band
of one (with jerk two) off-diagonals, so that a step costs a fixed number of operations per station. The dense rows go around the band (Schur
complement).
"""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from ..fastest.forward_backward import friction_braking
from .band import bordered, bordered_convex
from .iterate import Deadline, Direction, Iterate, Solution, State, longest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from ..bounds.jerk import JerkModel
    from .interval import IntervalModel, Slopes

    Floats = NDArray[np.float64]

_ITERATIONS = 150
#: The barrier shrinks by the second factor once all residuals are below the first times the barrier.
_CENTRED, _SHRINK = 50.0, 0.1
_BACKTRACKS = 12
#: Slacks start at least this large, bounds are kept away from by this share.
_APART, _INSIDE = 1e-3, 1e-2


class ChainProgramme:
    """A programme; see the module.

    Args:
        model: the intervals.
        bound: (n,) upper bounds of x; zero or equal to `fixed` where x is held.
        fixed: (n,) where x is held at its bound.
        deadlines: on sums of time.
        price: of every second, scaled; (N,) or one number.
        weight: of the energy; zero for least time.
        jerk: rows over three stations.
    """

    def __init__(
        self,
        model: IntervalModel,
        bound: Floats,
        fixed: NDArray[np.bool_],
        deadlines: Sequence[Deadline],
        *,
        price: float = 0.0,
        weight: float = 1.0,
        jerk: JerkModel | None = None,
    ) -> None:
        self.model, self.bound, self.fixed, self.deadlines = model, bound, fixed, list(deadlines)
        self.free = ~fixed
        self.price, self.weight, self.jerk = price, weight, jerk
        # where both ends of a circuit are held, they are held at the same speed
        self.closed = model.limits.closed and not bool(fixed[0])
        self.locals = 2 if model.braking else 1
        count = model.count
        self._within = np.array([np.arange(count) < row.intervals for row in self.deadlines], dtype=np.float64).reshape(-1, count)
        self._signs = np.array([row.sign for row in self.deadlines], dtype=np.float64)
        self._times = np.array([row.bound for row in self.deadlines])

    # -- evaluation -------------------------------------------------------------------------------------------------------------------

    def unknown(self, x: Floats, local: Floats) -> Floats:
        """(N, 4) unknowns per interval."""
        return np.column_stack([x[:-1], x[1:], local])

    def _state(self, x: Floats, local: Floats, slack: Floats, late: Floats, jerk_slack: Floats) -> State:
        values = self.model.values(self.unknown(x, local))
        jerk = self.jerk.values(x) if self.jerk else np.zeros((0, 2))
        excess = self._signs * (self._within @ values.time - self._times) / self._times
        infeasible = np.sum(np.abs(values.rows + slack)) + np.sum(np.abs(excess + late)) + np.sum(np.abs(jerk + jerk_slack))
        ring = abs(x[0] - x[-1]) if self.closed else 0.0
        return State(values, jerk, excess, float(infeasible + ring))

    def _room(self, x: Floats) -> Floats:
        """(n,) distance to the upper bounds, never zero by rounding; 1 where x is held."""
        return np.where(self.free, np.maximum(self.bound - x, 1e-16), 1.0)

    def _prices(self, price: Floats) -> Floats:
        """(N,) scaled price of a second in each interval."""
        return self.price + (self._signs * price / self._times) @ self._within

    def start(self, x: Floats, *, price: float = 1e-3, barrier: float = 1.0) -> Iterate:
        """A first iterate about speeds: inside the bounds, slacks where the rows are, multipliers for complementarity `barrier`."""
        x = np.where(self.fixed, self.bound, np.clip(x, _INSIDE * 1e-2 * self.bound, (1.0 - _INSIDE) * self.bound))
        local = np.zeros((self.model.count, 2))
        if self.model.braking:
            # what the motors may not recuperate at these speeds, or a battery that takes little, is violated by far without
            needed = friction_braking(self.model.limits, np.sqrt(2.0 * self.model.energy_scale * x))
            local[:, 1] = 1e-2 + (0.0 if needed is None else needed / self.model.force_scale)
        rows = self.model.values(self.unknown(x, local)).rows
        local[:, 0] = np.maximum(rows[:, 2], rows[:, 3]) + 1e-2
        values = self.model.values(self.unknown(x, local))
        slack = np.maximum(-values.rows, _APART)
        jerk_slack = np.maximum(-self.jerk.values(x), _APART) if self.jerk else np.zeros((0, 2))
        excess = self._signs * (self._within @ values.time - self._times) / self._times
        late = np.maximum(-excess, _APART)
        scale = barrier / self.model.count
        room = self._room(x)
        return Iterate(
            x,
            local,
            slack,
            scale / slack,
            np.where(self.free, scale / np.maximum(x, 1e-12), 0.0),
            np.where(self.free, scale / room, 0.0),
            late,
            np.full(len(late), price),
            0.0,
            jerk_slack,
            scale / jerk_slack,
        )

    def again(self, found: Iterate, barrier: float) -> Iterate:
        """A first iterate from the solution of a neighbouring programme: its unknowns drawn in from their bounds, its multipliers kept from zero."""
        x = np.where(self.fixed, self.bound, np.clip(found.x, 1e-6 * self.bound, (1.0 - 1e-4) * self.bound))
        values = self.model.values(self.unknown(x, found.local))
        slack = np.maximum(-values.rows, 1e-4)
        scale = barrier / self.model.count
        excess = self._signs * (self._within @ values.time - self._times) / self._times
        late = np.maximum(-excess, 1e-4)
        jerk_slack = np.maximum(-self.jerk.values(x), 1e-4) if self.jerk else np.zeros((0, 2))
        room = self._room(x)
        price = found.price if len(found.price) == len(late) else np.full(len(late), 1e-3)
        return Iterate(
            x,
            found.local,
            slack,
            np.maximum(found.dual, scale / slack),
            np.where(self.free, np.maximum(found.low, scale / np.maximum(x, 1e-12)), 0.0),
            np.where(self.free, np.maximum(found.high, scale / room), 0.0),
            late,
            np.maximum(price, 1e-6),
            found.ring,
            jerk_slack,
            np.maximum(found.jerk_dual, scale / jerk_slack) if self.jerk else jerk_slack,
        )

    # -- the method -------------------------------------------------------------------------------------------------------------------

    def solve(self, start: Iterate, *, tolerance: float = 1e-9, gap: float = 1e-7, until: float = np.inf) -> Solution:
        """Iterate until the residual of stationarity is below `tolerance` and complementarity below `gap` of the objective, or until the clock
        (`time.perf_counter`) passes `until`.
        """
        # a start far from any solution may overflow; such steps are not finite and end the search
        with np.errstate(all="ignore"):
            return self._iterated(start, tolerance, gap, until)

    def _iterated(self, start: Iterate, tolerance: float, gap: float, until: float) -> Solution:
        at, barrier, count = start, np.inf, 0
        state = self._state(at.x, at.local, at.slack, at.late, at.jerk_slack)
        shift, residual = 0.0, np.inf
        for count in range(_ITERATIONS):
            if perf_counter() > until:
                break
            slopes = self.model.slopes(self.unknown(at.x, at.local), at.dual, self._prices(at.price), self.weight)
            gradient, local_gradient = self._gradient(at, slopes)
            products = self._products(at)
            average = float(np.mean(products))
            scale = max(1.0, float(np.max(at.price, initial=0.0)))
            residual = max(float(np.max(np.abs(gradient))), float(np.max(np.abs(local_gradient)))) / scale
            moved = max(float(np.sum(np.abs(self.weight * state.values.energy + self._prices(at.price) * state.values.time))), 1e-9)
            if residual < tolerance and float(np.sum(products)) < gap * moved and state.infeasible < 1e-9:
                return Solution(at, residual, count, True)
            last = 0.1 * gap * moved / len(products)
            if barrier == np.inf:
                barrier = max(average, last)
            while barrier > last and max(residual, state.infeasible, float(np.max(np.abs(products - barrier)))) < _CENTRED * barrier:
                barrier = max(_SHRINK * barrier, last)
            direction, shift = self._direction(at, state, slopes, gradient, local_gradient, barrier, shift)
            if direction is None:
                break
            moved_on = self._moved(at, state, self._change(at, state, slopes, direction, barrier), barrier)
            if moved_on is None:
                break
            at, state = moved_on
        return Solution(at, residual, count + 1, False)

    def _products(self, at: Iterate) -> Floats:
        room = self._room(at.x)[self.free]
        parts = [(at.slack * at.dual).ravel(), at.late * at.price, (at.jerk_slack * at.jerk_dual).ravel()]
        return np.concatenate([*parts, (at.x * at.low)[self.free], room * at.high[self.free]])

    def _gradient(self, at: Iterate, slopes: Slopes) -> tuple[Floats, Floats]:
        """Gradient of the Lagrangian by x (n,) and by the local unknowns (N, locals)."""
        own = self.weight * slopes.energy + np.matmul(at.dual[:, None, :], slopes.rows)[:, 0, :]
        own[:, :2] += self._prices(at.price)[:, None] * slopes.time
        gradient = -at.low + at.high
        gradient[:-1] += own[:, 0]
        gradient[1:] += own[:, 1]
        if self.jerk:
            self.jerk.add_gradient(gradient, at.x, at.jerk_dual)
        if self.closed:
            gradient[0] += at.ring
            gradient[-1] -= at.ring
        return np.where(self.free, gradient, 0.0), own[:, 2 : 2 + self.locals]

    def _direction(
        self, at: Iterate, state: State, slopes: Slopes, gradient: Floats, local_gradient: Floats, barrier: float, shift: float
    ) -> tuple[Direction | None, float]:
        """A step of Newton's method, None where the band has no factor, and by how much its diagonal was raised."""
        rhs, local_rhs, hessian = self._condensed(at, state, slopes, gradient, local_gradient, barrier)
        inner = np.linalg.inv(hessian[:, 2:, 2:]) if self.locals == 2 else 1.0 / hessian[:, 2:, 2:]
        across = np.matmul(hessian[:, :2, 2:], inner)
        ends = hessian[:, :2, :2] - np.matmul(across, hessian[:, 2:, :2])
        carried = np.matmul(across, local_rhs[:, :, None])[:, :, 0]
        rhs[:-1] -= carried[:, 0]
        rhs[1:] -= carried[:, 1]
        band = self._band(at, ends)
        if self.jerk:
            self.jerk.add_curvature(band, rhs, at.x, at.jerk_slack, at.jerk_dual, barrier, self.free)
        rhs[self.fixed] = 0.0
        dense, diagonal, excess = self._dense(at, state, slopes, barrier)
        solved = bordered(band, rhs, dense, diagonal, excess)
        if solved is None:
            solved, shift = bordered_convex(band, rhs, dense, diagonal, excess, shift)
        else:
            shift = 0.0
        if solved is None:
            return None, shift
        x, multiplier = solved
        ends_x = np.column_stack([x[:-1], x[1:]])
        local = np.matmul(inner, (local_rhs - np.matmul(hessian[:, 2:, :2], ends_x[:, :, None])[:, :, 0])[:, :, None])[:, :, 0]
        ring = float(multiplier[-1]) if self.closed else 0.0
        return Direction(x, local, multiplier[: len(at.price)], ring), shift

    def _condensed(
        self, at: Iterate, state: State, slopes: Slopes, gradient: Floats, local_gradient: Floats, barrier: float
    ) -> tuple[Floats, Floats, Floats]:
        """Right-hand sides by stations (n,) and local unknowns (N, locals), and the intervals' Hessians, with the slacks of the rows eliminated."""
        size = 2 + self.locals
        rows = slopes.rows[:, :, :size].copy()
        hessian = slopes.hessian[:, :size, :size].copy()
        for end, free in ((0, self.free[:-1]), (1, self.free[1:])):
            rows[:, :, end] *= free[:, None]
            hessian[:, end, :] *= free[:, None]
            hessian[:, :, end] *= free[:, None]
        weight = at.dual / at.slack
        # what the slacks ask for: barrier / s - y + (y / s) (c + s), added to y
        wanted = barrier / at.slack - at.dual + weight * (state.values.rows + at.slack)
        hessian += np.matmul(rows.transpose(0, 2, 1), weight[:, :, None] * rows)
        push = np.matmul(wanted[:, None, :], rows)[:, 0, :]
        rhs, local_rhs = -gradient, -(local_gradient + push[:, 2:])
        rhs[:-1] -= push[:, 0]
        rhs[1:] -= push[:, 1]
        room, own = self._room(at.x), np.where(self.free, at.x, 1.0)
        rhs += np.where(self.free, barrier / own - at.low, 0.0) - np.where(self.free, barrier / room - at.high, 0.0)
        return rhs, local_rhs, hessian

    def _band(self, at: Iterate, ends: Floats) -> Floats:
        """The band in LAPACK's upper storage from the intervals' blocks `ends` (N, 2, 2) and the bounds of x."""
        room, own = self._room(at.x), np.where(self.free, at.x, 1.0)
        band = np.zeros((3 if self.jerk else 2, len(at.x)))
        band[-1] = np.where(self.free, at.low / own + at.high / room, 1.0)
        band[-1, :-1] += ends[:, 0, 0]
        band[-1, 1:] += ends[:, 1, 1]
        band[-2, 1:] = ends[:, 0, 1]
        return band

    def _dense(self, at: Iterate, state: State, slopes: Slopes, barrier: float) -> tuple[Floats, Floats, Floats]:
        """Gradients of the deadlines and the ring (m, n), what their slacks put on the diagonal, and the right-hand sides."""
        rows, diagonal, excess = [], [], []
        for k in range(len(self.deadlines)):
            inside = self._signs[k] / self._times[k] * self._within[k][:, None] * slopes.time
            row = np.zeros_like(at.x)
            row[:-1] += inside[:, 0]
            row[1:] += inside[:, 1]
            rows.append(np.where(self.free, row, 0.0))
            diagonal.append(at.late[k] / at.price[k])
            # (s / y) dy = barrier / y - s + (excess + s) + G dx
            excess.append(state.excess[k] + barrier / at.price[k])
        if self.closed:
            row = np.zeros_like(at.x)
            row[0], row[-1] = 1.0, -1.0
            rows.append(row)
            diagonal.append(0.0)
            excess.append(at.x[0] - at.x[-1])
        return np.array(rows).reshape(len(rows), len(at.x)), np.array(diagonal), np.array(excess)

    def _change(self, at: Iterate, state: State, slopes: Slopes, direction: Direction, barrier: float) -> Iterate:
        """The step for everything that an iterate holds."""
        local = np.zeros_like(at.local)
        local[:, : self.locals] = direction.local
        change = np.column_stack([direction.x[:-1], direction.x[1:], local])
        slack = -(state.values.rows + at.slack) - np.matmul(slopes.rows, change[:, :, None])[:, :, 0]
        room, own = self._room(at.x), np.where(self.free, at.x, 1.0)
        jerk_slack = jerk_dual = np.zeros((0, 2))
        if self.jerk:
            jerk_slack = -(state.jerk + at.jerk_slack) - self.jerk.along(at.x, direction.x)
            jerk_dual = barrier / at.jerk_slack - at.jerk_dual - at.jerk_dual / at.jerk_slack * jerk_slack
        return Iterate(
            np.where(self.free, direction.x, 0.0),
            local,
            slack,
            barrier / at.slack - at.dual - at.dual / at.slack * slack,
            np.where(self.free, barrier / own - at.low - at.low / own * direction.x, 0.0),
            np.where(self.free, barrier / room - at.high + at.high / room * direction.x, 0.0),
            barrier / at.price - at.late - at.late / at.price * direction.price,
            direction.price,
            direction.ring,
            jerk_slack,
            jerk_dual,
        )

    def _moved(self, at: Iterate, state: State, step: Iterate, barrier: float) -> tuple[Iterate, State] | None:
        """The next iterate: as far along the step as the boundary lets, shortened until the merit allows it; None where nothing does."""
        keep, free = max(0.99, 1.0 - barrier), self.free
        own, room = np.where(free, at.x, 1.0), self._room(at.x)
        unknowns = [(at.slack, step.slack), (own, step.x), (room, -step.x), (at.late, step.late), (at.jerk_slack, step.jerk_slack)]
        duals = [(at.dual, step.dual), (at.low[free], step.low[free]), (at.high[free], step.high[free]), (at.price, step.price)]
        length = primal = min(longest(value, change, keep) for value, change in unknowns)
        back = min(longest(value, change, keep) for value, change in [*duals, (at.jerk_dual, step.jerk_dual)])
        merit = self._merit(at.x, state, at.slack, at.late, at.jerk_slack, barrier)
        for attempt in range(_BACKTRACKS):
            x, local, slack, late, jerk_slack = (
                getattr(at, name) + length * getattr(step, name) for name in ("x", "local", "slack", "late", "jerk_slack")
            )
            new = self._state(x, local, slack, late, jerk_slack)
            value = self._merit(x, new, slack, late, jerk_slack, barrier)
            if np.isfinite(value) and _acceptable(merit, state.infeasible, value, new.infeasible, length):
                made = Iterate(
                    x, local, slack, at.dual + back * step.dual, at.low + back * step.low, at.high + back * step.high, late,
                    at.price + back * step.price, at.ring + length * step.ring, jerk_slack, at.jerk_dual + back * step.jerk_dual,
                )  # fmt: skip
                return made, new
            length = min(primal, 1e-3) if attempt == _BACKTRACKS - 2 else 0.5 * length
        return None

    def _merit(self, x: Floats, state: State, slack: Floats, late: Floats, jerk_slack: Floats, barrier: float) -> float:
        room = self._room(x)
        logs = np.sum(np.log(slack)) + np.sum(np.log(late)) + np.sum(np.log(jerk_slack)) + np.sum(np.log(room)) + np.sum(np.log(x[self.free]))
        return float(self.weight * np.sum(state.values.energy) + self.price * np.sum(state.values.time) - barrier * logs)


def _acceptable(merit: float, infeasible: float, value: float, new: float, length: float) -> bool:
    """Whether a trial improves the merit or the infeasibility, or is feasible to rounding with a merit that is no worse to rounding."""
    if new > 1e3 * max(infeasible, 1e-4):
        return False
    return value <= merit + 1e-9 * max(abs(merit), 1.0) or new <= (1.0 - 1e-4 * length) * infeasible
