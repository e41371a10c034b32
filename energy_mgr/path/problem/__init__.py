"""The problem of the path: what is free, what it costs, what holds at its ends."""

from .problem import CurvatureProblem

__all__ = ["CurvatureProblem"]
