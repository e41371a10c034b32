"""What an identification refuses: records that contradict each other, and cells that do not meet them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
import numpy as np

from ...errors import VehicleError
from ..cell import Cell, dump_cell

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .records import DynamicTest, OcvTest, Script
    from .report import Score

#: Share of the capacity by which sampled current and charge counter may differ; in the public A123 tests it is at most 1.2 %.
_COUNTED = 0.03
#: How far a dynamic test may leave the voltages of the slow tests, V; smallest span of a voltage that was measured at all, V.
_BEYOND, _SPAN = 0.7, 1e-3
#: Largest RMSE over the very tests with which a cell is returned, V.
_WORST = 0.1


def _scripts(test: OcvTest | DynamicTest) -> list[Script]:
    names = ("discharge", "empty", "charge", "full", "drive")
    return [script for name in names if (script := getattr(test, name, None)) is not None]


def check_records(ocv_tests: Sequence[OcvTest], dynamic_tests: Sequence[DynamicTest]) -> None:
    """Refuse dead channels and voltages of another cell.

    Raises:
        VehicleError: a slow or dynamic script whose current is zero throughout or whose voltage is constant, a dynamic script that leaves the
            voltages of the slow tests by more than 0.7 V.
    """
    slow = [script for test in ocv_tests for script in (test.discharge, test.charge)]
    drives = [test.drive for test in dynamic_tests]
    for script in (*slow, *drives):
        if not np.any(script.current):
            raise VehicleError(f"{script.source}: current is zero throughout, expected the current of a test")
        if np.ptp(script.voltage) < _SPAN:
            raise VehicleError(f"{script.source}: voltage is {script.voltage[0]:g} V throughout, expected the voltage of a test")
    low, high = min(float(np.min(s.voltage)) for s in slow), max(float(np.max(s.voltage)) for s in slow)
    for script in drives:
        for found in (float(np.min(script.voltage)), float(np.max(script.voltage))):
            if not low - _BEYOND <= found <= high + _BEYOND:
                expected = f"at most {_BEYOND:g} V outside the slow tests' {low:.3f} to {high:.3f} V"
                raise VehicleError(f"{script.source}: voltage reaches {found:g} V, expected {expected}")


def check_counters(ocv_tests: Sequence[OcvTest], dynamic_tests: Sequence[DynamicTest], capacity: float) -> None:
    """Refuse scripts whose current does not carry the charge that was counted: another unit, sign or scale.

    Args:
        ocv_tests: slow tests.
        dynamic_tests: dynamic tests.
        capacity: of the cell, A s.

    Raises:
        VehicleError: integral and counter differ by more than 3 % of the capacity.
    """
    for test in (*ocv_tests, *dynamic_tests):
        for script in _scripts(test):
            carried, (into, out) = float(np.sum(script.current[:-1] * np.diff(script.time))), script.moved
            if not abs(carried - (out - into)) <= _COUNTED * capacity:
                found = f"the sampled current carries {carried / 3600.0:.4g} Ah and the charge counter says {(out - into) / 3600.0:.4g} Ah"
                raise VehicleError(f"{script.source}: {found}, expected a difference of at most {100 * _COUNTED:g} % of {capacity / 3600.0:.4g} Ah")


def checked_cell(cell: Cell, scores: Sequence[Score]) -> Cell:
    """The cell with the worst of its scores as its voltage error.

    Raises:
        VehicleError: an error that is not finite or above 100 mV, a cell that would not load again.
    """
    for row in scores:
        if not row.rmse <= _WORST:
            found = f"the identified cell misses this very test by an RMSE of {1e3 * row.rmse:.4g} mV"
            raise VehicleError(f"{row.source}: {found}, expected at most {1e3 * _WORST:g} mV")
    worst = float(f"{max(row.rmse for row in scores):.5g}")
    cell = msgspec.structs.replace(cell, validity=msgspec.structs.replace(cell.validity, voltage_rmse_v=worst))
    try:
        again = msgspec.toml.decode(dump_cell(cell), type=Cell)
    except msgspec.ValidationError as error:
        raise VehicleError(f"{scores[0].source}: the identified cell could not be loaded again: {str(error).replace('`', '')}") from None
    if again != cell:
        raise VehicleError(f"{scores[0].source}: the identified cell is another one after writing and reading, expected the same")
    return cell
