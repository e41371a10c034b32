"""A path and the report of how it was found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from roads import PlanarCurve

    Floats = NDArray[np.float64]


@dataclass(frozen=True)
class PathReport:
    """How a path was found and how good it is.

    Attributes:
        status: `solved`, `lane centre` (nothing to solve) or `stalled` (inside the borders, but not at the optimum).
        cost_centre: integral of squared curvature of the lane centre, 1/m.
        cost: the same of the path, 1/m.
        iterations: QPs solved.
        optimality: decrease of the cost that is left, relative to the cost, as the QPs' promises tell.
        max_violation_m: how far the path leaves the corridor on re-evaluation every 0.1 m; zero or less is inside.
        solve_ms: wall time from corridor to checked path.
        knots: knots of the spline.
        qp: back end that solved the QPs; not the one asked for if that one failed.
    """

    status: str
    cost_centre: float
    cost: float
    iterations: int
    optimality: float
    max_violation_m: float
    solve_ms: float
    knots: int
    qp: str


@dataclass(frozen=True, eq=False)
class Path:
    """A path along a road.

    Attributes:
        curve: the path in the plane.
        knot_s: (k,) stations on the path, m.
        knot_road_s: (k,) stations on the road's reference that lie abreast of them, m.
        report: how it was found.
    """

    curve: PlanarCurve
    knot_s: Floats
    knot_road_s: Floats
    report: PathReport

    def road_station(self, s: ArrayLike) -> Floats:
        """Station on the road's reference abreast of path station `s`, m."""
        return np.interp(np.asarray(s, dtype=np.float64), self.knot_s, self.knot_road_s)
