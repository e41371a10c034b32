"""Exceptions of the planner."""


class PlanningError(ValueError):
    """A request that cannot be planned; the message is one line that says what, where and by how much."""


class InfeasibleError(PlanningError):
    """No trajectory satisfies the limits; the message names the limit and the station."""


class SolverError(PlanningError):
    """A solver ended without an answer that passes our own checks."""
