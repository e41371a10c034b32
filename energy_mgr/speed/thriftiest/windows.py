"""Windows of arrival: whether they can be met, what they are as deadlines, how much slower than the fastest a drive through them is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...errors import InfeasibleError
from ..checks import TIME_TOLERANCE, arrival_times, station_number
from .iterate import Deadline

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..bounds.speed_limits import SpeedLimits

    Floats = NDArray[np.float64]

#: How far inside its window a first guess passes, as a share of the least time to it.
_WITHIN = 0.02


def refuse_windows(limits: SpeedLimits, fastest: Floats, journey_time: float) -> None:
    """Refuse windows that even the fastest profile cannot meet.

    Raises:
        InfeasibleError: a window, or two of them, with station and by how much.
    """
    arrival = arrival_times(limits, fastest)
    before, before_t, before_words = 0, 0.0, "the start"
    for window in limits.windows:
        at = station_number(limits, window.s)
        least = before_t + float(arrival[at] - arrival[before])
        if least > window.latest + 1e-9:
            raise InfeasibleError(
                f"{limits.name}: the window at s = {window.s:g} m of the path ends at {window.latest:.2f} s, the earliest arrival from "
                f"{before_words} is {least:.2f} s, {least - window.latest:.2f} s too late"
            )
        if window.earliest > least:
            before, before_t, before_words = at, window.earliest, f"the window at s = {window.s:g} m"
    least = before_t + float(arrival[-1] - arrival[before])
    if least > journey_time * (1.0 + 1e-6) and before:
        raise InfeasibleError(
            f"{limits.name}: arrival after {journey_time:.2f} s cannot be met from {before_words}: the least possible time is {least:.2f} s, "
            f"{least - journey_time:.2f} s more"
        )


def window_deadlines(limits: SpeedLimits) -> list[Deadline]:
    """The windows as deadlines."""
    found: list[Deadline] = []
    for window in limits.windows:
        number = station_number(limits, window.s)
        # a window of no width has no inside; the check of times allows more than this
        ease = 0.25 * TIME_TOLERANCE if window.latest - window.earliest < 0.5 * TIME_TOLERANCE else 0.0
        if np.isfinite(window.latest):
            found.append(Deadline(number, window.latest + ease, 1))
        if window.earliest > 0.0:
            found.append(Deadline(number, window.earliest - ease, -1))
    return found


def shares_through(limits: SpeedLimits, v: Floats, factor: float) -> Floats:
    """(n,) share of the fastest v^2/2, with the fastest speeds `v`, to begin a search at: `factor`, and where a window opens late still less from the
    window before on.
    """
    fastest = arrival_times(limits, v)
    share, first, passed = np.full(len(limits.s), factor), 0, 0.0
    for window in limits.windows:
        last = station_number(limits, window.s)
        least = float(fastest[last] - fastest[first])
        late = min(max(passed + least / np.sqrt(factor), window.earliest + _WITHIN * least), max(window.latest - _WITHIN * least, passed + least))
        share[first : last + 1] = np.minimum(share[first : last + 1], (least / (late - passed)) ** 2)
        first, passed = last, late
    return share
