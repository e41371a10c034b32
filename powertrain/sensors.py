"""Sensors S1/R5: bias, white noise and latency on the 4 ms base clock, and a GNSS with delay, jitter and outages.

`Sensor` values are Table C.2 of the source. Its wheel accelerometers read their mounting tilt and gravity as bias; some signals have no noise
figures there and are passed on with their delay only.
"""

from __future__ import annotations

import heapq
from collections import deque
from typing import TYPE_CHECKING, NamedTuple

import msgspec
import numpy as np

from .description.sections import NotNegative, Positive
from .errors import VehicleError

if TYPE_CHECKING:
    from collections.abc import Mapping

#: s
BASE_CLOCK = 0.004


class Sensor(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What a sensor does to a value: bias and standard deviation in the value's unit, delay in s."""

    bias: float
    deviation: float
    delay_s: float

    def __post_init__(self) -> None:
        """Refuse numbers that describe no sensor.

        Raises:
            VehicleError: not finite, or a negative deviation or delay.
        """
        if not np.all(np.isfinite([self.bias, self.deviation, self.delay_s])) or self.deviation < 0.0 or self.delay_s < 0.0:
            raise VehicleError(f"{self}, expected finite numbers and neither deviation nor delay below zero")


#: Table C.2: inertial platform (`oxts`), optical speed sensor (`correvit`), per-wheel accelerometers, wheel travel, wheel speed. SI units.
TABLE_C2: dict[str, Sensor] = {
    "oxts_a_x": Sensor(-2.724418224663677e-1, 2.769240181700604e-2, 0.016),
    "oxts_a_y": Sensor(-1.638013449871428e-4, 3.138268966012002e-2, 0.016),
    "oxts_a_z": Sensor(-3.466036054923634e-3, 4.848351742705138e-2, 0.016),
    "oxts_v_x": Sensor(-1.183700305488312e-3, 1.214962752669004e-2, 0.016),
    "oxts_v_y": Sensor(4.671748052248540e-3, 7.316319010707994e-3, 0.016),
    "correvit_v_x": Sensor(3.877289277526296e-4, 6.842614450089170e-2, 0.024),
    "correvit_v_y": Sensor(-1.942064312033667e-2, 6.578393401372411e-2, 0.024),
    "wheel_a_x": Sensor(1.379990943683445, 4.937188165827279e-1, 0.004),
    "wheel_a_y": Sensor(-1.668700471533053, 4.840309242271431e-1, 0.004),
    "wheel_a_z": Sensor(9.064704725918237, 4.546746182918726e-1, 0.004),
    "wheel_travel": Sensor(3.372870728583747e-4, 6.585450722185397e-8, 0.004),
    "wheel_speed": Sensor(-4.197454752096141e-3, 3.718427530519079e-2, 0.004),
    "steering_speed": Sensor(0.0, 0.0, 0.004),
    "wheel_torque": Sensor(0.0, 0.0, 0.004),
    "steering_torque": Sensor(0.0, 0.0, 0.004),
    "steering_angle": Sensor(0.0, 0.0, 0.004),
}


class SensorBank:
    """Sensors that are sampled together, once per tick of the base clock."""

    def __init__(self, sensors: Mapping[str, Sensor], rng: np.random.Generator, *, clock_s: float = BASE_CLOCK) -> None:
        """A bank of `sensors` by name of the signal, its noise drawn from `rng`.

        Raises:
            VehicleError: a delay that is no multiple of the clock.
        """
        self._sensors, self._rng = dict(sensors), rng
        self._lines: dict[str, deque[float]] = {}
        for name, sensor in self._sensors.items():
            ticks = sensor.delay_s / clock_s
            if abs(ticks - round(ticks)) > 1e-6:
                raise VehicleError(f"sensor {name}: delay {sensor.delay_s} s, expected a multiple of the clock's {clock_s} s")
            self._lines[name] = deque([float("nan")] * round(ticks))
        self._bias = np.array([sensor.bias for sensor in self._sensors.values()])
        self._deviation = np.array([sensor.deviation for sensor in self._sensors.values()])

    def sample(self, truth: Mapping[str, float]) -> dict[str, float]:
        """What the sensors report at this tick, given the true values now; NaN until a delay has filled.

        Raises:
            VehicleError: a signal is missing.
        """
        missing = self._lines.keys() - truth.keys()
        if missing:
            raise VehicleError(f"no value for {', '.join(sorted(missing))}, expected one for each of {', '.join(self._lines)}")
        error = self._bias + self._deviation * self._rng.standard_normal(len(self._bias))
        report = {}
        for k, (name, line) in enumerate(self._lines.items()):
            line.append(float(truth[name]) + float(error[k]))
            report[name] = line.popleft()
        return report


class Fix(NamedTuple):
    """A position that a receiver reports: when it was true, when it arrived (s), where (m)."""

    time: float
    arrival: float
    x: float
    y: float


class GnssDescription(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A satellite receiver: fixes every `period_s`, late by `delay_s` plus an exponential jitter, none within `outages_s`."""

    period_s: Positive = 0.2
    delay_s: NotNegative = 0.2
    jitter_s: NotNegative = 0.0
    deviation_m: NotNegative = 0.02
    outages_s: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        """Refuse what is no receiver.

        Raises:
            VehicleError: a period that is not positive, another number below zero, or an outage that ends before it begins.
        """
        numbers = (self.delay_s, self.jitter_s, self.deviation_m)
        if not np.all(np.isfinite((self.period_s, *numbers))) or self.period_s <= 0.0 or min(numbers) < 0.0:
            raise VehicleError(f"{self}, expected a positive period and delay, jitter and deviation of at least zero")
        for start, end in self.outages_s:
            if not end > start:
                raise VehicleError(f"outage from {start} s to {end} s, expected it to end after it begins")


class Gnss:
    """A receiver in operation: fixes come late, and with jitter out of order."""

    def __init__(self, description: GnssDescription, rng: np.random.Generator) -> None:
        """A receiver whose noise and jitter are drawn from `rng`."""
        self._d, self._rng = description, rng
        self._taken = 0
        self._waiting: list[tuple[float, Fix]] = []

    def step(self, t: float, x: float, y: float) -> list[Fix]:
        """The fixes that arrived since the last call, given the true position at time `t` (s, not decreasing)."""
        d = self._d
        # compared in ticks of the period, so that rounding neither drops nor doubles a fix
        if t >= (self._taken - 1e-9) * d.period_s:
            self._taken = int(np.floor(t / d.period_s + 1e-9)) + 1
            noise = d.deviation_m * self._rng.standard_normal(2)
            late = d.delay_s + (self._rng.exponential(d.jitter_s) if d.jitter_s > 0.0 else 0.0)
            if not any(start <= t < end for start, end in d.outages_s):
                heapq.heappush(self._waiting, (t + late, Fix(t, t + late, x + float(noise[0]), y + float(noise[1]))))
        arrived = []
        while self._waiting and self._waiting[0][0] <= t + 1e-9:
            arrived.append(heapq.heappop(self._waiting)[1])
        return arrived
