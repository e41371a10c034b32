"""What this project uses of Clarabel, whose compiled module carries no types."""

from enum import Enum

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

class SolverStatus(Enum):
    Solved = ...
    AlmostSolved = ...

class DefaultSettings:
    verbose: bool
    iterative_refinement_enable: bool
    tol_gap_abs: float
    tol_gap_rel: float
    tol_feas: float

class DefaultSolution:
    x: list[float]
    z: list[float]
    status: SolverStatus

class Cone:
    def __init__(self, dim: int) -> None: ...

class ZeroConeT(Cone): ...
class NonnegativeConeT(Cone): ...
class SecondOrderConeT(Cone): ...

class DefaultSolver:
    def __init__(
        self, P: sp.csc_matrix, q: NDArray[np.float64], A: sp.csc_matrix, b: NDArray[np.float64], cones: list[Cone], settings: DefaultSettings
    ) -> None: ...
    def solve(self) -> DefaultSolution: ...
