"""The energy manager: what a controller calls once per period."""

from .guard import Trust
from .manager import EnergyManager
from .measurements import Measurements, WheelCommands
from .observers import DeadReckoning, Observer, PerfectState

__all__ = ["DeadReckoning", "EnergyManager", "Measurements", "Observer", "PerfectState", "Trust", "WheelCommands"]
