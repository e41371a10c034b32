"""Standard driving cycles: speed over time, as their regulations state it.

    cycle = roads.cycles.load("wltc_3b")
    cycle.t, cycle.v, cycle.distance

Each file beside this module holds one cycle at 1 Hz, with its regulation. FTP-75 leaves out the pause with the engine off. Where copies of the
regulation disagree on the last braking of ECE 15 (35 km/h held while the clutch is pressed, or not), the reading closer to the stated length is
taken.
"""

from .cycle import Cycle, load, names

__all__ = ["Cycle", "load", "names"]
