"""Drive cycles out of a battery at its limits: empty, full, too weak; and what is refused."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from powertrain import Vehicle, VehicleError, load_vehicle
from powertrain.battery import Pair, Rc, dump_cell, load_cell
from powertrain.description.sections import Battery
from powertrain.energy.cycle_charge import charge_over_cycle
from roads import cycles
from tests.powertrain.energy.test_cycle_charge import on_cycle, with_cell


@pytest.fixture(scope="module")
def compact() -> Vehicle:
    return load_vehicle("compact")


def test_an_empty_battery_goes_nowhere_and_lacks_all_driving(compact: Vehicle):
    nowhere = on_cycle(compact, soc=0.05, until="empty")
    assert nowhere.range == 0.0
    assert nowhere.end == "soc"
    assert nowhere.soc.tolist() == [0.05]
    assert nowhere.current.shape == (0,)
    ledger = charge_over_cycle(compact, [0.0, 10.0, 20.0], [0.0, 20.0, 20.0], soc=0.05)
    assert ledger.unserved == pytest.approx(ledger.cycle.energy, rel=1e-12)
    assert ledger.energy == ledger.charge_ah == 0.0
    assert ledger.shortage is not None
    assert ledger.shortage[:3] == (0.0, 0.0, "soc")
    assert ledger.range == 0.0


def test_charge_never_falls_below_the_least(compact: Vehicle):
    ledger = on_cycle(compact, soc=0.06)
    assert np.min(ledger.soc) == pytest.approx(0.05, abs=1e-6)
    assert np.min(ledger.soc) >= 0.05
    assert ledger.shortage is not None
    assert 0.0 < ledger.shortage.distance < ledger.distance[-1]
    assert ledger.unserved > 0.0
    assert ledger.energy + ledger.unserved == pytest.approx(ledger.cycle.energy, rel=1e-6)
    assert ledger.range is None


def test_a_full_battery_refuses_recuperation_and_the_brakes_take_it(compact: Vehicle):
    ledger = on_cycle(compact, "ece15", soc=1.0)
    back = -float(np.sum(np.minimum(ledger.cycle.power, 0.0) * np.diff(cycles.load("ece15").t)))
    assert back > 0.0
    assert ledger.refused == pytest.approx(back, rel=1e-12)
    assert ledger.components["brake"] == pytest.approx(ledger.cycle.components["brake"] + back, rel=1e-12)
    assert sum(ledger.components.values()) == pytest.approx(ledger.energy, rel=1e-9)
    assert np.all(np.diff(ledger.soc) <= 0.0)
    assert ledger.refusal is not None
    assert ledger.refusal.reason == "soc"
    assert ledger.shortage is None


def test_recuperation_fills_up_to_the_most_and_no_further(compact: Vehicle):
    ledger = charge_over_cycle(compact, np.arange(0.0, 601.0), np.full(601, 20.0), -0.08, soc=0.945)
    assert np.max(ledger.soc) == pytest.approx(0.95, abs=1e-6)
    assert np.max(ledger.soc) <= 0.95
    assert ledger.refused > 0.0
    assert ledger.refused - ledger.energy == pytest.approx(-ledger.cycle.energy, rel=1e-9)


@pytest.mark.parametrize(("key", "value", "reason"), [("voltage_min_v", 3.5, "voltage"), ("discharge_peak_a", 30.0, "current")])
def test_a_limit_on_the_way_is_named_and_kept_exactly(compact: Vehicle, tmp_path: Path, key: str, value: float, reason: str):
    limits = msgspec.structs.replace(
        load_cell("nmc_40ah").limits, **({"voltage_min_v": 2.0, "voltage_max_v": 5.0, "discharge_max_a": 30.0} | {key: value})
    )
    car = with_cell(compact, tmp_path, limits=limits)
    ledger = charge_over_cycle(car, np.arange(0.0, 21.0), np.linspace(0.0, 40.0, 21), soc=0.9)
    assert ledger.shortage is not None
    assert ledger.shortage.reason == reason
    worst = np.min(ledger.voltage) / 96 if reason == "voltage" else np.max(ledger.current) / 2
    assert worst == pytest.approx(value, rel=1e-6)
    gone = charge_over_cycle(car, np.arange(0.0, 41.0), np.append(np.linspace(0.0, 40.0, 21), np.linspace(38.0, 0.0, 20)), soc=0.9, until="empty")
    assert gone.end == reason
    assert gone.range == pytest.approx(ledger.shortage.distance)


def test_the_voltage_limit_holds_to_the_end_of_an_interval(compact: Vehicle, tmp_path: Path):
    """A cell whose voltage sags over the ten seconds by what its filters do: the end decides, not the beginning."""
    cell = load_cell("nmc_40ah")
    file = tmp_path / "cell.toml"
    file.write_text(dump_cell(msgspec.structs.replace(cell, limits=msgspec.structs.replace(cell.limits, voltage_min_v=3.6))))
    car = msgspec.structs.replace(compact, battery=Battery(cell=str(file), series=96, parallel=2))
    ledger = charge_over_cycle(car, [0.0, 10.0], [10.0, 40.0], soc=0.5)
    assert ledger.shortage is not None
    assert ledger.shortage.reason == "voltage"
    assert ledger.voltage[-1] / 96 == pytest.approx(3.6, abs=1e-6)
    assert ledger.voltage[0] / 96 > 3.605
    assert ledger.energy + ledger.unserved == pytest.approx(ledger.cycle.energy, rel=1e-6)


def test_more_than_the_resistance_lets_through_is_not_given(compact: Vehicle, tmp_path: Path):
    """E^2 / 4 R of the pack is the most, whatever is asked."""
    rc = Rc(ohmic_ohm=0.02, pairs=(Pair(resistance_ohm=0.0, time_constant_s=10.0),))
    limits = msgspec.structs.replace(
        load_cell("nmc_40ah").limits, voltage_min_v=0.1, voltage_max_v=9.0, discharge_max_a=500.0, discharge_peak_a=500.0
    )
    ledger = charge_over_cycle(with_cell(compact, tmp_path, rc=rc, limits=limits), [0.0, 8.0], [0.0, 40.0], soc=0.9)
    assert ledger.shortage is not None
    assert ledger.shortage.reason == "power"
    most = 96 * 2 * 3.6**2 / (4 * 0.02)
    assert ledger.cycle.power[0] > most
    assert ledger.power[0] == pytest.approx(most, rel=1e-6)
    assert ledger.unserved == pytest.approx((ledger.cycle.power[0] - most) * 8.0, rel=1e-5)


def test_peak_current_lasts_for_the_peak_duration(compact: Vehicle, tmp_path: Path):
    limits = msgspec.structs.replace(load_cell("nmc_40ah").limits, voltage_min_v=2.0, voltage_max_v=5.0, discharge_max_a=20.0, discharge_peak_a=80.0)
    ledger = charge_over_cycle(with_cell(compact, tmp_path, limits=limits), np.arange(0.0, 13.0), np.full(13, 40.0), soc=0.9)
    each = ledger.current / 2
    assert np.all(each[:10] > 20.5)
    assert each[10] == pytest.approx(20.0, rel=1e-6)
    assert ledger.shortage is not None
    assert (ledger.shortage.time, ledger.shortage.reason) == (10.0, "current")


T, V = [0.0, 10.0, 20.0], [0.0, 10.0, 0.0]
BAD = [
    ({"soc": 1.2}, T, V, 0.0, "soc is 1.2, expected 0 to 1"),
    ({"soc": float("nan")}, T, V, 0.0, "soc is nan, expected 0 to 1"),
    ({"temperature": 263.15}, T, V, 0.0, "expected 278.15 to 318.15"),
    ({"temperature": float("nan")}, T, V, 0.0, "at nan K"),
    ({"until": "noon"}, T, V, 0.0, "expected 'once' or 'empty'"),
    ({"until": "empty"}, T, V, -0.2, "never empties it"),
    ({"until": "empty"}, T, [0.0, 10.0, 10.0], 0.0, "ends at 10 m/s, expected equal speeds"),
    ({"until": "empty"}, [0.0, 1e-3, 2e-3], [1.0, 1.0, 1.0], 0.0, "expected at most 500000 intervals"),
    ({}, [0.0, 1e9], [1.0, 1.0], 0.0, "expected at most 500000"),
    ({}, [0.0, 1.0], [1.0], 0.0, "as many speeds"),
    ({}, [0.0, 1.0], [1e120, 1e120], 0.0, "expected speeds of a car"),
    ({}, [-np.inf, 1.0], [1.0, 1.0], 0.0, "expected increasing times"),
]


@pytest.mark.parametrize(("options", "t", "v", "slope", "words"), BAD)
def test_what_makes_no_sense_is_refused_in_one_line(
    compact: Vehicle, options: dict[str, float], t: list[float], v: list[float], slope: float, words: str
):
    with pytest.raises(VehicleError, match=words) as error:
        charge_over_cycle(compact, t, v, slope, **({"soc": 0.9} | options))  # pyright: ignore[reportArgumentType]
    assert "\n" not in str(error.value)


def test_a_car_without_battery_is_refused(compact: Vehicle):
    with pytest.raises(VehicleError, match=r"no section \[battery\]"):
        charge_over_cycle(msgspec.structs.replace(compact, battery=None), T, V, soc=0.9)
