"""Where polylines cross: by a spatial index over short pieces, in near-linear time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import RoadError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


def self_crossings(points: Floats, *, closed: bool) -> Iterator[tuple[int, int, Floats]]:
    """Yield (i, j, place): segments i < j of the polyline `points` (n, 2) that cross although they are not neighbours."""
    line = np.vstack([points, points[:1]]) if closed else points
    count = len(line) - 1
    meets = bool(np.hypot(*(line[-1] - line[0])) < 1e-6)
    starts, ends, owner = _pieces(line)
    pairs = np.sort(owner[_close_pairs(starts, ends)], axis=1)
    apart = pairs[:, 1] - pairs[:, 0]
    pairs = pairs[(apart > 1) & ~(meets & (pairs[:, 0] == 0) & (pairs[:, 1] == count - 1))]
    yield from _crossings(line, line, pairs)


def mutual_crossings(first: Floats, second: Floats) -> Iterator[tuple[int, int, Floats]]:
    """Yield (i, j, place): segment i of polyline `first` (n, 2) crosses segment j of polyline `second` (m, 2)."""
    one, other = _pieces(first), _pieces(second)
    starts, ends, owner = np.concatenate([one[0], other[0]]), np.concatenate([one[1], other[1]]), np.concatenate([one[2], other[2]])
    split = len(one[0])
    found = _close_pairs(starts, ends)
    found = np.sort(found[(found[:, 0] < split) != (found[:, 1] < split)], axis=1)
    yield from _crossings(first, second, owner[found])


def _crossings(one: Floats, other: Floats, pairs: NDArray[np.intp]) -> Iterator[tuple[int, int, Floats]]:
    """Of `pairs` (k, 2) of segments of the polylines those that cross or touch, with the place; parallel segments never count."""
    a, b = one[pairs[:, 0]], one[pairs[:, 0] + 1]
    c, d = other[pairs[:, 1]], other[pairs[:, 1] + 1]
    along, across, gap = b - a, d - c, c - a
    det = along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0]
    parallel = np.abs(det) < 1e-12 * np.hypot(*along.T) * np.hypot(*across.T)
    det = np.where(parallel, 1.0, det)
    t = (gap[:, 0] * across[:, 1] - gap[:, 1] * across[:, 0]) / det
    u = (gap[:, 0] * along[:, 1] - gap[:, 1] * along[:, 0]) / det
    for k in np.flatnonzero(~parallel & (t >= 0.0) & (t <= 1.0) & (u >= 0.0) & (u <= 1.0)).tolist():
        yield int(pairs[k, 0]), int(pairs[k, 1]), a[k] + t[k] * along[k]


def _pieces(line: Floats) -> tuple[Floats, Floats, NDArray[np.intp]]:
    """Cut each segment into pieces no longer than the polyline's median segment; `owner` tells the segment of each."""
    lengths = np.hypot(*np.diff(line, axis=0).T)
    longest = max(float(np.median(lengths)), float(np.sum(lengths)) / (8 * len(lengths)), 1e-9)
    parts = np.maximum(np.ceil(lengths / longest), 1).astype(np.intp)
    owner = np.repeat(np.arange(len(lengths)), parts)
    part = np.arange(len(owner)) - np.repeat(np.cumsum(parts) - parts, parts)
    step = np.diff(line, axis=0)[owner] / parts[owner][:, None]
    starts = line[owner] + part[:, None] * step
    return starts, starts + step, owner


def _close_pairs(starts: Floats, ends: Floats) -> NDArray[np.intp]:
    """Pairs (k, 2) of pieces whose boxes overlap, in order. Two pieces that cross have midpoints in the same or in neighbouring cells of a grid."""
    size = float(np.max(np.hypot(*(ends - starts).T)))
    cell = np.floor((0.5 * (starts + ends) - starts.min(axis=0)) / size).astype(np.int64)
    stride = int(cell[:, 1].max()) + 3
    key = cell[:, 0] * stride + cell[:, 1]
    order = np.argsort(key, kind="stable")
    ranked = key[order]
    # boxes in the order of the cells, axis by axis: neighbours are then close in memory too
    low, high = np.minimum(starts, ends).T[:, order].copy(), np.maximum(starts, ends).T[:, order].copy()
    steps = (0, 1, stride - 1, stride, stride + 1)
    neighbours = [(np.searchsorted(ranked, ranked + step), np.searchsorted(ranked, ranked + step, side="right"), step) for step in steps]
    if sum(int(np.sum(end - begin)) for begin, end, _ in neighbours) > 300 * len(key) + 1_000_000:
        raise RoadError("the line lies in so many layers over itself that it cannot be a road")
    found = []
    for begin, end, neighbour in neighbours:
        count = end - begin
        a = np.repeat(np.arange(len(key)), count)
        b = np.repeat(begin, count) + np.arange(len(a)) - np.repeat(np.cumsum(count) - count, count)
        overlap = (low[0, a] <= high[0, b]) & (low[0, b] <= high[0, a]) & (low[1, a] <= high[1, b]) & (low[1, b] <= high[1, a])
        overlap &= (neighbour > 0) | (a < b)
        found.append(np.sort(np.column_stack([order[a[overlap]], order[b[overlap]]]), axis=1))
    pairs = np.concatenate(found)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
