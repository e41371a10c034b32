"""A stretch of a problem as a problem of its own, cut out of what the whole has computed already."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..problem.objective import Objective
from ..problem.offsets import drawn_in
from ..problem.problem import CurvatureProblem
from ..problem.spline import PER_KNOT, ReducedSpline

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..problem.ends import End

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]


class Tables:
    """What a problem's windows are cut from: everything that depends on the road alone, computed once."""

    def __init__(self, problem: CurvatureProblem) -> None:
        self.problem = problem
        spline, objective = problem.spline, problem.objective
        self.count = len(problem.q)
        self.segments = len(spline.h)
        self.frame, self.place, self.b_scale, self.kappa = spline.frame, spline.place, spline.b_scale, spline.kappa
        self.maps, self.share = objective.maps, objective.share
        self.sideways = objective.sideways if objective.weights.offset > 0.0 else None
        self.offset_table, self.joint_table = problem.offset_table, problem.joint_table
        self.row_borders = problem.row_borders
        self.knot_borders = problem.corridor.offsets(problem.q)
        self.first_row = np.searchsorted(self.offset_table[0], np.arange(self.segments + 1))
        self.guess = problem.initial().reshape(-1, PER_KNOT)

    def station(self, knot: Ints) -> Floats:
        """(k,) stations of knots counted on beyond the seam of a circuit, m."""
        if not self.problem.closed:
            return self.problem.q[knot]
        turns, inner = np.divmod(knot, self.count)
        return self.problem.q[inner] + turns * self.problem.spline.reference.length

    def window(
        self,
        first: int,
        last: int,
        ends: tuple[End, End],
        borders: tuple[Floats, Floats, Floats, Floats] | None = None,
        tighter: tuple[Floats, Floats] | None = None,
        bends: Floats | None = None,
    ) -> CurvatureProblem:
        """The problem on the knots `first` to `last` (counted on beyond the seam).

        Args:
            first: the first knot.
            last: the last one, at least three later.
            ends: what holds there.
            borders: right and left border at the knots, then at the control points of the window, m; None for the road's.
            tighter: by how much they are drawn in at the knots and at the control points, m; None: as the problem has it.
            bends: stations at which the curvature is watched, m; None for none.
        """
        problem = self.problem
        knots = np.arange(first, last + 1)
        inner, segments = knots % self.count, knots[:-1] % self.segments
        spline, objective = self._cut_out(knots, inner, segments)
        rows, own = self.rows_of(segments)
        turns = knots[:-1][own] // self.count if problem.closed else np.zeros(len(own))
        row_q = problem.row_q[rows] + turns * problem.spline.reference.length
        made = replace(
            problem,
            spline=spline,
            objective=objective,
            ends=ends,
            start=self.guess[inner, 2],
            row_q=row_q,
            row_tighter=problem.row_tighter[rows] if tighter is None else tighter[1],
            bend_q=np.zeros(0) if bends is None else bends,
        )
        joints = inner[1:-1] - (0 if problem.closed else 1)
        right, left, row_right, row_left = borders or (
            *(border[inner] for border in self.knot_borders),
            *(border[rows] for border in self.row_borders),
        )
        _fill(
            made,
            offset_table=(own, self.offset_table[1][rows], self.offset_table[2][rows]),
            joint_table=(self.joint_table[0][joints], self.joint_table[1][joints]),
            row_borders=(row_right, row_left),
            borders=drawn_in(right, left, problem.tighter if tighter is None else tighter[0]),
        )
        return made

    def _cut_out(self, knots: Ints, inner: Ints, segments: Ints) -> tuple[ReducedSpline, Objective]:
        """Spline and objective on the window's knots, with what they would compute filled in."""
        problem = self.problem
        spline = ReducedSpline(problem.spline.reference, self.station(knots), problem.spline.unit, window=True)
        _fill(
            spline,
            frame=(self.frame[0][inner], self.frame[1][inner]),
            place=self.place[inner],
            origin=problem.spline.origin,
            h=problem.spline.h[segments],
            b_scale=self.b_scale[inner],
            kappa=self.kappa[inner],
        )
        four = (4 * segments[:, None] + np.arange(4)).ravel()
        objective = Objective(spline, problem.objective.weights, problem.objective.centre)
        _fill(objective, maps=(self.maps[0][four], self.maps[1][four]), share=(self.share[0][four], self.share[1][four]))
        if self.sideways is not None:
            _fill(objective, sideways=(self.sideways[0][four], self.sideways[1][four]))
        return spline, objective

    def rows_of(self, segments: Ints) -> tuple[Ints, Ints]:
        """Control points of some segments: their indices, and for each the place of its segment in `segments`."""
        low, high = self.first_row[segments], self.first_row[segments + 1]
        count = high - low
        own = np.repeat(np.arange(len(segments)), count)
        return low[own] + np.arange(len(own)) - np.repeat(np.cumsum(count) - count, count), own


def _fill(thing: object, **values: object) -> None:
    """Set what would be computed on first use."""
    vars(thing).update(values)
