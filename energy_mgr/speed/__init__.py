"""How fast to drive a path: limits, the fastest profile, the thriftiest one."""

from .battery import BatteryDrive, battery_profile
from .bounds.grip import Grip
from .bounds.limits import Window
from .bounds.parts import Arrival, BatteryPower, Comfort, FrictionBrakes, Jerk, Lateral, Motors, Posted, SpeedCap, Stop
from .bounds.rules import DriveRules
from .bounds.speed_limits import SpeedLimits
from .driving.horizon import HorizonSpeed, SpeedPlanner
from .fastest.forward_backward import fastest_profile, scaled_profile
from .methods import METHODS, SpeedMethod, plan_speed
from .result import Front, SpeedProfile
from .thriftiest.eco import EcoSolver, eco_profile

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
