"""What a solver of P1 returns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Solution:
    """Where an iteration ended.

    Attributes:
        x: the point.
        cost: the cost there.
        iterations: iterations, for Gauss-Newton QPs solved.
        optimality: decrease of the cost that is left, relative to the cost, as the method itself tells; nan where it tells nothing.
        kkt_residual: largest of gradient of the Lagrangian (cost scaled to one, variables in m), broken constraint (m) and multiplier of a constraint
            that has room; nan where the method knows no multipliers.
        converged: the method met its own tolerance.
        solver: what solved it; not the back end asked for if that one failed.
    """

    x: Floats
    cost: float
    iterations: int
    optimality: float
    kkt_residual: float
    converged: bool
    solver: str
