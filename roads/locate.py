"""The nearest point of a curve: globally by a spatial index, or followed from the last place, as a controller does.

The index holds samples `SPACING` apart. The nearest sample starts Newton's method. Where another branch of the curve passes within three
spacings (a crossing, a seam), all branches near the point are tried. Elsewhere two branches are told apart if their distances differ by
more than a sixteenth of the spacing.
"""

from __future__ import annotations

import os
from bisect import bisect_right
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property
from math import floor, hypot
from typing import TYPE_CHECKING

import numpy as np

from .errors import RoadError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .curve import PlanarCurve

    Floats = NDArray[np.float64]

#: Samples of the index are at most this far apart, m.
SPACING = 0.5
#: Branches that are tried where a curve comes close to itself.
_BRANCHES = 24
#: Places that are located together.
_BLOCK = 20_000


class Locator:
    """Finds stations and offsets of places beside one curve."""

    def __init__(self, curve: PlanarCurve) -> None:
        self.curve = curve

    @cached_property
    def _index(self):
        from scipy.spatial import cKDTree  # slow to import, and planning never asks globally

        u = self.curve.pieces.breaks
        parts = np.maximum(np.ceil(np.diff(self.curve.breaks_s) / SPACING), 1).astype(np.intp)
        piece = np.repeat(np.arange(len(parts)), parts)
        within = np.arange(len(piece)) - np.repeat(np.cumsum(parts) - parts, parts)
        samples = u[piece] + within / parts[piece] * np.diff(u)[piece]
        if not self.curve.closed:
            samples = np.append(samples, u[-1])
        places, d1, d2 = self.curve.pieces(samples, 2)
        speed = np.hypot(d1[:, 0], d1[:, 1])
        tree = cKDTree(places)
        s = self.curve.station(samples)
        pairs = tree.query_pairs(3.0 * SPACING, output_type="ndarray")
        apart = np.abs(s[pairs[:, 0]] - s[pairs[:, 1]]) if len(pairs) else np.zeros(0)
        if self.curve.closed:
            apart = np.minimum(apart, self.curve.length - apart)
        crowded = np.zeros(len(samples), dtype=bool)
        crowded[pairs[apart > 5.0 * SPACING].ravel()] = True
        return tree, np.array([samples, s, speed, np.sum(d1 * d2, axis=1) / speed]), crowded

    def __call__(self, points: ArrayLike) -> tuple[Floats, Floats]:
        """Stations (n,) in m and signed distances (n,) in m, positive to the left, of the nearest places to `points` (n, 2).

        Beyond the ends of an open curve the distance is that to the end, and its sign tells the side of the end's tangent.

        Raises:
            RoadError: a point that is not finite.
        """
        points = np.atleast_2d(np.asarray(points, dtype=np.float64))
        if not np.isfinite(points).all():
            raise RoadError(f"point {int(np.argmin(np.isfinite(points).all(axis=1)))} is not finite, expected places in m")
        if len(points) <= _BLOCK:
            return self._found(points)
        # blocks that fit the cache, on all cores: NumPy and the tree let other threads run
        _ = self._index
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            blocks = list(pool.map(self._found, (points[k : k + _BLOCK] for k in range(0, len(points), _BLOCK))))
        return np.concatenate([s for s, _ in blocks]), np.concatenate([offset for _, offset in blocks])

    def _found(self, points: Floats) -> tuple[Floats, Floats]:
        tree, samples, crowded = self._index
        nearest: NDArray[np.intp] = np.asarray(tree.query(points)[1])
        s, offset = self._descend(points, nearest)
        for k in np.flatnonzero(crowded[nearest]):
            others: NDArray[np.intp] = np.asarray(tree.query(points[k], k=min(_BRANCHES, samples.shape[1]))[1])
            tried = self._descend(np.repeat(points[k : k + 1], len(others), axis=0), others)
            best = int(np.argmin(np.abs(tried[1])))
            s[k], offset[k] = tried[0][best], tried[1][best]
        return s, offset

    def _descend(self, points: Floats, nearest: NDArray[np.intp]) -> tuple[Floats, Floats]:
        """Newton's method from samples that lie within a spacing of the nearest places.

        It squares its error, so that a step of 10 um is the last; the distance does not feel what is left of it. The way from the sample is
        the corrected trapezium rule over the speed |dp/du|, right to 1e-9 m over half a metre.
        """
        pieces, closed = self.curve.pieces, self.curve.closed
        first, last = float(pieces.breaks[0]), float(pieces.breaks[-1])
        start, s_start, v_start, a_start = self._index[1][:, nearest]
        s, offset = np.empty(len(start)), np.empty(len(start))
        todo, here, moved = np.arange(len(start)), start, np.zeros(len(start))
        for _ in range(12):
            place, d1, d2 = pieces(here, 2)
            gap = points[todo] - place
            square = d1[:, 0] ** 2 + d1[:, 1] ** 2
            speed = np.sqrt(square)
            slope = gap[:, 0] * d1[:, 0] + gap[:, 1] * d1[:, 1]
            move = slope / np.maximum(square - gap[:, 0] * d2[:, 0] - gap[:, 1] * d2[:, 1], 0.2 * square)
            after = here + move
            if closed:
                after = first + np.mod(after - first, last - first)
            else:
                after = np.clip(after, first, last)
                move = after - here
            side = d1[:, 0] * gap[:, 1] - d1[:, 1] * gap[:, 0]
            # the foot is perpendicular except at an open end, where the whole gap counts
            distance = np.abs(side) / speed
            if not closed:
                at_end = (move == 0.0) & ((here == first) | (here == last))
                distance = np.where(at_end, np.hypot(gap[:, 0], gap[:, 1]), distance)
            gain = (d1[:, 0] * d2[:, 0] + d1[:, 1] * d2[:, 1]) / speed
            s[todo] = s_start + moved * (0.5 * (v_start + speed) + moved * (a_start - gain) / 12.0) + move * speed
            offset[todo] = np.where(side < 0.0, -distance, distance)
            going = np.abs(move) * speed > 1e-5
            if not going.any():
                break
            todo, here, moved = todo[going], after[going], (moved + move)[going]
            s_start, v_start, a_start = s_start[going], v_start[going], a_start[going]
        return np.mod(s, self.curve.length) if closed else np.clip(s, 0.0, self.curve.length), offset


def _cut(curve: PlanarCurve) -> tuple[Floats, Floats, Floats]:
    """Breaks, stations and coefficients (4, 2, n) of the curve's pieces, halved until three nodes measure each of them."""
    pieces = curve.pieces
    looks = [np.abs(curve.curvature(curve.breaks_s[:-1] + share * np.diff(curve.breaks_s))) for share in (0.1, 0.5, 0.9)]
    turn = np.abs(np.diff(curve.breaks_psi)) + np.diff(curve.breaks_s) * np.max(looks, axis=0)
    parts = np.clip(np.ceil(turn / 0.1), 1, 64).astype(np.intp)
    piece = np.repeat(np.arange(len(parts)), parts)
    share = (np.arange(len(piece)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[piece]
    th = share * np.diff(pieces.breaks)[piece]
    a, b, c, d = pieces.coefficients[:, :, piece]
    rows = np.array([a, b + 3.0 * a * th, c + (2.0 * b + 3.0 * a * th) * th, ((a * th + b) * th + c) * th + d])
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
        self._locator = Locator(curve)
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
        s, offset = self._locator([[x, y]])
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
