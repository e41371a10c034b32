"""Records that contradict each other give an error that names the file, not a cell."""

from dataclasses import replace

import numpy as np
import pytest

from powertrain import VehicleError
from powertrain.battery import OcvTest, Script, dump_cell, load_cell
from powertrain.battery.identify import charge_balances, identify, label, laboratory, read_dynamic, sort_files

from ..conftest import make
from .test_identify import DYN, WARM, Bench


@pytest.fixture(scope="module")
def tests():
    return laboratory(Bench(make("rc", hysteresis_v=0.0, coulombic_efficiency=1.0)), 40.0, [WARM], hours=3.0)


def changed(tests, **columns):
    """The tests with columns of the dynamic profile changed by functions."""
    ocv, (dynamic,) = tests
    drive = replace(dynamic.drive, **{name: change(getattr(dynamic.drive, name)) for name, change in columns.items()})
    return ocv, [replace(dynamic, drive=drive)]


def put(value):
    def change(column):
        column = column.copy()
        column[7] = value
        return column

    return change


@pytest.mark.parametrize(
    ("columns", "says"),
    [
        ({"current": lambda i: 1.2 * i}, "sampled current carries .* expected a difference of at most 3 %"),
        ({"current": lambda i: -i}, "sampled current carries"),
        ({"current": lambda i: 1e-3 * i}, "sampled current carries"),
        ({"current": lambda i: 0.0 * i}, "current is zero throughout"),
        ({"voltage": lambda v: 0.0 * v + 3.7}, "voltage is 3.7 V throughout"),
        ({"voltage": lambda v: v + 2.0}, "voltage reaches .* at most 0.7 V outside the slow tests'"),
        ({"voltage": lambda v: 1e3 * v}, "voltage reaches"),
        ({"voltage": put(0.0)}, "voltage reaches 0 V"),
        ({"voltage": put(np.nan)}, "voltage at sample 7 is not finite"),
        ({"current": put(2e6)}, "current at sample 7 is 2e"),
        ({"current": put(-np.inf)}, "current at sample 7 is not finite"),
        ({"voltage": lambda v: v + 0.15 * (-1.0) ** np.arange(len(v))}, "RMSE of .* mV, expected at most 100 mV"),
    ],
)
def test_a_dynamic_test_that_contradicts_itself_or_the_slow_ones_is_refused_by_name(tests, columns, says):
    with pytest.raises(VehicleError, match=says) as error:
        identify(*changed(tests, **columns), model="rc", heat_capacity_jpk=1000.0)
    assert "virtual profile at 25 degC" in str(error.value)
    assert "\n" not in str(error.value)


def test_a_dead_channel_of_a_slow_test_is_refused_by_name(tests):
    (slow,), dynamic = tests
    dead = replace(slow.charge, voltage=np.full(len(slow.charge.time), 3.0))
    with pytest.raises(VehicleError, match="virtual slow charge at 25 degC: voltage is 3 V throughout"):
        identify([replace(slow, charge=dead)], dynamic)


def test_half_a_percent_between_current_and_counter_is_what_real_cyclers_have(tests):
    found = identify(*changed(tests, current=lambda i: 1.005 * i), model="rc")
    assert found.scores[0].rmse < 0.02


def test_the_error_that_a_cell_states_is_that_of_its_own_run_and_it_loads_again(tests, tmp_path):
    found = identify(*tests, model="rc")
    assert found.cell.validity.voltage_rmse_v == pytest.approx(max(row.rmse for row in found.scores), rel=1e-4)
    (tmp_path / "cell.toml").write_text(dump_cell(found.cell), encoding="utf-8")
    assert load_cell(tmp_path / "cell.toml") == found.cell


def test_a_cell_that_would_not_load_again_is_not_returned(tests):
    with pytest.raises(VehicleError, match="heat_capacity_jpk is"):
        identify(*tests, model="rc", heat_capacity_jpk=-3.0)


def test_a_charge_balance_that_cannot_be_names_every_script():
    def script(name, into, out):
        zero = np.zeros(2)
        return Script(name, np.array([0.0, 1.0]), zero, zero + 3.0, np.array([0.0, into]), np.array([0.0, out]))

    broken = OcvTest(WARM, script("S1", 0, 7000.0), charge=script("S3", 3000.0, 0), empty=script("S2", 0, 10.0), full=script("S4", 20.0, 0))
    with pytest.raises(VehicleError, match=r"S1, S3, S2, S4: coulombic efficiency"):
        charge_balances([broken])


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (DYN.replace("step, current", "current, current"), "has the column current 2 times"),
        (DYN.splitlines()[0] + "\n", "0 lines of data"),
        (DYN.splitlines()[0] + "\n\n \n", "0 lines of data"),
    ],
)
def test_a_doubled_column_and_a_bare_header_are_refused_without_a_warning(content, says, tmp_path):
    path = tmp_path / "C_DYN_50_P25_s1.csv"
    path.write_text(content)
    with pytest.raises(VehicleError, match=says):
        read_dynamic(path)


def test_names_with_two_temperatures_or_a_script_too_many_are_refused(tmp_path):
    assert label("P14_DYN_50_P25_s1.csv").temperature == WARM  # P14 is the name of a cell
    with pytest.raises(VehicleError, match="temperatures P25 and P45, expected one"):
        label("C_DYN_P25_P45_s1.csv")
    path = tmp_path / "C_DYN_50_P25_s4.csv"
    path.write_text(DYN)
    with pytest.raises(VehicleError, match="DYN script 4, expected 1 to 3"):
        sort_files([path])
