"""Where the joint problem starts: a path that is there already, as variables of the spline, and a speed on it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..path import CurvatureProblem, Weights
from ..path.planner import TIGHTER
from ..path.problem.objective import Objective
from ..path.problem.spline import PER_KNOT
from ..path.solvers import solve

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from powertrain import Vehicle
    from roads import Road
    from roads.road import Extent

    from ..path import Path, PathOptions
    from ..speed import SpeedProfile
    from .grid import Grid

    Floats = NDArray[np.float64]

#: Distance of control points, m: a path that is no longer kept gentle for its own sake bends around the borders between distant ones.
_APART = 1.0
#: Weight of length that makes a path nearly the shortest one, 1/m^2.
_SHORT = 1.0


def problem_of(road: Road, path: Path, clearance: float, extent: Extent, options: PathOptions) -> CurvatureProblem:
    """The problem whose solution `path` is: the same knots, borders and ends."""
    problem = CurvatureProblem.on(
        road.corridor(extent, clearance),
        road.lane_centre(),
        knots=path.knot_road_s[:-1] if road.closed else path.knot_road_s,
        control_points=0,
        ends=options.ends,
        curvature_max=options.curvature_max,
        tighter=TIGHTER,
    )
    width = np.diff(problem.spline.breaks)
    count = np.maximum(np.ceil(width / _APART).astype(int), options.control_points + 1)
    piece = np.repeat(np.arange(len(count)), count)
    share = (np.arange(len(piece)) - np.repeat(np.cumsum(count) - count, count)) / count[piece]
    inside = share > 0.0
    stations = (problem.spline.breaks[piece] + share * width[piece])[inside]
    return problem.with_rows(stations, np.full(len(stations), TIGHTER))


def variables_of(problem: CurvatureProblem, path: Path) -> Floats:
    """(3n,) the variables of the spline whose curve `path` is."""
    spline, pieces = problem.spline, path.curve.pieces
    count, (tangent, normal) = len(problem.q), spline.frame
    place, square = pieces.coefficients[3].T, pieces.coefficients[1].T
    if not problem.closed:
        h = float(pieces.breaks[-1] - pieces.breaks[-2])
        cubic = pieces.coefficients[:, :, -1]
        place = np.vstack([place, ((cubic[0] * h + cubic[1]) * h + cubic[2]) * h + cubic[3]])
        square = np.vstack([square, cubic[1] + 3.0 * h * cubic[0]])
    offset = np.sum((place - spline.origin - spline.place) * normal, axis=1)
    bend = square * (spline.b_scale / spline.unit**2)[:, None]
    x = np.empty((count, PER_KNOT))
    x[:, 0], x[:, 1], x[:, 2] = np.sum(bend * tangent, axis=1), np.sum(bend * normal, axis=1), offset
    return x.ravel()


def short_path(problem: CurvatureProblem) -> Floats:
    """(3n,) the variables of nearly the shortest path, another place to start from."""
    spline = problem.spline
    shorter = replace(problem, objective=Objective(spline, Weights(length=_SHORT), problem.objective.centre))
    return solve(shorter, shorter.initial(), "gauss-newton", tolerance=1e-4).x


def speeds_on(grid: Grid, x: Floats, profile: SpeedProfile, vehicle: Vehicle) -> Floats:
    """(m + 1,) the speeds of a profile at the same shares of the way, as far as limits and bends of the path `x` allow, m/s."""
    way = np.append(0.0, np.cumsum(grid.lengths(x)))
    v = profile.speed_at(way * (profile.s[-1] / way[-1]))
    bend = np.max(np.abs(grid.curvatures(x)), axis=1)
    most = np.sqrt(vehicle.limits.lateral_acceleration_max_mps2 / np.maximum(bend, 1e-9))
    return np.minimum(np.minimum(v, grid.v_posted), np.minimum(np.append(most, most[-1]), np.append(most[0], most)))
