"""Curvature minimisation: the gentlest path inside a corridor."""

from .ends import End
from .objective import Weights
from .planner import PathOptions, plan_path
from .problem import CurvatureProblem
from .result import Path, PathReport

__all__ = ["CurvatureProblem", "End", "Path", "PathOptions", "PathReport", "Weights", "plan_path"]
