"""`identify`: from cell tests to a cell, with a report of what was met how well."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...errors import VehicleError
from ..cell import Cell, CellLimits
from ..tables import ZERO_CELSIUS
from .assemble import build_cell
from .checks import check_counters, check_records, checked_cell
from .readers import sort_files
from .regression import Drive, Regression, Tables
from .report import Score, evaluate
from .slow import Branches, Charge, branches, charge_balances
from .structure import STRUCTURES, Structure

if TYPE_CHECKING:
    from collections.abc import Sequence
    from os import PathLike

    from .records import DynamicTest, OcvTest
    from .report import Use

#: Where the search for the hysteresis rate begins, and how many rows are enough for the search.
_RATE, _SEARCH_ROWS = 30.0, 6000
#: Typical of cylindrical and pouch cells; used, with a warning, where none is given. J/K per Ah.
_HEAT_PER_AH = 40.0


@dataclass(frozen=True, eq=False)
class Identified:
    """What an identification found.

    Attributes:
        cell: ready to use, to `dump_cell`.
        scores: the cell over the very tests it was identified on (in-sample), current kept to the tester's charge counter.
        sampled: likewise with the current as sampled: what a battery system without such a counter would see.
        charge: charge balances of the slow tests, then of the dynamic tests.
        slow: branches of the slow tests.
        time_constants: s.
        warnings: what to know before trusting the cell.
    """

    cell: Cell
    scores: tuple[Score, ...]
    sampled: tuple[Score, ...]
    charge: tuple[Charge, ...]
    slow: tuple[Branches, ...]
    time_constants: tuple[float, ...]
    warnings: tuple[str, ...]

    def __str__(self) -> str:
        lines = [f"{self.cell.name}: {self.cell.model}, {self.cell.capacity_ah:.4g} Ah, gamma {self.cell.hysteresis_rate:.3g}"]
        lines.append("time constants of the filters: " + ", ".join(f"{tau:.3g} s" for tau in self.time_constants))
        for balance in self.charge:
            warm = balance.temperature - ZERO_CELSIUS
            lines.append(f"{warm:5.1f} degC  coulombic efficiency {balance.efficiency:.4f}  capacity {balance.capacity / 3600.0:.4f} Ah")
        lines += ["over the tests it was identified on, current kept to the charge counter:", *map(str, self.scores)]
        raw = ", ".join(f"{1e3 * row.rmse:.2f} mV at {row.temperature - ZERO_CELSIUS:g} degC" for row in self.sampled)
        lines += [f"with the current as sampled, not kept to the counter: RMSE {raw}", *(f"warning: {text}" for text in self.warnings)]
        return "\n".join(lines)


def identify(
    ocv_tests: Sequence[OcvTest],
    dynamic_tests: Sequence[DynamicTest],
    *,
    name: str = "identified",
    source: str = "",
    model: str | Structure = "mesc",
    limits: CellLimits | None = None,
    heat_capacity_jpk: float | None = None,
    hysteresis_rate: float = _RATE,
    refine: bool = False,
    use: Use | None = None,
) -> Identified:
    """A cell from slow and dynamic tests at one or several temperatures.

    Args:
        ocv_tests: slow full discharges and charges, each at its temperature.
        dynamic_tests: dynamic profiles from full to empty; the cell covers their temperatures, Arrhenius curves lie between.
        name: of the cell.
        source: what its file says about its origin.
        model: a name out of `STRUCTURES`, or a structure.
        limits: of the cell; from the tests' extremes if not given.
        heat_capacity_jpk: of the cell; a typical one per capacity if not given.
        hysteresis_rate: gamma, where the search begins (or its value, without search).
        refine: search for poles and hysteresis rate (10 to 20 s); else those of the structure stay, which predict as well where they fit the cell.
        use: from the time (s) of a dynamic profile's samples which of them are fitted; the rest is left for a test of the cell.

    Raises:
        VehicleError: no tests, two at one temperature, an unknown model, charge balances that cannot be, records that contradict each other (see
            `checks`), a cell that misses its own tests by more than 100 mV or cannot be written and read.
    """
    structure = _structure(model)
    _check(ocv_tests, dynamic_tests)
    check_records(ocv_tests, dynamic_tests)
    slow_charge, drive_charge = charge_balances(ocv_tests), _drive_charge(ocv_tests, dynamic_tests)
    check_counters(ocv_tests, dynamic_tests, float(np.mean([balance.capacity for balance in drive_charge])))
    by_temperature = {balance.temperature: balance for balance in slow_charge}
    slow = [branches(test, by_temperature[test.temperature]) for test in sorted(ocv_tests, key=lambda test: test.temperature)]
    tests = sorted(dynamic_tests, key=lambda test: test.temperature)
    drives = [_drive(test, balance, use) for test, balance in zip(tests, drive_charge, strict=True)]
    found = _solve(drives, slow, structure, hysteresis_rate, refine)
    cell = build_cell(
        found, drives, structure, name=name, source=source, limits=limits or _limits(ocv_tests, dynamic_tests),
        heat_capacity=heat_capacity_jpk or _HEAT_PER_AH * drives[0].capacity / 3600.0,
    )  # fmt: skip
    scores = tuple(evaluate(cell, test) for test in tests)
    cell = checked_cell(cell, scores)
    sampled = tuple(evaluate(cell, test, counted=False) for test in tests)
    warnings = _warnings(slow_charge, drive_charge, drives, scores, known_heat=heat_capacity_jpk is not None, known_limits=limits is not None)
    return Identified(cell, scores, sampled, (*slow_charge, *drive_charge), tuple(slow), found.time_constants, tuple(warnings))


def from_files(
    files: Sequence[str | PathLike[str]], *, name: str = "identified", source: str = "", model: str | Structure = "mesc", refine: bool = False
) -> Identified:
    """A cell from test files, sorted by header and name (see `readers.label`); the rest as in `identify`.

    Raises:
        VehicleError: a file that is no test, a test that lacks a script, and what `identify` raises.
    """
    ocv, dynamic = sort_files(files)
    return identify(ocv, dynamic, name=name, source=source, model=model, refine=refine)


def _structure(model: str | Structure) -> Structure:
    if isinstance(model, Structure):
        return model
    if model not in STRUCTURES:
        raise VehicleError(f"model is {model!r}, expected one of {', '.join(STRUCTURES)}")
    return STRUCTURES[model]


def _check(ocv_tests: Sequence[OcvTest], dynamic_tests: Sequence[DynamicTest]) -> None:
    for kind, tests in (("slow", ocv_tests), ("dynamic", dynamic_tests)):
        if not tests:
            raise VehicleError(f"identification has no {kind} test, expected at least one")
        warmth = [test.temperature for test in tests]
        for t in warmth:
            if not 200.0 < t < 400.0:
                raise VehicleError(f"identification: {kind} test at {t:g} K, expected 200 to 400 K")
            if warmth.count(t) > 1:
                raise VehicleError(f"identification: {warmth.count(t)} {kind} tests at {t - ZERO_CELSIUS:g} degC, expected one per temperature")


def _drive_charge(ocv_tests: Sequence[OcvTest], dynamic_tests: Sequence[DynamicTest]) -> list[Charge]:
    """Charge balances of the dynamic tests; those that do not close the cycle take them from the slow test nearest in temperature."""
    if all(test.empty is not None and test.full is not None for test in dynamic_tests):
        return charge_balances(dynamic_tests)
    slow = charge_balances(ocv_tests)
    nearest = [(t, min(slow, key=lambda s, at=t: abs(s.temperature - at))) for t in sorted(test.temperature for test in dynamic_tests)]
    return [replace(balance, temperature=t) for t, balance in nearest]


def _drive(test: DynamicTest, balance: Charge, use: Use | None) -> Drive:
    script = test.drive.aligned()
    dt = np.diff(script.time)
    if not np.all(dt > 0.0):
        raise VehicleError(f"{script.source}: time stands still at sample {int(np.argmin(dt > 0.0)) + 1}, expected increasing")
    stored = np.where(script.current < 0.0, balance.efficiency, 1.0) * script.current
    soc = 1.0 - np.concatenate([[0.0], np.cumsum(stored[:-1] * dt)]) / balance.capacity
    used = np.ones(len(soc), dtype=np.bool_) if use is None else np.asarray(use(script.time - script.time[0]))
    if used.shape != soc.shape or used.dtype != np.bool_ or np.count_nonzero(used) < 100:
        found = f"{used.dtype} of shape {used.shape}"
        raise VehicleError(f"{script.source}: use() gives {found}, expected booleans {soc.shape}, at least 100 of them true")
    return Drive(test.temperature, script.time, script.current, script.voltage, soc, balance.capacity, balance.efficiency, used)


def _solve(drives: list[Drive], slow: list[Branches], structure: Structure, rate: float, refine: bool) -> Tables:
    time_constants = structure.time_constants
    if refine:
        stride = max(sum(len(drive.time) for drive in drives) // _SEARCH_ROWS, 1)
        time_constants, rate = Regression(drives, slow, structure, stride).search(time_constants, rate, evaluations=6)
    return Regression(drives, slow, structure).solve(time_constants, rate)[0]


def _limits(ocv_tests: Sequence[OcvTest], dynamic_tests: Sequence[DynamicTest]) -> CellLimits:
    scripts = [script for test in ocv_tests for script in (test.discharge, test.charge)]
    low, high = min(np.min(s.voltage) for s in scripts), max(np.max(s.voltage) for s in scripts)
    strongest = max(float(np.max(test.drive.current)) for test in dynamic_tests)
    charging = max(float(-np.min(test.drive.current)) for test in dynamic_tests)
    warmth = [test.temperature - ZERO_CELSIUS for test in (*ocv_tests, *dynamic_tests)]
    return CellLimits(
        voltage_min_v=round(float(low), 3), voltage_max_v=round(float(high), 3), discharge_max_a=strongest, charge_max_a=max(charging, 1e-3),
        discharge_peak_a=strongest, charge_peak_a=max(charging, 1e-3),
        temperature_min_degc=min(warmth) - 10.0, temperature_max_degc=max(warmth) + 10.0,
    )  # fmt: skip


def _warnings(
    slow: list[Charge], dynamic: list[Charge], drives: list[Drive], scores: tuple[Score, ...], *, known_heat: bool, known_limits: bool
) -> list[str]:
    found = [
        f"{b.temperature - ZERO_CELSIUS:g} degC: coulombic efficiency {b.efficiency:.4f} is above 1, taken as 1"
        for b in (*slow, *dynamic)
        if b.efficiency > 1.0
    ]
    ratio = np.mean([b.capacity for b in dynamic]) / np.mean([b.capacity for b in slow])
    if abs(ratio - 1.0) > 0.005:
        found.append(f"capacity of the dynamic tests is {100 * ratio:.1f} % of the slow tests'; the cell has that of the dynamic tests")
    spread = np.ptp([b.capacity for b in dynamic]) / np.mean([b.capacity for b in dynamic])
    if spread > 0.001:
        found.append(f"capacity differs by {100 * spread:.2f} % between temperatures; the cell has the mean, which shows near empty")
    found += [
        f"{d.temperature - ZERO_CELSIUS:g} degC: dynamic test ends at {100 * np.min(d.soc):.0f} % charge, what lies below rests on slow tests"
        for d in drives
        if np.min(d.soc) > 0.1
    ]
    found += [
        f"{row.temperature - ZERO_CELSIUS:g} degC: RMSE {1e3 * row.rmse:.1f} mV on the very test, the model does not fit this cell"
        for row in scores
        if row.rmse > 0.02
    ]
    if not known_heat:
        found.append(f"heat capacity not identified: {_HEAT_PER_AH:g} J/K per Ah assumed")
    if not known_limits:
        found.append("limits are the extremes of the tests, not the maker's")
    return found
