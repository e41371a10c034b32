"""Receding horizon (P3): the path of the next few hundred metres, planned again and again while the car drives and the borders change.

Each step plans from a knot just ahead of the car, where place, heading and curvature are those of the plan in force, to the horizon, and proves the
result. What cannot be proven is not used: the last proven path stays in force, as far as it is still proven against the borders as they are now.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np

from roads import PlanarCurve, RoadError

from ...errors import PlanningError, SolverError
from ..planner import PathOptions, refuse_narrow
from ..problem.knots import knots_by_need
from ..problem.problem import CurvatureProblem
from ..solvers.backends import Piqp
from .aside import from_place
from .onward import onward
from .plan import Plan, Planned, proven_again
from .step import PathState, PathStep, StepStatus
from .stitching import cut, end_of
from .strip import Strip
from .terms import CONTROL_POINTS, SHORTEST, TIGHTER, Clock, Terms

if TYPE_CHECKING:
    from collections.abc import Sequence

    from powertrain import Vehicle
    from roads import Narrowing, Road
    from roads.road import Extent

#: Knots are no farther apart than this, m: a border that comes closer later needs some near it.
_WIDEST = 8.0


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
            control_points=max(options.control_points, CONTROL_POINTS),
            weights=options.weights,
            curvature_max=self.curvature_max,
            tighter=TIGHTER,
        )
        self._strip = Strip(problem)
        self._terms = Terms(road, self._strip, self.curvature_max, Piqp())
        self._plan: Plan | None = None
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
        clock = Clock(time.process_time(), self.budget_ms)
        refused = [self._update(corridor_update), self._reject(s, state)]
        self.rejected += sum(bool(reason) for reason in refused)
        reason, iterations, cost = next(filter(None, refused), ""), 0, np.nan
        if refused[1]:
            s, state = self._last_s or 0.0, None
        s = self._unwrapped(s, state)
        self._plan = proven_again(self._plan, s, self._strip, self.curvature_max)
        try:
            if not refused[1] and (found := self._planned(s, state, clock)) is not None:
                self._plan, iterations, cost = found
        except (RoadError, PlanningError) as error:
            reason = reason or str(error)
        return self._in_force(s, state, reason, iterations, cost, clock)

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

    # -- planning --------------------------------------------------------------------------------------------------------------------

    def _planned(self, s: float, state: PathState | None, clock: Clock) -> Planned | None:
        """Plan from the path in force, from the car, or from the lane; None: there is nothing new to plan."""
        plan, strip = self._plan, self._strip
        if plan is None or (state is not None and not plan.carries(s, state)):
            if state is not None:
                return from_place(self._terms, s, state, self.horizon)
            knot = strip.knot_at(s)
            return onward(self._terms, None, s, knot, strip.on_lane(knot), self.horizon, clock)
        if s >= plan.proven_to and plan.proven_to < plan.end:
            raise SolverError(f"{self.road.name}: the car is at s = {s:.1f} m, where the path in force is not proven any more")
        knot = self._stitch(plan, s)
        if self._is_done(plan, knot):
            return None
        if not strip.exists(knot) or strip.station(knot) >= plan.proven_to:
            raise SolverError(f"{self.road.name}: the path in force is proven to s = {plan.proven_to:.1f} m only, which is before the next knot")
        return onward(self._terms, plan, s, knot, end_of(plan.pieces, strip.station(knot), strip.tables, knot), self.horizon, clock)

    def _stitch(self, plan: Plan, s: float) -> int:
        """The first knot ahead of the car that the path in force has too: a path from beside the plan lacks those close to where it began."""
        knot = self._strip.knot_at(s) + 1
        while self._strip.exists(knot) and np.min(np.abs(plan.pieces.breaks - self._strip.station(knot))) > 1e-6 and knot < plan.first_knot:
            knot += 1
        return knot

    def _is_done(self, plan: Plan, knot: int) -> bool:
        """True if planning from `knot` would find the path in force again: the same window, or the end of the road is reached already."""
        if not plan.is_whole:
            return False
        if not self.road.closed and plan.last_knot == self._strip.tables.count - 1:
            return True
        return plan.converged and knot == plan.first_knot and self._strip.last_knot(knot, self.horizon, SHORTEST) == plan.last_knot

    # -- what goes out ---------------------------------------------------------------------------------------------------------------

    def _in_force(self, s: float, state: PathState | None, reason: str, iterations: int, cost: float, clock: Clock) -> PathStep:
        plan = self._plan

        def answer(status: StepStatus, clear_to: float, why: str) -> PathStep:
            pieces = cut(plan.pieces, clear_to) if plan is not None and status != "lost" else None
            return PathStep(status, s, pieces, clear_to, why, iterations, cost, clock.spent_ms)

        if plan is None or not plan.start <= s <= plan.end or (state is not None and not plan.carries(s, state)):
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
