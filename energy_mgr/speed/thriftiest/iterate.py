"""What the interior-point method for chains passes around: iterates, values, directions; step lengths."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .interval import Values

    Floats = NDArray[np.float64]


class Deadline(NamedTuple):
    """The time over the first `intervals` intervals is at most (sign +1) or at least (sign -1) `bound` s."""

    intervals: int
    bound: float
    sign: int


@dataclass(frozen=True, eq=False)
class Iterate:
    """Unknowns, slacks and multipliers.

    Attributes:
        x: (n,) scaled v^2/2.
        local: (N, 2) scaled |F| and friction braking.
        slack: (N, k) of the rows.
        dual: (N, k) multipliers of the rows.
        low: (n,) multipliers of x >= 0.
        high: (n,) multipliers of x <= bound.
        late: (m,) slacks of the deadlines.
        price: (m,) multipliers of the deadlines, scaled.
        ring: multiplier of x_0 = x_n.
        jerk_slack: (N - 1, 2).
        jerk_dual: (N - 1, 2).
    """

    x: Floats
    local: Floats
    slack: Floats
    dual: Floats
    low: Floats
    high: Floats
    late: Floats
    price: Floats
    ring: float
    jerk_slack: Floats
    jerk_dual: Floats


@dataclass(frozen=True, eq=False)
class Solution:
    """The last iterate and how good it is: largest scaled residual of the optimality conditions, iterations, whether both tolerances are met."""

    iterate: Iterate
    residual: float
    iterations: int
    solved: bool


class State(NamedTuple):
    """An iterate with its values."""

    values: Values
    jerk: Floats
    excess: Floats
    infeasible: float


class Direction(NamedTuple):
    """A step of Newton's method."""

    x: Floats
    local: Floats
    price: Floats
    ring: float


def longest(value: Floats, change: Floats, keep: float) -> float:
    """The longest step, up to 1, that leaves `value` positive."""
    shrink = change < 0.0
    if not np.any(shrink):
        return 1.0
    return min(1.0, keep * float(np.min(-value[shrink] / change[shrink])))
