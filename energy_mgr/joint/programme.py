"""The joint problem as one sparse nonlinear programme, solved by IPOPT with exact second derivatives.

Variables: those of the path's spline (`CurvatureProblem`), then per station the speed, per interval the positive and negative part of the force, at
last by how much the arrival is late. Being late is dear, so that it is zero where it can be; where the time leaves no choice these stations may
miss it by a hair, and the programme still has a solution.
Every interval depends on ten of them through one small function, which is mapped over all intervals; hence derivatives are exact, sparse, and
their cost grows linearly with the road.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sp

from powertrain.energy.balance import KWH, balance
from powertrain.symbolic import ca

from ..errors import SolverError
from ..path.problem.bends import CURVATURE_SHARE
from .assembly import Assembled, assemble
from .grid import Grid
from .interval import OUTPUTS, Scales, interval_function

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from powertrain import Vehicle
    from roads import Road

    from ..path import CurvatureProblem

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

#: No station but the ends of an open road is passed more slowly, m/s: at standstill the time is unbounded.
_SLOWEST = 0.1
_ROW = {name: at for at, name in enumerate(OUTPUTS)}
#: Price of being late by the whole journey time, in units of the cost, which is of the size of a hundred.
_LATE = 1e3
#: How IPOPT is run; from afar, and from a point that is an optimum but for few rows: there the barrier starts low and pushes little.
_OPTIONS = {"print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes", "ipopt.max_iter": 500}
_FAR = {"ipopt.mu_init": 1e-2, "ipopt.mu_strategy": "adaptive", "ipopt.bound_push": 1e-4, "ipopt.bound_frac": 1e-4}
_NEAR = {"ipopt.mu_init": 1e-5, "ipopt.mu_strategy": "monotone", "ipopt.bound_push": 1e-6, "ipopt.bound_frac": 1e-6}


@dataclass(frozen=True, eq=False)
class Point:
    """Values of the variables.

    Attributes:
        x: (3n,) variables of the path's spline.
        q: (m + 1,) stations of the road, m.
        v: (m + 1,) speeds there, m/s.
    """

    x: Floats
    q: Floats
    v: Floats

    def on(self, q: Floats) -> Point:
        """The same with the speed at other stations."""
        return Point(self.x, q, np.sqrt(np.interp(q, self.q, self.v**2)))


@dataclass(frozen=True, eq=False)
class JointSolution:
    """What IPOPT found.

    Attributes:
        point: path and speed.
        energy: J.
        journey_time: s.
        iterations: of IPOPT.
        build_ms: wall time to set the programme up, ms.
        solve_ms: wall time of IPOPT, ms.
        residual: largest violated constraint, scaled.
    """

    point: Point
    energy: float
    journey_time: float
    iterations: int
    build_ms: float
    solve_ms: float
    residual: float


@dataclass(frozen=True, eq=False)
class JointProgramme:
    """The programme for one road, car and arrival time.

    Attributes:
        problem: the path's variables, continuity, ends and borders.
        road: posted limits and heights.
        vehicle: the car.
        journey_time: the time allowed, s.
        energy_scale: J, of the size of a hundredth of the energy that moves.
        parts: (pieces,) in how many intervals each piece of the spline is cut.
        start_speed: on open roads, m/s.
        end_speed: on open roads, m/s.
    """

    problem: CurvatureProblem
    road: Road
    vehicle: Vehicle
    journey_time: float
    energy_scale: float
    parts: Ints
    start_speed: float = 0.0
    end_speed: float = 0.0

    @cached_property
    def grid(self) -> Grid:
        """The intervals."""
        return Grid.of(self.problem, self.road, self.vehicle, self.parts)

    @cached_property
    def scales(self) -> Scales:
        """Units of the variables and rows."""
        own, bound = self.vehicle.limits, self.problem.curvature_max
        return Scales(
            speed=10.0,
            force=self.vehicle.effective_mass,
            energy=self.energy_scale,
            power=self.vehicle.drive.motor_count * self.vehicle.drive.power_max_w,
            lateral=own.lateral_acceleration_max_mps2,
            curvature=CURVATURE_SHARE * bound if np.isfinite(bound) else 1.0,
        )

    def solve(self, start: Point, *, near: bool = False, tolerance: float = 1e-6, report: Callable[[str], None] | None = None) -> JointSolution:
        """A local optimum near `start`.

        Args:
            start: path and speed to start from; limits may be broken there.
            near: the start is nearly the optimum.
            tolerance: of IPOPT, on the scaled problem.
            report: called with a line of progress.

        Raises:
            SolverError: IPOPT did not converge.
        """
        began = time.perf_counter()
        linear, select, lower, upper = self._rows()
        assembled = self._assembled(linear, select)
        options = _OPTIONS | (_NEAR if near else _FAR) | {"ipopt.tol": tolerance} | assembled.derivatives
        solver = ca.nlpsol("joint", "ipopt", assembled.nlp, options)
        built = time.perf_counter()
        least, most = self._bounds()
        answer = solver(x0=np.clip(self._vector(start), least, most), lbx=least, ubx=most, lbg=lower, ubg=upper)
        stats: dict[str, Any] = solver.stats()
        energy = (float(answer["f"]) - _LATE * float(answer["x"][-1])) * self.energy_scale
        if report:
            report(f"joint: IPOPT, {stats['iter_count']} iterations, {energy / KWH:.6f} kWh")
        if not stats["success"]:
            raise SolverError(f"{self.road.name}: IPOPT ended the joint problem with {stats['return_status']} after {stats['iter_count']} iterations")
        point, value = self._point(np.array(answer["x"]).ravel()), np.array(answer["g"]).ravel()
        ended = time.perf_counter()
        return JointSolution(
            point,
            energy,
            float(np.sum(2.0 * self.grid.lengths(point.x) / (point.v[1:] + point.v[:-1]))),
            int(stats["iter_count"]),
            1e3 * (built - began),
            1e3 * (ended - built),
            float(np.max(np.maximum(value - upper, lower - value))),
        )

    def _assembled(self, linear: sp.csc_matrix, select: sp.csc_matrix) -> Assembled:
        """The programme with its derivatives."""
        cost = np.zeros(select.shape[1])
        cost[_ROW["energy"] :: len(OUTPUTS)] = 1.0
        price = np.zeros(self._variables)
        price[-1] = _LATE
        return assemble(interval_function(self.vehicle, self.scales), self.grid.table(), self._places, cost, price, linear, select)

    # -- variables -------------------------------------------------------------------------------------------------------------------

    @property
    def _path(self) -> int:
        return self.problem.spline.size

    @property
    def _variables(self) -> int:
        return self._path + 3 * self.grid.count + 2

    @cached_property
    def _places(self) -> Ints:
        """(10, m) indices of the variables of each interval."""
        m, k = self.grid.count, np.arange(self.grid.count)
        speed, pull = self._path + k, self._path + m + 1 + k
        return np.vstack([self.grid.columns.T, speed, speed + 1, pull, pull + m])

    def _bounds(self) -> tuple[Floats, Floats]:
        """Bounds of all variables."""
        right, left = self.problem.bounds
        most = self.grid.v_posted.copy()
        least = np.full_like(most, _SLOWEST)
        if not self.problem.closed:
            most[0], most[-1] = least[0], least[-1] = self.start_speed, self.end_speed
        forces = np.zeros(2 * self.grid.count)
        return (
            np.concatenate([right, least / self.scales.speed, forces, [0.0]]),
            np.concatenate([left, most / self.scales.speed, forces + np.inf, [np.inf]]),
        )

    def _point(self, variables: Floats) -> Point:
        """Path and speed out of all variables."""
        return Point(variables[: self._path], self.grid.q, self.scales.speed * variables[self._path : self._path + self.grid.count + 1])

    def _vector(self, point: Point) -> Floats:
        """All variables at a point."""
        v = np.maximum(point.v, 0.0)
        force = balance(self.vehicle, self.grid.lengths(point.x), v[:-1], v[1:], np.diff(self.grid.z)).force / self.scales.force
        return np.concatenate([point.x, v / self.scales.speed, np.maximum(force, 0.0), np.maximum(-force, 0.0), [0.0]])

    # -- rows ------------------------------------------------------------------------------------------------------------------------

    def _rows(self) -> tuple[sp.csc_matrix, sp.csc_matrix, Floats, Floats]:
        """Constraints `lower <= linear x + select outputs <= upper`; see `assembly`."""
        problem, m, size = self.problem, self.grid.count, len(OUTPUTS)
        equal, rhs = problem.equalities
        inside = problem.rows
        linear = [equal, inside.matrix]
        lower, upper = [rhs, inside.lower], [rhs, inside.upper]
        if problem.closed:
            seam = sp.csc_matrix(([1.0, -1.0], ([0, 0], [self._path, self._path + m])))
            linear, lower, upper = [*linear, seam], [*lower, np.zeros(1)], [*upper, np.zeros(1)]
        chosen, keep = [], np.arange(m)
        for names, low, high, where in self._limits():
            chosen += [size * (keep if where is None else where) + _ROW[name] for name in names]
            lower += [np.full(len(one), low) for one in chosen[-len(names) :]]
            upper += [np.full(len(one), high) for one in chosen[-len(names) :]]
        pick = np.concatenate(chosen)
        above = sum(block.shape[0] for block in linear)
        columns = np.append(pick, size * keep + _ROW["time"])
        rows = above + np.append(np.arange(len(pick)), np.full(m, len(pick)))
        values = np.append(np.ones(len(pick)), np.full(m, 1.0 / self.journey_time))
        shape = above + len(pick) + 1
        select = sp.csc_matrix((values, (rows, columns)), shape=(shape, size * m))
        wide = [_widened(block, self._variables) for block in linear]
        late = sp.csc_matrix(([-1.0], ([len(pick)], [self._variables - 1])), shape=(len(pick) + 1, self._variables))
        stacked: Any = sp.vstack([*wide, late], format="csc")
        return stacked, select, np.concatenate([*lower, np.zeros(1)]), np.concatenate([*upper, np.ones(1)])

    def _limits(self) -> list[tuple[tuple[str, ...], float, float, Ints | None]]:
        """Names of rows, lower and upper limit, and at which intervals they are kept (None: at all).

        What holds at the end of an interval holds at the start of the next one.
        """
        own, drive = self.vehicle.limits, self.vehicle.drive
        total = drive.motor_count * self.vehicle.motor_ratio / self.scales.force
        power = drive.motor_count / self.scales.power
        end = np.arange(0 if self.problem.closed else 1) + self.grid.count - 1
        limits: list[tuple[tuple[str, ...], float, float, Ints | None]] = [
            (("force_gap",), 0.0, 0.0, None),
            (("gain",), -own.deceleration_max_mps2, own.acceleration_max_mps2, None),
            (("lateral_start", "lateral_after", "lateral_before"), -1.0, 1.0, None),
            (("lateral_end",), -1.0, 1.0, end),
            (("force_start", "force_end"), -total * drive.regen_torque_max_nm, total * drive.torque_max_nm, None),
            (("power_start", "power_end"), -power * drive.regen_power_max_w, power * drive.power_max_w, None),
        ]
        if np.isfinite(self.problem.curvature_max):
            limits += [(("bend_start", "bend_middle"), -1.0, 1.0, None), (("bend_end",), -1.0, 1.0, end)]
        return limits


def _widened(matrix: sp.csc_matrix, columns: int) -> sp.csc_matrix:
    """The matrix with empty columns added."""
    rows, missing = matrix.shape[0], columns - matrix.shape[1]
    wide: Any = sp.hstack([matrix, sp.csc_matrix((rows, missing))], format="csc")
    return wide
