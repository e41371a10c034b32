"""Parts of a path of cubics, cut ever shorter by the proofs; points are (2, k), one coordinate after the other."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from roads.geometry.cubic import PiecewiseCubic

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]


class Pieces(NamedTuple):
    """Parts of the path: stations of their ends, m."""

    start: Floats
    end: Floats


def cut(pieces: Pieces, longest: Floats | float) -> Pieces:
    """The parts cut into equal ones no longer than `longest`, m."""
    length = pieces.end - pieces.start
    count = np.maximum(np.ceil(length / longest), 1.0).astype(np.intp)
    which = np.repeat(np.arange(len(count)), count)
    part = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
    step = (length / count)[which]
    return Pieces(pieces.start[which] + part * step, pieces.start[which] + (part + 1) * step)


def halves(pieces: Pieces) -> Pieces:
    """Every part in two."""
    middle = 0.5 * (pieces.start + pieces.end)
    return Pieces(np.column_stack([pieces.start, middle]).ravel(), np.column_stack([middle, pieces.end]).ravel())


def piece_of(path: PiecewiseCubic, s: Floats) -> Ints:
    """Cubic on which each station lies."""
    return np.minimum(np.maximum(np.searchsorted(path.breaks, s, side="right") - 1, 0), len(path.breaks) - 2)


def places(path: PiecewiseCubic, piece: Ints, s: Floats) -> Floats:
    """(2, k) the path at stations `s` of the cubics `piece`."""
    th = s - path.breaks[piece]
    a, b, c, d = path.coefficients[:, :, piece]
    return ((a * th + b) * th + c) * th + d


def dot(a: Floats, b: Floats) -> Floats:
    """Scalar products (k,)."""
    return a[0] * b[0] + a[1] * b[1]


def cross(a: Floats, b: Floats) -> Floats:
    """Cross products (k,)."""
    return a[0] * b[1] - a[1] * b[0]
