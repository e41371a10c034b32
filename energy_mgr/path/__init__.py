"""Curvature minimisation: the gentlest path inside a corridor, planned once or over a receding horizon."""

from .certificate import Certificate, Prover
from .ends import End
from .horizon import PathPlanner
from .objective import Weights
from .planner import PathOptions, plan_path
from .problem import CurvatureProblem
from .receding import receding_path
from .result import Path, PathReport
from .step import PathState, PathStep

__all__ = [
    "Certificate",
    "CurvatureProblem",
    "End",
    "Path",
    "PathOptions",
    "PathPlanner",
    "PathReport",
    "PathState",
    "PathStep",
    "Prover",
    "Weights",
    "plan_path",
    "receding_path",
]
