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
        status: `solved`, `lane centre` (nothing to solve) or `stalled` (inside the borders, but not
            at the optimum) or `approximate` (by a method that does not reach it).
        certified: proven to keep its clearance, and its bound on curvature, everywhere and not only at samples.
        cost_centre: integral of squared curvature of the lane centre, 1/m.
        cost: the same of the path, 1/m.
        iterations: QPs solved, or what the method counts.
        optimality: decrease of the cost that is left, relative to the cost, as the method tells.
        kkt_residual: of the last QP and its step; see `Solution`.
        max_violation_m: proven bound on how far the path leaves the corridor; zero or less is inside.
        max_curvature: largest curvature, 1/m: proven where a bound was asked for, else at the knots.
        solve_ms: wall time from corridor to proven path.
        knots: knots of the spline.
        method: solver.
        qp: back end that solved the QPs; not the one asked for if that one failed.
    """

    status: str
    certified: bool
    cost_centre: float
    cost: float
    iterations: int
    optimality: float
    kkt_residual: float
    max_violation_m: float
    max_curvature: float
    solve_ms: float
    knots: int
    method: str
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
