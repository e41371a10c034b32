"""Recurrences over stations, vectorised."""

from __future__ import annotations

from math import isqrt
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


def climb(start: float, bound: Floats, rise: Floats) -> Floats:
    """x (m+1,) with x_0 = start, x_{i+1} = min(bound_i, x_i + rise_i), without a loop."""
    total = np.concatenate([[0.0], np.cumsum(rise)])
    return total + np.minimum.accumulate(np.append(start, bound) - total)


def affine_climb(start: float, bound: Floats, factor: Floats, rise: Floats) -> Floats:
    """x (m+1,) with x_0 = start, x_{i+1} = min(bound_i, factor_i x_i + rise_i), factors positive.

    Such maps are closed under composition, so stretches are composed side by side first and only their ends are passed on one by one.
    """
    count = len(bound)
    length = max(isqrt(count) // 2, 1)
    rows = -(-count // length)
    pad = rows * length - count
    c = np.append(bound, np.full(pad, np.inf)).reshape(rows, length).T.copy()
    a = np.append(factor, np.ones(pad)).reshape(rows, length).T.copy()
    b = np.append(rise, np.zeros(pad)).reshape(rows, length).T.copy()
    most, by, add = c[0], a[0], b[0]
    for k in range(1, length):
        most, by, add = np.minimum(c[k], a[k] * most + b[k]), a[k] * by, a[k] * add + b[k]
    starts, x = [], start
    for m, f, r in zip(most.tolist(), by.tolist(), add.tolist(), strict=True):
        starts.append(x)
        x = min(m, f * x + r)
    inside, x = np.empty((length, rows)), np.array(starts)
    for k in range(length):
        x = np.minimum(c[k], a[k] * x + b[k])
        inside[k] = x
    return np.append(start, inside.T.ravel()[:count])
