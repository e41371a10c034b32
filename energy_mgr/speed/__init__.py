"""How fast to drive a path: limits, the fastest profile, the thriftiest one."""

from .battery import BatteryDrive, battery_profile
from .eco import EcoSolver, eco_profile
from .forward_backward import fastest_profile, scaled_profile
from .grip import Grip
from .horizon import HorizonSpeed, SpeedPlanner
from .limits import Window
from .methods import METHODS, SpeedMethod, plan_speed
from .parts import Arrival, BatteryPower, Comfort, FrictionBrakes, Jerk, Lateral, Motors, Posted, SpeedCap, Stop
from .result import Front, SpeedProfile
from .rules import DriveRules
from .speed_limits import SpeedLimits

__all__ = [
    "METHODS",
    "Arrival",
    "BatteryDrive",
    "BatteryPower",
    "Comfort",
    "DriveRules",
    "EcoSolver",
    "FrictionBrakes",
    "Front",
    "Grip",
    "HorizonSpeed",
    "Jerk",
    "Lateral",
    "Motors",
    "Posted",
    "SpeedCap",
    "SpeedLimits",
    "SpeedMethod",
    "SpeedPlanner",
    "SpeedProfile",
    "Stop",
    "Window",
    "battery_profile",
    "eco_profile",
    "fastest_profile",
    "plan_speed",
    "scaled_profile",
]
