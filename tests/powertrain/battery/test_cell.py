import casadi as ca
import numpy as np
import pytest

from powertrain import VehicleError
from powertrain.battery import (
    Cell,
    Table,
    derivative,
    dump_cell,
    heat,
    load_cell,
    powers,
    rest,
    shipped_cells,
    simulate,
    states,
    voltage,
)
from powertrain.battery.cell import frozen_at
from powertrain.battery.simulation import transitions

from ...timing import least_time
from .conftest import make

WARM = 298.15


def random_state(cell: Cell, rng, shape=()):
    return [rng.uniform(0.1, 0.9, shape), rng.uniform(-0.02, 0.02, shape), *(rng.uniform(-80, 80, shape) for _ in states(cell)[2:])]


def integrate(cell: Cell, time, current, temperature, soc0):
    """An independent answer: a stiff integrator on the derivative, piece by piece."""
    from scipy.integrate import solve_ivp

    x, out = np.array(rest(cell, soc0), dtype=float), []
    for a, b, i in zip(time[:-1], time[1:], current[:-1], strict=True):
        out.append(x)
        found = solve_ivp(lambda _, y, i=i: np.array(derivative(cell, list(y), i, temperature)), (a, b), x, rtol=1e-9, atol=1e-11, method="LSODA")
        x = found.y[:, -1]
    return np.array([*out, x]).T


def test_the_mesc_has_the_states_of_the_thesis():
    assert states(make("mesc")) == ("soc", "hysteresis", "f1", "f2", "f3", "f4")
    assert states(make("rc")) == ("soc", "hysteresis", "f1", "f2")


def test_discharge_lowers_the_charge_and_charging_stores_less_than_it_takes(cell):
    out, into = (derivative(cell, rest(cell, 0.5), i, WARM)[0] for i in (40.0, -40.0))
    assert out == pytest.approx(-1.0 / 3600.0)
    assert into == pytest.approx(0.99 / 3600.0)


def test_hysteresis_is_drawn_down_by_discharge_and_up_by_charge_and_stays_at_rest(cell):
    at = {i: derivative(cell, rest(cell, 0.5), i, WARM)[1] for i in (40.0, -40.0, 0.0)}
    assert at[40.0] < 0.0 < at[-40.0]
    assert at[0.0] == 0.0
    bound = 0.025
    for i in (40.0, -40.0):
        assert derivative(cell, rest(cell, 0.5, -np.sign(i) * bound), i, WARM)[1] == pytest.approx(0.0, abs=1e-15)


def test_the_published_mesc_is_the_formula_of_the_thesis(rng):
    cell = make("mesc")
    x = [0.5, *random_state(cell, rng)[1:]]
    resistance = 0.003 + (x[0] - 0.2) / 0.8 * (0.002 - 0.003)
    warm = 273.15
    assert voltage(cell, x, 70.0, warm) == pytest.approx(cell.ocv_v(x[0]) + x[1] - resistance * x[5])
    assert heat(cell, x, 70.0, warm) == pytest.approx(resistance * x[5] ** 2)


def test_power_adds_up_and_no_loss_is_negative(cell, rng):
    x = random_state(cell, rng, (500,))
    current = rng.uniform(-100, 200, 500)
    p = powers(cell, x, current, rng.uniform(263, 320, 500))
    assert p.chemical == pytest.approx(p.terminal + p.heat + p.polarisation, abs=1e-9)
    assert np.all(p.heat >= 0.0)


def test_a_closed_cycle_of_the_rc_cell_loses_exactly_its_heat():
    """What the capacitors held is back after a long rest: energy in less energy out is heat, from an integral of its own."""
    cell = make("rc", hysteresis_v=0.0, coulombic_efficiency=1.0)
    t = np.arange(0.0, 4000.0, 0.05)
    current = np.select([t < 300, t < 600, t < 900], [80.0, 0.0, -80.0], 0.0)
    run = simulate(cell, t, current, WARM, 0.6)
    assert run.soc[-1] == pytest.approx(0.6)
    lost = -np.sum(run.current[:-1] * 0.5 * (run.voltage[:-1] + voltage(cell, list(run.state[:, 1:]), run.current[:-1], WARM))) * 0.05
    warmed = np.sum(0.5 * (run.heat[:-1] + heat(cell, list(run.state[:, 1:]), run.current[:-1], WARM))) * 0.05
    assert lost == pytest.approx(warmed, rel=1e-4)  # the open-circuit energy goes and comes back; trapezoids over 0.05 s
    assert warmed > 1000.0


def test_a_slow_full_cycle_loses_the_area_of_the_hysteresis_loop():
    cell = make("rc", coulombic_efficiency=1.0, hysteresis_v=0.02, hysteresis_rate=400.0)
    t = np.arange(0.0, 2 * 36000.0 + 1.0, 10.0)
    current = np.where(t < 36000.0, 1.0, -1.0) * 3.2  # 0.1 C over 80 % of the capacity
    run = simulate(cell, t, current, WARM, 0.9)
    assert run.soc[-1] == pytest.approx(0.9)
    lost = -np.sum(run.current[:-1] * run.voltage[:-1]) * 10.0
    loop = 2.0 * 0.02 * 3.2 * 36000.0
    ohmic = 3.2**2 * 0.0025 * 72000.0
    assert lost == pytest.approx(loop + ohmic, rel=0.03)  # 1/400 of the capacity is needed to turn at each end


def test_the_exact_run_is_what_a_stiff_integrator_finds(cell):
    t = np.concatenate([np.arange(0.0, 60.0, 2.0), np.arange(60.0, 600.0, 30.0)])
    current = 60.0 * np.sign(np.sin(t / 40.0)) + 20.0
    truth = integrate(cell, t, current, WARM, 0.7)
    run = simulate(cell, t, current, WARM, 0.7)
    assert run.soc == pytest.approx(truth[0], abs=1e-9)
    assert run.state[2:] == pytest.approx(truth[2:], abs=1e-4)
    assert run.hysteresis == pytest.approx(truth[1], abs=2e-5)  # M(l) is taken in the middle of a step of 30 s


def test_constant_current_fills_the_critically_damped_filter_as_the_gamma_distribution():
    from scipy.stats import gamma

    cell = make("mesc")
    t = np.arange(0.0, 60.0)
    run = simulate(cell, t, np.full(60, 40.0), WARM, 0.9)
    for stage in range(1, 5):
        assert run.state[1 + stage] == pytest.approx(40.0 * gamma.cdf(0.4 * t, stage), abs=1e-9)


def test_uneven_steps_and_changing_temperature_do_not_change_a_constant_result(cell, rng):
    t = np.concatenate([[0.0], np.cumsum(rng.uniform(0.5, 5.0, 200))])
    current = np.full(201, 30.0)
    run = simulate(cell, t, current, np.linspace(290.0, 291.0, 201), 0.9)
    other = simulate(cell, np.array([0.0, t[-1]]), [30.0, 30.0], 290.0, 0.9)
    assert run.state[2:, -1] == pytest.approx(other.state[2:, -1], rel=1e-9)
    assert run.soc[-1] == pytest.approx(other.soc[-1])


def test_the_same_line_serves_numbers_arrays_and_symbols(cell, rng):
    x = ca.SX.sym("x", len(states(cell)))
    i, warm = ca.SX.sym("i"), ca.SX.sym("T")
    parts = [x[k] for k in range(x.numel())]
    outputs = [ca.vertcat(*derivative(cell, parts, i, warm)), voltage(cell, parts, i, warm), heat(cell, parts, i, warm)]
    symbolic = ca.Function("f", [x, i, warm], outputs)
    batch = random_state(cell, rng, (20,))
    current, temperature = rng.uniform(-80, 150, 20), rng.uniform(270, 320, 20)
    rates = derivative(cell, batch, current, temperature)
    u, q = voltage(cell, batch, current, temperature), heat(cell, batch, current, temperature)
    for k in range(20):
        dx, uk, qk = symbolic([float(part[k]) for part in batch], current[k], temperature[k])
        assert np.asarray(dx).ravel() == pytest.approx([float(np.broadcast_to(r, (20,))[k]) for r in rates], abs=1e-12)
        assert (float(uk), float(qk)) == (pytest.approx(u[k], abs=1e-12), pytest.approx(q[k], abs=1e-9))


@pytest.mark.timing
@pytest.mark.parametrize("jitter", [0.0, 0.1])
def test_samples_of_a_long_log_cost_little_each_also_where_the_clock_jitters(cell, rng, jitter):
    t, current = np.concatenate([[0.0], np.cumsum(rng.uniform(1.0 - jitter, 1.0 + jitter, 29999))]), rng.normal(0, 40, 30000)
    two = least_time(lambda: [simulate(cell, t[:2], current[:2], WARM, 0.5) for _ in range(100)])
    # all 30,000 for less than 300 calls with two: 0.03 and 0.08 s where those take 0.1
    assert least_time(lambda: simulate(cell, t, current, WARM, 0.5)) < 3.0 * two


@pytest.mark.parametrize("poles", [(0.667, 0.0667, 0.00667, 0.001), (0.4, 0.4, 0.4, 0.4), (3.0, 3.0000001, 1e-4, 2.0)])
def test_steps_of_the_filters_are_the_matrix_exponential_of_scipy(poles):
    from scipy.linalg import expm

    w, dt = np.array(poles), np.array([1e-6, 0.1, 1.0, 30.0, 3600.0])
    for chain in (True, False):
        rates = -np.diag(w) + (np.diag(w[1:], -1) if chain else 0.0)
        assert transitions(dt, w[None, :], chain=chain) == pytest.approx(np.stack([expm(h * rates) for h in dt]), abs=1e-11)


def test_a_cell_survives_being_written_and_read(cell, tmp_path):
    path = tmp_path / "cell.toml"
    path.write_text(dump_cell(cell), encoding="utf-8")
    assert load_cell(path) == cell


@pytest.mark.parametrize("name", ["a123_26650", "nmc_40ah"])
def test_shipped_cells_load_round_and_have_sane_voltages(name, tmp_path):
    assert name in shipped_cells()
    cell = load_cell(name)
    (tmp_path / "again.toml").write_text(dump_cell(cell), encoding="utf-8")
    assert load_cell(tmp_path / "again.toml") == cell
    soc = np.linspace(0.0, 1.0, 51)
    for warm in (278.15, 298.15, 318.15):
        ocv = cell.ocv_v(soc, warm)
        assert np.all(np.diff(ocv) > -2e-3)  # flat stretches of LFP; 2 mV of the fit
        assert cell.limits.voltage_min_v - 0.7 < ocv[0] < ocv[-1] < cell.limits.voltage_max_v + 0.05


def text(**changes) -> str:
    return dump_cell(make("mesc", **changes))


@pytest.mark.parametrize(
    ("broken", "says"),
    [
        (lambda s: s.replace("capacity_ah = 40.0", "capacity_ah = -1.0"), "capacity_ah is -1.0, expected"),
        (lambda s: s.replace("capacity_ah = 40.0\n", ""), "key capacity_ah is missing"),
        (lambda s: s.replace("capacity_ah = 40.0", 'capacity_ah = "forty"'), "capacity_ah is 'forty'"),
        (lambda s: s.replace("[limits]", "[limits]\ncolour = 3"), "unknown key limits.colour"),
        (lambda s: s.replace('model = "mesc"', 'model = "rint"'), "model is 'rint'"),
        (lambda s: s.replace('model = "mesc"', 'model = "rc"'), r"expected the table \[rc\]"),
        (lambda s: s.replace("voltage_min_v = 2.8", "voltage_min_v = 5.0"), "limits: voltage_min_v is 5, expected less than"),
        (lambda s: s.replace("soc = [0.0, 0.1, 0.9, 1.0]", "soc = [0.0, 0.9, 0.1, 1.0]"), "ocv_v: .*increasing"),
        (lambda s: s.replace("values = [3.0, 3.5, 4.0, 4.15]", "values = [3.0, 3.5, 4.0]"), "ocv_v: .*shape"),
        (lambda s: s.replace("[0.006, 0.003]", "[0.006, -0.003]"), "resistance has a value of -0.003"),
        (lambda s: s.replace("values = [0.03, 0.02]", 'values = [0.03, 0.02]\nextrapolate = "linear"'), "hysteresis_v continues linearly"),
        (lambda s: s + "\n= 3", "not TOML"),
        (lambda s: s.replace("charge_max_a = 40.0", "charge_max_a = 400.0"), "charge_max_a is 400, expected at most"),
        (lambda s: s.replace("coulombic_efficiency = 0.99", "coulombic_efficiency = 1.2"), "coulombic_efficiency is 1.2"),
    ],
)
def test_a_malformed_cell_is_refused_in_one_line_that_names_file_and_key(broken, says, tmp_path):
    path = tmp_path / "cell.toml"
    path.write_text(broken(text()), encoding="utf-8")
    with pytest.raises(VehicleError, match=says) as error:
        load_cell(path)
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("name", ["a123_26650", "nmc_40ah"])
def test_a_cell_frozen_at_a_temperature_answers_the_same_there(name, rng):
    cell = load_cell(name)
    frozen = frozen_at(cell, 283.0)
    x, current = random_state(cell, rng, (50,)), rng.uniform(-80, 150, 50)
    assert voltage(frozen, x, current, 283.0) == pytest.approx(voltage(cell, x, current, 283.0), abs=1e-12)
    assert voltage(frozen, x, current, 313.0) == pytest.approx(voltage(cell, x, current, 283.0), abs=1e-12)


def test_an_unknown_name_says_which_cells_ship():
    with pytest.raises(VehicleError, match=r"no shipped cell.*a123_26650"):
        load_cell("duracell")


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"t": [0.0, 1.0, 1.0]}, "time at sample 2"),
        ({"current": [0.0, np.nan, 0.0]}, "current at sample 1 is not finite"),
        ({"current": [0.0, 0.0]}, "expected two equal columns"),
        ({"temperature": 25.0}, "kelvin"),
        ({"temperature": [298.0, 298.0]}, "temperature has shape"),
        ({"soc0": np.nan}, "finite"),
    ],
)
def test_a_run_refuses_what_cannot_be(change, says):
    given = {"t": [0.0, 1.0, 2.0], "current": [1.0, 1.0, 1.0], "temperature": WARM, "soc0": 0.5} | change
    with pytest.raises(VehicleError, match=says):
        simulate(make("rc"), **given)


def test_efficiency_over_charge_is_refused():
    with pytest.raises(VehicleError, match="depends on soc"):
        make("rc", coulombic_efficiency=Table(soc=(0.0, 1.0), values=(0.9, 0.95)))
