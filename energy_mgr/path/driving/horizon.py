"""Receding horizon (P3): the path of the next few hundred metres, planned again and again while the car drives and the borders change.

Each step plans from a knot just ahead of the car, where place, heading and curvature are those of the plan in force, to the horizon, and proves the
result. What cannot be proven is not used: the last proven path stays in force, as far as it is still proven against the borders as they are now.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from roads import PlanarCurve, RoadError

from ...errors import PlanningError, SolverError
from ..planner import PathOptions, refuse_narrow, with_repairs
from ..problem.ends import End
from ..problem.knots import knots_by_need
from ..problem.problem import CurvatureProblem
from ..problem.spline import PER_KNOT
from ..proof.certificate import Certificate
from ..solvers import gauss_newton
from ..solvers.backends import Piqp
from .step import PathState, PathStep, StepStatus
from .stitching import cut, end_of, joined
from .strip import Strip

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from powertrain import Vehicle
    from roads import Narrowing, Road
    from roads.geometry.cubic import PiecewiseCubic
    from roads.road import Extent

    Floats = NDArray[np.float64]

#: Knots are no farther apart than this, m: a border that comes closer later needs some near it.
_WIDEST = 8.0
#: Control points between knots, at least, and by how much the borders are drawn in, m: more than for a plan made once, to fail the proof seldom.
_CONTROL_POINTS, _TIGHTER = 6, 2e-3
#: A car this far beside its plan, or turned against it by this much, starts a plan of its own, m and rad.
_OFF_PLAN, _TURNED = 0.3, 0.1
#: A plan is kept this far behind the car, m; what could not be proven is kept clear of by this much.
_TAIL, _CLEAR = 20.0, 0.5
#: Solves and proofs per step; steps that promise less than this fraction of the cost end a solve.
_ROUNDS, _TOLERANCE = 6, 1e-5
#: QPs per solve where the window has moved by at most so many knots, and otherwise.
_FEW, _MANY, _NEAR = 1, 8, 2
#: Shortest window, in segments; a path from a place beside the plan reaches its first knot after this way, m.
_SHORTEST, _FIRST_WAY = 4, 2.0


class _Plan(NamedTuple):
    """The path in force: pieces over unwrapped stations, from and to where they are proven in which version of the borders, and the variables."""

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


class PathPlanner:
    """Plans the path ahead, step by step; holds the path in force.

    Args:
        road: where to drive.
        vehicle: the car; its width and turning circle count.
        extent: part of the road that may be used.
        margin: distance between the car's side and the borders, m.
        horizon: length of a window, m.
        budget_ms: a step along a path in force starts no solve that is likely to end after this processor time.
        options: weights, bound on curvature and control points; knots, solver and ends are the planner's own.

    Raises:
        InfeasibleError: the road is narrower than the car with its margins; the station is named.
        PlanningError: arguments out of range.
    """

    def __init__(
        self,
        road: Road,
        vehicle: Vehicle,
        *,
        extent: Extent = "own",
        margin: float = 0.2,
        horizon: float = 200.0,
        budget_ms: float = 12.0,
        options: PathOptions | None = None,
    ) -> None:
        options = options or PathOptions()
        _check(horizon, budget_ms, margin, options)
        self.road, self.horizon, self.budget_ms = road, horizon, budget_ms
        radius = vehicle.limits.turning_radius_min_m
        self.curvature_max = min(options.curvature_max, np.inf if radius is None else 1.0 / radius)
        corridor = road.corridor(extent, 0.5 * vehicle.chassis.width_m + margin)
        refuse_narrow(corridor)
        problem = CurvatureProblem.on(
            corridor,
            road.lane_centre(),
            knots=knots_by_need(corridor, density=options.density, widest=_WIDEST),
            control_points=max(options.control_points, _CONTROL_POINTS),
            weights=options.weights,
            curvature_max=self.curvature_max,
            tighter=_TIGHTER,
        )
        self._strip = Strip(problem)
        self._qp = Piqp()
        self._plan: _Plan | None = None
        self._last_s: float | None = None
        self.rejected = 0

    @property
    def path(self) -> PlanarCurve | None:
        """The path in force, None before the first step; its parameter is the road's station."""
        return None if self._plan is None else PlanarCurve.of_pieces(self._plan.pieces)

    def step(self, s: float, state: PathState | None = None, corridor_update: Sequence[Narrowing] | None = None) -> PathStep:
        """Plan the next window.

        Args:
            s: the car's station on the road's reference, m; on a circuit it may wrap or count on.
            state: where the car is, if it may not be on the path in force; its place then counts, not `s`.
            corridor_update: all places where the borders are closer than the road's from now on; None changes nothing.

        Returns:
            The path in force. A step never raises: where nothing new is proven, and where a measurement cannot be, it says why and keeps what is;
            measurements and updates that are refused are counted in `rejected`.
        """
        started = time.process_time()
        refused = [self._update(corridor_update), self._reject(s, state)]
        self.rejected += sum(bool(reason) for reason in refused)
        reason, iterations, cost = next(filter(None, refused), ""), 0, np.nan
        if refused[1]:
            s, state = self._last_s or 0.0, None
        s = self._unwrapped(s, state)
        self._renew(s)
        try:
            if not refused[1]:
                iterations, cost = self._planned(s, state, started)
        except (RoadError, PlanningError) as error:
            reason = reason or str(error)
        return self._in_force(s, state, reason, iterations, cost, started)

    # -- what comes in ---------------------------------------------------------------------------------------------------------------

    def _reject(self, s: float, state: PathState | None) -> str:
        """Why the measurements cannot be; empty if they can."""
        length = self.road.length
        values = [s] if state is None else [s, state.x, state.y, state.psi, state.kappa]
        if not np.all(np.isfinite(values)):
            return f"{self.road.name}: station {s} and {state}, expected finite numbers"
        if not self.road.closed and not -1.0 <= s <= length + 1.0:
            return f"{self.road.name}: station {s:.1f} m, expected 0 to {length:.1f} m"
        return ""

    def _update(self, narrowings: Sequence[Narrowing] | None) -> str:
        """Take over the borders; why not, if not."""
        try:
            if narrowings is not None:
                self._strip.update(narrowings)
        except RoadError as error:
            return str(error)
        return ""

    def _unwrapped(self, s: float, state: PathState | None) -> float:
        length = self.road.length
        if state is not None:
            s = float(self._strip.corridor.reference.project([[state.x, state.y]], [s])[0][0])
        if not self.road.closed:
            self._last_s = min(max(s, 0.0), length)
        else:
            self._last_s = s if self._last_s is None else s + length * round((self._last_s - s) / length)
        return self._last_s

    def _renew(self, s: float) -> None:
        """Prove the path in force again where borders have changed or the car is before what was proven; drop it where it does not reach."""
        plan = self._plan
        if plan is None:
            return
        if not plan.start <= s <= plan.end:
            self._plan = None
        elif plan.version != self._strip.version or s < plan.proven_from:
            found = self._strip.prover(s, plan.end).prove(plan.pieces, self.curvature_max, start=s, end=plan.end)
            ends = [float(values[0]) for values in (found.where, found.bends) if len(values)]
            clear = max(min(ends) - _CLEAR, s) if ends else plan.end
            self._plan = plan._replace(proven_from=s, proven_to=clear, version=self._strip.version)

    # -- planning --------------------------------------------------------------------------------------------------------------------

    def _planned(self, s: float, state: PathState | None, started: float) -> tuple[int, float]:
        """Plan from the path in force, from the car, or from the lane; QPs solved and cost. (0, nan): there is nothing new to plan."""
        plan, strip = self._plan, self._strip
        if plan is not None and (state is None or _is_on(plan, s, state)):
            if s >= plan.proven_to and plan.proven_to < plan.end:
                raise SolverError(f"{self.road.name}: the car is at s = {s:.1f} m, where the path in force is not proven any more")
            knot = self._stitch(plan, s)
            if self._is_done(plan, knot):
                return 0, np.nan
            if not strip.exists(knot) or strip.station(knot) >= plan.proven_to:
                raise SolverError(f"{self.road.name}: the path in force is proven to s = {plan.proven_to:.1f} m only, which is before the next knot")
            return self._advance(s, knot, end_of(plan.pieces, strip.station(knot), strip.tables, knot), started)
        if state is not None:
            return self._from_state(s, state)
        return self._advance(s, strip.knot_at(s), strip.on_lane(strip.knot_at(s)), started)

    def _stitch(self, plan: _Plan, s: float) -> int:
        """The first knot ahead of the car that the path in force has too: a path from beside the plan lacks those close to where it began."""
        knot = self._strip.knot_at(s) + 1
        while self._strip.exists(knot) and np.min(np.abs(plan.pieces.breaks - self._strip.station(knot))) > 1e-6 and knot < plan.first_knot:
            knot += 1
        return knot

    def _is_done(self, plan: _Plan, knot: int) -> bool:
        """True if planning from `knot` would find the path in force again: the same window, or the end of the road is reached already."""
        if plan.proven_to < plan.end:
            return False
        last = plan.first_knot + len(plan.x) // PER_KNOT - 1
        if not self.road.closed and last == self._strip.tables.count - 1:
            return True
        return plan.converged and knot == plan.first_knot and self._strip.last_knot(knot, self.horizon, _SHORTEST) == last

    def _from_state(self, s: float, state: PathState) -> tuple[int, float]:
        """Solve and prove from where the car is, with its curvature if that can be had; takes a few times as long as a step along a path in force."""
        reference = self._strip.corridor.reference
        place, normal = reference.position(np.array([s]))[0], reference.normal(np.array([s]))[0]
        offset = float((np.array([state.x, state.y]) - place) @ normal)
        turn = state.psi - float(reference.heading(np.array([s]))[0])
        heading = float(np.arctan2(np.sin(turn), np.cos(turn)))
        right, left = (float(border) for border in self._strip.corridor.offsets(s))
        if not right <= offset <= left or abs(heading) > 1.0:
            raise SolverError(
                f"{self.road.name}: the car is at {offset:.2f} m beside the reference and turned by {heading:.2f} rad at s = {s:.1f} m, "
                f"expected {right:.2f} to {left:.2f} m and less than 1 rad"
            )
        if abs(state.kappa) < self.curvature_max:
            try:
                return self._solve_from(s, End(offset, heading, state.kappa))
            except PlanningError:
                pass  # a jump of curvature is better than no path
        return self._solve_from(s, End(offset, heading))

    def _solve_from(self, s: float, end: End) -> tuple[int, float]:
        strip = self._strip
        first = strip.knot_at(s + _FIRST_WAY) + 1
        if not strip.exists(first + _SHORTEST - 1):
            raise SolverError(f"{self.road.name}: the road ends within the window, nothing can be planned from a place beside the path")
        last = strip.last_knot(first, self.horizon, _SHORTEST - 1)
        problem = CurvatureProblem.on(
            strip.corridor,
            self.road.lane_centre(),
            knots=np.concatenate([[s], strip.tables.station(np.arange(first, last + 1))]),
            control_points=_CONTROL_POINTS,
            weights=strip.tables.problem.objective.weights,
            ends=(end, strip.far_end(last)),
            curvature_max=self.curvature_max,
            tighter=_TIGHTER,
            window=True,
        )
        x, iterations, fault = problem.initial(), 0, ""
        for _ in range(_ROUNDS):
            solution = gauss_newton.solve(problem, x, tolerance=_TOLERANCE)
            x, iterations = solution.x, iterations + solution.iterations
            pieces = problem.spline.pieces(x)
            stop = float(pieces.breaks[-1])
            certificate = strip.prover(s, stop).prove(pieces, self.curvature_max)
            if certificate.certified:
                self._plan = _Plan(pieces, s, stop, strip.version, first, x[PER_KNOT:], solution.converged)
                return iterations, solution.cost
            fault = certificate.fault
            problem = with_repairs(problem, x, certificate)
        raise SolverError(f"{self.road.name}: {fault}")

    def _advance(self, s: float, first: int, end: End, started: float) -> tuple[int, float]:
        """Solve and prove from the knot `first`; the plan is replaced only by a proven one."""
        strip, plan = self._strip, self._plan
        last = strip.last_knot(first, self.horizon, _SHORTEST)
        if last - first < _SHORTEST or not strip.exists(last):
            raise SolverError(f"{self.road.name}: the road ends within the window, nothing is left to plan")
        guess = x = self._guess(first, last)
        # after a small advance one QP is enough: what it leaves, the next step takes up (real-time iteration)
        warm = plan is not None and plan.proven_to == plan.end and first - plan.first_knot <= _NEAR
        iterations, certificate = 0, None
        for _ in range(_ROUNDS):
            # without a path in force there is nothing to fall back on, and time does not count
            left = np.inf if plan is None else self.budget_ms - 1e3 * (time.process_time() - started)
            if iterations and left < 0.3 * self.budget_ms:
                break
            problem = strip.window(first, last, end)
            if plan is not None and plan.proven_to == plan.end:
                _allow(problem, plan, first, guess)
            count = _FEW if warm else _MANY
            solution = gauss_newton.solve(problem, x, qp=self._qp, tolerance=_TOLERANCE, iterations=count, seconds=1e-3 * left, residual=False)
            x, iterations = solution.x, iterations + solution.iterations
            pieces = joined(None if plan is None else plan.pieces, problem.spline.pieces(x), s - _TAIL)
            start, stop = max(s, float(pieces.breaks[0])), float(pieces.breaks[-1])
            certificate = strip.prover(start, stop).prove(pieces, self.curvature_max, start=start, end=stop)
            if certificate.certified:
                self._plan = _Plan(pieces, start, stop, strip.version, first, x, solution.converged)
                return iterations, solution.cost
            strip.learn(problem, x, first, certificate)
        raise SolverError(f"{self.road.name}: {certificate.fault if isinstance(certificate, Certificate) else 'no time was left to solve'}")

    def _guess(self, first: int, last: int) -> Floats:
        """Variables to start from: those of the path in force where it reaches, the lane's beyond."""
        tables, plan = self._strip.tables, self._plan
        x = tables.guess[np.arange(first, last + 1) % tables.count].copy()
        if plan is not None:
            old = plan.x.reshape(-1, PER_KNOT)
            low, high = max(first, plan.first_knot), min(last, plan.first_knot + len(old) - 1)
            if low <= high:
                x[low - first : high - first + 1] = old[low - plan.first_knot : high - plan.first_knot + 1]
        return x.ravel()

    # -- what goes out ---------------------------------------------------------------------------------------------------------------

    def _in_force(self, s: float, state: PathState | None, reason: str, iterations: int, cost: float, started: float) -> PathStep:
        plan = self._plan

        def answer(status: StepStatus, clear_to: float, why: str) -> PathStep:
            pieces = cut(plan.pieces, clear_to) if plan is not None and status != "lost" else None
            return PathStep(status, s, pieces, clear_to, why, iterations, cost, 1e3 * (time.process_time() - started))

        if plan is None or not plan.start <= s <= plan.end or (state is not None and not _is_on(plan, s, state)):
            return answer("lost", s, reason or "the car is not on the path in force")
        if plan.proven_to < plan.end:
            return answer("blocked" if s < plan.proven_to else "lost", plan.proven_to, reason)
        return answer("kept" if reason else "solved", plan.end, reason)


def _check(horizon: float, budget_ms: float, margin: float, options: PathOptions) -> None:
    if not 10.0 <= horizon <= 1e6:
        raise PlanningError(f"horizon {horizon} m, expected 10 m to 1000 km")
    if not budget_ms > 0.0 or not 0.0 <= margin < 100.0:
        raise PlanningError(f"budget {budget_ms} ms and margin {margin} m, expected a time above 0 and 0 to 100 m")
    usual = PathOptions()
    for name in ("knots", "method", "qp", "tolerance", "ends"):
        if getattr(options, name) != getattr(usual, name):
            raise PlanningError(f"{name} {getattr(options, name)!r}: a receding horizon has its own, leave it out")


def _is_on(plan: _Plan, s: float, state: PathState) -> bool:
    """True if the car is where the path in force leads."""
    place, first = (value[0] for value in plan.pieces(np.array([s]), 1))
    across = (first[0] * (state.y - place[1]) - first[1] * (state.x - place[0])) / float(np.hypot(*first))
    turn = np.arctan2(first[1], first[0]) - state.psi
    return bool(abs(across) <= _OFF_PLAN and abs(np.arctan2(np.sin(turn), np.cos(turn))) <= _TURNED)


def _allow(window: CurvatureProblem, plan: _Plan, first: int, x: Floats) -> None:
    """Widen the borders to what the path in force does: it is proven, and rows drawn in since then must not shut it out."""
    count = plan.first_knot + len(plan.x) // PER_KNOT - first  # knots of the window that the path in force has
    if count < 2 or first < plan.first_knot:
        return
    right, left = (border.copy() for border in window.borders)
    e = x[2::PER_KNOT][:count]
    right[:count], left[:count] = np.minimum(right[:count], e), np.maximum(left[:count], e)
    rows = window.rows
    covered = window.offset_table[0] < count - 1
    value = rows.matrix @ x
    lower = np.where(covered, np.minimum(rows.lower, value), rows.lower)
    upper = np.where(covered, np.maximum(rows.upper, value), rows.upper)
    vars(window).update(borders=(right, left), rows=rows._replace(lower=lower, upper=upper))
