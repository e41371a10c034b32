"""The main job: from a road and a car to a thrifty drive, compared with an ordinary one at the same arrival time."""

from powertrain import KWH

from ..request import PlanRequest
from .comparison import Comparison, Plan, Run, saving_percent
from .one_call import plan, plan_front
from .planner import Planner
from .score import Score, score

__all__ = ["KWH", "Comparison", "Plan", "PlanRequest", "Planner", "Run", "Score", "plan", "plan_front", "saving_percent", "score"]
