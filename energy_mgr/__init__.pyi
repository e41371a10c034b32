from .errors import InfeasibleError as InfeasibleError
from .errors import PlanningError as PlanningError
from .errors import SolverError as SolverError
from .path.ends import End as End
from .path.objective import Weights as Weights
from .path.planner import PathOptions as PathOptions
from .path.planner import plan_path as plan_path
from .path.result import Path as Path
from .path.result import PathReport as PathReport
from .planning import Plan as Plan
from .planning import plan as plan
from .speed.limits import SpeedLimits as SpeedLimits
from .speed.result import SpeedProfile as SpeedProfile
from .trajectory import Trajectory as Trajectory

__all__ = [
    "End",
    "InfeasibleError",
    "Path",
    "PathOptions",
    "PathReport",
    "Plan",
    "PlanningError",
    "SolverError",
    "SpeedLimits",
    "SpeedProfile",
    "Trajectory",
    "Weights",
    "plan",
    "plan_path",
]
