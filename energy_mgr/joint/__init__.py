"""Path and speed planned together, as one optimal control problem."""

from .planner import JointPlan, joint_plan

__all__ = ["JointPlan", "joint_plan"]
