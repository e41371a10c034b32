"""The road as a receding horizon sees it: borders as they are now, windows cut out of it, and what failed proofs have taught."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..problem.ends import End
from ..problem.spline import PER_KNOT
from ..proof.certificate import Certificate, Prover
from .window import Tables

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from roads import Corridor, Narrowing

    from ..problem.problem import CurvatureProblem

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

#: A place beyond the border is drawn in by so much more than it is beyond, m.
_REPAIR_MORE = 1e-3
#: The borders are cut up from this far behind the car to this far beyond what is to be proven, m; and proven with this much to spare, besides the
#: margin.
_BEHIND, _BEYOND, _SPARE = 30.0, 120.0, 5.0
#: Stations at which the curvature is watched lie this far apart at least, m.
_APART = 0.5


class Strip:
    """A corridor whose borders may change.

    Attributes:
        corridor: the corridor as it is now.
        version: counts the changes.
        narrowings: what is narrower now than the road.
        tables: what windows are cut from.
    """

    def __init__(self, problem: CurvatureProblem) -> None:
        self.tables = Tables(problem)
        self.corridor: Corridor = problem.corridor
        self.narrowings: tuple[Narrowing, ...] = ()
        self.version = 0
        self._base = problem.corridor
        self._tighter = problem.row_tighter.copy(), np.full(len(problem.q), problem.tighter)
        self._tighter_base = self._tighter
        self._bend_q = problem.bend_q
        self._heading = _headings(problem, self.tables.guess)
        self._prover: Prover | None = None

    @property
    def closed(self) -> bool:
        """True on a circuit."""
        return self.tables.problem.closed

    @property
    def length(self) -> float:
        """Length of the road, m."""
        return self.corridor.reference.length

    def update(self, narrowings: Sequence[Narrowing]) -> None:
        """Take over what is narrower from now on; nothing changes if it cannot be.

        Raises:
            RoadError: a stretch that ends before it begins or lies beside the road.
        """
        if tuple(narrowings) == self.narrowings:
            return
        self.corridor = self._base.narrowed(*narrowings)
        self.narrowings, self.version, self._prover = tuple(narrowings), self.version + 1, None
        # what proofs beside an obstacle have taught is forgotten with it
        self._tighter = (self._tighter_base[0].copy(), self._tighter_base[1].copy()) if narrowings else self._tighter_base

    def exists(self, knot: int) -> bool:
        """True if the road has the knot."""
        return self.closed or 0 <= knot < self.tables.count

    def knot_at(self, s: float) -> int:
        """The knot at or before station `s`."""
        q, length = self.tables.problem.q, self.length
        turn = int(np.floor(s / length)) if self.closed else 0
        return int(np.searchsorted(q, s - turn * length + 1e-9, side="right")) - 1 + turn * self.tables.count

    def station(self, knot: int) -> float:
        """Station of a knot, m."""
        return float(self.tables.station(np.array([knot]))[0])

    def last_knot(self, first: int, horizon: float, shortest: int) -> int:
        """Where a window from the knot `first` ends; at the end of an open road no scrap is left over."""
        end = self.station(first) + horizon
        last = max(self.knot_at(end if self.closed else min(end, self.length)), first + shortest)
        if self.closed:
            return min(last, first + self.tables.count - 1)
        final = self.tables.count - 1
        return final if last >= final - 2 else last

    def on_lane(self, knot: int) -> End:
        """The end condition on the lane, along it, as far inside the borders as they are now."""
        right, left = self.corridor.offsets(np.array([self.station(knot)]))
        offset = float(np.clip(self.tables.guess[knot % self.tables.count, 2], right[0], left[0]))
        return End(offset, float(self._heading[knot % self.tables.count]))

    def far_end(self, last: int) -> End:
        """What holds at the end of a window: along the lane, on it only where the road ends."""
        ends = self.tables.problem.ends
        if ends is not None and last == self.tables.count - 1:
            return ends[1]
        return End(heading=float(self._heading[last % self.tables.count]))

    def window(self, first: int, last: int, end: End) -> CurvatureProblem:
        """The problem from knot `first` to knot `last` in the borders as they are now."""
        tables = self.tables
        knots = np.arange(first, last + 1)
        rows, own = tables.rows_of(knots[:-1] % tables.segments)
        borders = None
        if self.narrowings:
            turns = knots[:-1][own] // tables.count if self.closed else 0
            row_q = tables.problem.row_q[rows] + turns * self.length
            borders = (*self.corridor.offsets(tables.station(knots)), *self.corridor.offsets(row_q))
        tighter = self._tighter[1][knots % tables.count], self._tighter[0][rows]
        return tables.window(first, last, (end, self.far_end(last)), borders, tighter, self._bends(first, last))

    def _bends(self, first: int, last: int) -> Floats:
        """Stations between two knots at which the curvature is watched, counted on beyond the seam."""
        if len(self._bend_q) == 0:
            return self._bend_q
        start, end = self.station(first), self.station(last)
        turns = np.arange(np.floor(start / self.length), np.floor(end / self.length) + 1.0) if self.closed else np.zeros(1)
        every = np.concatenate([self._bend_q + turn * self.length for turn in turns])
        return every[(every >= start) & (every <= end)]

    def learn(self, problem: CurvatureProblem, x: Floats, first: int, certificate: Certificate) -> None:
        """Draw the borders in at the rows or knots nearest to where the proof failed, or watch the curvature there, from now on."""
        if len(certificate.bends):
            at = np.mod(certificate.bends, self.length) if self.closed else certificate.bends
            self._bend_q = np.unique(np.concatenate([self._bend_q, np.round(at / _APART) * _APART]))
            self._bend_q = self._bend_q[self._bend_q < self.length] if self.closed else np.minimum(self._bend_q, self.length)
        tables = self.tables
        value, (right, left) = problem.rows.matrix @ x, problem.borders
        spare_row = np.maximum(np.minimum(problem.rows.upper - value, value - problem.rows.lower), 0.0)
        spare_knot = np.maximum(np.minimum(left - x[2::PER_KNOT], x[2::PER_KNOT] - right), 0.0)
        knots = np.arange(first, first + len(problem.q))
        rows, _ = tables.rows_of(knots[:-1] % tables.segments)
        for station, depth in zip(certificate.where, certificate.depth, strict=True):
            row, knot = int(np.argmin(np.abs(problem.row_q - station))), int(np.argmin(np.abs(problem.q - station)))
            nearer = abs(problem.row_q[row] - station) <= abs(problem.q[knot] - station)
            used, index, spare = (
                (self._tighter[0], rows[row], spare_row[row]) if nearer else (self._tighter[1], knots[knot] % tables.count, spare_knot[knot])
            )
            before = problem.row_tighter[row] if nearer else used[index]
            used[index] = max(used[index], before + spare + 1.5 * depth + _REPAIR_MORE)

    def prover(self, start: float, end: float) -> Prover:
        """A prover for the borders as they are now, at least from station `start` to station `end`."""
        spare = self.corridor.margin + _SPARE
        prover = self._prover
        if prover is None or prover.start is None or prover.end is None or not prover.start <= start - spare < end + spare <= prover.end:
            prover = self._prover = Prover(self.corridor, start - spare - _BEHIND, end + spare + _BEYOND)
        return prover


def _headings(problem: CurvatureProblem, guess: Floats) -> Floats:
    """(n,) heading of the guess at the knots against the reference, rad."""
    spline = problem.spline
    segments = np.minimum(np.arange(len(spline.q)), len(spline.h) - 1)
    slope = spline.values(spline.basis(spline.q, 1, segments), guess.ravel())
    tangent, normal = spline.frame
    return np.arctan2(np.sum(slope * normal, axis=1), np.sum(slope * tangent, axis=1))
