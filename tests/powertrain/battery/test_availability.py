import numpy as np
import pytest

from powertrain import VehicleError
from powertrain.battery import Pack, available_power, electromotive, load_cell, pack_power, published_power, rest, simulate, voltage

from .conftest import LIMITS, make

WARM = 298.15


def linear_cell(**limits):
    """Ohmic cell with a line for its open-circuit voltage: limits by hand."""
    import msgspec

    from powertrain.battery import Esc, Table

    window = msgspec.structs.replace(LIMITS, **limits)
    return make(
        "esc", limits=window, hysteresis_v=0.0, hysteresis_rate=0.0, ocv_v=Table(soc=(0.0, 1.0), values=(3.0, 4.0)),
        esc=Esc(ohmic_ohm=0.004, resistance_ohm=0.0, pole_radps=1.0), coulombic_efficiency=1.0, heat_capacity_jpk=1e8,
    )  # fmt: skip


def test_the_voltage_limit_of_an_ohmic_cell_is_the_hand_value():
    cell = linear_cell(discharge_peak_a=1e3, charge_peak_a=1e3)
    found = available_power(cell, rest(cell, 0.5), WARM, horizons=(1e-6,), margin=0.0, extrapolate=True)
    for answer, u in ((found.discharge[0], 2.8), (found.charge[0], 4.2)):
        current = abs(3.5 - u) / 0.004
        assert answer.current == pytest.approx(current, rel=1e-3)
        assert answer.current <= current
        assert answer.power == pytest.approx(current * u, rel=1e-3)
        assert answer.power <= current * u
        assert answer.power_limit == answer.current_limit == "voltage"


def test_current_charge_temperature_and_power_are_named_where_they_bind():
    cell = linear_cell()
    assert available_power(cell, rest(cell, 0.5), WARM).discharge[0].current_limit == "current"
    assert available_power(cell, rest(cell, 0.5), WARM).discharge[0].current == pytest.approx(160.0, rel=1e-3)
    nearly_empty = available_power(cell, rest(cell, 0.0505), WARM, horizons=(30.0,)).discharge[0]
    assert nearly_empty.current_limit == "soc"
    assert nearly_empty.current == pytest.approx(0.0005 * cell.capacity / 30.0, rel=1e-2)
    too_hot = available_power(cell, rest(cell, 0.5), 330.0)
    assert {a.power_limit for a in (*too_hot.discharge, *too_hot.charge)} == {"temperature"}
    assert {a.power for a in (*too_hot.discharge, *too_hot.charge)} == {0.0}
    loose = linear_cell(voltage_min_v=0.5, discharge_peak_a=1e3)
    answer = available_power(loose, rest(loose, 0.5), WARM, horizons=(1e-6,), extrapolate=True).discharge[0]
    held, ohmic = electromotive(loose, rest(loose, 0.5), 0.0, WARM)
    assert answer.power_limit == "power"
    assert answer.power == pytest.approx(held**2 / 4 / ohmic, rel=1e-3)


def test_no_more_current_is_promised_than_the_cell_was_identified_with():
    cell = linear_cell(discharge_peak_a=250.0, voltage_min_v=1.0)
    known, beyond = (available_power(cell, rest(cell, 0.5), WARM, horizons=(1.0,), extrapolate=e).discharge[0] for e in (False, True))
    assert (known.current_limit, beyond.current_limit) == ("validity", "current")
    assert (known.current, beyond.current) == (pytest.approx(200.0, rel=1e-3), pytest.approx(250.0, rel=1e-3))


def test_longer_than_the_peak_only_the_steady_current_is_had():
    cell = linear_cell()
    found = available_power(cell, rest(cell, 0.5), WARM)
    assert [round(a.current) for a in found.discharge] == [160, 160, 80]
    assert [round(a.current) for a in found.charge] == [80, 80, 40]


def test_what_is_promised_for_longer_is_never_more(cell):
    found = available_power(cell, rest(cell, 0.3), WARM)
    for answers in (found.discharge, found.charge):
        assert answers[0].power >= answers[1].power >= answers[2].power


@pytest.mark.parametrize("soc", [0.06, 0.2, 0.5, 0.9, 0.94])
def test_the_limits_hold_when_the_cell_is_driven_at_the_promised_current(cell, soc):
    found = available_power(cell, rest(cell, soc), 280.0, margin=0.0)
    for horizon, down, up in zip(found.horizons, found.discharge, found.charge, strict=True):
        t = np.linspace(0.0, horizon, 400)
        for current in (down.current, -up.current):
            run = simulate(cell, t, np.full(400, current), 280.0, soc)
            assert np.min(run.voltage) > LIMITS.voltage_min_v - 2e-3
            assert np.max(run.voltage) < LIMITS.voltage_max_v + 2e-3
            assert LIMITS.soc_min - 1e-9 <= run.soc[-1] <= LIMITS.soc_max + 1e-9


def test_the_published_formula_counts_charge_in_ampere_seconds():
    cell = make("rc")
    down, up = published_power(cell, rest(cell, 0.05 + 1e-3), WARM, 10.0)
    assert down == pytest.approx(1e-3 * 40.0 * 3600.0 / 10.0 * voltage(cell, rest(cell, 0.051), 0.0, WARM))
    assert up == pytest.approx(-80.0 * voltage(cell, rest(cell, 0.051), 0.0, WARM))


def test_the_published_limits_fill_and_empty_the_cell_just_to_the_ends_of_its_window():
    """(5.7): the charge balance (5.2), (5.3) run over the horizon at the promised current ends where the window does, in both directions.

    k_i = 1.3 and eta = 0.8 are far from one and from each other, so that neither can be missing or on the wrong side of the fraction.
    """
    cell, horizon = make("rc", capacity_correction=1.3, coulombic_efficiency=0.8), 30.0
    soc = {"down": LIMITS.soc_min + 0.005, "up": LIMITS.soc_max - 0.002}
    for which, start in soc.items():
        down, up = published_power(cell, rest(cell, start), WARM, horizon)
        current = float(down if which == "down" else up) / float(voltage(cell, rest(cell, start), 0.0, WARM))
        # both currents are within the limits of the cell, so that it is the charge that decides
        assert -LIMITS.charge_max_a < current < LIMITS.discharge_max_a
        ends = LIMITS.soc_min if which == "down" else LIMITS.soc_max
        by_hand = start - current * 1.3 * (0.8 if current < 0.0 else 1.0) * horizon / (40.0 * 3600.0)
        assert by_hand == pytest.approx(ends, abs=1e-12)
        run = simulate(cell, np.linspace(0.0, horizon, 31), np.full(31, current), WARM, start)
        assert run.soc[-1] == pytest.approx(ends, abs=1e-9)


def test_the_published_formula_promises_more_than_the_voltage_allows():
    """Why ours exists: (5.7) multiplies by the voltage before the load."""
    cell = make("mesc-taps")
    down, _ = published_power(cell, rest(cell, 0.15), 275.0, 10.0)
    assert down > available_power(cell, rest(cell, 0.15), 275.0, horizons=(10.0,)).discharge[0].power


def test_the_weakest_cell_of_a_pack_decides():
    cell = make("mesc-taps")
    resistance = np.ones((4, 1))
    resistance[2] = 1.8
    pack = Pack(cell, np.ones((4, 1)), resistance, np.zeros((4, 1)))
    state = pack.rest(0.12, WARM)
    down, up, weakest = pack_power(pack, state)
    assert weakest == (2, 0)
    typical = available_power(cell, rest(cell, 0.12), WARM, horizons=(10.0,))
    assert down < 4 * typical.discharge[0].power
    assert up == pytest.approx(LIMITS.charge_peak_a * pack.voltage(state, -LIMITS.charge_peak_a), rel=2e-3)  # the current decides


@pytest.mark.parametrize("degrees", [-10.0, 4.9, 45.1])
def test_nothing_is_promised_at_temperatures_where_the_cell_was_not_identified(degrees):
    cell = load_cell("nmc_40ah")
    found = available_power(cell, rest(cell, 0.5), 273.15 + degrees)
    assert {(a.power, a.current, a.power_limit) for a in (*found.discharge, *found.charge)} == {(0.0, 0.0, "validity")}
    beyond = available_power(cell, rest(cell, 0.5), 273.15 + degrees, horizons=(10.0,), extrapolate=True)
    assert beyond.discharge[0].power > 0.0


def test_power_is_promised_up_to_the_very_ends_of_the_identified_temperatures():
    cell = load_cell("nmc_40ah")
    for degrees in (5.0, 45.0):
        assert available_power(cell, rest(cell, 0.5), 273.15 + degrees, horizons=(10.0,)).discharge[0].power > 0.0


@pytest.mark.parametrize("name", ["a123_26650", "nmc_40ah"])
def test_near_empty_and_near_full_no_limit_is_passed_between_the_steps(name):
    """LFP near empty: resistance falls as the cell fills, so the voltage on charge rises by a volt within seconds to a peak and falls again."""
    cell = load_cell(name)
    low, high = cell.limits.voltage_min_v, cell.limits.voltage_max_v
    for soc in (0.0, 0.003, 0.01, 0.02, 0.97, 1.0):
        found = available_power(cell, rest(cell, soc), WARM, margin=0.0)
        for horizon, down, up in zip(found.horizons, found.discharge, found.charge, strict=True):
            t = np.linspace(0.0, horizon, 1000)
            for current in (down.current, -up.current):
                u = simulate(cell, t, np.full(1000, current), WARM, soc).voltage
                assert not (current > 0.0 and np.min(u) < low - 0.01)
                assert not (current < 0.0 and np.max(u) > high + 0.01)


@pytest.mark.parametrize("soc", [0.0, 0.01, 0.06, 0.5])
def test_a_longer_horizon_never_promises_more_in_whatever_order_it_is_asked(soc):
    cell = load_cell("a123_26650")
    found = available_power(cell, rest(cell, soc), WARM, horizons=(30.0, 1.0, 3.0, 10.0))
    for answers in (found.discharge, found.charge):
        power, current = ([getattr(answers[k], name) for k in (1, 2, 3, 0)] for name in ("power", "current"))
        assert power == sorted(power, reverse=True)
        assert current == sorted(current, reverse=True)


@pytest.mark.parametrize(
    ("state", "horizons", "says"),
    [
        ((np.nan, 0, 0), (1.0,), "finite"),
        ((1.2, 0, 0), (1.0,), "soc is 1.2"),
        ((-0.1, 0, 0), (1.0,), "soc is -0.1"),
        ((0.5, 0), (1.0,), "3 finite"),
        ((0.5, 0, 0), (0.0,), "positive"),
    ],
)
def test_a_question_that_makes_no_sense_is_refused(state, horizons, says):
    with pytest.raises(VehicleError, match=says):
        available_power(make("esc"), state, WARM, horizons=horizons)
