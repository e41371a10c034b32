"""The curve of the magic formula, its cosine sister, and the factors that they have."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

#: Keeps square roots smooth at zero; squared, below rounding for every slip that matters.
TINY = 1e-9


class Factors(NamedTuple):
    """Stiffness, shape, peak and curvature factor of one curve, its shifts and its slope at zero slip."""

    b: Any
    c: Any
    d: Any
    e: Any
    horizontal: Any = 0.0
    vertical: Any = 0.0
    slope: Any = 0.0
    friction: Any = 0.0


def argument(b: Any, c: Any, e: Any, x: Any) -> Any:
    """`C atan(B x - E (B x - atan(B x)))`, the angle whose sine or cosine the magic formula takes."""
    bx = b * x
    return c * np.arctan(bx - e * (bx - np.arctan(bx)))


def sine(f: Factors, x: Any) -> Any:
    """A force: `D sin(..)` of the slip that is already shifted, without the vertical shift."""
    return f.d * np.sin(argument(f.b, f.c, f.e, x))


def cosine(f: Factors, x: Any) -> Any:
    """A trail or a residual moment: `D cos(..)` of the slip that is already shifted."""
    return f.d * np.cos(argument(f.b, f.c, f.e, x))


def weight(b: Any, c: Any, e: Any, x: Any, shift: Any) -> Any:
    """The reduction of one force by the other slip: a cosine that is 1 where `x` is zero."""
    return np.cos(argument(b, c, e, x + shift)) / np.cos(argument(b, c, e, shift))


def length(x: Any, y: Any) -> Any:
    """Length of a vector, smooth at zero.

    The standard gives equivalent slips the sign of the lateral one; they only enter even functions, where the sign is without effect.
    """
    return np.sqrt(x * x + y * y + TINY**2)
