"""Solvers of P1 behind one call; which one when, and what it costs, stands in their modules."""

from .solution import Solution
from .solve import METHODS, Method, solve

__all__ = ["METHODS", "Method", "Solution", "solve"]
