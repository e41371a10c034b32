"""A C2 curve in the plane, asked by arc length.

The curve is a piecewise cubic in a free parameter `u`; every public question is asked by arc length `s`. Arc length per piece comes from
Gauss-Legendre quadrature and is inverted by Newton's method, so that `s` is good to 1e-6 m for pieces that turn by less than about half
a radian.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..errors import RoadError
from .cubic import PiecewiseCubic, interpolate
from .locate import Locator

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)
_NEWTON_STEPS = 4
#: Stations whose parameters are worked out together.
_CHUNK = 20_000


def read_only(values: ArrayLike) -> Floats:
    """A float copy of `values` that refuses to be written to."""
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


@dataclass(frozen=True, eq=False)
class PlanarCurve:
    """A C2 piecewise cubic curve `[x(u), y(u)]`.

    Attributes:
        pieces: the cubic pieces over the parameter `u`, m.
        closed: True if the end joins the start with continuous second derivative.
        breaks_s: (n,) arc length at the breaks of `pieces`, m.
        breaks_psi: (n,) unwrapped heading at the breaks, rad.
    """

    pieces: PiecewiseCubic
    closed: bool
    breaks_s: Floats
    breaks_psi: Floats

    @classmethod
    def through(cls, points: ArrayLike, *, closed: bool = False) -> PlanarCurve:
        """The interpolating cubic spline through `points`.

        Args:
            points: (n, 2) positions in m, in order, none repeated; a closed curve does not repeat its first point at the end.
            closed: join the end to the start.

        Raises:
            RoadError: fewer than two points (three where closed), or points that are not finite or repeated.
        """
        knots = np.asarray(points, dtype=np.float64)
        least = 3 if closed else 2
        if knots.ndim != 2 or knots.shape[1] != 2 or len(knots) < least:
            raise RoadError(f"a curve needs at least {least} points of shape (n, 2), found shape {knots.shape}")
        if closed:
            knots = np.vstack([knots, knots[:1]])
        steps = np.hypot(*np.diff(knots, axis=0).T)
        if not np.all(np.isfinite(knots)):
            raise RoadError(f"point {int(np.argmin(np.isfinite(knots).all(axis=1)))} of the curve is not finite")
        if np.any(steps <= 0.0):
            raise RoadError(f"points {int(np.argmin(steps))} and {int(np.argmin(steps)) + 1} of the curve are the same")
        u = np.concatenate([[0.0], np.cumsum(steps)])
        return cls.of_pieces(interpolate(u, knots, closed=closed), closed=closed)

    @classmethod
    def of_pieces(cls, pieces: PiecewiseCubic, *, closed: bool = False) -> PlanarCurve:
        """A curve from its piecewise polynomial; arc length and headings at the breaks are computed here."""
        h = np.diff(pieces.breaks)
        lengths = 0.5 * h * (np.hypot(*_rates(pieces, 0.5 * (1.0 + _NODES))) @ _WEIGHTS)
        x, y = (np.append(rate[:, :-1].ravel(), rate[-1, -1]) for rate in _rates(pieces, np.linspace(0.0, 1.0, 5)))
        psi = np.unwrap(np.arctan2(y, x))[::4]
        return cls(pieces, closed, read_only(np.concatenate([[0.0], np.cumsum(lengths)])), read_only(psi))

    @property
    def length(self) -> float:
        """Arc length of the whole curve, m."""
        return float(self.breaks_s[-1])

    def parameter(self, s: ArrayLike) -> Floats:
        """The parameter `u` at arc length `s` (m); a closed curve wraps, an open one is held at its ends."""
        s = np.asarray(s, dtype=np.float64)
        if s.size > 2 * _CHUNK:  # in parts, since what is in between takes fifty times the memory of the answer
            parts = [self.parameter(part) for part in np.array_split(s.ravel(), s.size // _CHUNK)]
            return np.concatenate(parts).reshape(s.shape)
        s = np.mod(s, self.length) if self.closed else np.clip(s, 0.0, self.length)
        u_breaks = self.pieces.breaks
        piece = np.clip(np.searchsorted(self.breaks_s, s, side="right") - 1, 0, len(u_breaks) - 2)
        start, end = u_breaks[piece], u_breaks[piece + 1]
        wanted = s - self.breaks_s[piece]
        share = wanted / (self.breaks_s[piece + 1] - self.breaks_s[piece])
        slow = self._slowness[:, piece]
        # the cubic with the right rates at both ends is off by the fourth power of the piece
        u = start + share * (slow[0] + share * (3.0 * (end - start) - 2.0 * slow[0] - slow[1] + share * (slow[0] + slow[1] - 2.0 * (end - start))))
        for _ in range(_NEWTON_STEPS):
            half = 0.5 * (u - start)
            inner = (start + half)[..., None] + half[..., None] * _NODES
            gap = half * (_speed(self.pieces, inner, piece[..., None]) @ _WEIGHTS) - wanted
            u = np.minimum(np.maximum(u - gap / _speed(self.pieces, u, piece), start), end)
            # Newton's method squares the error, which is at most that of the rate, a few per cent, times the gap
            if np.max(np.abs(gap), initial=0.0) < 1e-8:
                break
        return u

    @cached_property
    def _slowness(self) -> Floats:
        """(2, pieces) rate of the parameter by the share of arc length at the start and at the end of every piece."""
        x, y = _rates(self.pieces, np.array([0.0, 1.0]))
        return (np.diff(self.breaks_s)[:, None] / np.maximum(np.hypot(x, y), 1e-12)).T

    def station(self, u: ArrayLike) -> Floats:
        """Arc length (m) at parameter `u`, the inverse of `parameter`."""
        u = np.asarray(u, dtype=np.float64)
        u_breaks = self.pieces.breaks
        piece = np.clip(np.searchsorted(u_breaks, u, side="right") - 1, 0, len(u_breaks) - 2)
        half = 0.5 * (u - u_breaks[piece])
        inner = (u_breaks[piece] + half)[..., None] + half[..., None] * _NODES
        return self.breaks_s[piece] + half * (_speed(self.pieces, inner, piece[..., None]) @ _WEIGHTS)

    def position(self, s: ArrayLike) -> Floats:
        """Positions (..., 2) in m at arc length `s`."""
        return self.pieces(self.parameter(s))[0]

    def tangent(self, s: ArrayLike) -> Floats:
        """Unit tangents (..., 2) at arc length `s`."""
        first = self.pieces.derivative(self.parameter(s))
        return np.moveaxis(first / np.hypot(*first), 0, -1)

    def normal(self, s: ArrayLike) -> Floats:
        """Unit normals (..., 2) at arc length `s`, to the left of the direction of travel."""
        tangent = self.tangent(s)
        return np.stack([-tangent[..., 1], tangent[..., 0]], axis=-1)

    def heading(self, s: ArrayLike) -> Floats:
        """Continuous (unwrapped) heading in rad at arc length `s`, counter-clockwise from +x; over the seam it goes on counting."""
        s = np.asarray(s, dtype=np.float64)
        turns = np.floor_divide(s, self.length) if self.closed else np.zeros_like(s)
        tangent = self.tangent(s)
        angle = np.arctan2(tangent[..., 1], tangent[..., 0])
        about = np.interp(s - turns * self.length, self.breaks_s, self.breaks_psi) + turns * (self.breaks_psi[-1] - self.breaks_psi[0])
        return angle + 2.0 * np.pi * np.round((about - angle) / (2.0 * np.pi))

    def curvature(self, s: ArrayLike) -> Floats:
        """Curvature in 1/m at arc length `s`, positive in left turns (3.11)."""
        return curvature_of(self.pieces, self.parameter(s))

    def curvature_rate(self, s: ArrayLike) -> Floats:
        """Derivative of curvature by arc length in 1/m^2, piecewise smooth, taken from the right at breaks."""
        u = self.parameter(s)
        _, d1, d2, d3 = self.pieces(u, 3)
        speed2 = d1[..., 0] ** 2 + d1[..., 1] ** 2
        cross12 = d1[..., 0] * d2[..., 1] - d1[..., 1] * d2[..., 0]
        cross13 = d1[..., 0] * d3[..., 1] - d1[..., 1] * d3[..., 0]
        dot12 = d1[..., 0] * d2[..., 0] + d1[..., 1] * d2[..., 1]
        return cross13 / speed2**2 - 3.0 * cross12 * dot12 / speed2**3

    def squared_curvature(self) -> float:
        """The integral of curvature squared over arc length, 1/m: what a gentle path has least of."""
        u = self.pieces.breaks
        half = 0.5 * np.diff(u)[:, None]
        inner = 0.5 * (u[1:] + u[:-1])[:, None] + half * _NODES
        return float(np.sum(half * curvature_of(self.pieces, inner) ** 2 * _speed(self.pieces, inner) * _WEIGHTS))

    def locate(self, points: ArrayLike) -> tuple[Floats, Floats]:
        """Stations (n,) and signed distances (n,) in m, positive left, of the nearest places to `points` (n, 2), found globally.

        See `roads.geometry.locate`; a controller that follows one place uses `roads.Tracker`.
        """
        return self._locator(points)

    @cached_property
    def _locator(self) -> Locator:
        return Locator(self.pieces, self.breaks_s, self.station, closed=self.closed)

    def project(self, points: ArrayLike, near: ArrayLike) -> tuple[Floats, Floats]:
        """Stations and signed offsets of `points`, searched from the stations `near`.

        Args:
            points: (n, 2) positions, m.
            near: (n,) stations close to the wanted ones, m; the search is local (Newton's method), it does not jump to another branch.

        Returns:
            Stations (n,) in m and lateral offsets (n,) in m, positive to the left.
        """
        u, turns, offset = self.project_parameter(points, near)
        return self.station(u) + turns * self.length, offset

    def project_parameter(self, points: ArrayLike, near: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """As `project`, but returns parameters (n,), full turns (n,) and offsets (n,); saves the quadrature where stations are not needed."""
        points, near = np.asarray(points, dtype=np.float64), np.asarray(near, dtype=np.float64)
        turns = np.floor_divide(near, self.length) if self.closed else np.zeros_like(near)
        u = np.interp(near - turns * self.length, self.breaks_s, self.pieces.breaks)
        first, last = float(self.pieces.breaks[0]), float(self.pieces.breaks[-1])
        period = last - first
        for _ in range(_NEWTON_STEPS + 4):
            place, d1, d2 = self.pieces(u, 2)
            gap = points - place
            square = _dot(d1, d1)
            move = _dot(gap, d1) / np.maximum(square - _dot(gap, d2), 0.2 * square)
            u = u + move
            if self.closed:
                over = np.floor_divide(u - first, period)
                turns, u = turns + over, u - over * period
            else:
                u = np.clip(u, first, last)
            # Newton's method squares the error: a step of 0.1 mm leaves less than a micrometre
            if np.max(np.abs(move) * np.sqrt(square), initial=0.0) < 1e-4:
                break
        place, d1 = self.pieces(u, 1)
        gap = points - place
        offset = (d1[..., 0] * gap[..., 1] - d1[..., 1] * gap[..., 0]) / np.maximum(np.hypot(d1[..., 0], d1[..., 1]), 1e-12)
        return u, turns, offset


def curvature_of(pieces: PiecewiseCubic, u: ArrayLike) -> Floats:
    """Curvature in 1/m of a plane piecewise polynomial at parameters `u` (3.11)."""
    _, d1, d2 = pieces(u, 2)
    speed = np.hypot(d1[..., 0], d1[..., 1])
    return (d1[..., 0] * d2[..., 1] - d1[..., 1] * d2[..., 0]) / speed**3


def _rates(pieces: PiecewiseCubic, shares: Floats) -> tuple[Floats, Floats]:
    """First derivatives of x and of y, (n, k) each, at k shares of every piece."""
    th = np.diff(pieces.breaks)[:, None] * shares
    a, b, c, _ = pieces.coefficients
    x, y = ((3.0 * a[k][:, None] * th + 2.0 * b[k][:, None]) * th + c[k][:, None] for k in (0, 1))
    return x, y


def _speed(pieces: PiecewiseCubic, u: ArrayLike, piece: NDArray[np.intp] | None = None) -> Floats:
    return np.hypot(*pieces.derivative(np.asarray(u, dtype=np.float64), piece))


def _dot(a: Floats, b: Floats) -> Floats:
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1]
