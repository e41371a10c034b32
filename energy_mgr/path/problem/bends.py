"""The curvature of the path where it is watched; the one bound on a path that is not linear in the variables."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .spline import Basis, ReducedSpline

    Floats = NDArray[np.float64]

#: Rows aim at this share of the bound on curvature, so that the path keeps it between them too.
CURVATURE_SHARE = 0.998


class Bends(NamedTuple):
    """A spline's first and second derivative at the stations where the curvature is watched."""

    spline: ReducedSpline
    first: Basis
    second: Basis

    @classmethod
    def at(cls, spline: ReducedSpline, q: Floats) -> Bends:
        """Those at stations `q`."""
        return cls(spline, spline.basis(q, 1), spline.basis(q, 2))

    def shares(self, x: Floats, bound: float) -> tuple[Floats, Floats]:
        """Curvature (k,) as a multiple of what `bound` lets it be, and its derivatives (k, 6) by the segment's variables."""
        p, q = self.spline.values(self.first, x), self.spline.values(self.second, x)
        square, cross = np.sum(p**2, axis=1), p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
        by_p = np.column_stack([q[:, 1], -q[:, 0]]) - 3.0 * (cross / square)[:, None] * p
        by_q = np.column_stack([-p[:, 1], p[:, 0]])
        jacobian = np.matmul(by_p[:, None, :], self.first.matrix)[:, 0] + np.matmul(by_q[:, None, :], self.second.matrix)[:, 0]
        scale = square**-1.5 / (CURVATURE_SHARE * bound)
        return cross * scale, jacobian * scale[:, None]


def watched(spline: ReducedSpline, bound: float) -> Floats:
    """Where the curvature is watched from the start: at the knots and between them where the road bends by half the bound or more."""
    breaks = spline.breaks
    q = np.sort(np.concatenate([spline.q, 0.5 * (breaks[1:] + breaks[:-1])]))
    return q[np.abs(spline.reference.curvature(q)) > 0.5 * bound]
