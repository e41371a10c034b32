"""A virtual laboratory: the test procedure, run on anything that answers a current with a voltage, gives the same records as a cycler does.

So `identify` works on a cell model of another kind (an electrochemical one, say) as on files. Procedure per temperature, always from a full
cell at rest: slow discharge (capacity), slow discharge followed by slow charge (open-circuit voltage both ways), and a profile of pulses and
stop-and-go until the cell is empty.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np

from ...errors import VehicleError
from ..tables import ZERO_CELSIUS
from .records import DynamicTest, OcvTest, Script

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


class BenchCell(Protocol):
    """A cell on the bench."""

    def run(self, time: Floats, current: Floats, temperature: float) -> Floats:
        """Terminal voltage in V of a full, rested cell at `temperature` (K) that follows `current` (A, positive on discharge, held over a step).

        One value per sample; fewer if the cell switches off at one of its voltage limits before the end.
        """
        ...


def slow_test(bench: BenchCell, capacity_ah: float, temperature: float, *, hours: float = 20.0, step: float = 30.0) -> OcvTest:
    """Slow discharge and charge.

    Args:
        bench: the cell.
        capacity_ah: about what it holds, Ah.
        temperature: K.
        hours: for a full discharge.
        step: between samples, s.

    Raises:
        VehicleError: a cell that does not end a discharge of 1.5 times its capacity.
    """
    current = capacity_ah / hours
    settle = int(np.ceil(600.0 / step))
    count = int(1.5 * 3600.0 * hours / step)
    down = np.concatenate([np.zeros(settle), np.full(count, current)])
    voltage = _run(bench, down, step, temperature)
    if len(voltage) == len(down):
        raise VehicleError(f"virtual lab: cell of {capacity_ah:g} Ah not empty after 1.5 times that charge, expected it to end at its lowest voltage")
    turn = len(voltage)
    both = np.concatenate([down[: turn - 1], np.zeros(2 * settle), np.full(count, -current)])
    there = _run(bench, both, step, temperature)
    back = slice(turn - 1, len(there))
    discharge = _script(f"virtual slow discharge at {temperature - ZERO_CELSIUS:g} degC", down[:turn], voltage, step)
    charge = _script(f"virtual slow charge at {temperature - ZERO_CELSIUS:g} degC", both[back], there[back], step)
    return OcvTest(temperature, discharge=discharge, charge=charge)


def dynamic_test(bench: BenchCell, capacity_ah: float, temperature: float, *, seed: int = 1, hours: float = 6.0) -> DynamicTest:
    """Pulses, rests and stop-and-go from full to empty; the same profile for the same seed.

    Args:
        bench: the cell.
        capacity_ah: about what it holds, Ah.
        temperature: K.
        seed: of the profile.
        hours: the longest it may take.
    """
    current = capacity_ah * profile(np.random.default_rng(seed), hours)
    voltage = _run(bench, current, 1.0, temperature)
    return DynamicTest(temperature, drive=_script(f"virtual profile at {temperature - ZERO_CELSIUS:g} degC", current[: len(voltage)], voltage, 1.0))


def profile(rng: np.random.Generator, hours: float) -> Floats:
    """Current at 1 Hz as a share of 1 C: rests, pulses both ways, stop-and-go, steady discharge; net discharge about 0.4 C.

    Discharge pulses reach 5 C above 30 % of charge, else 2 C; charge pulses 5 C below 85 %, else 2 C. The first tenth is taken out steadily, so
    that a full cell is not charged.

    Args:
        rng: where the stop-and-go comes from.
        hours: length.
    """
    parts, length, soc = [np.zeros(60), np.full(600, 0.6), np.zeros(300)], 960, 0.9
    while length < 3600.0 * hours:
        pulses = [_pulse_pair(level, soc) for level in (5.0, rng.choice([0.5, 1.0, 2.0, 3.0]))]
        levels = np.clip(rng.normal(0.45, 0.9, 40), -1.4, 3.0)
        traffic = np.repeat(levels, rng.integers(3, 12, 40))
        steady = np.full(int(rng.integers(60, 180)), 0.8)
        block = np.concatenate([*pulses, traffic, steady, np.zeros(int(rng.choice([20, 60, 300])))])
        parts.append(block)
        length += len(block)
        soc -= float(np.sum(block)) / 3600.0
    return np.concatenate(parts)


def _pulse_pair(level: float, soc: float) -> Floats:
    """Ten seconds of discharge and of charge with rests, at `level` C or what the charge state allows."""
    out, back = min(level, 5.0 if soc > 0.3 else 2.0), -min(level, 5.0 if soc < 0.85 else 2.0)
    return np.concatenate([np.full(10, out), np.zeros(30), np.full(10, back), np.zeros(30)])


def laboratory(
    bench: BenchCell, capacity_ah: float, temperatures: Sequence[float], *, seed: int = 1, hours: float = 6.0
) -> tuple[list[OcvTest], list[DynamicTest]]:
    """Both tests at every temperature (K), for `identify`."""
    slow = [slow_test(bench, capacity_ah, temperature) for temperature in temperatures]
    return slow, [dynamic_test(bench, capacity_ah, temperature, seed=seed, hours=hours) for temperature in temperatures]


def _run(bench: BenchCell, current: Floats, step: float, temperature: float) -> Floats:
    voltage = np.asarray(bench.run(_clock(len(current), step), current, temperature), dtype=np.float64)
    if voltage.ndim != 1 or not 2 <= len(voltage) <= len(current) or not np.all(np.isfinite(voltage)):
        raise VehicleError(f"virtual lab: run() gave voltages of shape {voltage.shape}, expected 2 to {len(current)} finite values")
    return voltage


def _script(source: str, current: Floats, voltage: Floats, step: float) -> Script:
    moved = np.concatenate([[0.0], np.cumsum(current[:-1] * step)])
    into = np.concatenate([[0.0], np.cumsum(np.maximum(-current[:-1], 0.0) * step)])
    return Script(source, _clock(len(current), step), current, voltage, into, moved + into)


def _clock(count: int, step: float) -> Floats:
    return np.arange(count, dtype=np.float64) * step
