"""The planners that P1 was published against: P0a, all spline coefficients free, and P0b, lateral fractions alone.

Kept to compare with, not to drive by.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sp

from roads import PlanarCurve
from roads.geometry.cubic import PiecewiseCubic, interpolate

from ...errors import InfeasibleError, PlanningError, SolverError
from ..problem.objective import thin_beam
from ..problem.spline import PER_KNOT
from .backends import QP_SCALE, Qp, qp_solver
from .solution import Solution

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..problem.problem import CurvatureProblem

    Floats = NDArray[np.float64]


def lateral_fractions(problem: CurvatureProblem) -> Solution:
    """P0b: the linearised curvature (3.2) over the offsets at the knots alone; second derivatives follow from the spline through them, dense.

    Control points are not kept: nothing holds the path inside between two knots, and `prove` it is not to be expected.

    Raises:
        SolverError: the QP failed.
    """
    spline = problem.spline
    matrix, rhs = problem.equalities
    dense = matrix.toarray()
    offsets = np.arange(spline.size) % PER_KNOT == PER_KNOT - 1
    # equalities that hold second derivatives give them by the offsets; what is left over are conditions on offsets
    bends: Any = np.linalg.lstsq(dense[:, ~offsets], np.column_stack([rhs, -dense[:, offsets]]), rcond=None)[0]
    count = int(offsets.sum())
    base, moves = _filled(offsets, bends[:, :1], np.zeros((count, 1)))[:, 0], _filled(offsets, bends[:, 1:], np.eye(count))
    rest, missing = dense @ moves, rhs - dense @ base
    hessian = thin_beam(spline).toarray()
    P = moves.T @ hessian @ moves
    scale = QP_SCALE / max(float(np.max(np.abs(P))), 1e-12)
    held = np.linalg.norm(rest, axis=1) > 1e-7
    right, left = problem.borders
    kept = _independent(rest[held], missing[held])
    none = sp.csc_matrix((0, P.shape[0]))
    program = Qp(
        sp.csc_matrix(P * scale), moves.T @ (hessian @ base) * scale, sp.csc_matrix(kept[0]), kept[1], none, np.zeros(0), np.zeros(0), right, left
    )
    found = qp_solver("clarabel").solve(program, 1e-9)
    if found is None:
        raise SolverError(f"{problem.corridor.name}: the QP over lateral fractions failed")
    x = base + moves @ found.x
    return Solution(x, problem.cost(x), 1, np.nan, program.residual(found), True, "clarabel")


def _filled(offsets: NDArray[np.bool_], bends: Floats, own: Floats) -> Floats:
    """Rows for all variables from those of the second derivatives and those of the offsets."""
    rows = np.zeros((len(offsets), own.shape[1]))
    rows[~offsets], rows[offsets] = bends, own
    return rows


def _independent(rows: Floats, rhs: Floats) -> tuple[Floats, Floats]:
    """The same conditions without repeated ones."""
    if len(rows) == 0:
        return rows, rhs
    u, size, v = np.linalg.svd(rows, full_matrices=False)
    rank = int(np.sum(size > 1e-9 * size[0]))
    return v[:rank], (u.T @ rhs)[:rank] / size[:rank]


def all_coefficients(problem: CurvatureProblem) -> PlanarCurve:
    """P0a: the linearised curvature (3.2) over all eight coefficients per segment, kept inside by comparing each with those of the borders' splines.

    The comparison needs the borders in the same order along x and y over a whole segment: where the road passes a quadrant within one, or its
    borders' coefficients cross, there is no solution, as the source reports. It works on gentle roads that keep their quadrant.

    Raises:
        InfeasibleError: no coefficients lie between those of the borders.
        PlanningError: a circuit; the published formulation is for open roads.
    """
    if problem.ends is None:
        raise PlanningError(f"{problem.corridor.name}: P0a is formulated for open roads, this is a circuit")
    spline = problem.spline
    n, normal = len(spline.q), spline.frame[1]
    right, left = problem.borders
    unit = np.arange(n, dtype=np.float64)
    sides = [interpolate(unit, spline.place + border[:, None] * normal, closed=False).coefficients for border in (right, left)]
    start = problem.initial()[2::PER_KNOT]
    ends = (spline.place + start[:, None] * normal)[[0, -1]]
    size = 8 * (n - 1)  # order: coefficient a b c d, axis, segment
    index = np.arange(size).reshape(4, 2, n - 1)
    A, b = _joints(index, ends, spline.frame[1][[0, -1]])
    program = Qp(
        _beam_of_coefficients(index), np.zeros(size), A, b, sp.csc_matrix((0, size)), np.zeros(0), np.zeros(0),
        np.minimum(*sides).ravel(), np.maximum(*sides).ravel(),
    )  # fmt: skip
    _refuse_crossed(problem, sides)
    found = qp_solver("clarabel").solve(program, 1e-9)
    if found is None:
        raise InfeasibleError(f"{problem.corridor.name}: no spline coefficients lie between those of the borders (P0a)")
    coefficients = found.x.reshape(4, 2, n - 1)
    coefficients[3] += spline.origin[:, None]
    return PlanarCurve.of_pieces(PiecewiseCubic(unit, coefficients))


def _refuse_crossed(problem: CurvatureProblem, sides: list[Floats]) -> None:
    """Raise where a segment's coefficients are in different order: between them then does not mean between the borders."""
    gap = sides[1] - sides[0]
    order = np.sign(np.where(np.abs(gap) < 1e-9, 0.0, gap))
    crossed = np.any(np.max(order, axis=0) - np.min(order, axis=0) > 1.0, axis=0)
    if crossed.any():
        at = float(problem.q[int(np.argmax(crossed))])
        raise InfeasibleError(
            f"{problem.corridor.name}: the borders' coefficients change their order in {int(crossed.sum())} of {len(crossed)} segments, first at "
            f"s = {at:.1f} m; P0a would need further knots there"
        )


def _joints(index: NDArray[np.intp], ends: Floats, normals: Floats) -> tuple[sp.csc_matrix, Floats]:
    """Equalities: place, slope and second derivative continuous; both ends at their place, along the road."""
    rows, columns, values, rhs = [], [], [], []

    def add(entries: list[tuple[int, float]], value: float) -> None:
        for column, weight in entries:
            rows.append(len(rhs))
            columns.append(column)
            values.append(weight)
        rhs.append(value)

    a, b, c, d = index
    for axis in range(2):
        for k in range(index.shape[2] - 1):
            add([(a[axis, k], 1.0), (b[axis, k], 1.0), (c[axis, k], 1.0), (d[axis, k], 1.0), (d[axis, k + 1], -1.0)], 0.0)
            add([(a[axis, k], 3.0), (b[axis, k], 2.0), (c[axis, k], 1.0), (c[axis, k + 1], -1.0)], 0.0)
            add([(a[axis, k], 3.0), (b[axis, k], 1.0), (b[axis, k + 1], -1.0)], 0.0)
        add([(d[axis, 0], 1.0)], float(ends[0, axis]))
        add([(a[axis, -1], 1.0), (b[axis, -1], 1.0), (c[axis, -1], 1.0), (d[axis, -1], 1.0)], float(ends[1, axis]))
    add([(c[axis, 0], float(normals[0, axis])) for axis in range(2)], 0.0)
    add([(one[axis, -1], factor * float(normals[1, axis])) for axis in range(2) for one, factor in ((a, 3.0), (b, 2.0), (c, 1.0))], 0.0)
    matrix = sp.csc_matrix((values, (rows, columns)), shape=(len(rhs), index.size))
    return matrix, np.array(rhs)


def _beam_of_coefficients(index: NDArray[np.intp]) -> sp.csc_matrix:
    """Hessian of (3.2): b0^2 + b0 b1 + b1^2 with b1 = b0 + 3 a per segment and axis."""
    a, b = index[0].ravel(), index[1].ravel()
    rows, columns = np.concatenate([b, a, b, a]), np.concatenate([b, b, a, a])
    values = np.repeat([6.0, 9.0, 9.0, 18.0], len(a))
    floor = sp.identity(index.size, format="csc") * 1e-9
    return sp.csc_matrix(sp.csc_matrix((values, (rows, columns)), shape=(index.size, index.size)) + floor)
