"""Identification on cells whose parameters are known, and on files that are broken."""

from dataclasses import replace

import numpy as np
import pytest

from powertrain import VehicleError
from powertrain.battery import Cell, simulate
from powertrain.battery.identify import (
    OcvTest,
    Script,
    branches,
    charge_balances,
    dynamic_test,
    evaluate,
    from_files,
    identify,
    kind_of,
    label,
    laboratory,
    read_arbin,
    read_dynamic,
)
from powertrain.battery.identify.assemble import arrhenius
from powertrain.battery.identify.structure import STRUCTURES

from ..conftest import make

WARM = 298.15


class Bench:
    """A known cell on the bench; it switches off at its voltage limits."""

    def __init__(self, cell: Cell) -> None:
        self.cell = cell

    def run(self, time, current, temperature):
        run = simulate(self.cell, time, current, temperature, 1.0)
        low, high = 3.0, 4.15
        slow = (current < 0.0) & (current > -8.0)
        out = np.flatnonzero((run.soc < 0.0) | (run.voltage < low - 0.5) | (slow & (run.voltage > high)))
        return run.voltage[: int(out[0])] if len(out) else run.voltage


def test_the_resistances_of_a_known_rc_cell_are_found_again():
    cell = make("rc", hysteresis_v=0.0, coulombic_efficiency=1.0)
    ocv, dynamic = laboratory(Bench(cell), 40.0, [WARM])
    structure = replace(STRUCTURES["rc"], time_constants=(5.0, 90.0))
    found = identify(ocv, dynamic, model=structure, refine=False)
    assert found.cell.rc is not None
    assert found.cell.capacity_ah == pytest.approx(40.0, rel=2e-3)  # 30 s steps of the slow test
    soc = np.linspace(0.15, 0.95, 9)
    assert found.cell.rc.ohmic_ohm(soc) == pytest.approx(np.full(9, 0.001), rel=0.02)  # pyright: ignore[reportCallIssue]
    for pair, r in zip(found.cell.rc.pairs, (0.0006, 0.0009), strict=True):
        assert pair.resistance_ohm(soc) == pytest.approx(np.full(9, r), rel=0.05)  # pyright: ignore[reportCallIssue]
    assert found.scores[0].rmse < 3e-4


def test_the_search_finds_the_pole_of_a_known_published_mesc():
    cell = make("mesc", hysteresis_v=0.0, coulombic_efficiency=1.0)
    ocv, dynamic = laboratory(Bench(cell), 40.0, [WARM])
    structure = replace(STRUCTURES["mesc-published"], hysteresis=False, current_nodes=(), time_constants=(1.0,))
    found = identify(ocv, dynamic, model=structure, refine=True)
    assert found.time_constants[0] == pytest.approx(1.0 / 0.4, rel=0.02)
    assert found.scores[0].rmse < 1e-3


def test_efficiency_and_capacity_follow_from_the_counted_charge():
    def script(into, out):
        zero = np.zeros(2)
        return Script("made", np.array([0.0, 1.0]), zero, zero + 3.0, np.array([0.0, into]), np.array([0.0, out]))

    eta, eta_cold, capacity = 0.98, 0.99, 7200.0
    # 25 degC: everything at one efficiency; 5 degC: the first and third script at its own
    warm = OcvTest(298.15, script(0, 7000.0), script(6850.0 / eta, 0), script(50.0 / eta, 250.0), script(350.0 / eta, 0))
    cold = OcvTest(278.15, script(0, 6500.0), script(6350.0 / eta_cold, 0), script(50.0 / eta, 750.0), script(850.0 / eta, 0))
    found = charge_balances([warm, cold])
    assert [b.temperature for b in found] == [278.15, 298.15]
    assert [b.efficiency for b in found] == pytest.approx([eta_cold, eta])
    assert [b.capacity for b in found] == pytest.approx([capacity, capacity])


def test_slow_branches_give_the_curve_and_half_their_distance():
    cell = make("rc", coulombic_efficiency=1.0, hysteresis_v=0.02, hysteresis_rate=300.0)
    ocv, _ = laboratory(Bench(cell), 40.0, [WARM], hours=0.5)
    balance = charge_balances(ocv)[0]
    soc = np.linspace(0.1, 0.9, 17)
    mean, half = branches(ocv[0], balance).mean(soc)
    assert mean == pytest.approx(cell.ocv_v(soc), abs=4e-3)  # what the corrected drop of C/20 leaves, 30 s of charge
    assert half == pytest.approx(np.full(17, 0.02), abs=6e-3)


def test_arrhenius_values_lie_on_the_straight_line_over_inverse_temperature():
    tested, law = np.array([278.15, 318.15]), lambda t: 1e-3 * np.exp(4000.0 / t - 4000.0 / 298.15)
    wanted = np.array([283.15, 298.15, 308.15])
    assert arrhenius(tested, law(tested)[:, None], wanted)[:, 0] == pytest.approx(law(wanted), rel=2e-3)  # a floor of 1/1000 is in


def test_an_aligned_current_carries_exactly_the_counted_charge(rng):
    t = np.arange(5000.0)
    current = rng.normal(0, 2, 5000)
    into, out = (np.concatenate([[0.0], np.cumsum(np.maximum(s * 1.01 * current[:-1] + 0.002, 0.0))]) for s in (-1, 1))
    script = Script("made", t, current, np.full(5000, 3.0), into, out).aligned()
    assert np.sum(script.current[:-1]) == pytest.approx(out[-1] - into[-1], abs=1e-6)
    assert np.max(np.abs(script.current - current)) < 0.1


def test_a_cell_identified_on_a_part_is_scored_on_the_rest():
    cell = make("rc", hysteresis_v=0.0, coulombic_efficiency=1.0)
    ocv, dynamic = laboratory(Bench(cell), 40.0, [WARM])
    structure = replace(STRUCTURES["rc"], time_constants=(5.0, 90.0))
    found = identify(ocv, dynamic, model=structure, refine=False, use=lambda t: (t // 900.0) % 2 == 1)
    assert evaluate(found.cell, dynamic[0], use=lambda t: (t // 900.0) % 2 == 0).rmse < 2e-3


def test_names_say_kind_temperature_and_script():
    assert label("a/A123_DYN_50_P25_s1.csv") == ("DYN", 298.15, 1)
    assert label("X_OCV_N05_S3.csv") == ("OCV", 268.15, 3)
    with pytest.raises(VehicleError, match="name says no test"):
        label("cell.csv")


DYN = "time, step, current, voltage, chgAh, disAh\n0, 1, 1.0, 3.3, 0, 0\n1, 1, 1.0, 3.2, 0, 0.0003\n2, 1, 1.0, 3.1, 0, 0.0006\n"
ARBIN = "Test_Time(s),Step_Index,Current(A),Voltage(V),Charge_Capacity(Ah),Discharge_Capacity(Ah)\n0,1,-1,3.3,0,0\n1,1,-1,3.2,0,0.0003\n"


def test_both_formats_give_discharge_a_positive_current(tmp_path):
    (tmp_path / "d.csv").write_text(DYN)
    (tmp_path / "a.csv").write_text(ARBIN)
    for script in (read_dynamic(tmp_path / "d.csv"), read_arbin(tmp_path / "a.csv")):
        assert np.all(script.current == 1.0)
        assert script.discharged[1] == pytest.approx(0.0003 * 3600.0)
    assert (kind_of(tmp_path / "d.csv"), kind_of(tmp_path / "a.csv")) == ("DYN", "OCV")


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (DYN.replace("voltage", "volt"), "line 1 lacks the column voltage"),
        (DYN.replace("3.2", "high"), "voltage in line 3 is 'high'"),
        (DYN.replace("1, 1, 1.0, 3.2, 0, 0.0003", "1, 1, 1.0"), "line 3 has 3 columns"),
        (DYN.replace("3.2", "nan"), "voltage in data row 2 is nan"),
        (DYN.replace("3.2", ""), "voltage in line 3 is ''"),
        (DYN.replace("\n2, 1", "\n0.5, 1"), "time goes back"),
        (DYN.replace("0.0006", "0.0001"), "discharged charge falls at sample 2"),
        (DYN.replace("3.3, 0, 0\n", "3.3, 0, -1\n"), "disAh in data row 1 is -1"),
        (DYN.splitlines()[0] + "\n", "expected at least two"),
        (DYN.replace("1.0, 3.1", "inf, 3.1"), "current in data row 3 is inf"),
        ("", "lacks the column time"),
        ("PK\x00\x01", "lacks the column time"),
    ],
)
@pytest.mark.filterwarnings("ignore:loadtxt")
def test_a_malformed_file_is_refused_in_one_line_that_names_file_and_place(content, says, tmp_path):
    path = tmp_path / "C_DYN_50_P25_s1.csv"
    path.write_text(content)
    with pytest.raises(VehicleError, match=says) as error:
        read_dynamic(path)
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)


def test_files_that_are_missing_doubled_or_mixed_up_are_named(tmp_path):
    dynamic = [tmp_path / f"C_DYN_50_P25_s{k}.csv" for k in (1, 3)]
    for path in dynamic:
        path.write_text(DYN)
    slow = tmp_path / "C_OCV_P25_S1.csv"
    slow.write_text(ARBIN)
    with pytest.raises(VehicleError, match=r"missing DYN at 25 degC script 2; OCV at 25 degC script 2, 3, 4"):
        from_files([*dynamic, slow])
    with pytest.raises(VehicleError, match=r"every OCV script"):
        from_files(dynamic)
    with pytest.raises(VehicleError, match="no test files"):
        from_files([])
    slow.write_text(DYN)
    with pytest.raises(VehicleError, match="name says OCV, header says DYN"):
        from_files([slow])
    (tmp_path / "D_DYN_40_P25_s1.csv").write_text(DYN)
    with pytest.raises(VehicleError, match="comes twice"):
        from_files([dynamic[0], tmp_path / "D_DYN_40_P25_s1.csv"])
    slow.write_text("a,b\n1,2\n")
    with pytest.raises(VehicleError, match="header is"):
        from_files([slow])
    with pytest.raises(VehicleError, match="no such file"):
        from_files([tmp_path / "E_OCV_P25_S1.csv"])


def test_an_identification_that_cannot_be_is_refused():
    cell = make("rc", hysteresis_v=0.0, coulombic_efficiency=1.0)
    ocv, dynamic = laboratory(Bench(cell), 40.0, [WARM], hours=0.5)
    for args, says in (
        (([], dynamic), "no slow test"),
        ((ocv, []), "no dynamic test"),
        ((ocv, dynamic * 2), "one per temperature"),
        ((ocv, [replace(dynamic[0], temperature=25.0)]), "at 25 K"),
    ):
        with pytest.raises(VehicleError, match=says):
            identify(*args)
    with pytest.raises(VehicleError, match="expected one of mesc"):
        identify(ocv, dynamic, model="spice")
    with pytest.raises(VehicleError, match="at least 100"):
        identify(ocv, dynamic, use=lambda t: t < 10.0)


def test_a_bench_that_answers_nonsense_is_refused():
    class Broken:
        def run(self, time, current, temperature):
            return np.full(len(time), np.nan)

    with pytest.raises(VehicleError, match="virtual lab"):
        dynamic_test(Broken(), 40.0, WARM)
