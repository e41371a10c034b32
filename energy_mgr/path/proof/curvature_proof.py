"""Proof that a path of cubics keeps a bound on its curvature everywhere.

Curvature is `N / S^(3/2)` with `N = o' x o''` and `S = |o'|^2`: a quadratic's Bernstein coefficients bound `N`, those of `o'` bound `S` from below.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .pieces import Pieces, cross, dot, halves, piece_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from roads.geometry.cubic import PiecewiseCubic

    Floats = NDArray[np.float64]


def prove_curvature(path: PiecewiseCubic, parts: Pieces, most: float) -> tuple[bool, float, Floats]:
    """Whether the bound is kept, a bound on the curvature, and the places that were not proven."""
    worst, where = 0.0, [np.zeros(0)]
    while len(parts.start):
        length = parts.end - parts.start
        piece = piece_of(path, 0.5 * (parts.start + parts.end))
        a, b, c, _ = path.coefficients[:, :, piece]
        bounds = []
        for s in (parts.start, 0.5 * (parts.start + parts.end), parts.end):
            th = s - path.breaks[piece]
            bounds.append(((3.0 * a * th + 2.0 * b) * th + c, 6.0 * a * th + 2.0 * b))
        (begin, _), (first, _), (end, _) = bounds
        # Bernstein coefficients of o' and of N, both quadratic
        middle = 2.0 * first - 0.5 * (begin + end)
        turn = [cross(p, q) for p, q in bounds]
        turn[1] = 2.0 * turn[1] - 0.5 * (turn[0] + turn[2])
        along = first / np.maximum(np.sqrt(dot(first, first)), 1e-12)
        slowest = np.minimum(np.minimum(dot(begin, along), dot(end, along)), dot(middle, along))
        bound = np.max(np.abs(turn), axis=0) / np.maximum(slowest, 1e-9) ** 3
        loose = ~((bound <= most) & (slowest > 0.0))
        done = loose & (length < 0.02)
        where.append(parts.start[done])
        worst = max(worst, float(np.max(bound[~loose | done], initial=0.0)))
        rest = loose & ~done
        parts = halves(Pieces(parts.start[rest], parts.end[rest]))
    stations = np.concatenate(where)
    return len(stations) == 0, worst, np.sort(stations)
