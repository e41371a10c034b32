"""The speed that costs least energy for a given arrival time as a sequence of second-order cone programmes: a check on `eco` by other means.

A programme is linearised about the last profile (`cone_model`) and solved again until the energy on the true loss model no longer changes. Where no
power limit is near, that is known without another solve: if the linear model is right at the solution to a fraction of the energy, no other profile
can be better by more than that. The copper loss of field weakening is in no programme: a profile of a car with `drive.weakening` is checked and
counted with it, but not optimal for it (0.03 to 0.09 % above `nlp` where it weakens strongly).
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np

from powertrain import drive_energy
from powertrain.energy.balance import KWH, balance

from ...errors import InfeasibleError, PlanningError, SolverError
from ..bounds.forces import Power, Torque
from ..checks import TIME_TOLERANCE, arrival_times, check_profile, check_times
from ..fastest.forward_backward import fastest_profile, refuse_too_early, scaled_profile
from ..result import SpeedProfile
from .cone_model import ConeModel

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from ..bounds.speed_limits import SpeedLimits

    Floats = NDArray[np.float64]

#: An allowed time within this fraction of the least possible one leaves no choice: the fastest profile is the only one.
_NO_CHOICE = 1e-6
#: The sequence ends when the energy changes by less than this fraction of the energy that moves (sum of magnitudes of all components).
_TOLERANCE = 2e-6
_ITERATIONS = 60


def cone_profile(limits: SpeedLimits, journey_time: float, *, report: Callable[[str], None] | None = None) -> SpeedProfile:
    """The profile of least energy that arrives after `journey_time` in s, by Clarabel.

    Of the bounds on force it knows torque and power of the motors.

    Where arriving earlier costs less energy than crawling, the profile arrives earlier and its status is `solved early`.

    Args:
        limits: what bounds the speed.
        journey_time: allowed time, s.
        report: called with a line of progress per programme.

    Raises:
        InfeasibleError: the time is shorter than the least possible one, which is named; or the car cannot pass a slope.
        PlanningError: limits that are not written as cones here.
        SolverError: no profile that passes the checks was found.
    """
    started = time.perf_counter()
    _refuse_others(limits)
    fastest = fastest_profile(limits)
    refuse_too_early(limits.name, journey_time, fastest.journey_time)
    if journey_time <= fastest.journey_time * (1.0 + _NO_CHOICE):
        return SpeedProfile(limits.s, fastest.v, "solved", 0, 1e3 * (time.perf_counter() - started), method="socp")
    if report:
        report(f"speed: least energy over {len(limits.s)} stations")
    v, ceiling = _first_guess(limits, fastest, journey_time)
    cost, moved = _energy(limits, v)
    count, change, exact = 0, np.inf, False
    while (change > _TOLERANCE * moved or not exact) and count < _ITERATIONS:
        programme = ConeModel(limits, v, journey_time)
        v = programme.solve()
        count, exact = count + 1, programme.exact
        last, (cost, moved) = cost, _energy(limits, v)
        change = abs(last - cost) if _near_power_limit(limits, v) else min(abs(last - cost), programme.model_error(v))
        if report:
            report(f"speed: cone programme {count}, {cost / KWH:.6f} kWh")
    if change > _TOLERANCE * moved:
        raise SolverError(f"{limits.name}: the energy still changes by {change:.3g} J after {count} cone programmes")
    if cost > ceiling + 1e-4 * moved:
        raise SolverError(f"{limits.name}: the profile found takes {cost:.0f} J, more than the scaled one with {ceiling:.0f} J")
    check_profile(limits, v)
    check_times(limits, v, journey_time)
    duration = float(arrival_times(limits, v)[-1])
    status = "solved" if duration >= journey_time - TIME_TOLERANCE else "solved early"
    status = status if exact else "reduced accuracy"
    return SpeedProfile(limits.s, v, status, count, 1e3 * (time.perf_counter() - started), method="socp")


def _refuse_others(limits: SpeedLimits) -> None:
    other = [limit.name for limit in limits.forces if not isinstance(limit, Torque | Power)]
    other += ["friction brakes"] * (limits.brake > 0.0) + ["jerk"] * bool(np.isfinite(limits.jerk)) + ["windows"] * bool(limits.windows)
    other += ["stop lines"] * bool(np.any(limits.energy_max[1:-1] <= 0.0))
    if other:
        raise PlanningError(f"{limits.name}: method socp does not know {', '.join(sorted(set(other)))}; eco and nlp do")


def _first_guess(limits: SpeedLimits, fastest: SpeedProfile, journey_time: float) -> tuple[Floats, float]:
    """Speeds to linearise about and the energy that a solution must not exceed: the scaled profile, where there is one."""
    try:
        v = scaled_profile(limits, journey_time).v
    except InfeasibleError:
        return fastest.v, np.inf  # a slope that is only passed with momentum: no scaled profile arrives so late
    return v, _energy(limits, v)[0]


def _energy(limits: SpeedLimits, v: Floats) -> tuple[float, float]:
    """Energy on the true loss model, and the sum of the magnitudes of its components as a scale for it, J."""
    ledger = drive_energy(limits.vehicle, limits.s, v, limits.z)
    return ledger.total, sum(abs(part) for part in ledger.components.values())


def _near_power_limit(limits: SpeedLimits, v: Floats) -> bool:
    """Whether the motors come within 2 % of their power anywhere; that limit is linearised, so the profile may still move there."""
    drive = limits.vehicle.drive
    found = balance(limits.vehicle, limits.ds, v[:-1], v[1:], np.diff(limits.z))
    power = found.force * np.maximum(v[:-1], v[1:])
    return bool(np.max(power) > 0.98 * drive.motor_count * drive.power_max_w or -np.min(power) > 0.98 * drive.motor_count * drive.regen_power_max_w)
