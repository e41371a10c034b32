"""The bounds on force: `ceiling` inverts `excess`, `majorant` lies above `ceiling`, symbols give the same numbers."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from energy_mgr.speed.bounds.forces import UNBOUND, ElectricPower, ForceLimit, Grip, Power, Torque, grip_loads
from powertrain import Vehicle, load_vehicle
from powertrain.description.sections import Weakening
from powertrain.vehicle import GRAVITY

from ..rig import ROMO, VAN, changed

#: Values per interval in these tests.
N = 7
SIGNS = st.sampled_from([1, -1])


def random_car(rng: np.random.Generator) -> Vehicle:
    base = (ROMO, VAN)[int(rng.integers(2))]
    drive = {
        "torque_max_nm": rng.uniform(0.2, 2.0) * base.drive.torque_max_nm,
        "regen_torque_max_nm": rng.uniform(0.05, 2.0) * base.drive.regen_torque_max_nm,
        "power_max_w": rng.uniform(0.05, 2.0) * base.drive.power_max_w,
        "regen_power_max_w": rng.uniform(0.02, 2.0) * base.drive.regen_power_max_w,
        "phase_resistance_ohm": rng.uniform(0.2, 3.0) * base.drive.phase_resistance_ohm,
        "inverter_constant_w": rng.uniform(0.0, 2.0) * base.drive.inverter_constant_w,
        "gear_efficiency": rng.uniform(0.85, 1.0),
    }
    return changed(base, drive=drive, chassis={"mass_kg": rng.uniform(500, 4000)})


def grip(rng: np.random.Generator, sign: int) -> Grip:
    friction = rng.uniform(0.2, 1.2, N)
    bank = rng.uniform(-0.9, 0.9, N) * np.minimum(np.arctan(friction), 0.3)
    return Grip(sign, float(rng.uniform(0.3, 1.0)), friction, rng.uniform(-0.05, 0.05, N), bank)


def grip_speed(limit: Grip) -> np.ndarray:
    """Where the ellipse is empty, by a scan: no speed below it uses up the friction."""
    u = np.linspace(0.0, 60.0, 6001)[:, None]
    lateral, most = grip_loads(u, *limit.data)
    beyond = np.abs(lateral) > most
    first = np.where(beyond.any(axis=0), np.argmax(beyond, axis=0), len(u) - 1)
    return np.maximum(u[np.maximum(first - 1, 0), 0], 0.0)


def made(kind: str, rng: np.random.Generator, sign: int) -> ForceLimit:
    if kind == "electric":
        return ElectricPower(sign, rng.uniform(1e3, 6e4, N), float(rng.uniform(0.0, 800.0)))
    return {"torque": Torque, "power": Power}[kind](sign) if kind != "grip" else grip(rng, sign)


def speeds(limit: ForceLimit, rng: np.random.Generator) -> np.ndarray:
    return rng.uniform(0.0, 0.98, N) * grip_speed(limit) if isinstance(limit, Grip) else rng.uniform(0.2, 35.0, N)


KINDS = st.sampled_from(["torque", "power", "electric", "grip"])
SEEDS = st.integers(0, 2**32 - 1)


@settings(max_examples=120, deadline=None)
@given(kind=KINDS, seed=SEEDS, sign=SIGNS)
def test_the_excess_at_the_ceiling_is_zero_below_it_negative_above_it_positive(kind: str, seed: int, sign: int):
    rng = np.random.default_rng(seed)
    car, limit = random_car(rng), made(kind, rng, sign)
    v = speeds(limit, rng)
    most = np.asarray(limit.ceiling(car, v, limit.data))
    assert np.all(most >= 0.0)
    bound = (most > 1e-6) & (most < 0.99 * UNBOUND)
    assert limit.excess(car, sign * most, v, limit.data)[bound] == pytest.approx(np.zeros(bound.sum()), abs=1e-7)
    step = 1e-3 * most + 1.0
    assert np.all(limit.excess(car, sign * (most - step), v, limit.data)[bound] < 0.0)
    # recuperation has a vertex: just above the ceiling the power still grows, unless the ceiling is the vertex
    above = limit.excess(car, sign * (most + 1e-4 * step), v, limit.data)[bound]
    assert np.all(above > -1e-9)


@settings(max_examples=60, deadline=None)
@given(kind=st.sampled_from(["torque", "power", "grip"]), seed=SEEDS, sign=SIGNS)
def test_more_force_is_more_excess(kind: str, seed: int, sign: int):
    rng = np.random.default_rng(seed)
    car, limit = random_car(rng), made(kind, rng, sign)
    v = speeds(limit, rng)
    forces = np.linspace(-8e3, 8e3, 33)[:, None] * sign
    values = limit.excess(car, forces, v, limit.data)
    assert np.all(np.diff(values, axis=0) >= 0.0)


@settings(max_examples=60, deadline=None)
@given(seed=SEEDS)
def test_electric_driving_power_rises_with_force_and_falls_back_with_braking(seed: int):
    rng = np.random.default_rng(seed)
    car, limit = random_car(rng), ElectricPower(1, np.full(N, 2e4), 300.0)
    v = rng.uniform(0.2, 35.0, N)
    forces = np.linspace(0.0, 2e4, 41)[:, None]
    assert np.all(np.diff(limit.excess(car, forces, v, limit.data), axis=0) > 0.0)
    # what is drawn equals wheel power plus losses, which are the same for both signs
    drawn, back = limit.drawn(car, forces, v), limit.drawn(car, -forces, v)
    assert drawn - back == pytest.approx(2.0 * forces * v, rel=1e-9, abs=1e-6)
    assert np.all(drawn + back >= 2.0 * 300.0)


@settings(max_examples=60, deadline=None)
@given(seed=SEEDS, sign=SIGNS, kind=st.sampled_from(["torque", "power"]))
def test_motor_ceilings_never_rise_with_speed(seed: int, sign: int, kind: str):
    rng = np.random.default_rng(seed)
    car, limit = random_car(rng), made(kind, rng, sign)
    v = np.linspace(0.0, 40.0, 500)
    assert np.all(np.diff(limit.ceiling(car, v, limit.data)) <= 1e-9)


@settings(max_examples=150, deadline=None)
@given(kind=KINDS, seed=SEEDS, sign=SIGNS)
def test_the_majorant_is_above_the_ceiling_at_all_speeds_up_to_the_fastest(kind: str, seed: int, sign: int):
    rng = np.random.default_rng(seed)
    car, limit = random_car(rng), made(kind, rng, sign)
    fastest = grip_speed(limit) if isinstance(limit, Grip) else rng.uniform(0.2, 35.0, N)
    v = rng.uniform(0.0, 1.0, N) * fastest
    line = limit.majorant(car, v, fastest, limit.data)
    assume(line is not None)
    u = np.linspace(0.0, 1.0, 301)[:, None] * fastest
    # motor power is replaced by torque and power together: what must hold is that both together are below
    least = np.asarray(limit.ceiling(car, u, limit.data))
    if isinstance(limit, Power):
        least = np.minimum(least, Torque(sign).ceiling(car, u, ()))
    above = line[0] + line[1] * u**2
    assert np.all(above >= least * (1.0 - 1e-9) - 1e-6)


@settings(max_examples=60, deadline=None)
@given(seed=SEEDS, sign=SIGNS)
def test_the_majorant_of_grip_touches_its_ellipse_where_it_is_asked_for(seed: int, sign: int):
    rng = np.random.default_rng(seed)
    limit = grip(rng, sign)
    v = rng.uniform(0.0, 0.9, N) * grip_speed(limit)
    line = limit.majorant(ROMO, v, grip_speed(limit), limit.data)
    assume(line is not None)
    lateral, most = grip_loads(v, *limit.data)
    exact = ROMO.chassis.mass_kg * GRAVITY * limit.share * np.sqrt(np.maximum(most**2 - lateral**2, 0.0))
    wide = most**2 - lateral**2 > 1e-3
    assert (line[0] + line[1] * v**2)[wide] == pytest.approx(exact[wide], rel=1e-9)


def test_the_majorant_of_power_is_exact_at_the_corner_and_at_the_fastest_speed():
    corner = ROMO.drive.power_max_w / ROMO.drive.torque_max_nm / ROMO.motor_ratio
    fastest = np.array([1.4 * corner])
    c0, c2 = Power(1).majorant(ROMO, fastest, fastest, ())
    torque = Torque(1).ceiling(ROMO, corner, ())
    assert (c0 + c2 * corner**2)[0] == pytest.approx(torque, rel=1e-9)
    assert (c0 + c2 * fastest**2)[0] == pytest.approx(Power(1).ceiling(ROMO, fastest, ())[0], rel=1e-9)


def test_a_road_below_the_corner_speed_has_no_bound_on_power_and_battery_power_has_no_line():
    slow = np.array([0.5 * ROMO.drive.power_max_w / ROMO.drive.torque_max_nm / ROMO.motor_ratio])
    c0, c2 = Power(1).majorant(ROMO, slow, slow, ())
    assert c0[0] >= 1e6
    assert c2[0] == 0.0
    assert ElectricPower(1, np.ones(1)).majorant(ROMO, slow, slow, (np.ones(1),)) is None
    assert Power(-1).majorant(changed(ROMO, drive={"regen_power_max_w": 0.0}), slow, slow, ()) is None


def test_the_grip_ceiling_is_the_ellipse_less_its_rounding():
    data = np.array([0.8]), np.array([0.02]), np.array([0.0])
    v = np.array([10.0])
    weight = ROMO.chassis.mass_kg * GRAVITY
    exact = weight * np.sqrt(0.8**2 - (0.02 * 100 / GRAVITY) ** 2)
    found = Grip(1, 1.0, *data).ceiling(ROMO, v, data)[0]
    assert exact * (1.0 - 1e-3) < found <= exact


@settings(max_examples=40, deadline=None)
@given(seed=SEEDS, sign=SIGNS)
def test_grip_holds_for_left_and_right_bends_alike(seed: int, sign: int):
    rng = np.random.default_rng(seed)
    one = grip(rng, sign)
    other = Grip(sign, one.share, one.friction, -one.kappa, -one.bank)
    v = rng.uniform(0.0, 0.98, N) * grip_speed(one)
    assert one.ceiling(ROMO, v, one.data) == pytest.approx(other.ceiling(ROMO, v, other.data), rel=1e-12)


@settings(max_examples=40, deadline=None)
@given(kind=KINDS, seed=SEEDS, sign=SIGNS)
def test_casadi_symbols_give_the_same_excess(kind: str, seed: int, sign: int):
    rng = np.random.default_rng(seed)
    car, limit = random_car(rng), made(kind, rng, sign)
    v, force = speeds(limit, rng), rng.uniform(-6e3, 6e3, N)
    own = [ca.SX.sym(f"data{k}") for k in range(len(limit.data))]
    f, u = ca.SX.sym("force"), ca.SX.sym("v")
    symbolic = ca.Function("excess", [f, u, *own], [limit.excess(car, f, u, tuple(own))])
    numeric = np.broadcast_to(limit.excess(car, force, v, limit.data), (N,))
    for k in range(N):
        assert float(symbolic(force[k], v[k], *(x[k] for x in limit.data))) == pytest.approx(numeric[k], rel=1e-12, abs=1e-14)


@settings(max_examples=30, deadline=None)
@given(seed=SEEDS, sign=SIGNS)
def test_casadi_derivatives_of_the_excess_are_finite_also_without_force_and_at_rest(seed: int, sign: int):
    rng = np.random.default_rng(seed)
    for kind in ("torque", "power", "electric", "grip"):
        car, limit = random_car(rng), made(kind, rng, sign)
        own = [ca.SX.sym(f"data{k}") for k in range(len(limit.data))]
        f, u = ca.SX.sym("force"), ca.SX.sym("v")
        value = limit.excess(car, f, u, tuple(own))
        slope = ca.Function("slope", [f, u, *own], [ca.gradient(value, f), ca.gradient(value, u)])
        given_data = [x[0] for x in limit.data]
        for force, v in ((0.0, 0.0), (0.0, 10.0), (1e3, 0.0)):
            assert np.all(np.isfinite([float(x) for x in slope(force, v, *given_data)]))


@settings(max_examples=40, deadline=None)
@given(seed=SEEDS, sign=SIGNS)
def test_field_weakening_lowers_the_battery_ceiling_and_the_excess_is_still_zero_there(seed: int, sign: int):
    rng = np.random.default_rng(seed)
    weak = Weakening(inductance_h=150e-6, current_max_a=530.0, dc_voltage_v=400.0)
    car = changed(load_vehicle("compact"), drive={"weakening": weak, "magnet_flux_wb": 0.045, "torque_max_nm": 200.0, "power_max_w": 6e4})
    limit = ElectricPower(sign, rng.uniform(2e4, 8e4, N), 200.0)
    v = rng.uniform(20.0, 0.98 * car.limits.speed_max_mps, N)
    most = limit.ceiling(car, v, limit.data)
    bound = (most > 1.0) & (most < 0.99 * UNBOUND)
    plain = limit.ceiling(changed(car, drive={"weakening": None}), v, limit.data)
    assert np.all(sign * most[bound] <= sign * plain[bound] + 1e-6)
    assert np.abs(limit.excess(car, sign * most, v, limit.data)[bound]) == pytest.approx(np.zeros(bound.sum()), abs=1e-5)
