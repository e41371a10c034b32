"""The cheapest ways from one place of a graph to all others, with costs of either sign."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import RoadError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]


def shortest(count: int, begins: Ints, ends: Ints, weights: Floats, source: int, path: str) -> tuple[Floats, NDArray[np.int32]]:
    """Least cost from `source` to every place of `count`, and the place before it on that way (-1 or less: none).

    Raises:
        RoadError: costs that fall without end on a ring; it names `path`.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import dijkstra

    if np.any(weights < 0.0):
        return _relaxed(count, begins, ends, weights, source, path)
    graph = csr_array((weights, (begins, ends)), shape=(count, count))
    distance, before = dijkstra(graph, indices=[source], return_predecessors=True)
    return distance[0], before[0]


def _relaxed(count: int, begins: Ints, ends: Ints, weights: Floats, source: int, path: str) -> tuple[Floats, NDArray[np.int32]]:
    """The same where costs are negative: Bellman and Ford's rounds over all edges at once; a ring among the ways found earns without end."""
    order = np.argsort(ends, kind="stable")
    begins, ends, weights = begins[order], ends[order], weights[order]
    firsts = np.flatnonzero(np.append(True, ends[1:] != ends[:-1]))
    targets, sizes = ends[firsts], np.diff(np.append(firsts, len(ends)))
    distance, before = np.full(count, np.inf), np.full(count, -1, dtype=np.int32)
    distance[source] = 0.0
    for turn in range(1, count + 1):
        offer = distance[begins] + weights
        least = np.minimum.reduceat(offer, firsts)
        better = least < distance[targets] - 1e-9 * (1.0 + np.abs(np.where(np.isfinite(least), least, 0.0)))
        if not better.any():
            return distance, before
        best = np.flatnonzero((offer == np.repeat(least, sizes)) & np.repeat(better, sizes))
        before[ends[best]] = begins[best]
        distance[targets[better]] = least[better]
        if turn % 50 == 0 and _has_ring(before):
            break
    raise RoadError(f"{path}: the cost falls without end on a way round, expected a cost that going round does not lower")


def _has_ring(before: NDArray[np.int32]) -> bool:
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    rows = np.flatnonzero(before >= 0)
    graph = csr_array((np.ones(len(rows)), (before[rows], rows)), shape=(len(before), len(before)))
    count, _ = connected_components(graph, directed=True, connection="strong", return_labels=True)
    return count < len(before)
