"""The nearest point of a curve, found globally by a spatial index; `roads.geometry.tracker` follows one place from where it was last.

The index holds samples `SPACING` apart. The nearest sample starts Newton's method. Where another branch of the curve passes within three
spacings (a crossing, a seam), all branches near the point are tried. Elsewhere two branches are told apart if their distances differ by
more than a sixteenth of the spacing.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..errors import RoadError

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

    from .cubic import PiecewiseCubic

    Floats = NDArray[np.float64]

#: Samples of the index are at most this far apart, m.
SPACING = 0.5
#: Branches that are tried where a curve comes close to itself.
_BRANCHES = 24
#: Places that are located together.
_BLOCK = 20_000


class Locator:
    """Finds stations and offsets of places beside one curve.

    It is made of what it needs of the curve, and so knows nothing of `roads.PlanarCurve`, which uses it.

    Args:
        pieces: the curve's cubic pieces, m.
        breaks_s: (n,) arc length at their breaks, m.
        station: arc length (m) at parameters of `pieces`.
        closed: the end joins the start.
    """

    def __init__(self, pieces: PiecewiseCubic, breaks_s: Floats, station: Callable[[Floats], Floats], *, closed: bool) -> None:
        self._pieces, self._breaks_s, self._station, self._closed = pieces, breaks_s, station, closed
        self._length = float(breaks_s[-1])

    @cached_property
    def _index(self):
        from scipy.spatial import cKDTree  # slow to import, and planning never asks globally

        u = self._pieces.breaks
        parts = np.maximum(np.ceil(np.diff(self._breaks_s) / SPACING), 1).astype(np.intp)
        piece = np.repeat(np.arange(len(parts)), parts)
        within = np.arange(len(piece)) - np.repeat(np.cumsum(parts) - parts, parts)
        samples = u[piece] + within / parts[piece] * np.diff(u)[piece]
        if not self._closed:
            samples = np.append(samples, u[-1])
        places, d1, d2 = self._pieces(samples, 2)
        speed = np.hypot(d1[:, 0], d1[:, 1])
        tree = cKDTree(places)
        s = self._station(samples)
        pairs = tree.query_pairs(3.0 * SPACING, output_type="ndarray")
        apart = np.abs(s[pairs[:, 0]] - s[pairs[:, 1]]) if len(pairs) else np.zeros(0)
        if self._closed:
            apart = np.minimum(apart, self._length - apart)
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
        pieces, closed = self._pieces, self._closed
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
        return np.mod(s, self._length) if closed else np.clip(s, 0.0, self._length), offset
