"""All methods for the speed behind one call."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from ..errors import PlanningError
from .checks import check_profile
from .fastest.forward_backward import fastest_profile, scaled_profile
from .thriftiest.eco import EcoSolver

if TYPE_CHECKING:
    from .bounds.speed_limits import SpeedLimits
    from .result import SpeedProfile

#: Names of the methods. The first two know no energy; the others need an arrival time (`eco` and `dp` also take a price of time).
SpeedMethod = Literal["forward-backward", "toppra", "eco", "socp", "dp", "nlp"]
METHODS: tuple[SpeedMethod, ...] = get_args(SpeedMethod)


def plan_speed(limits: SpeedLimits, method: SpeedMethod = "eco", *, journey_time: float | None = None, price: float | None = None) -> SpeedProfile:
    """The speed along a path.

    Args:
        limits: what bounds it.
        method: `forward-backward` (V1; with a journey time scaled to it, V2), `toppra` (time-optimal, the library), `eco` (least energy), `socp` (the
            same by cone programmes), `dp` (the same by dynamic programming on a grid), `nlp` (the same by IPOPT).
        journey_time: allowed time, s; None: the least possible.
        price: of time, W, instead (`eco`, `dp`).

    Raises:
        InfeasibleError: no profile within the limits; which one, where, by how much.
        SolverError: none was found.
        PlanningError: arguments that the method does not take, limits that it does not know.
    """
    if method not in METHODS:
        raise PlanningError(f"speed method {method!r}, expected one of {', '.join(METHODS)}")
    if price is not None and (method not in ("eco", "dp") or journey_time is not None):
        raise PlanningError(f"method {method} with price {price:g} W and time {journey_time}, expected a price alone, with eco or dp")
    if method == "forward-backward" and (np.isfinite(limits.jerk) or limits.windows):
        raise PlanningError(f"{limits.name}: method forward-backward knows no limit of jerk and no windows; eco and nlp do")
    profile = _made(limits, method, journey_time, price)
    check_profile(limits, profile.v, profile.brake)
    return profile


def _made(limits: SpeedLimits, method: SpeedMethod, journey_time: float | None, price: float | None) -> SpeedProfile:
    if method == "toppra":
        if journey_time is not None:
            raise PlanningError(f"method toppra with time {journey_time:g} s, expected none: it finds the least time; eco keeps an arrival time")
        from .fastest.time_optimal import toppra_profile

        return toppra_profile(limits)
    if price is None and journey_time is None:
        knows_more = np.isfinite(limits.jerk) or bool(limits.windows)
        return EcoSolver(limits).earliest() if knows_more else fastest_profile(limits)
    if method == "forward-backward":
        return scaled_profile(limits, _given(journey_time))
    return _least_energy(limits, method, journey_time, price)


def _least_energy(limits: SpeedLimits, method: SpeedMethod, journey_time: float | None, price: float | None) -> SpeedProfile:
    if method == "dp":
        from .comparison.dp import dp_profile

        return dp_profile(limits, journey_time, price=price)
    if method == "eco":
        from .thriftiest.eco import eco_profile

        return eco_profile(limits, journey_time, price=price)
    if method == "socp":
        from .comparison.cone_eco import cone_profile

        return cone_profile(limits, _given(journey_time))
    from .comparison.nlp import nlp_profile

    return nlp_profile(limits, _given(journey_time))


def _given(journey_time: float | None) -> float:
    if journey_time is None:
        raise PlanningError("expected a journey time")
    return journey_time
