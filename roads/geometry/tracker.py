"""The nearest place of a curve to one that moves, followed from where it was last, as a controller does."""

from __future__ import annotations

from bisect import bisect_right
from math import floor, hypot
from typing import TYPE_CHECKING

import numpy as np

from .cubic import counted_from

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .curve import PlanarCurve

    Floats = NDArray[np.float64]


def _cut(curve: PlanarCurve) -> tuple[Floats, Floats, Floats]:
    """Breaks, stations and coefficients (4, 2, n) of the curve's pieces, halved until three nodes measure each of them."""
    pieces = curve.pieces
    looks = [np.abs(curve.curvature(curve.breaks_s[:-1] + share * np.diff(curve.breaks_s))) for share in (0.1, 0.5, 0.9)]
    turn = np.abs(np.diff(curve.breaks_psi)) + np.diff(curve.breaks_s) * np.max(looks, axis=0)
    parts = np.clip(np.ceil(turn / 0.1), 1, 64).astype(np.intp)
    piece = np.repeat(np.arange(len(parts)), parts)
    share = (np.arange(len(piece)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[piece]
    th = share * np.diff(pieces.breaks)[piece]
    rows = counted_from(th, pieces.coefficients[:, :, piece])
    breaks = np.append(pieces.breaks[piece] + th, pieces.breaks[-1])
    return breaks, curve.station(breaks), rows


class Tracker:
    """Follows one moving place along a curve, in plain floats: a few microseconds a call.

    Each call searches from the last station. Where that leads nowhere (a first call, a place more than `window` off, a jump), it
    searches globally and `reacquired` counts it.

    Args:
        curve: the curve.
        window: how far along the curve the place may move between two calls, m.
    """

    def __init__(self, curve: PlanarCurve, window: float = 10.0) -> None:
        self.curve = curve
        self.window = window
        self.reacquired = 0
        breaks, stations, rows = _cut(curve)
        self._breaks: list[float] = breaks.tolist()
        self._stations: list[float] = stations.tolist()
        self._rows: list[list[float]] = rows.transpose(2, 0, 1).reshape(-1, 8).tolist()
        a, b, c = rows[0], rows[1], rows[2]
        # the square of the speed as a polynomial of each piece's parameter
        speeds = [9.0 * a**2, 12.0 * a * b, 4.0 * b**2 + 6.0 * a * c, 4.0 * b * c, c**2]
        self._speeds: list[list[float]] = np.array(speeds).sum(axis=1).T.tolist()
        self._u: float | None = None
        self._s, self._piece = 0.0, 0

    def __call__(self, x: float, y: float) -> tuple[float, float]:
        """Station in m and signed distance in m (positive left) of the place nearest to (x, y)."""
        if self._u is not None:
            found = self._follow(x, y, self._u)
            if found is not None:
                return found
        return self._acquire(x, y)

    def _acquire(self, x: float, y: float) -> tuple[float, float]:
        self.reacquired += 1
        s, offset = self.curve.locate([[x, y]])
        self._s = float(s[0])
        self._u = float(self.curve.parameter(self._s))
        return self._s, float(offset[0])

    def _follow(self, x: float, y: float, u: float) -> tuple[float, float] | None:
        breaks, rows, closed = self._breaks, self._rows, self.curve.closed
        first, last = breaks[0], breaks[-1]
        piece = self._piece
        for _ in range(8):
            if not breaks[piece] <= u <= breaks[piece + 1]:
                piece = min(max(bisect_right(breaks, u) - 1, 0), len(rows) - 1)
            th = u - breaks[piece]
            ax, ay, bx, by, cx, cy, dx, dy = rows[piece]
            gx, gy = x - (((ax * th + bx) * th + cx) * th + dx), y - (((ay * th + by) * th + cy) * th + dy)
            tx, ty = (3.0 * ax * th + 2.0 * bx) * th + cx, (3.0 * ay * th + 2.0 * by) * th + cy
            square = tx * tx + ty * ty
            move = (gx * tx + gy * ty) / max(square - gx * (6.0 * ax * th + 2.0 * bx) - gy * (6.0 * ay * th + 2.0 * by), 0.2 * square)
            after = u + move
            if closed:
                if not first <= after < last:
                    after = first + (after - first) % (last - first)
            elif not first <= after <= last:
                after = first if after < first else last
                move = after - u
            u = after
            if -1e-5 < move * square**0.5 < 1e-5:
                break
        else:
            return None
        if not breaks[piece] <= u <= breaks[piece + 1]:
            piece = min(max(bisect_right(breaks, u) - 1, 0), len(rows) - 1)
        s = self._station(piece, u - breaks[piece])
        apart = abs(s - self._s)
        if closed:
            length = self._stations[-1]
            apart = abs(apart - length * floor(apart / length + 0.5))
        side = tx * gy - ty * gx
        distance = hypot(gx, gy) if not closed and u in (first, last) else abs(side) / square**0.5
        if not (apart <= self.window and distance <= self.window):
            return None
        self._u, self._s, self._piece = u, s, piece
        return s, distance if side >= 0.0 else -distance

    def _station(self, piece: int, th: float) -> float:
        """Arc length by Gauss-Legendre quadrature with three nodes; the pieces are cut so short that this is exact to 1e-8 m."""
        a, b, c, d, e = self._speeds[piece]
        half = 0.5 * th
        low, high = 0.22540333075851662 * half, 1.7745966692414834 * half
        return self._stations[piece] + half * (
            0.5555555555555556 * ((((a * low + b) * low + c) * low + d) * low + e) ** 0.5
            + 0.8888888888888888 * ((((a * half + b) * half + c) * half + d) * half + e) ** 0.5
            + 0.5555555555555556 * ((((a * high + b) * high + c) * high + d) * high + e) ** 0.5
        )
