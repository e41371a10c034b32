"""Smoothing of noisy centre lines: the line with least change of curvature that stays within a stated distance of the points.

What is minimised is `sum m_i |z_i - y_i|^2 + lam int |z'''(s)|^2 ds` over places z beside the points y, a banded system of width 3. `lam` is
the largest one of a geometric ladder that leaves the typical deviation at a third of the bound and the largest near it; then the weights m of
points farther off than the bound grow until none is, with a weaker `lam` where that does not end. Every step costs time in proportion to the
number of points.

The bound is kept at the points and, by the final check, by the curve through the new points at the old ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import solveh_banded

from ..borders import way_along
from ..errors import RoadError
from ..geometry.curve import PlanarCurve

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

#: Share of the bound that the root mean square deviation is led to before single points are pulled back.
_TYPICAL = 1.0 / 3.0
#: And share of it that no point may exceed before that.
_FARTHEST = 1.3
#: A closed line is wound on by this many points at both ends.
_WRAP = 200
_ROUNDS = 12


def smooth_points(points: ArrayLike, bound: float, *, closed: bool = False) -> Floats:
    """The smoothed line's points (n, 2), each within `bound` (m) of its own one; the ends of an open line stay.

    Raises:
        RoadError: a bound that is not positive, or points that make no curve.
    """
    points = np.asarray(points, dtype=np.float64)
    if not 0.0 < bound < np.inf:
        raise RoadError(f"largest deviation {bound} m, expected more than 0")
    PlanarCurve.through(points, closed=closed)  # says what is wrong with the points
    if len(points) < 5:
        return points.copy()
    count = len(points)
    wrap = min(_WRAP, count) if closed else 0
    line = np.vstack([points[count - wrap :], points, points[:wrap]]) if closed else points
    inner = slice(wrap, wrap + count)
    penalty = _Penalty.of(line)
    weight = np.ones(len(line))
    if not closed:
        weight[[0, -1]] = 1e9
    # around the middle scale of the problem: where point and penalty weigh the same
    scale = 1.0 / float(np.median(penalty.bands[-1]))
    lam = scale
    for factor in 10.0 ** np.arange(0.0, 12.0, 0.5):
        off = _distance(_solved(line, weight, scale * factor, penalty), line)[inner]
        if float(np.sqrt(np.mean(off**2))) > _TYPICAL * bound or float(np.max(off)) > _FARTHEST * bound:
            break
        lam = scale * factor
    while lam > 1e-6 * scale:
        found = _pulled_back(line, weight.copy(), lam, penalty, bound, inner, closed)
        if found is not None:
            return found
        lam *= 0.1
    return points.copy()


def _pulled_back(line: Floats, weight: Floats, lam: float, penalty: _Penalty, bound: float, inner: slice, closed: bool) -> Floats | None:
    """The smoothed points with all of them within `bound`; None where that takes a weaker penalty."""
    # the bound is on the curve as well as on its points: a little is kept in hand for what lies between
    aim = 0.9 * bound
    for _ in range(_ROUNDS):
        found = _solved(line, weight, lam, penalty)
        off = _distance(found, line)
        if closed:
            off = np.maximum(off, _rolled(off[inner], len(line), inner.start))
        if np.max(off[inner]) <= aim:
            return found[inner] if _kept(found[inner], line[inner], bound, closed) else None
        weight *= np.maximum(off / (0.8 * aim), 1.0) ** 3
    return None


def _rolled(off: Floats, count: int, wrap: int) -> Floats:
    """Deviations of one round repeated over the parts that are wound on."""
    return np.concatenate([off[len(off) - wrap :], off, off[:wrap]])[:count]


def _kept(line: Floats, points: Floats, bound: float, closed: bool) -> bool:
    curve = PlanarCurve.through(line, closed=closed)
    near = curve.breaks_s[:-1] if closed else curve.breaks_s
    _, offset = curve.project(points, near)
    return bool(np.max(np.abs(offset)) <= bound)


def _distance(a: Floats, b: Floats) -> Floats:
    return np.hypot(a[:, 0] - b[:, 0], a[:, 1] - b[:, 1])


@dataclass(frozen=True, eq=False)
class _Penalty:
    """The matrix of the squared third derivative, which is taken by divided differences.

    Attributes:
        bands: (4, n) upper bands of the matrix.
        pull: (n, 2) the matrix times the points themselves.
    """

    bands: Floats
    pull: Floats

    @classmethod
    def of(cls, line: Floats) -> _Penalty:
        s = way_along(line)
        count = len(s)
        window = [s[k : count - 3 + k] for k in range(4)]
        rows = np.array([6.0 / np.prod([window[k] - window[j] for j in range(4) if j != k], axis=0) for k in range(4)])
        rows = rows * np.sqrt((window[3] - window[0]) / 3.0)
        bands = np.zeros((4, count))
        for a in range(4):
            for b in range(a, 4):
                bands[3 - (b - a), b : count - 3 + b] += rows[a] * rows[b]
        differences = np.sum([rows[k][:, None] * line[k : count - 3 + k] for k in range(4)], axis=0)
        pull = np.zeros_like(line)
        for k in range(4):
            pull[k : count - 3 + k] += rows[k][:, None] * differences
        return cls(bands, pull)


def _solved(line: Floats, weight: Floats, lam: float, penalty: _Penalty) -> Floats:
    """The minimiser, solved for how far it lies from the points: that keeps its digits where the penalty outweighs the points by far."""
    bands = lam * penalty.bands
    bands[3] += weight
    return line - solveh_banded(bands, lam * penalty.pull, check_finite=False)
