from .double_track import DoubleTrack as DoubleTrack
from .machine import Machine as Machine
from .quarter_car import QuarterCar as QuarterCar
from .single_track import SingleTrack as SingleTrack

__all__ = ["DoubleTrack", "Machine", "QuarterCar", "SingleTrack"]
