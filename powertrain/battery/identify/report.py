"""How well a cell meets a test, by charge range; nothing fitted here."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ..simulation import simulate
from ..tables import ZERO_CELSIUS

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from ..cell import Cell
    from ..simulation import CellRun
    from .records import DynamicTest

    Floats = NDArray[np.float64]
    #: From time since the profile's beginning (s) which samples count.
    Use = Callable[[Floats], NDArray[np.bool_]]

#: Edges of the ranges of charge that are reported one by one.
RANGES = (0.0, 0.05, 0.1, 0.2, 0.5, 0.9, 0.95, 1.0)


@dataclass(frozen=True)
class Score:
    """Voltage error of a cell over one dynamic test, open loop, V.

    Attributes:
        source: the test's name.
        temperature: K.
        rmse: over the whole script, both ends of charge included.
        rmse_inner: between 5 and 95 % of charge.
        mean: mean error (measured less model).
        spread: standard deviation of the error.
        worst: largest magnitude.
        by_range: RMSE between neighbouring `RANGES`; None where the test was not.
    """

    source: str
    temperature: float
    rmse: float
    rmse_inner: float
    mean: float
    spread: float
    worst: float
    by_range: tuple[float | None, ...]

    def __str__(self) -> str:
        ranges = "  ".join(
            f"{100 * a:.0f}-{100 * b:.0f} %: {1e3 * e:.1f}" for a, b, e in zip(RANGES[:-1], RANGES[1:], self.by_range, strict=True) if e is not None
        )
        return (
            f"{self.temperature - ZERO_CELSIUS:5.1f} degC  RMSE {1e3 * self.rmse:6.2f} mV  (5-95 %: {1e3 * self.rmse_inner:5.2f})  "
            f"mean {1e3 * self.mean:+.2f}  worst {1e3 * self.worst:.0f}  by charge in mV: {ranges}"
        )


def score(source: str, temperature: float, soc: Floats, error: Floats) -> Score:
    """A score from an error (V) over charge."""

    def rms(part: NDArray[np.bool_]) -> float | None:
        return float(np.sqrt(np.mean(error[part] ** 2))) if np.any(part) else None

    edges = [-1.0, *RANGES[1:-1], 2.0]
    ranges = tuple(rms((soc > a) & (soc <= b)) for a, b in pairwise(edges))
    inner = rms((soc > 0.05) & (soc < 0.95))
    whole = float(np.sqrt(np.mean(error**2)))
    mean, spread, worst = float(np.mean(error)), float(np.std(error)), float(np.max(np.abs(error)))
    return Score(source, temperature, whole, whole if inner is None else inner, mean, spread, worst, ranges)


def predict(cell: Cell, test: DynamicTest, *, counted: bool = True) -> CellRun:
    """The cell driven open loop with a test's current, from full and at rest.

    Args:
        cell: the cell; its own capacity and efficiency count the charge.
        test: the test; its voltage is not looked at.
        counted: keep the current's integral to the tester's charge counter; else the current as sampled.
    """
    drive = test.drive.aligned() if counted else test.drive
    return simulate(cell, drive.time, drive.current, test.temperature, 1.0)


def evaluate(cell: Cell, test: DynamicTest, *, counted: bool = True, use: Use | None = None) -> Score:
    """Score of `predict` against the measured voltage, over the whole script or over the samples that `use` picks."""
    run = predict(cell, test, counted=counted)
    picked = slice(None) if use is None else use(run.time - run.time[0])
    return score(test.drive.source, test.temperature, run.soc[picked], (test.drive.voltage - run.voltage)[picked])
