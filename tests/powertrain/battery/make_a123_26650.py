"""Makes the shipped cell `a123_26650` anew: `python -m tests.powertrain.battery.make_a123_26650 OUT.toml` (needs battery/a123 of ENERGY_MGR_DATA)."""

from __future__ import annotations

import sys
from pathlib import Path

from powertrain.battery import CellLimits, dump_cell
from powertrain.battery.identify import identify, sort_files
from tests.conftest import DATA

LIMITS = CellLimits(
    voltage_min_v=2.0,
    voltage_max_v=3.6,
    discharge_max_a=10.2,
    charge_max_a=9.3,
    discharge_peak_a=10.2,
    charge_peak_a=9.3,
    temperature_min_degc=0.0,
    temperature_max_degc=50.0,
)
SOURCE = (
    "identified by this project at 5, 25 and 45 degC from the public tests of G. L. Plett (LFP cell, 2.3 Ah nominal); current limits are those of "
    "the tests; heat capacity assumed (76 g, 1100 J/kgK)"
)


def main() -> None:
    """Identify the cell from the public test files, write it."""
    slow, dynamic = sort_files(sorted((DATA / "battery" / "a123").glob("*.csv")))
    found = identify(slow, dynamic, name="A123 26650", source=SOURCE, heat_capacity_jpk=84.0, limits=LIMITS)
    Path(sys.argv[1]).write_text(dump_cell(found.cell), encoding="utf-8")
    sys.stdout.write(f"{found}\n")


if __name__ == "__main__":
    main()
