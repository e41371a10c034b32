"""Curvature minimisation: the gentlest path inside a corridor, planned once or over a receding horizon."""

from .driving.horizon import PathPlanner
from .driving.receding import receding_path
from .driving.step import PathState, PathStep
from .planner import PathOptions, plan_path
from .problem.ends import End
from .problem.objective import Weights
from .problem.problem import CurvatureProblem
from .proof.certificate import Certificate, Prover
from .result import Path, PathReport

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
