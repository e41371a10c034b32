"""What is told of a car, where a number can be counted by hand."""

import re
from pathlib import Path

import msgspec
import numpy as np
import pytest

from energy_mgr.report.vehicle.table import vehicle_table
from powertrain import load_vehicle
from powertrain.battery import dump_cell, load_cell
from powertrain.description.sections import Battery


def test_range_counts_the_charge_between_the_cells_limits_alone(tmp_path: Path):
    """A cell that may be used from 40 to 90 %: half of what the whole battery holds."""
    car = load_vehicle("compact")
    assert car.battery is not None
    cell = load_cell(car.battery.cell)
    cell = msgspec.structs.replace(cell, limits=msgspec.structs.replace(cell.limits, soc_min=0.4, soc_max=0.9))
    file = tmp_path / "half.toml"
    file.write_text(dump_cell(cell))
    car = msgspec.structs.replace(car, battery=Battery(cell=str(file), series=96, parallel=1))
    text = vehicle_table(car)
    found = re.search(r"range +(\d+) km on the WLTC with ([\d.]+) kWh usable", text)
    used = re.search(r"consumption +([\d.]+) kWh/100 km", text)
    assert found is not None
    assert used is not None
    whole = cell.capacity_ah * 96 * float(np.mean(np.asarray(cell.ocv_v(np.linspace(0.0, 1.0, 1001))))) / 1e3
    # figures are told with one digit after the point
    assert float(found[2]) == pytest.approx(0.5 * whole, abs=0.06)
    assert float(found[1]) == pytest.approx(100.0 * 0.5 * whole / float(used[1]), rel=0.01, abs=0.6)
