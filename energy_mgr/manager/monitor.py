"""Noticing by their answers that actuators do not do what they are told: dead or weak motors, stuck steering.

Every motor and every steering drive is compared with what its lag and its rate would have made of the commands. Where the answer stays away from that
for longer than noise or a lag would explain, the actuator is at fault: a motor has the share of its largest torque that it reports, a wheel is stuck
at its angle. Not noticed are a motor that gives too much, and one that is only asked for what it has. A
fault stays until `clear` is called: an actuator that failed once is not tried again on the road.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from powertrain.description.sections import Steering

from ..allocation import NO_FAULTS, Faults
from ..following.law import limited

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..allocation import Layout

#: Differences that count: share of what was asked of a motor, and least torque (Nm) to judge by; rad.
_WEAK, _TORQUE, _ANGLE = 0.3, 8.0, 0.012
#: A motor is judged while its torque moves slower than this share of its rate.
_SETTLED = 0.3
#: How long a difference must last, s.
_LASTS = 0.06
#: A stuck wheel stays within this much of where it is, rad per period.
_STILL = 2e-4


class Monitor:
    """Models of all drives beside what they report."""

    def __init__(self, layout: Layout, period: float) -> None:
        """For a car with `layout`, called every `period` seconds."""
        drive, steering = layout.vehicle.drive, layout.vehicle.need("steering", Steering)
        self._motors, self._steered = layout.motors, len(layout.steered)
        self._largest = max(drive.torque_max_nm, drive.regen_torque_max_nm)
        self._torque_gain, self._torque_step = min(period / drive.torque_lag_s, 1.0), drive.torque_rate_nmps * period
        self._angle_gain, self._angle_step = min(period / steering.lag_s, 1.0), steering.rate_max_radps * period
        self._patience = _LASTS / period
        self.faults = NO_FAULTS
        self.clear()

    def clear(self) -> None:
        """Believe all drives again."""
        self.faults = NO_FAULTS
        self._torques: list[float] = []
        self._angles: list[float] = []
        self._before: tuple[float, ...] = ()
        self._off = [0.0] * (self._motors + self._steered)
        self._shares = [1.0] * self._motors
        self._stuck: list[float | None] = [None] * self._steered
        self._brakes: tuple[float, ...] = ()

    def update(self, command: Sequence[float], torques: Sequence[float], angles: Sequence[float], brakes: Sequence[float]) -> Faults:
        """The faults, after `command` (in the order of the layout) was in force for a period and the drives report `torques` and `angles`."""
        brakes = tuple(brakes)
        changed = brakes != self._brakes
        if len(torques):
            changed |= self._judge_motors(command, torques)
        if len(angles):
            changed |= self._judge_steering(command, angles)
        if changed:
            self._brakes = brakes
            found = Faults(tuple(self._shares), self._brakes, tuple(self._stuck))
            self.faults = found if found.any else NO_FAULTS
        return self.faults

    def _judge_motors(self, command: Sequence[float], torques: Sequence[float]) -> bool:
        changed = False
        if not self._torques:
            self._torques = list(torques)
        models, off, gain, fastest = self._torques, self._off, self._torque_gain, self._torque_step
        for k, reported in enumerate(torques):
            step = gain * (command[k] - models[k])
            expected = models[k] = models[k] + limited(step, fastest)
            size = abs(expected)
            # while torque runs at its rate, how the drive rounds the corners is as large as a fault
            if (
                size - abs(reported) * (1.0 if reported * expected > 0.0 else -1.0) > _WEAK * size
                and size > _TORQUE
                and abs(step) < _SETTLED * fastest
                and self._shares[k] == 1.0
            ):
                off[k] += 1.0
                if off[k] > self._patience:
                    self._shares[k], changed = min(max(reported / math.copysign(self._largest, expected), 0.0), 0.99), True
            elif off[k]:
                off[k] -= 1.0
        return changed

    def _judge_steering(self, command: Sequence[float], angles: Sequence[float]) -> bool:
        changed, start = False, self._motors + 4
        if not self._angles:
            self._angles, self._before = list(angles), tuple(angles)
        models, off, gain, fastest = self._angles, self._off, self._angle_gain, self._angle_step
        for k, reported in enumerate(angles):
            expected = models[k] = models[k] + limited(gain * (command[start + k] - models[k]), fastest)
            at = self._motors + k
            if abs(expected - reported) > _ANGLE and abs(reported - self._before[k]) < _STILL and self._stuck[k] is None:
                off[at] += 1.0
                if off[at] > self._patience:
                    self._stuck[k], changed = reported, True
            elif off[at]:
                off[at] -= 1.0
        self._before = tuple(angles)
        return changed

    def snapshot(self) -> dict[str, Any]:
        """The memory, as plain data."""
        return {
            "torques": list(self._torques),
            "angles": list(self._angles),
            "before": list(self._before),
            "off": list(self._off),
            "shares": list(self._shares),
            "stuck": list(self._stuck),
            "brakes": self._brakes,
        }

    def restore(self, memory: dict[str, Any]) -> None:
        """Take up what `snapshot` gave."""
        self._torques, self._angles, self._before = list(memory["torques"]), list(memory["angles"]), tuple(memory["before"])
        self._off, self._shares, self._stuck = list(memory["off"]), list(memory["shares"]), list(memory["stuck"])
        self._brakes = tuple(memory["brakes"])
        found = Faults(tuple(self._shares), self._brakes, tuple(self._stuck))
        self.faults = found if found.any else NO_FAULTS
