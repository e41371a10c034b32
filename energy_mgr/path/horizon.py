"""Receding horizon (P3): the path of the next few hundred metres, planned again and again while the car drives and the borders change.

Each step plans from a knot just ahead of the car, where place, heading and curvature are those of the plan in force, to the horizon, and proves the
result. What cannot be proven is not used: the last proven path stays in force, as far as it is still proven against the borders as they are now.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from roads import PlanarCurve, RoadError

from ..errors import InfeasibleError, PlanningError, SolverError
from .backends import Piqp
from .certificate import Certificate, Prover
from .ends import End
from .knots import knots_by_need
from .planner import PathOptions, refuse_narrow, with_repairs
from .problem import CurvatureProblem
from .solvers import gauss_newton
from .spline import PER_KNOT
from .step import PathState, PathStep, StepStatus
from .stitching import cut, end_of, joined
from .window import Tables

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from powertrain import Vehicle
    from roads import Narrowing, Road
    from roads.cubic import PiecewiseCubic
    from roads.road import Extent

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

#: Knots are no farther apart than this, m: a border that comes closer later needs some near it.
_WIDEST = 8.0
#: Control points between knots, at least, and by how much the borders are drawn in, m: more than a plan made once, to fail the proof seldom.
_CONTROL_POINTS, _TIGHTER = 6, 2e-3
#: A car this far beside its plan, or turned against it by this much, starts a plan of its own, m and rad.
_OFF_PLAN, _TURNED = 0.3, 0.1
#: The borders are cut up from this far behind the car to this far beyond the horizon, m.
_BEHIND, _BEYOND = 30.0, 120.0
#: A plan is kept this far behind the car, m.
_TAIL = 20.0
#: Solves and proofs per step; steps that promise less than this fraction of the cost end a solve.
_ROUNDS, _TOLERANCE = 6, 1e-5
#: QPs per solve where the window has moved by at most so many knots, and otherwise.
_FEW, _MANY, _NEAR = 1, 8, 2
#: A place beyond the border is drawn in by so much more than it is beyond, m.
_REPAIR_MORE = 1e-3
#: Shortest window, in segments.
_SHORTEST = 4


class _Plan(NamedTuple):
    """The path in force: pieces over unwrapped stations, where it is proven to, against which borders, and the variables at its knots."""

    pieces: PiecewiseCubic
    proven_to: float
    version: int
    first_knot: int
    x: Floats
    converged: bool


class _Start(NamedTuple):
    """Where a window begins: its problem's first knot on the road's grid, the end condition, and the old pieces before it."""

    knot: int
    end: End
    before: PiecewiseCubic | None


class PathPlanner:
    """Plans the path ahead, step by step; holds the path in force.

    Args:
        road: where to drive.
        vehicle: the car; its width and turning circle count.
        extent: part of the road that may be used.
        margin: distance between the car's side and the borders, m.
        horizon: length of a window, m.
        budget_ms: a step starts no solve that is likely to end after this time.
        options: how paths are found; knots are placed by need.

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
        if not 10.0 <= horizon <= 1e6:
            raise PlanningError(f"horizon {horizon} m, expected 10 m to 1000 km")
        if not budget_ms > 0.0 or not 0.0 <= margin < 100.0:
            raise PlanningError(f"budget {budget_ms} ms and margin {margin} m, expected a time above 0 and 0 to 100 m")
        self.road, self.horizon, self.budget_ms = road, horizon, budget_ms
        options = options or PathOptions()
        radius = vehicle.limits.turning_radius_min_m
        self.curvature_max = min(options.curvature_max, np.inf if radius is None else 1.0 / radius)
        self._base = road.corridor(extent, 0.5 * vehicle.chassis.width_m + margin)
        refuse_narrow(self._base)
        problem = CurvatureProblem.on(
            self._base,
            road.lane_centre(),
            knots=knots_by_need(self._base, density=options.density, widest=_WIDEST),
            control_points=max(options.control_points, _CONTROL_POINTS),
            weights=options.weights,
            curvature_max=self.curvature_max,
            tighter=_TIGHTER,
        )
        self._tables = Tables(problem)
        self._tighter_rows, self._tighter_knots = problem.row_tighter.copy(), np.full(len(problem.q), _TIGHTER)
        self._lane_heading = _headings(problem, self._tables.guess)
        self._corridor, self._narrowings, self._version = self._base, (), 0
        self._prover: Prover | None = None
        self._qp = Piqp()
        self._plan: _Plan | None = None
        self._last_s = 0.0
        self.rejected = 0

    @property
    def path(self) -> PlanarCurve | None:
        """The path in force, None before the first step; its parameter is the road's station."""
        return None if self._plan is None else PlanarCurve.of_pieces(self._plan.pieces)

    def step(self, s: float, state: PathState | None = None, corridor_update: Sequence[Narrowing] | None = None) -> PathStep:
        """Plan the next window.

        Args:
            s: the car's station on the road's reference, m; on a circuit it may wrap or count on.
            state: where the car is, if it is not on the path in force.
            corridor_update: all places where the borders are closer than the road's from now on; None changes nothing.

        Returns:
            The path in force. A step never raises: where nothing new is proven, and where a measurement cannot be, it says why and keeps what is;
            measurements and updates that are refused are counted in `rejected`.
        """
        started = time.process_time()
        reason, iterations, cost = self._reject(s, state), 0, np.nan
        s = self._unwrapped(s)
        if reason:
            return self._in_force(s, None, reason, 0, cost, started)
        try:
            self._update(corridor_update)
            start = self._start(s, state)
            if isinstance(start, PathState):
                iterations, cost = self._from_state(s, start)
            elif start is not None:
                iterations, cost = self._advance(s, start, started)
        except (RoadError, InfeasibleError, SolverError) as error:
            reason = str(error)
        return self._in_force(s, state, reason, iterations, cost, started)

    # -- a step's parts --------------------------------------------------------------------------------------------------------------

    def _reject(self, s: float, state: PathState | None) -> str:
        """Why the measurements cannot be; empty if they can."""
        length = self.road.length
        values = [s] if state is None else [s, state.x, state.y, state.psi, state.kappa]
        reason = ""
        if not np.all(np.isfinite(values)):
            reason = f"{self.road.name}: station {s} and {state}, expected finite numbers"
        elif not self.road.closed and not -1.0 <= s <= length + 1.0:
            reason = f"{self.road.name}: station {s:.1f} m, expected 0 to {length:.1f} m"
        self.rejected += bool(reason)
        return reason

    def _update(self, narrowings: Sequence[Narrowing] | None) -> None:
        if narrowings is None or tuple(narrowings) == self._narrowings:
            return
        try:
            corridor = self._base.narrowed(*narrowings)
        except RoadError:
            self.rejected += 1
            raise
        self._narrowings, self._corridor = tuple(narrowings), corridor
        self._version += 1
        self._prover = None

    def _unwrapped(self, s: float) -> float:
        length = self.road.length
        if not np.isfinite(s):
            return self._last_s
        if not self.road.closed:
            self._last_s = min(max(s, 0.0), length)
        else:
            self._last_s = s + length * round((self._last_s - s) / length)
        return self._last_s

    def _start(self, s: float, state: PathState | None) -> _Start | PathState | None:
        """Where the window begins: on the path in force, at the car, or on the lane. None: there is nothing new to plan."""
        plan = self._plan
        tables = self._tables
        if plan is not None and plan.pieces.breaks[0] <= s < plan.proven_to and (state is None or self._on_plan(plan, s, state)):
            knot = self._knot_at(s) + 1
            if plan.version == self._version and self._is_done(plan, knot):
                return None
            at = float(tables.station(np.array([knot]))[0]) if self._exists(knot) else np.inf
            if at < plan.proven_to:
                return _Start(knot, end_of(plan.pieces, at, self._tables, knot), plan.pieces)
            raise SolverError(f"{self.road.name}: the path in force ends before the next knot")
        if state is not None:
            return state
        knot = self._knot_at(s)
        inner = knot % tables.count
        return _Start(knot, End(self._lane_offset(knot), float(self._lane_heading[inner])), None)

    def _is_done(self, plan: _Plan, knot: int) -> bool:
        """True if planning from `knot` would find the path in force again: the same window, or the end of the road is reached already."""
        final = self._tables.count - 1
        last = plan.first_knot + len(plan.x) // PER_KNOT - 1
        if not self.road.closed and last == final:
            return True
        return plan.converged and knot == plan.first_knot and self._last_knot(knot) == last

    def _lane_offset(self, knot: int) -> float:
        right, left = self._offsets(np.array([knot]))
        return float(np.clip(self._tables.guess[knot % self._tables.count, 2], right[0] + _TIGHTER, left[0] - _TIGHTER))

    def _from_state(self, s: float, state: PathState) -> tuple[int, float]:
        """Solve and prove from where the car is, with its curvature if that can be had; takes a few times as long as a step along a path in force."""
        reference = self._corridor.reference
        station, offset = (float(value[0]) for value in reference.project([[state.x, state.y]], [s]))
        turn = state.psi - float(reference.heading(np.array([station]))[0])
        heading = float(np.arctan2(np.sin(turn), np.cos(turn)))
        right, left = (float(border) for border in self._corridor.offsets(station))
        if not right <= offset <= left or abs(heading) > 1.0:
            raise SolverError(
                f"{self.road.name}: the car is at {offset:.2f} m beside the reference and turned by {heading:.2f} rad at s = {station:.1f} m, "
                f"expected {right:.2f} to {left:.2f} m and less than 1 rad"
            )
        ends = [End(offset, heading, state.kappa), End(offset, heading)]
        if abs(state.kappa) < self.curvature_max:
            try:
                return self._solve_from(station, ends[0])
            except (InfeasibleError, SolverError):
                pass  # a jump of curvature is better than no path
        return self._solve_from(station, ends[1])

    def _solve_from(self, station: float, end: End) -> tuple[int, float]:
        tables = self._tables
        first = self._knot_at(station + 2.0) + 1
        last = self._last_knot(first)
        if not self.road.closed and last - first < _SHORTEST - 1:
            raise SolverError(f"{self.road.name}: the road ends within the window, nothing can be planned from a place beside the path")
        grid = np.arange(first, last + 1)
        at_end = last == tables.count - 1 and not self.road.closed
        final = tables.problem.ends[1] if at_end and tables.problem.ends else End(heading=float(self._lane_heading[last % tables.count]))
        problem = CurvatureProblem.on(
            self._corridor,
            self.road.lane_centre(),
            knots=np.concatenate([[station], tables.station(grid)]),
            control_points=_CONTROL_POINTS,
            weights=tables.problem.objective.weights,
            ends=(end, final),
            curvature_max=self.curvature_max,
            tighter=_TIGHTER,
            window=True,
        )
        x, iterations = problem.initial(), 0
        certificate: Certificate | None = None
        for _ in range(_ROUNDS):
            solution = gauss_newton.solve(problem, x, tolerance=_TOLERANCE)
            x, iterations = solution.x, iterations + solution.iterations
            pieces = problem.spline.pieces(x)
            certificate = self._proof(float(pieces.breaks[-1])).prove(pieces, self.curvature_max)
            if certificate.certified:
                self._plan = _Plan(pieces, float(pieces.breaks[-1]), self._version, first, x[PER_KNOT:], solution.converged)
                return iterations, solution.cost
            problem = with_repairs(problem, x, certificate) if not certificate.inside else problem.with_bends(certificate.bends[::20])
        raise SolverError(f"{self.road.name}: {_what_failed(certificate)}")

    def _advance(self, s: float, start: _Start, started: float) -> tuple[int, float]:
        """Solve and prove from `start`; the plan is replaced only by a proven one."""
        first, last = start.knot, self._last_knot(start.knot)
        if last - first < _SHORTEST:
            raise SolverError(f"{self.road.name}: the road ends within the window, nothing is left to plan")
        guess = x = self._guess(first, last)
        # after a small advance one QP is enough: what it leaves, the next step takes up (real-time iteration)
        warm = self._plan is not None and self._plan.version == self._version and start.knot - self._plan.first_knot <= _NEAR
        iterations = 0
        certificate: Certificate | None = None
        for _ in range(_ROUNDS):
            spent = 1e3 * (time.process_time() - started)
            if self._plan is None:
                spent = -np.inf  # without a path in force there is nothing to fall back on
            elif iterations and spent > 0.7 * self.budget_ms:
                break
            problem = self._window(first, last, start.end, guess)
            solution = gauss_newton.solve(
                problem,
                x,
                qp=self._qp,
                tolerance=_TOLERANCE,
                iterations=_FEW if warm else _MANY,
                seconds=1e-3 * (self.budget_ms - spent),
                residual=False,
            )
            x, iterations = solution.x, iterations + solution.iterations
            pieces = joined(start.before, problem.spline.pieces(x), s - _TAIL)
            end = float(pieces.breaks[-1])
            certificate = self._proof(end).prove(pieces, self.curvature_max, start=max(s, float(pieces.breaks[0])), end=end)
            if certificate.certified:
                self._plan = _Plan(pieces, end, self._version, first, x, solution.converged)
                return iterations, solution.cost
            self._draw_in(problem, x, first, last, certificate)
        raise SolverError(f"{self.road.name}: {_what_failed(certificate)}")

    def _window(self, first: int, last: int, end: End, x: Floats) -> CurvatureProblem:
        tables = self._tables
        knots = np.arange(first, last + 1)
        segments = knots[:-1] % tables.segments
        rows, _ = tables.rows_of(segments)
        borders = None
        if self._narrowings:
            turns = (knots[:-1][tables.rows_of(segments)[1]] // tables.count) if self.road.closed else 0
            row_q = tables.problem.row_q[rows] + turns * self.road.length
            borders = (*self._corridor.offsets(tables.station(knots)), *self._corridor.offsets(row_q))
        at_end = last == tables.count - 1 and not self.road.closed
        final = tables.problem.ends[1] if at_end and tables.problem.ends else End(heading=float(self._lane_heading[last % tables.count]))
        window = tables.window(first, last, (end, final), borders, (self._tighter_knots[knots % tables.count], self._tighter_rows[rows]))
        if self._plan is not None and self._plan.version == self._version:
            _allow(window, self._plan, first, x)
        return window

    def _draw_in(self, problem: CurvatureProblem, x: Floats, first: int, last: int, certificate: Certificate) -> None:
        """Draw the borders in at the rows or knots nearest to where the proof failed, for this and all later windows."""
        tables = self._tables
        value, (right, left) = problem.rows.matrix @ x, problem.borders
        spare_row = np.maximum(np.minimum(problem.rows.upper - value, value - problem.rows.lower), 0.0)
        spare_knot = np.maximum(np.minimum(left - x[2::PER_KNOT], x[2::PER_KNOT] - right), 0.0)
        segments = np.arange(first, last) % tables.segments
        rows, _ = tables.rows_of(segments)
        inner = np.arange(first, last + 1) % tables.count
        length = self.road.length if self.road.closed else np.inf
        for station, depth in zip(certificate.where, certificate.depth, strict=True):
            at = station % length if np.isfinite(length) else station
            to_row, to_knot = (np.abs(_around(q - at, length)) for q in (tables.problem.row_q[rows], tables.problem.q[inner]))
            if len(rows) and np.min(to_row) <= np.min(to_knot):
                near = int(np.argmin(to_row))
                self._tighter_rows[rows[near]] = max(
                    self._tighter_rows[rows[near]], problem.row_tighter[near] + spare_row[near] + 1.5 * depth + _REPAIR_MORE
                )
            else:
                near = int(np.argmin(to_knot))
                used = self._tighter_knots[inner[near]]
                self._tighter_knots[inner[near]] = max(used, used + spare_knot[near] + 1.5 * depth + _REPAIR_MORE)

    def _in_force(self, s: float, state: PathState | None, reason: str, iterations: int, cost: float, started: float) -> PathStep:
        plan = self._plan

        def answer(status: StepStatus, clear_to: float, why: str) -> PathStep:
            pieces = cut(plan.pieces, clear_to) if plan is not None and status != "lost" else None
            return PathStep(status, pieces, clear_to, why, iterations, cost, 1e3 * (time.process_time() - started))

        if (
            plan is None
            or not plan.pieces.breaks[0] - 1.0 <= s <= plan.pieces.breaks[-1]
            or (state is not None and not self._on_plan(plan, s, state))
        ):
            return answer("lost", s, reason or "the car is not on the path in force")
        if not reason:
            return answer("solved", plan.proven_to, "")
        if plan.version != self._version:
            certificate = self._proof(plan.proven_to).prove(plan.pieces, self.curvature_max, start=s, end=plan.proven_to)
            ends = [values[0] for values in (certificate.where, certificate.bends) if len(values)]
            clear = max(min(ends) - 0.5, s) if ends else plan.proven_to
            self._plan = plan = plan._replace(proven_to=clear, version=self._version)
            if ends:
                return answer("blocked" if clear > s + 1e-6 else "lost", clear, reason)
        return answer("kept", plan.proven_to, reason)

    # -- places ----------------------------------------------------------------------------------------------------------------------

    def _exists(self, knot: int) -> bool:
        return self.road.closed or 0 <= knot < self._tables.count

    def _knot_at(self, s: float) -> int:
        """The knot at or before station `s`."""
        q, length = self._tables.problem.q, self.road.length
        turn = int(np.floor(s / length)) if self.road.closed else 0
        return int(np.searchsorted(q, s - turn * length + 1e-9, side="right")) - 1 + turn * self._tables.count

    def _last_knot(self, first: int) -> int:
        end = float(self._tables.station(np.array([first]))[0]) + self.horizon
        last = max(self._knot_at(end) if self.road.closed else self._knot_at(min(end, self.road.length)), first + _SHORTEST)
        if self.road.closed:
            return min(last, first + self._tables.count - 1)
        final = self._tables.count - 1
        return final if last >= final - 2 else last

    def _offsets(self, knots: Ints) -> tuple[Floats, Floats]:
        return self._corridor.offsets(self._tables.station(knots))

    def _guess(self, first: int, last: int) -> Floats:
        """Variables to start from: those of the path in force where it reaches, the lane's beyond."""
        x = self._tables.guess[np.arange(first, last + 1) % self._tables.count].copy()
        plan = self._plan
        if plan is not None:
            old = plan.x.reshape(-1, PER_KNOT)
            low, high = max(first, plan.first_knot), min(last, plan.first_knot + len(old) - 1)
            if low <= high:
                x[low - first : high - first + 1] = old[low - plan.first_knot : high - plan.first_knot + 1]
        return x.ravel()

    def _on_plan(self, plan: _Plan, s: float, state: PathState) -> bool:
        place, first = (value[0] for value in plan.pieces(np.array([s]), 1))
        speed = float(np.hypot(*first))
        across = (first[0] * (state.y - place[1]) - first[1] * (state.x - place[0])) / speed
        turn = np.arctan2(first[1], first[0]) - state.psi
        return bool(abs(across) <= _OFF_PLAN and abs(np.arctan2(np.sin(turn), np.cos(turn))) <= _TURNED)

    def _proof(self, end: float) -> Prover:
        prover = self._prover
        if prover is None or prover.start is None or prover.end is None or not prover.start <= self._last_s - 5.0 <= end + 5.0 <= prover.end:
            start, stop = self._last_s - _BEHIND, max(end, self._last_s + self.horizon) + _BEYOND
            if not self.road.closed:
                start, stop = start if start > 0.0 else -_BEHIND, stop
            prover = self._prover = Prover(self._corridor, start, stop)
        return prover


def _allow(window: CurvatureProblem, plan: _Plan, first: int, x: Floats) -> None:
    """Widen the borders to what the path in force does: it is proven, and rows drawn in since then must not shut it out."""
    count = plan.first_knot + len(plan.x) // PER_KNOT - first  # knots of the window that the path in force has
    if count < 2 or first < plan.first_knot:
        return
    right, left = (border.copy() for border in window.borders)
    e = x[2::PER_KNOT][:count]
    right[:count], left[:count] = np.minimum(right[:count], e), np.maximum(left[:count], e)
    rows = window.rows
    covered = window._offset_table[0] < count - 1
    value = rows.matrix @ x
    lower = np.where(covered, np.minimum(rows.lower, value), rows.lower)
    upper = np.where(covered, np.maximum(rows.upper, value), rows.upper)
    vars(window).update(borders=(right, left), rows=rows._replace(lower=lower, upper=upper))


def _headings(problem: CurvatureProblem, guess: Floats) -> Floats:
    """(n,) heading of the guess at the knots against the reference, rad."""
    spline = problem.spline
    segments = np.minimum(np.arange(len(spline.q)), len(spline.h) - 1)
    slope = spline.values(spline.basis(spline.q, 1, segments), guess.ravel())
    tangent, normal = spline.frame
    return np.arctan2(np.sum(slope * normal, axis=1), np.sum(slope * tangent, axis=1))


def _around(gap: Floats, length: float) -> Floats:
    return gap - length * np.round(gap / length) if np.isfinite(length) else gap


def _what_failed(certificate: Certificate | None) -> str:
    if certificate is None:
        return "no time was left to solve"
    if not certificate.inside:
        at = int(np.argmax(certificate.depth))
        return f"the path could not be proven to keep its clearance near s = {certificate.where[at]:.1f} m ({certificate.depth[at]:.4f} m too close)"
    return f"the path could not be proven to keep its bound on curvature near s = {certificate.bends[0]:.1f} m"
