from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from powertrain import VehicleError
from powertrain.battery import Pack, PackModel, current_from_power, derivative, electromotive, heat, rest, states, voltage

from .conftest import make

WARM = 298.15


def equal(cell, series, parallel) -> Pack:
    ones = np.ones((series, parallel))
    return Pack(cell, ones, ones, 0.0 * ones, thermal_resistance=20.0)


def test_equal_cells_are_the_lumped_pack():
    cell = make("rc")
    lumped = PackModel(cell, 9, 3, thermal_resistance=20.0 / 27.0)
    full = equal(cell, 9, 3)
    inner = (0.6, 0.01, 12.0, -5.0)
    state, spread = (*inner, 300.0), [np.full((9, 3), x) for x in (*inner, 300.0)]
    assert full.voltage(spread, 90.0) == pytest.approx(lumped.voltage(state, 90.0))
    assert lumped.voltage(state, 90.0) == pytest.approx(9 * voltage(cell, inner, 30.0, 300.0))
    for one, many in zip(lumped.derivative(state, 90.0, 290.0), full.derivative(spread, 90.0, 290.0), strict=True):
        assert many == pytest.approx(np.full((9, 3), one))


def test_cells_side_by_side_share_current_at_one_voltage(rng):
    cell = make("rc")
    pack = Pack.spread(cell, 4, 3, rng, capacity=0.05, resistance=0.2, soc=0.02)
    state = pack.rest(0.5, WARM)
    each, group = pack.split(state, 60.0)
    assert np.sum(each, axis=1) == pytest.approx(np.full(4, 60.0))
    alone = voltage(cell, state[:-1], each, WARM, resistance_scale=pack.resistance)
    assert alone == pytest.approx(np.repeat(group[:, None], 3, axis=1))
    assert np.ptp(each) > 1.0


def test_a_fuller_cell_feeds_its_neighbour_at_rest():
    cell = make("rc")
    ones = np.ones((1, 2))
    pack = Pack(cell, ones, ones, np.array([[0.02, -0.02]]))
    each, _ = pack.split(pack.rest(0.5, WARM), 0.0)
    assert each[0, 0] > 0.0
    assert each[0, 0] == pytest.approx(-each[0, 1])
    # two open-circuit voltages over two ohmic resistances
    gap = cell.ocv_v(0.52) - cell.ocv_v(0.48)
    assert each[0, 0] == pytest.approx(gap / (2 * 0.001))


def test_spread_comes_from_the_generator_that_is_passed():
    cell = make("rc")
    one, two = (Pack.spread(cell, 5, 2, np.random.default_rng(7)) for _ in range(2))
    assert np.array_equal(one.capacity, two.capacity)
    assert np.array_equal(one.soc_offset, two.soc_offset)


def test_the_weakest_group_decides_what_charge_is_usable():
    cell = make("rc")
    capacity = np.array([[1.0], [0.9], [1.1]])
    pack = Pack(cell, capacity, np.ones((3, 1)), np.zeros((3, 1)))
    down, up = pack.usable_charge(pack.rest(0.5, WARM)[0])
    assert down == pytest.approx(0.45 * 0.9 * cell.capacity)
    assert up == pytest.approx(0.45 * 0.9 * cell.capacity)
    assert pack.within_limits(pack.rest(0.5, WARM), 100.0) == ""
    assert pack.within_limits(pack.rest(0.5, WARM), 170.0) == "current"
    assert pack.within_limits(pack.rest(0.0, WARM), 10.0) == "soc"
    assert pack.within_limits(pack.rest(0.5, 340.0), 10.0) == "temperature"


def test_a_step_of_the_pack_is_its_derivative(rng):
    pack = Pack.spread(make("rc"), 3, 2, rng, thermal_resistance=15.0)
    state = [x + 0.0 for x in pack.rest(0.6, WARM)]
    state[2] = state[2] + 3.0
    ahead = pack.step(state, 50.0, 290.0, 1e-3)
    for new, old, rate in zip(ahead, state, pack.derivative(state, 50.0, 290.0), strict=True):
        assert (new - old) / 1e-3 == pytest.approx(rate, rel=2e-3, abs=1e-7)


@pytest.mark.parametrize("shape", [(3, 1), (3, 2)])
def test_what_is_carried_away_from_a_pack_is_shared_by_its_cells(shape: tuple[int, int]):
    pack = replace(equal(make("rc"), *shape), thermal_resistance=np.inf)
    cells, watt, seconds = shape[0] * shape[1], 6.0, 20.0
    # insulated and without current all heat that leaves is the cooling's
    cooled = pack.step(pack.rest(0.5, WARM), 0.0, WARM, seconds, cooling=watt)[-1]
    assert cooled == pytest.approx(np.full(shape, WARM - watt * seconds / (cells * pack.cell.heat_capacity_jpk)), abs=1e-9)
    rate = pack.derivative(pack.rest(0.5, WARM), 0.0, WARM, cooling=watt)[-1]
    assert rate * seconds == pytest.approx(cooled - WARM, abs=1e-9)


def test_the_thermal_node_comes_to_rest_where_heat_leaves_as_fast_as_it_comes():
    pack = PackModel(make("rc"), 90, 1, thermal_resistance=0.05)
    inner = (0.6, 0.0, 40.0, 40.0)
    q = 90 * heat(pack.cell, inner, 40.0, 300.0)
    state = (*inner, 290.0 + 0.05 * q)
    assert pack.derivative(state, 40.0, 290.0)[-1] == pytest.approx(0.0, abs=1e-9)
    assert pack.derivative(state, 40.0, 290.0, cooling=100.0)[-1] == pytest.approx(-100.0 / (90 * 1000.0))


@pytest.mark.parametrize("kind", ["mesc", "mesc-taps", "esc", "rc"])
@pytest.mark.parametrize("power", [-9000.0, -10.0, 0.0, 10.0, 15000.0])
def test_the_current_that_is_found_gives_the_power_back_by_the_smaller_root(kind, power):
    pack = PackModel(make(kind), 90)
    state = (*rest(pack.cell, 0.5), WARM)
    found = pack.current_from_power(power, state)
    assert found.feasible == 1.0
    assert found.current * pack.voltage(state, found.current) == pytest.approx(power, abs=1e-6)
    held, ohmic = electromotive(pack.cell, state[:-1], 0.0, WARM)
    assert ohmic == 0.0 or found.current < held / (2.0 * ohmic)


def test_more_than_the_largest_power_is_answered_with_its_current_and_a_status():
    cell = make("rc")
    held, ohmic = electromotive(cell, rest(cell, 0.5), 0.0, WARM)
    largest = held**2 / (4.0 * ohmic)
    for factor in (1.01, 5.0, 1e6):
        found = current_from_power(cell, rest(cell, 0.5), factor * largest, WARM)
        assert found.feasible == 0.0
        assert found.current == pytest.approx(held / (2.0 * ohmic))
    assert current_from_power(cell, rest(cell, 0.5), 0.99 * largest, WARM).feasible == 1.0


def test_the_lumped_pack_serves_symbols():
    pack = PackModel(make("mesc-taps"), 90, 2, thermal_resistance=0.1)
    x, p = ca.SX.sym("x", len(pack.states)), ca.SX.sym("p")
    parts = [x[k] for k in range(x.numel())]
    found = pack.current_from_power(p, parts)
    f = ca.Function("f", [x, p], [found.current, found.feasible, ca.vertcat(*pack.derivative(parts, found.current, 290.0))])
    state = (*rest(pack.cell, 0.5), 300.0)
    for power in (-5e3, 2e4, 1e7):
        numeric = pack.current_from_power(power, state)
        current, feasible, rates = f(state, power)
        assert float(current) == pytest.approx(numeric.current, rel=1e-12)
        assert float(feasible) == numeric.feasible
        assert np.asarray(rates).ravel() == pytest.approx([float(r) for r in pack.derivative(state, numeric.current, 290.0)], rel=1e-10)


def test_romo_sized_pack_has_the_voltage_and_energy_of_the_table():
    from powertrain.battery import load_cell

    pack = PackModel(load_cell("nmc_40ah"), 90)
    soc = np.linspace(0.0, 1.0, 201)
    energy = 90 * np.mean(pack.cell.ocv_v(soc, WARM)) * pack.cell.capacity_ah / 1000.0
    assert energy == pytest.approx(13.7, rel=0.03)
    assert pack.voltage(pack.rest(0.5, WARM), 0.0) == pytest.approx(342.0, rel=0.05)


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        (lambda: PackModel(make("rc"), 0), "0 cells in series"),
        (lambda: PackModel(make("rc"), 3, 1, thermal_resistance=0.0), "thermal resistance"),
        (lambda: Pack(make("rc"), np.ones((2, 1)), np.ones((1, 2)), np.zeros((2, 1))), "shapes"),
        (lambda: Pack(make("rc"), np.zeros((2, 1)), np.ones((2, 1)), np.zeros((2, 1))), "capacity factor"),
        (lambda: equal(make("mesc"), 2, 2).split(equal(make("mesc"), 2, 2).rest(0.5, WARM), 1.0), "without ohmic resistance"),
    ],
)
def test_a_pack_that_cannot_be_is_refused(wrong, says):
    with pytest.raises(VehicleError, match=says):
        wrong()


def test_states_are_those_of_the_cell_and_a_temperature():
    pack = PackModel(make("mesc"), 90)
    assert pack.states == (*states(pack.cell), "temperature")
    assert len(pack.derivative(pack.rest(0.5, WARM), 1.0, 290.0)) == len(pack.states)
    assert derivative(pack.cell, rest(pack.cell, 0.5), 1.0, WARM)[0] == pack.derivative(pack.rest(0.5, WARM), 1.0, 290.0)[0]
