"""Newton's equations of a chain: a symmetric band A bordered by a few dense rows G,

    [A  G'] [x]   [ r]
    [G  -D] [y] = [-e]      D >= 0 diagonal, y the change of the rows' multipliers,

solved by block elimination, so that the effort is proportional to the number of stations.

A step of Newton's method goes downhill where A is positive definite on what the rows leave free, that is where the whole matrix has n positive and m
negative eigenvalues (Nocedal and Wright, Numerical Optimization, 16.3). That A itself is positive definite is sufficient and quickly seen (Cholesky).
It is not necessary: with a deadline, driving everywhere a little faster may be a direction of negative curvature, but the deadline forbids it. So
where A is indefinite its negative eigenvalues are counted (Sylvester) with those of the Schur complement; only where the sum is wrong is the diagonal
raised. Raising it where there is no need makes steps that are too short for ever.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg.lapack import dgbsv, dpbtrf, dpbtrs

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

#: What is added to the diagonal when the curvature is not positive: first try, growth, last try.
_SHIFT = 1e-8, 20.0, 1e6


def bordered(band: Floats, rhs: Floats, dense: Floats, diagonal: Floats, excess: Floats) -> tuple[Floats, Floats] | None:
    """Solve the system as it is.

    Args:
        band: (w + 1, n) A in LAPACK's upper storage.
        rhs: (n,) r.
        dense: (m, n) G.
        diagonal: (m,) D.
        excess: (m,) e.

    Returns:
        x (n,) and y (m,); None where the step need not go downhill.
    """
    factor, fault = dpbtrf(band)
    if fault == 0:
        return _eliminated(lambda right: dpbtrs(factor, right)[0], rhs, dense, diagonal, excess)
    negative = _negative(band)
    if not 0 < negative <= len(dense):
        return None
    return _eliminated(lambda right: _general(band, right), rhs, dense, diagonal, excess, negative)


def bordered_convex(
    band: Floats, rhs: Floats, dense: Floats, diagonal: Floats, excess: Floats, shift: float
) -> tuple[tuple[Floats, Floats] | None, float]:
    """As `bordered`, with the diagonal raised by a share of itself until the band is positive definite; and that share, tried from below `shift`."""
    first, grow, last = _SHIFT
    scale = np.abs(band[-1]) + 1e-12
    shift = max(first, shift / grow)
    while shift <= last:
        raised = band.copy()
        raised[-1] += shift * scale
        factor, fault = dpbtrf(raised)
        if fault == 0:
            return _eliminated(lambda right, factor=factor: dpbtrs(factor, right)[0], rhs, dense, diagonal, excess), shift
        shift *= grow
    return None, shift


def _eliminated(
    solve: Callable[[Floats], Floats | None], rhs: Floats, dense: Floats, diagonal: Floats, excess: Floats, negative: int = 0
) -> tuple[Floats, Floats] | None:
    """x and y by the band's Schur complement; None unless that has `negative` negative eigenvalues, and where a matrix is singular."""
    solved = solve(np.column_stack([rhs, dense.T]))
    if solved is None or not np.all(np.isfinite(solved)):
        return None
    x = solved[:, 0]
    if not len(dense):
        return x, np.zeros(0)
    schur = dense @ solved[:, 1:] + np.diag(diagonal)
    if negative and np.count_nonzero(np.linalg.eigvalsh(0.5 * (schur + schur.T)) < 0.0) != negative:
        return None
    try:
        y = np.linalg.solve(schur, dense @ x + excess).astype(np.float64)
    except np.linalg.LinAlgError:
        return None
    return x - solved[:, 1:] @ y, y


def _general(band: Floats, right: Floats) -> Floats | None:
    """A^-1 `right` (n, k) for a band that need not be definite: LU with partial pivoting."""
    wide = len(band) - 1
    general = np.zeros((3 * wide + 1, band.shape[1]))
    general[wide : 2 * wide + 1] = band
    for k in range(1, wide + 1):
        general[2 * wide + k, :-k] = band[wide - k, k:]
    *_, solved, fault = dgbsv(wide, wide, general, right)
    return solved if fault == 0 else None


def _negative(band: Floats) -> int:
    """Number of negative eigenvalues of A: of negative pivots of L D L' (Sylvester's law of inertia)."""
    wide, count = len(band) - 1, 0
    # one entry after the other: plain floats are several times quicker than arrays of one
    diagonal, beside = band[-1].tolist(), band[-2].tolist()
    second = band[-3].tolist() if wide > 1 else [0.0] * len(diagonal)
    least = 1e-12 * float(np.max(np.abs(band), initial=1e-300))
    before, at, factor = 1.0, 1.0, 0.0  # the two pivots before, and the entry of L beside the last one
    for k, value in enumerate(diagonal):
        far = second[k] / before if k > 1 else 0.0
        near = (beside[k] - far * before * factor) / at if k else 0.0
        pivot = value - near * near * at - far * far * before
        if abs(pivot) < least:  # an exact zero says nothing of the sign, and dividing by next to nothing would overflow
            pivot = least
        count += pivot < 0.0
        before, at, factor = at, pivot, near
    return count
