"""The trajectory lambda(s): where to be and how fast, over stations; between them, and in files."""

from .files import write_csv, write_path_table
from .pieces import TrajectoryPoint
from .trajectory import Trajectory

__all__ = ["Trajectory", "TrajectoryPoint", "write_csv", "write_path_table"]
