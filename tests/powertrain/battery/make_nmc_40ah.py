"""Makes the shipped cell `nmc_40ah` anew: `python -m tests.powertrain.battery.make_nmc_40ah OUT.toml` (needs PyBaMM, some minutes)."""

from __future__ import annotations

import sys
from pathlib import Path

from powertrain.battery import CellLimits, dump_cell
from powertrain.battery.identify import STRUCTURES, identify, laboratory, slow_test

from .pybamm_cell import PybammCell

CAPACITY_AH = 40.0
LIMITS = CellLimits(
    voltage_min_v=2.8,
    voltage_max_v=4.2,
    discharge_max_a=120.0,
    charge_max_a=80.0,
    discharge_peak_a=200.0,
    charge_peak_a=200.0,
    peak_duration_s=10.0,
    soc_min=0.05,
    soc_max=0.95,
    temperature_min_degc=-10.0,
    temperature_max_degc=55.0,
)
SOURCE = (
    "virtual lab: PyBaMM SPMe with parameter set Ecker2015 (NMC/graphite pouch), isothermal at 5, 15, 25 and 45 degC, current scaled by one factor "
    "so that C/20 from 4.2 to 2.5 V at 25 degC gives 40 Ah (resistance goes with 1/capacity); no contact resistance. Stands for a cell such as the "
    "Li-Tec HEi40, of which no tables are public. Limits and heat capacity (1.1 kg, 1000 J/kgK) assumed"
)


def main() -> None:
    """Scale the cell to its capacity, test it in the virtual laboratory, identify it, write it."""
    out = Path(sys.argv[1])
    first = slow_test(PybammCell("Ecker2015", CAPACITY_AH), CAPACITY_AH, 298.15).discharge.moved[1] / 3600.0
    cell = PybammCell("Ecker2015", CAPACITY_AH**2 / first)
    slow, dynamic = laboratory(cell, CAPACITY_AH, [273.15 + warm for warm in (5.0, 15.0, 25.0, 45.0)], hours=8.0)
    found = identify(slow, dynamic, name="NMC pouch 40 Ah", source=SOURCE, heat_capacity_jpk=1100.0, limits=LIMITS, model=STRUCTURES["mesc-nmc"])
    out.write_text(dump_cell(found.cell), encoding="utf-8")
    sys.stdout.write(f"{found}\n")


if __name__ == "__main__":
    main()
