"""The horizon study (P3): what is lost by seeing only so far ahead."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from roads import PlanarCurve
from roads.geometry.cubic import PiecewiseCubic

from ...errors import SolverError

if TYPE_CHECKING:
    from .horizon import PathPlanner


def receding_path(planner: PathPlanner, advance: float | None = None) -> PlanarCurve:
    """The path that a car drives along an open road if it plans anew every `advance` metres; its parameter is the road's station.

    Args:
        planner: a planner that has not stepped yet.
        advance: m; by default half the horizon.

    Raises:
        SolverError: a step found no way on, or the road is a circuit, which has no end to drive to.
    """
    length = planner.road.length
    if planner.road.closed:
        raise SolverError(f"{planner.road.name}: a horizon study needs a road with an end, this is a circuit")
    advance = advance or 0.5 * planner.horizon
    breaks, coefficients = [], []
    stations = np.append(np.arange(0.0, length - 1e-6, advance), length)
    for s, following in pairwise(stations):
        step = planner.step(float(s))
        if step.pieces is None or step.clear_to < following - 1e-6:
            raise SolverError(f"{planner.road.name}: at s = {s:.1f} m: {step.status}, {step.reason}")
        # driven are the pieces from here to the next planning; what a later step does not change it joins at the same breaks
        low = 0 if s == 0.0 else int(np.searchsorted(step.pieces.breaks, breaks[-1] - 1e-6))
        high = len(step.pieces.breaks) - 1 if following == length else int(np.searchsorted(step.pieces.breaks, following, side="right"))
        breaks = breaks[:-1] + step.pieces.breaks[low : high + 1].tolist()
        coefficients.append(step.pieces.coefficients[:, :, low:high])
    return PlanarCurve.of_pieces(PiecewiseCubic(np.array(breaks), np.concatenate(coefficients, axis=2)))
