"""Piecewise cubic curves: the C2 interpolating spline, evaluated with all derivatives in one pass.

SciPy's `CubicSpline` gives the same numbers (the tests compare them). This one is here because a curve is asked for position, first and second
derivative at the same parameters again and again, and because importing `scipy.interpolate` takes longer than planning a road.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import solve_banded

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PiecewiseCubic:
    """`a th^3 + b th^2 + c th + d` per piece, `th` counted from the piece's start.

    Attributes:
        breaks: (n,) parameters where pieces meet, increasing.
        coefficients: (4, 2, n - 1) a, b, c, d of x and y.
    """

    breaks: Floats
    coefficients: Floats

    def __call__(self, u: ArrayLike, order: int = 0) -> tuple[Floats, ...]:
        """Value and derivatives up to `order` (at most 3) at parameters `u`, each (..., 2). Outside the breaks the end pieces go on."""
        u = np.asarray(u, dtype=np.float64)
        piece = np.clip(np.searchsorted(self.breaks, u, side="right") - 1, 0, len(self.breaks) - 2)
        th = u - self.breaks[piece]
        # x and y lead while computing: long inner loops; they come last in the answer
        a, b, c, d = (row[:, piece] for row in self.coefficients)
        found = [((a * th + b) * th + c) * th + d]
        if order > 0:
            found.append((3.0 * a * th + 2.0 * b) * th + c)
        if order > 1:
            found.append(6.0 * a * th + 2.0 * b)
        if order > 2:
            found.append(6.0 * a + 0.0 * th)
        return tuple(np.moveaxis(value, 0, -1) for value in found)

    def derivative(self, u: Floats, piece: NDArray[np.intp] | None = None) -> Floats:
        """The first derivative (2, ...) at parameters `u`, and nothing else; `piece` says on which pieces they lie, where that is known."""
        if piece is None:
            piece = np.clip(np.searchsorted(self.breaks, u, side="right") - 1, 0, len(self.breaks) - 2)
        th = u - self.breaks[piece]
        a, b, c, _ = self.coefficients
        return (3.0 * a[:, piece] * th + 2.0 * b[:, piece]) * th + c[:, piece]


def interpolate(u: Floats, points: Floats, *, closed: bool) -> PiecewiseCubic:
    """The C2 cubic spline through `points` (n, 2) at parameters `u` (n,).

    Closed curves repeat their first point at the end and are periodic; open ones have the not-a-knot end condition (a parabola through three
    points, a line through two).
    """
    h, chord = np.diff(u)[:, None], np.diff(points, axis=0)
    slope = chord / h
    bend = _periodic(h, slope) if closed else _open(h, slope)
    a = np.diff(bend, axis=0) / (6.0 * h)
    c = slope - h * (2.0 * bend[:-1] + bend[1:]) / 6.0
    return PiecewiseCubic(u, np.stack([a, 0.5 * bend[:-1], c, points[:-1]]).transpose(0, 2, 1).copy())


def counted_from(th: Floats, coefficients: Floats) -> Floats:
    """The same cubics, coefficients (4, 2, n), with each piece's parameter counted from `th` (n,) further on."""
    a, b, c, d = coefficients
    return np.array([a, b + 3.0 * a * th, c + (2.0 * b + 3.0 * a * th) * th, ((a * th + b) * th + c) * th + d])


def _open(h: Floats, slope: Floats) -> Floats:
    """(n, 2) second derivatives at the points, the third one continuous at the second and the last but one."""
    if len(h) == 1:
        return np.zeros((2, 2))
    rhs = 6.0 * np.diff(slope, axis=0)
    if len(h) == 2:
        return np.repeat(rhs / (3.0 * (h[0] + h[1])), 3, axis=0)
    flat = h[:, 0]
    bands = np.zeros((3, len(rhs)))
    bands[0, 1:], bands[1], bands[2, :-1] = flat[1:-1], 2.0 * (flat[:-1] + flat[1:]), flat[1:-1]
    first, last = flat[0] / flat[1], flat[-1] / flat[-2]
    bands[1, 0] += flat[0] * (1.0 + first)
    bands[0, 1] -= flat[0] * first
    bands[1, -1] += flat[-1] * (1.0 + last)
    bands[2, -2] -= flat[-1] * last
    inner = solve_banded((1, 1), bands, rhs)
    start = inner[:1] + first * (inner[:1] - inner[1:2])
    end = inner[-1:] + last * (inner[-1:] - inner[-2:-1])
    return np.concatenate([start, inner, end])


def _periodic(h: Floats, slope: Floats) -> Floats:
    """(n, 2) second derivatives of the closed curve; the corner entries of the cyclic system by the Sherman-Morrison formula."""
    before, flat = np.roll(h[:, 0], 1), h[:, 0]
    rhs = 6.0 * (slope - np.roll(slope, 1, axis=0))
    count, corner = len(flat), flat[-1]
    bands = np.zeros((3, count))
    bands[0, 1:], bands[1], bands[2, :-1] = flat[:-1], 2.0 * (before + flat), flat[:-1]
    gamma = -bands[1, 0]
    bands[1, 0] -= gamma
    bands[1, -1] -= corner**2 / gamma
    spike = np.zeros((count, 1))
    spike[0, 0], spike[-1, 0] = gamma, corner
    solved = solve_banded((1, 1), bands, np.hstack([rhs, spike]))
    bend, wave = solved[:, :2], solved[:, 2:]
    along = (bend[:1] + corner / gamma * bend[-1:]) / (1.0 + wave[0] + corner / gamma * wave[-1])
    bend = bend - wave * along
    return np.concatenate([bend, bend[:1]])
