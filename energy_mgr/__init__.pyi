from .errors import InfeasibleError as InfeasibleError
from .errors import PlanningError as PlanningError
from .errors import SolverError as SolverError
from .path.planner import plan_path as plan_path
from .path.result import Path as Path
from .path.result import PathReport as PathReport
from .planning import Plan as Plan
from .planning import plan as plan
from .speed.limits import SpeedLimits as SpeedLimits
from .speed.result import SpeedProfile as SpeedProfile
from .trajectory import Trajectory as Trajectory

__all__ = [
    "InfeasibleError",
    "Path",
    "PathReport",
    "Plan",
    "PlanningError",
    "SolverError",
    "SpeedLimits",
    "SpeedProfile",
    "Trajectory",
    "plan",
    "plan_path",
]
