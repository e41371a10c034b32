"""How fast to drive a path: limits, the fastest profile, the thriftiest one."""

from .eco import eco_profile
from .forward_backward import fastest_profile, scaled_profile
from .limits import SpeedLimits
from .result import SpeedProfile

__all__ = ["SpeedLimits", "SpeedProfile", "eco_profile", "fastest_profile", "scaled_profile"]
