"""Cells with known parameters."""

import pytest

from powertrain.battery import Cell, CellLimits, Esc, Mesc, Pair, Rc, Table, Validity

LIMITS = CellLimits(
    voltage_min_v=2.8, voltage_max_v=4.2, discharge_max_a=80.0, charge_max_a=40.0, discharge_peak_a=160.0, charge_peak_a=80.0,
    soc_min=0.05, soc_max=0.95, temperature_min_degc=-10.0, temperature_max_degc=55.0,
)  # fmt: skip
RESISTANCE = Table(soc=(0.0, 0.2, 1.0), temperature_degc=(0.0, 40.0), values=((0.006, 0.003), (0.003, 0.0015), (0.002, 0.001)))
SECTIONS = {
    "mesc": {"mesc": Mesc(pole_radps=0.4, resistance_ohm=RESISTANCE)},
    "mesc-taps": {"mesc": Mesc(pole_radps=(1.0, 0.1, 0.02, 0.004), ohmic_ohm=0.001, stage_ohm=(0.0005, 0.0004, 0.0003), resistance_ohm=0.0004)},
    "esc": {"esc": Esc(ohmic_ohm=0.0012, resistance_ohm=0.0008, pole_radps=0.05)},
    "rc": {"rc": Rc(ohmic_ohm=0.001, pairs=(Pair(resistance_ohm=0.0006, time_constant_s=5.0), Pair(resistance_ohm=0.0009, time_constant_s=90.0)))},
}  # fmt: skip


def make(kind: str, **changes) -> Cell:
    given = {
        "name": kind, "model": kind.split("-")[0], "capacity_ah": 40.0, "coulombic_efficiency": 0.99, "heat_capacity_jpk": 1000.0, "limits": LIMITS,
        "validity": Validity(soc=(0.0, 1.0), temperature_degc=(0.0, 40.0), current_a=(-100.0, 200.0)), "hysteresis_rate": 50.0,
        "ocv_v": Table(soc=(0.0, 0.1, 0.9, 1.0), values=(3.0, 3.5, 4.0, 4.15)), "hysteresis_v": Table(soc=(0.0, 1.0), values=(0.03, 0.02)),
    } | SECTIONS[kind] | changes  # fmt: skip
    return Cell(**given)


@pytest.fixture(params=list(SECTIONS))
def cell(request) -> Cell:
    return make(request.param)
