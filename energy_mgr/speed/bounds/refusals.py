"""Why a road cannot be driven within its limits: which one, where, by how much."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...errors import InfeasibleError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .speed_limits import SpeedLimits

    Floats = NDArray[np.float64]

#: Below this fraction of the bound a station counts as one that the car does not reach or pass.
_STANDSTILL = 1e-3


def refuse_standstill(limits: SpeedLimits, energy: Floats) -> None:
    """Inner stations where the fastest profile halts, stop lines apart, are places that the car cannot pass.

    Raises:
        InfeasibleError: the first on a climb, or the last on a descent that the car cannot hold; with the force that is missing.
    """
    bound = limits.energy_max
    halted = (energy <= _STANDSTILL**2 * bound) & (bound > 0.0)
    if not limits.closed:
        halted[[0, -1]] = False
    if not np.any(halted):
        return
    stations = np.flatnonzero(halted)
    # the interval that leads to the first halt going forward, and from the last one going backward; on circuits the steepest ones
    up = int(np.argmax(limits.slope)) if limits.closed else int(stations[0]) - 1
    down = int(np.argmin(limits.slope)) if limits.closed else min(int(stations[-1]), len(limits.ds) - 1)
    rest = np.zeros(len(limits.ds))
    mass = limits.vehicle.effective_mass
    for sign, at, what in ((1, up, "climb"), (-1, down, "hold back on")):
        missing = -float(limits.ceiling(rest, sign)[at]) * mass
        if missing > 0.0:
            needs = sign * float(limits.resistance(rest, sign)[at])
            raise InfeasibleError(
                f"{limits.name}: {limits.vehicle.name} cannot {what} the slope of {100 * limits.slope_against(sign)[at]:.1f} % "
                f"at s = {limits.s[at]:.1f} m: "
                f"it needs {needs:.0f} N, {_weakest(limits, sign, at, rest)} gives {needs - missing:.0f} N, {missing:.0f} N are missing"
            )
    _refuse_at_speed(limits, stations)


def _refuse_at_speed(limits: SpeedLimits, stations: NDArray[np.intp]) -> None:
    """Raise InfeasibleError for a force that suffices at rest and nowhere above it."""
    at = min(int(stations[0]), len(limits.ds) - 1)
    speed = np.full(len(limits.ds), 1.0)
    mass = limits.vehicle.effective_mass
    short = {sign: -float(limits.ceiling(speed, sign)[at]) * mass for sign in (1, -1)}
    sign = 1 if short[1] >= short[-1] else -1
    where = f"{limits.name}: {limits.vehicle.name} comes to a halt at s = {limits.s[at]:.1f} m and cannot go on within its limits"
    if short[sign] <= 0.0:
        raise InfeasibleError(where)
    needs = sign * float(limits.resistance(speed, sign)[at])
    raise InfeasibleError(
        f"{where}: already at 1 m/s it needs {needs:.0f} N to {'drive on' if sign > 0 else 'hold back'}, {_weakest(limits, sign, at, speed)} gives "
        f"{needs - short[sign]:.0f} N, {short[sign]:.0f} N are missing"
    )


def _weakest(limits: SpeedLimits, sign: int, at: int, rest: Floats) -> str:
    """Name of the force limit that gives least at speeds `rest` in interval `at`."""
    own = [limit for limit in limits.forces if limit.sign == sign]
    found = [(float(np.asarray(limit.ceiling(limits.vehicle, rest, limit.data))[at]), limit.name) for limit in own]
    return min(found)[1] if found else "nothing"


def refuse_ends(limits: SpeedLimits, energy: Floats) -> None:
    """Raise InfeasibleError where the fastest profile `energy` (v^2/2) is slower at an end than the speed asked for there."""
    if limits.closed:
        return
    for end, at in (("start", 0), ("end", -1)):
        asked, most = np.sqrt(2.0 * limits.energy_max[at]), np.sqrt(2.0 * energy[at])
        if asked > most + 1e-6 + 1e-6 * asked:
            reached = _touched(limits, energy, at)
            word, way = ("deceleration", "to") if at == 0 else ("acceleration", "from")
            raise InfeasibleError(
                f"{limits.name}: {end} speed {asked:.3f} m/s at s = {limits.s[at]:.1f} m is {asked - most:.3f} m/s too fast: within the {word} "
                f"allowed only {most:.3f} m/s lead {way} the limit `{limits.binding(reached)}` at s = {limits.s[reached]:.1f} m"
            )


def _touched(limits: SpeedLimits, energy: Floats, at: int) -> int:
    """The station nearest to an end where the profile touches its bound."""
    touching = np.flatnonzero(energy >= limits.energy_max * (1.0 - 1e-9))
    touching = touching[touching != (0 if at == 0 else len(energy) - 1)]
    if not len(touching):
        return len(energy) - 1 if at == 0 else 0
    return int(touching[0] if at == 0 else touching[-1])
