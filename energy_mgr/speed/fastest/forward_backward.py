"""The fastest profile (V1): limits by road, car and bends, then one pass forward for driving and one backward for braking.

Both passes work on v^2/2, in which constant acceleration is linear over way. Forces are kept at both ends of every interval by solving for the end
that is sought (implicitly), not with the force of the known end. A pass is the largest solution of

    e_{i+1} = min(bound_{i+1}, e_i + ds a_i,  e_i + ds A_i(e_i),  e_i + ds A_i(e_{i+1})),

A the acceleration that the forces leave. Newton's method on all stations at once: with A linearised, the recurrence is a scan (`scan`).
"""

from __future__ import annotations

import time
from math import ceil
from typing import TYPE_CHECKING

import numpy as np

from ...errors import InfeasibleError, PlanningError, SolverError
from ..bounds.limits import UNLIMITED
from ..bounds.refusals import refuse_ends, refuse_standstill
from ..result import SpeedProfile
from ..root import root
from .scan import affine_climb, climb

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from ..bounds.speed_limits import SpeedLimits

    Floats = NDArray[np.float64]

_SWEEPS, _NEWTON = 300, 120
#: Newton's method ends when v^2/2 changes by less than this, relative to its largest value.
_SETTLED = 1e-10
#: Stands for the arrival time of a drive that never arrives, s.
_NEVER = 1e9
#: Root finding for the scaled profile ends at the first figure; a profile that misses its time by the second is none, s.
_TIME_ACCURACY, _TIME_TOLERANCE = 1e-9, 0.05


def fastest_profile(limits: SpeedLimits) -> SpeedProfile:
    """The profile that no other profile within the limits passes at any station; jerk and windows are not looked at.

    Raises:
        InfeasibleError: the car cannot climb a slope or hold back on it, or the speeds at start and end cannot be had; with limit, station and
            by how much.
    """
    started = time.perf_counter()
    v = np.sqrt(2.0 * fastest_energy(limits))
    return SpeedProfile(limits.s, v, "solved", 1, 1e3 * (time.perf_counter() - started), brake=friction_braking(limits, v), method="forward-backward")


def fastest_energy(limits: SpeedLimits, *, ends: bool = True) -> Floats:
    """(n,) v^2/2 of the fastest profile; see there. Without `ends` the speeds at start and end may be lower than asked for."""
    energy = limits.energy_max
    shift = int(np.argmin(energy[:-1])) if limits.closed else 0
    if limits.closed:
        # start where the bound is lowest: the profile touches it there, if anywhere
        energy = np.append(np.roll(energy[:-1], -shift), energy[shift])
    ways = [_Way(limits, sign, shift) for sign in (1, -1)]
    for _ in range(_SWEEPS):
        before = energy
        energy = ways[0].passed(energy)
        energy = ways[1].passed(energy[::-1])[::-1]
        if limits.closed:
            energy = energy.copy()
            energy[0] = energy[-1] = min(energy[0], energy[-1])
        if np.max(np.abs(before - energy)) <= 1e-9 * np.max(energy) + 1e-12:
            break
    else:
        raise SolverError(f"{limits.name}: the passes for the fastest profile still change it after {_SWEEPS} rounds")
    if limits.closed:
        energy = np.roll(energy[:-1], shift)
        energy = np.append(energy, energy[0])
    refuse_standstill(limits, energy)
    if ends:
        refuse_ends(limits, energy)
    return energy


class _Way:
    """One direction of the pass: forward for driving (+1), backward for braking (-1), stations in the order of the pass."""

    def __init__(self, limits: SpeedLimits, sign: int, shift: int) -> None:
        self.limits, self._sign, self._shift = limits, sign, shift
        self.ds = self._turned(limits.ds)
        self._comfort = np.minimum(self._turned(limits.acceleration if sign > 0 else limits.deceleration), UNLIMITED) * self.ds
        self._scale = float(np.max(limits.energy_max))

    def _turned(self, values: Floats) -> Floats:
        """Values per interval in the order of the pass."""
        values = np.roll(values, -self._shift, axis=-1) if self._shift else values
        return values if self._sign > 0 else values[..., ::-1]

    def _back(self, values: Floats) -> Floats:
        """The inverse of `_turned`."""
        values = values if self._sign > 0 else values[..., ::-1]
        return np.roll(values, self._shift, axis=-1) if self._shift else values

    def surplus(self, energy: Floats) -> Floats:
        """Rise of v^2/2 over each interval that the forces leave at v^2/2 = `energy` (..., n-1)."""
        v = np.sqrt(2.0 * np.maximum(energy, 0.0))
        return self.ds * self._turned(self.limits.ceiling(self._back(v), self._sign))

    def passed(self, bound: Floats) -> Floats:
        """The bound (n,), lowered so that the forces suffice."""
        energy = climb(float(bound[0]), bound[1:], self._comfort)
        if not self.limits.forces:
            return energy
        least = np.min(self.surplus(np.array([energy[1:], energy[:-1]])), axis=0)
        if np.all(np.minimum(np.diff(energy), self._comfort) <= least + _SETTLED * self._scale):
            return energy
        change = np.inf
        for count in range(_NEWTON):
            last, energy = energy, self._step(bound, energy)
            if count >= _NEWTON // 4:
                energy = 0.5 * (last + energy)
            if count >= _NEWTON // 2:
                # a bound on force with a corner may make the steps swing about it: come down to it
                energy = np.minimum(last, energy)
            change = float(np.max(np.abs(energy - last)))
            if change <= _SETTLED * self._scale:
                return energy
        raise SolverError(f"{self.limits.name}: the fastest profile still changes by {np.sqrt(2.0 * change):.2g} m/s after {_NEWTON} Newton steps")

    def _step(self, bound: Floats, energy: Floats) -> Floats:
        """One step of Newton's method, as a scan."""
        known, sought = energy[:-1], energy[1:]
        (implicit, explicit), (by_sought, by_known) = self._linear(np.array([sought, known]))
        # e1 = e0 + A(e1): e1 (1 - A') = e0 + A - A' e1_last
        solved = 1.0 / np.maximum(1.0 - by_sought, 1e-3)
        factor, rise = solved, (implicit - by_sought * sought) * solved
        start = np.maximum(1.0 + by_known, 1e-9)
        other = known + explicit - start * known
        use_start = start * known + other < factor * known + rise
        factor, rise = np.where(use_start, start, factor), np.where(use_start, other, rise)
        comfort = self._comfort < factor * known + rise - known
        factor, rise = np.where(comfort, 1.0, factor), np.where(comfort, self._comfort, rise)
        return np.maximum(affine_climb(float(bound[0]), bound[1:], factor, rise), 0.0)

    def _linear(self, energy: Floats) -> tuple[Floats, Floats]:
        """`surplus` at `energy` (..., n-1) and its derivative, which is not positive but for rounding and corners."""
        width = 1e-6 * self._scale
        low = np.maximum(energy - width, 0.0)
        high = low + 2.0 * width
        at_low, at_high = self.surplus(np.array([low, high]))
        by = (at_high - at_low) / (2.0 * width)
        return at_low + by * (energy - low), by


def friction_braking(limits: SpeedLimits, v: Floats) -> Floats | None:
    """(n-1,) force of the friction brakes that a profile needs beyond what recuperation takes, N; None where the limits have none."""
    if limits.brake <= 0.0:
        return None
    gain = np.diff(v**2) / (2.0 * limits.ds)
    brake = np.zeros_like(gain)
    for end in (v[:-1], v[1:]):
        force = limits.vehicle.effective_mass * gain + limits.resistance(end, -1)
        for limit in limits.forces:
            if limit.sign < 0 and limit.of == "motors":
                brake = np.maximum(brake, -force - limit.ceiling(limits.vehicle, end, limit.data))
    return brake


def scaled_profile(limits: SpeedLimits, journey_time: float) -> SpeedProfile:
    """The fastest profile under limits scaled by one factor such that it takes `journey_time` in s (V2); jerk and windows are not looked at.

    Raises:
        PlanningError: a time out of range.
        InfeasibleError: the time is too short; the least possible time is named.
    """
    started = time.perf_counter()
    if not 0.0 < journey_time < 1e7:
        raise PlanningError(f"{limits.name}: arrival time {journey_time} s, expected more than 0 and less than 1e7 s")
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

    factor = 1.0
    if best.journey_time < journey_time:
        factor = _factor(late)
    if abs(late(factor)) > _TIME_TOLERANCE:
        raise InfeasibleError(
            f"{limits.name}: no common scale of speed and acceleration arrives after {journey_time:.2f} s: a slope needs momentum; eco keeps it"
        )
    profile = fastest_profile(limits.scaled(factor))
    milliseconds = 1e3 * (time.perf_counter() - started)
    return SpeedProfile(profile.s, profile.v, "solved", count, milliseconds, scale=factor, brake=profile.brake, method="scaled")


def _factor(late: Callable[[float], float]) -> float:
    low = 0.5
    while late(low) < 0.0:
        low *= 0.5
    return root(late, low, 2.0 * low, _TIME_ACCURACY)


def refuse_too_early(name: str, journey_time: float, least: float) -> None:
    """Raise InfeasibleError if `journey_time` (s) is below the `least` possible one, which the message names, rounded up to be asked for."""
    if journey_time < least * (1.0 - 1e-6):
        possible = ceil(100.0 * least) / 100.0
        raise InfeasibleError(
            f"{name}: arrival after {journey_time:.2f} s cannot be met: the least possible time is {possible:.2f} s, "
            f"{possible - journey_time:.2f} s more"
        )
