"""The fastest profile (V1): limits by road, car and bends, then one pass forward for driving and one backward for recuperation.

Both passes work on v^2/2, in which constant acceleration is linear over way. Force limits are kept at both ends of every interval by solving for
the end that is sought (implicitly), not with the force of the known end.
"""

from __future__ import annotations

import time
from math import ceil, sqrt
from typing import TYPE_CHECKING

import numpy as np

from powertrain import driving_resistance, force_limits

from ..errors import InfeasibleError, SolverError
from .result import SpeedProfile
from .root import root

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .limits import SpeedLimits

    Floats = NDArray[np.float64]

#: Below this fraction of the bound an inner station counts as one that the car does not reach or pass.
_STANDSTILL = 1e-3
_SWEEPS = 300
#: Stands for the arrival time of a drive that never arrives, s.
_NEVER = 1e9
#: Root finding for the scaled profile ends at the first figure; a profile that misses its time by the second is none, s.
_TIME_ACCURACY, _TIME_TOLERANCE = 1e-9, 0.05


def fastest_profile(limits: SpeedLimits) -> SpeedProfile:
    """The profile that no other profile within the limits passes at any station.

    Raises:
        InfeasibleError: the motors cannot pull the car up a slope or hold it back; station and missing force are named.
    """
    started = time.perf_counter()
    energy = limits.energy_max
    shift = int(np.argmin(energy[:-1])) if limits.closed else 0
    if limits.closed:
        # start where the bound is lowest: the profile touches it there, if anywhere
        energy = np.append(np.roll(energy[:-1], -shift), energy[shift])
    slope = np.roll(np.diff(limits.z) / limits.ds, -shift)
    steepness, (up, down) = slope.tolist(), _sure_gains(limits, slope, energy)
    for _ in range(_SWEEPS):
        before = energy.copy()
        energy = _backward(limits, steepness, down, _forward(limits, steepness, up, energy))
        if limits.closed:
            energy[0] = energy[-1] = min(energy[0], energy[-1])
        if np.allclose(before, energy, rtol=1e-9, atol=1e-7):
            break
    else:
        raise SolverError(f"{limits.name}: the passes for the fastest profile still change it after {_SWEEPS} rounds")
    _refuse_standstill(limits, np.roll(energy[:-1], shift) if limits.closed else energy, np.roll(slope, shift))
    if limits.closed:
        energy = np.append(np.roll(energy[:-1], shift), np.roll(energy[:-1], shift)[0])
    milliseconds = 1e3 * (time.perf_counter() - started)
    return SpeedProfile(limits.s, np.sqrt(2.0 * energy), "solved", 1, milliseconds)


def scaled_profile(limits: SpeedLimits, journey_time: float) -> SpeedProfile:
    """The fastest profile under limits scaled by one factor such that it takes `journey_time` in s (V2).

    Raises:
        InfeasibleError: the time is too short; the least possible time is named.
    """
    started = time.perf_counter()
    best = fastest_profile(limits)
    refuse_too_early(limits.name, journey_time, best.journey_time)
    count = 1

    def late(factor: float) -> float:
        nonlocal count
        count += 1
        try:
            return fastest_profile(limits.scaled(factor)).journey_time - journey_time
        except (InfeasibleError, SolverError):
            return _NEVER

    factor, low = 1.0, 1.0
    if best.journey_time < journey_time:
        while late(low) < 0.0:
            low *= 0.5
        factor = root(late, low, min(2.0 * low, 1.0), _TIME_ACCURACY)
    if abs(late(factor)) > _TIME_TOLERANCE:
        raise InfeasibleError(f"{limits.name}: no common scale of speed and acceleration arrives after {journey_time:.2f} s: a slope needs momentum")
    profile = fastest_profile(limits.scaled(factor))
    milliseconds = 1e3 * (time.perf_counter() - started)
    return SpeedProfile(profile.s, profile.v, "solved", count, milliseconds, factor)


def refuse_too_early(name: str, journey_time: float, least: float) -> None:
    """Raise InfeasibleError if `journey_time` (s) is below the `least` possible one, which the message names, rounded up to be asked for."""
    if journey_time < least * (1.0 - 1e-6):
        possible = ceil(100.0 * least) / 100.0
        raise InfeasibleError(f"{name}: arrival after {journey_time:.2f} s cannot be met: the least possible time is {possible:.2f} s")


def _sure_gains(limits: SpeedLimits, slope: Floats, energy: Floats) -> tuple[list[float], list[float]]:
    """Per interval, the rise of v^2/2 forward and backward that the motors can give at any speed up to the bound; most need no closer look."""
    vehicle = limits.vehicle
    fastest = np.sqrt(2.0 * np.maximum(energy[1:], energy[:-1]))
    drive, regen = force_limits(vehicle, fastest)
    per_force = limits.ds / vehicle.effective_mass
    up = per_force * (drive - driving_resistance(vehicle, fastest, slope))
    down = per_force * (regen + driving_resistance(vehicle, 0.0 * fastest, slope))
    return up.tolist(), down.tolist()


def _forward(limits: SpeedLimits, slope: list[float], sure: list[float], bound: Floats) -> Floats:
    """Lower the bound so that driving forces and accelerations suffice."""
    energy, gain = bound.tolist(), limits.acceleration * limits.ds
    for i, surely in enumerate(sure):
        if energy[i + 1] > energy[i] + gain:
            energy[i + 1] = energy[i] + gain
        if energy[i + 1] > energy[i] + surely:
            energy[i + 1] = _reachable(limits, slope[i], energy[i], energy[i + 1])
    return np.array(energy)


def _backward(limits: SpeedLimits, slope: list[float], sure: list[float], bound: Floats) -> Floats:
    """Lower the bound so that recuperating forces and decelerations suffice."""
    energy, gain = bound.tolist(), limits.deceleration * limits.ds
    for i in range(len(sure) - 1, -1, -1):
        if energy[i] > energy[i + 1] + gain:
            energy[i] = energy[i + 1] + gain
        if energy[i] > energy[i + 1] + sure[i]:
            energy[i] = _stoppable(limits, slope[i], energy[i + 1], energy[i])
    return np.array(energy)


def _surplus(limits: SpeedLimits, slope: float, energy: float) -> tuple[float, float]:
    """Acceleration and deceleration that the motors can give at v^2/2 = `energy`, m/s^2; negative where they cannot hold the speed."""
    v = sqrt(2.0 * energy)
    drive, regen = force_limits(limits.vehicle, v)
    resistance = driving_resistance(limits.vehicle, v, slope)
    mass = limits.vehicle.effective_mass
    return float(drive - resistance) / mass, float(regen + resistance) / mass


def _reachable(limits: SpeedLimits, slope: float, start: float, wanted: float) -> float:
    """The largest v^2/2 at the end of an interval, up to `wanted`, that the driving force allows from `start`."""
    at_start = _surplus(limits, slope, start)[0]
    least = start + limits.ds * at_start
    if at_start <= 0.0 or wanted <= start:
        return max(min(least, wanted), 0.0)

    def excess(end: float) -> float:
        return end - start - limits.ds * _surplus(limits, slope, end)[0]

    return wanted if excess(wanted) <= 0.0 else root(excess, start, wanted, 1e-9)


def _stoppable(limits: SpeedLimits, slope: float, end: float, wanted: float) -> float:
    """The largest v^2/2 at the start of an interval, up to `wanted`, from which the recuperating force comes down to `end`."""
    at_end = _surplus(limits, slope, end)[1]

    def excess(start: float) -> float:
        return start - end - limits.ds * min(_surplus(limits, slope, start)[1], at_end)

    if excess(wanted) <= 0.0:
        return wanted
    return root(excess, 0.0, wanted, 1e-9) if excess(0.0) < 0.0 else 0.0


def _refuse_standstill(limits: SpeedLimits, energy: Floats, slope: Floats) -> None:
    """Inner stations where the profile halts are places that the car cannot pass: name the first, or the last on a descent it cannot hold."""
    halted = energy <= _STANDSTILL**2 * 0.5 * limits.v_max[: len(energy)] ** 2
    if not limits.closed:
        halted[[0, -1]] = False
    if not np.any(halted):
        return
    stations = np.flatnonzero(halted)
    drive, regen = (float(force) for force in force_limits(limits.vehicle, 0.0))
    name, vehicle = limits.name, limits.vehicle.name
    # the interval that leads to the first halt going forward, and from the last one going backward; on circuits the steepest ones
    up = int(np.argmax(slope)) if limits.closed else int(stations[0]) - 1
    down = int(np.argmin(slope)) if limits.closed else int(stations[-1])
    climb, hold = (float(driving_resistance(limits.vehicle, 0.0, slope[at])) for at in (up, down))
    if climb > drive:
        what, at, needs, has = "climb", up, climb, drive
    elif -hold > regen:
        what, at, needs, has = "hold back on", down, -hold, regen
    else:
        raise InfeasibleError(f"{name}: {vehicle} comes to a halt at s = {limits.s[stations[0]]:.1f} m and cannot go on within its limits")
    raise InfeasibleError(
        f"{name}: {vehicle} cannot {what} the slope of {100 * slope[at]:.1f} % at s = {limits.s[at]:.1f} m: "
        f"it needs {needs:.0f} N, the motors give {has:.0f} N, {needs - has:.0f} N are missing"
    )
