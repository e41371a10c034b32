from . import report as report
from .errors import InfeasibleError as InfeasibleError
from .errors import PlanningError as PlanningError
from .errors import SolverError as SolverError
from .manager.manager import EnergyManager as EnergyManager
from .manager.measurements import Measurements as Measurements
from .manager.measurements import WheelCommands as WheelCommands
from .path.problem.ends import End as End
from .path.problem.objective import Weights as Weights
from .path.planner import PathOptions as PathOptions
from .path.planner import plan_path as plan_path
from .path.result import Path as Path
from .path.result import PathReport as PathReport
from .planning.planner import Planner as Planner
from .planning.comparison import Plan as Plan
from .planning.one_call import plan as plan
from .planning.one_call import plan_front as plan_front
from .planning.score import Score as Score
from .planning.score import score as score
from .request import PlanRequest as PlanRequest
from .simulation.drive import simulate as simulate
from .simulation.events import Event as Event
from .simulation.log import Drive as Drive
from .speed.driving.horizon import SpeedPlanner as SpeedPlanner
from .speed.bounds.speed_limits import SpeedLimits as SpeedLimits
from .speed.methods import plan_speed as plan_speed
from .speed.result import SpeedProfile as SpeedProfile
from .speed.bounds.rules import DriveRules as DriveRules
from .trajectory.trajectory import Trajectory as Trajectory
from .trajectory.pieces import TrajectoryPoint as TrajectoryPoint

__all__ = [
    "Drive",
    "DriveRules",
    "End",
    "EnergyManager",
    "Event",
    "InfeasibleError",
    "Measurements",
    "Path",
    "PathOptions",
    "PathReport",
    "Plan",
    "PlanRequest",
    "Planner",
    "PlanningError",
    "Score",
    "SolverError",
    "SpeedLimits",
    "SpeedPlanner",
    "SpeedProfile",
    "Trajectory",
    "TrajectoryPoint",
    "Weights",
    "WheelCommands",
    "plan",
    "plan_front",
    "plan_path",
    "plan_speed",
    "report",
    "score",
    "simulate",
]
