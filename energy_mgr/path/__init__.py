"""Curvature minimisation: the gentlest path inside a corridor."""

from .planner import plan_path
from .problem import CurvatureProblem
from .result import Path, PathReport

__all__ = ["CurvatureProblem", "Path", "PathReport", "plan_path"]
