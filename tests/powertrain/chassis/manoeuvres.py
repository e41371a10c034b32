"""Steering signals and figures of merit for the manoeuvres of `crvm_reference`: step steer, lane change, double lane change."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Signal = Callable[[float], float]


@dataclass(frozen=True)
class StepFigures:
    """A step response: final value; half and peak time in s from the start of the step, rise time from 10 to 90 %; overshoot as a share.

    Without an overshoot of at least 0.1 % there is no peak and its time is NaN.
    """

    final: float
    half_time: float
    rise_time: float
    peak_time: float
    overshoot: float


def step(amplitude: float, start: float = 0.1, ramp: float = 0.1) -> Signal:
    """Ramp step of the steering angle (ISO 7401 asks for at most 0.15 s)."""
    return lambda t: amplitude * min(max((t - start) / ramp, 0.0), 1.0)


def single_sine(amplitude: float, frequency: float = 0.5, start: float = 0.1) -> Signal:
    """One period of a sine: a lane change to one side."""
    return lambda t: float(amplitude * np.sin(2.0 * np.pi * frequency * (t - start))) if start <= t <= start + 1.0 / frequency else 0.0


def double_sine(amplitude: float, frequency: float = 0.5, start: float = 0.1, gap: float = 1.0) -> Signal:
    """A period to one side, a pause, a period back: a double lane change."""
    there, back = single_sine(amplitude, frequency, start), single_sine(-amplitude, frequency, start + 1.0 / frequency + gap)
    return lambda t: there(t) + back(t)


def step_figures(time: Array, value: Array, start: float = 0.1) -> StepFigures:
    """Figures of a step response; the final value is the mean of the record's last tenth."""
    final = float(np.mean(value[-max(1, len(value) // 10) :]))
    share = value / final
    peak = int(np.argmax(share))
    over = float(share[peak]) - 1.0
    tenth, half, nine = (_crossing(time, share, level) for level in (0.1, 0.5, 0.9))
    return StepFigures(final, half - start, nine - tenth, float(time[peak]) - start if over > 1e-3 else float("nan"), max(over, 0.0))


def _crossing(time: Array, share: Array, level: float) -> float:
    """Time at which `share` first reaches `level`, between samples."""
    k = max(1, int(np.argmax(share >= level)))
    return float(np.interp(level, share[k - 1 : k + 1], time[k - 1 : k + 1]))
