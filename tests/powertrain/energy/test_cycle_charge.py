"""Drive cycles out of a battery: every joule and every coulomb, and ranges."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from powertrain import Vehicle, drive_cycle, load_vehicle, shipped
from powertrain.battery import Cell, PackModel, Pair, Rc, Table, dump_cell, load_cell
from powertrain.description.sections import Battery
from powertrain.energy.cycle_charge import ChargeLedger, charge_over_cycle
from roads import cycles

WLTC = cycles.load("wltc_3b")


def on_cycle(car: Vehicle, name: str = "wltc_3b", **options: float | str) -> ChargeLedger:
    cycle = cycles.load(name)
    return charge_over_cycle(car, cycle.t, np.minimum(cycle.v, car.limits.speed_max_mps), **options)  # pyright: ignore[reportArgumentType]


def battery_of(car: Vehicle) -> Battery:
    return car.need("battery", Battery)


def stored(car: Vehicle, high: float, low: float, temperature: float = 298.15) -> float:
    """Energy between two charges, J: integral of the open-circuit voltage over charge."""
    battery = battery_of(car)
    cell = load_cell(battery.cell)
    soc = np.union1d(np.linspace(low, high, 20_001), [s for s in (cell.ocv_v.soc or ()) if low < s < high])
    volts = np.asarray(cell.ocv_v(soc, temperature))
    return float(np.sum(0.5 * (volts[1:] + volts[:-1]) * np.diff(soc))) * cell.capacity * battery.series * battery.parallel


def with_cell(car: Vehicle, tmp_path: Path, *, series: int = 96, parallel: int = 2, **changes: object) -> Vehicle:
    """`car` on cells of 3.6 V behind 2 mOhm at every charge, 40 Ah; nothing else in them."""
    base = load_cell("nmc_40ah")
    limits = msgspec.structs.replace(base.limits, voltage_min_v=2.0, voltage_max_v=5.0)
    fields = {"name": "ideal", "model": "rc", "capacity_ah": 40.0, "heat_capacity_jpk": 1000.0, "limits": limits, "validity": base.validity}
    fields["ocv_v"] = Table(soc=(0.0, 1.0), values=(3.6, 3.6))
    fields["rc"] = Rc(ohmic_ohm=2e-3, pairs=(Pair(resistance_ohm=0.0, time_constant_s=10.0),))
    file = tmp_path / "ideal.toml"
    file.write_text(dump_cell(Cell(**(fields | changes))))  # pyright: ignore[reportArgumentType]
    return msgspec.structs.replace(car, battery=Battery(cell=str(file), series=series, parallel=parallel))


@pytest.fixture(scope="module")
def compact() -> Vehicle:
    return load_vehicle("compact")


@pytest.fixture(scope="module")
def emptied(compact: Vehicle) -> ChargeLedger:
    return on_cycle(compact, soc=0.9, until="empty")


def test_power_of_a_cycle_adds_up_to_its_energy_and_cannot_be_written(compact: Vehicle):
    ledger = drive_cycle(compact, WLTC.t, WLTC.v)
    assert ledger.power.shape == (len(WLTC.t) - 1,)
    assert float(np.sum(ledger.power * np.diff(WLTC.t))) == pytest.approx(ledger.energy, rel=1e-12)
    assert np.min(ledger.power) < 0.0
    with pytest.raises(ValueError, match="read-only"):
        ledger.power[0] = 1.0


@pytest.mark.parametrize("name", shipped())
@pytest.mark.parametrize("until", ["once", "empty"])
def test_terminal_energy_and_losses_are_the_energy_that_left_the_charge(name: str, until: str):
    """Asked for 0.1 %. The middle of each second is exact but where it passes a node of the open-circuit voltage."""
    car = load_vehicle(name)
    ledger = on_cycle(car, soc=0.9, until=until)
    assert ledger.energy + ledger.loss == pytest.approx(stored(car, float(ledger.soc[0]), float(ledger.soc[-1])), rel=1e-7)
    # the rest is polarisation, given back in part
    assert ledger.heat == pytest.approx(ledger.loss, rel=0.1)


@pytest.mark.parametrize("name", shipped())
def test_charge_drawn_is_the_change_of_soc(name: str):
    car = load_vehicle(name)
    ledger = on_cycle(car, soc=0.9)
    full = load_cell(battery_of(car).cell).capacity_ah * battery_of(car).parallel
    assert (ledger.soc[0] - ledger.soc[-1]) * full == pytest.approx(ledger.charge_ah, rel=1e-10)
    assert float(np.sum(ledger.current * np.diff(ledger.time))) / 3600.0 == pytest.approx(ledger.charge_ah, rel=1e-12)


@pytest.mark.parametrize("name", shipped())
def test_the_battery_gives_what_the_cycle_asks_where_no_limit_binds(name: str):
    ledger = on_cycle(load_vehicle(name), soc=0.8)
    assert ledger.power == pytest.approx(ledger.cycle.power, abs=1e-4)
    assert sum(ledger.components.values()) == pytest.approx(ledger.energy, rel=1e-9)
    assert ledger.unserved == ledger.refused == 0.0
    assert ledger.shortage is ledger.refusal is None
    assert ledger.end == "cycle done"
    assert ledger.time.shape == ledger.distance.shape == ledger.soc.shape == ledger.voltage.shape == WLTC.t.shape
    assert ledger.current.shape == (len(WLTC.t) - 1,)
    assert ledger.cycles == pytest.approx(1.0)


def test_steps_of_a_second_follow_an_exact_integrator(compact: Vehicle):
    """LSODA on the pack's differential equations, the power held at every instant, over its hardest half minute."""
    from scipy.integrate import solve_ivp

    rows = slice(1560, 1591)
    t, v = WLTC.t[rows] - WLTC.t[1560], WLTC.v[rows]
    found = charge_over_cycle(compact, t, v, soc=0.6)
    assert np.array_equal(found.speed, v)
    assert found.distance[-1] == pytest.approx(float(np.sum(0.5 * (v[1:] + v[:-1]))))
    pack = PackModel(load_cell("nmc_40ah"), 96, 2)
    x = np.array(pack.rest(0.6, 298.15))

    def rate(_: float, y: np.ndarray, power: float) -> np.ndarray:
        state = [*y[:-1], 298.15]
        return np.array([*pack.derivative(state, pack.current_from_power(power, state).current, 298.15)[:-1], 0.0], dtype=np.float64)

    exact = [x[0]]
    for power, dt in zip(found.cycle.power, np.diff(t), strict=True):
        x = solve_ivp(rate, (0.0, dt), x, method="LSODA", args=(power,), rtol=1e-7, atol=1e-9).y[:, -1]
        exact.append(x[0])
    moved = exact[0] - min(exact)
    assert moved > 0.002
    assert found.soc == pytest.approx(exact, abs=1e-4 * moved)
    last = [*x[:-1], 298.15]
    assert found.voltage[-1] == pytest.approx(float(pack.voltage(last, found.current[-1])), abs=0.02)


def test_an_ideal_battery_has_the_current_of_the_quadratic_and_the_range_of_its_charge(compact: Vehicle, tmp_path: Path):
    car = with_cell(compact, tmp_path)
    t, v = np.arange(0.0, 601.0), np.full(601, 25.0)
    ledger = charge_over_cycle(car, t, v, soc=0.9)
    volts, ohm, power = 96 * 3.6, 96 * 2e-3 / 2, ledger.cycle.power[0]
    current = (volts - np.sqrt(volts**2 - 4.0 * ohm * power)) / (2.0 * ohm)
    assert ledger.current == pytest.approx(np.full(600, current), rel=1e-9)
    assert ledger.voltage == pytest.approx(np.full(601, volts - ohm * current), rel=1e-9)
    assert ledger.loss == pytest.approx(ohm * current**2 * 600.0, rel=1e-9)
    assert ledger.heat == pytest.approx(ledger.loss, rel=1e-9)
    way = 25.0 * 0.85 * 80.0 * 3600.0 / current
    assert ledger.range == pytest.approx(way, rel=1e-9)
    assert charge_over_cycle(car, t, v, soc=0.9, until="empty").range == pytest.approx(way, abs=25.0)


def test_a_long_interval_is_driven_in_parts_and_takes_what_short_ones_take(compact: Vehicle):
    coarse = charge_over_cycle(compact, [0.0, 30.0, 3000.0, 3030.0], [0.0, 20.0, 20.0, 0.0], soc=0.9)
    t = np.arange(0.0, 3031.0)
    v = np.interp(t, [0.0, 30.0, 3000.0, 3030.0], [0.0, 20.0, 20.0, 0.0])
    fine = charge_over_cycle(compact, t, v, soc=0.9)
    steady = (coarse.time >= 30.0) & (coarse.time <= 3000.0)
    assert coarse.distance[-1] == pytest.approx(fine.distance[-1], rel=1e-12)
    assert coarse.speed == pytest.approx(np.interp(coarse.time, t, v), abs=1e-9)
    drop = np.interp(coarse.time[steady], t, fine.soc) - coarse.soc[steady]
    # the ramp differs by its mean drag; after it both fall alike
    assert drop - drop[0] == pytest.approx(np.zeros(len(drop)), abs=2e-6)


def test_range_is_that_of_the_energy_less_what_is_lost_inside(compact: Vehicle, emptied: ChargeLedger):
    """At constant speed no part of a cycle matters: to 0.1 %. On the WLTC, whose last round is cut short, to 1 %."""
    usable = stored(compact, 0.9, 0.05)
    steady = charge_over_cycle(compact, np.arange(0.0, 101.0), np.full(101, 25.0), soc=0.9, until="empty")
    for ledger, exact in ((steady, 1e-3), (emptied, 1e-2)):
        assert ledger.range is not None
        assert ledger.end == "soc"
        assert ledger.soc[-1] == pytest.approx(0.05, abs=2e-4)
        assert ledger.range == pytest.approx(ledger.cycle.range(usable), rel=0.03)
        assert ledger.range < ledger.cycle.range(usable)
        assert ledger.range == pytest.approx(ledger.cycle.range(usable - ledger.loss), rel=exact)


def test_repeating_a_cycle_is_driving_it_written_twice(compact: Vehicle, emptied: ChargeLedger):
    n = len(WLTC.t)
    twice = charge_over_cycle(compact, np.append(WLTC.t, WLTC.t[1:] + WLTC.t[-1]), np.append(WLTC.v, WLTC.v[1:]), soc=0.9)
    assert twice.soc == pytest.approx(emptied.soc[: 2 * n - 1], abs=1e-12)
    assert twice.distance == pytest.approx(emptied.distance[: 2 * n - 1], rel=1e-12)
    assert np.all(np.diff(emptied.time) == 1.0)
    assert emptied.cycles == pytest.approx(emptied.distance[-1] / WLTC.distance)


def test_standing_draws_auxiliaries_and_inverters_only(compact: Vehicle):
    t = np.array([0.0, 1.0, 2.0, 2.0 + 3600.0])
    ledger = charge_over_cycle(compact, t, [0.0, 1.0, 0.0, 0.0], soc=0.5)
    assert compact.electrics is not None
    electrics = compact.electrics
    draw = electrics.auxiliary_w / electrics.converter_efficiency + electrics.converter_constant_w + compact.drive.inverter_constant_w
    still = ledger.time[:-1] >= 2.0
    assert ledger.power[still] == pytest.approx(np.full(np.sum(still), draw), rel=1e-3)
    assert np.ptp(ledger.distance[2:]) == 0.0
    before = float(np.interp(2.0, ledger.time, ledger.soc))
    assert stored(compact, before, float(ledger.soc[-1])) == pytest.approx(draw * 3600.0, rel=2e-3)


def test_a_cell_with_hysteresis_and_coulombic_losses_runs_until_it_is_empty(compact: Vehicle):
    car = msgspec.structs.replace(compact, battery=Battery(cell="a123_26650", series=110, parallel=40))
    ledger = on_cycle(car, soc=0.9, until="empty")
    assert ledger.end in ("soc", "voltage", "current")
    assert ledger.range is not None
    assert ledger.range == pytest.approx(ledger.cycle.range(stored(car, 0.9, float(ledger.soc[-1]))), rel=0.1)


def test_cold_cells_lose_more(compact: Vehicle):
    losses = [on_cycle(compact, soc=0.9, temperature=kelvin).loss for kelvin in (278.15, 288.15, 298.15, 318.15)]
    assert losses == sorted(losses, reverse=True)
    assert losses[0] > 1.5 * losses[2]


@pytest.mark.parametrize(("name", "published"), [("compact", 11.1), ("dual_motor", 16.0), ("van", 26.2)])
def test_shipped_cars_go_about_as_far_as_is_published(name: str, published: float):
    """Of 5 to 95 % of charge on the WLTC, against that energy over the published kWh/100 km (`test_performance`): as near as the consumption."""
    car = load_vehicle(name)
    ledger = on_cycle(car, soc=0.95, until="empty")
    assert ledger.range == pytest.approx(stored(car, 0.95, 0.05) / (36.0 * published), rel=0.1)
