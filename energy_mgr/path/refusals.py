"""What is refused before anything is solved, with the place and the reason: so that every road ends in bounded time and memory."""

from __future__ import annotations

from typing import TYPE_CHECKING

from roads.border_line import refuse_turning_back

from ..errors import InfeasibleError, PlanningError

if TYPE_CHECKING:
    from roads import Corridor

#: A corridor must leave the path at least this width, m.
LEAST_WIDTH = 2e-3
#: Shortest and longest road that is planned, m: no car fits on a shorter one; the longest takes minutes and some gigabytes.
SHORTEST, LONGEST = 1.0, 2e6


def refuse_road(corridor: Corridor) -> None:
    """Refuse a corridor of a length that nobody drives at one go, or about a line that turns back on itself.

    Raises:
        PlanningError: shorter than a metre, or longer than 2000 km.
        RoadError: the line turns on the spot; the station and the place are named.
    """
    length = corridor.reference.length
    if not SHORTEST <= length <= LONGEST:
        expected = f"{SHORTEST:g} m to {LONGEST / 1000.0:g} km"
        raise PlanningError(f"{corridor.name}: {length:.3g} m long, expected a road of {expected}; is the file in metres?")
    refuse_turning_back(corridor)


def refuse_narrow(corridor: Corridor) -> None:
    """Raise InfeasibleError where the corridor leaves no width to a path."""
    s, width = corridor.narrowest()
    if width < LEAST_WIDTH:
        right, left = corridor.borders(s)
        oblique = " (the borders are oblique there)" if float(left - right) > 2 * corridor.margin else ""
        raise InfeasibleError(
            f"{corridor.name}: the corridor is narrower than the car with its margins at s = {s:z.1f} m: "
            f"{float(left - right):z.2f} m wide, needs {2 * corridor.margin + LEAST_WIDTH - min(width, 0.0) * bool(oblique):z.2f} m{oblique}"
        )
