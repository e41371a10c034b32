"""Joints: where two segments of the spline meet, which they do without a kink (3.7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .spline import ReducedSpline

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]


def joints(spline: ReducedSpline) -> Ints:
    """Knots at which two segments meet: all of a circuit's, else all but the ends."""
    return np.arange(len(spline.q)) if spline.closed else np.arange(1, len(spline.q) - 1)


def segments_at(joint: Ints, spline: ReducedSpline) -> tuple[Ints, Ints]:
    """The segments that end and that begin at joints."""
    return (joint - 1) % len(spline.h), joint % len(spline.h)


def jumps(spline: ReducedSpline) -> tuple[Floats, Floats]:
    """Jump of the slope at the joints, along and across the road, of the size of offsets: rows (k, 2, 9) by the variables of three knots, constants
    (k, 2).
    """
    inner = joints(spline)
    before, after = segments_at(inner, spline)
    size = 0.5 * (spline.h[before] + spline.h[after])
    left, right = spline.basis(spline.breaks[before + 1], 1, before), spline.basis(spline.breaks[after], 1, after)
    directions = np.stack(spline.frame, axis=1)[inner]
    values = [size[:, None, None] * np.matmul(directions, basis.matrix) for basis in (left, right)]
    constant = size[:, None] * np.matmul(directions, (left.constant - right.constant)[:, :, None])[:, :, 0]
    joint = np.concatenate([values[0][:, :, :3], values[0][:, :, 3:] - values[1][:, :, :3], -values[1][:, :, 3:]], axis=2)
    return joint, constant
