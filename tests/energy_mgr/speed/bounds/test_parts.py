"""Each part's bound against numbers worked out by hand."""

from itertools import permutations

import msgspec
import numpy as np
import pytest
from scipy.optimize import brentq

from energy_mgr.speed import Arrival, BatteryPower, Comfort, FrictionBrakes, Grip, Jerk, Lateral, Motors, Posted, SpeedCap, Stop
from energy_mgr.speed.bounds.forces import UNBOUND
from energy_mgr.speed.bounds.parts import Part
from powertrain import VehicleError, force_limits, motor_losses
from powertrain.vehicle import GRAVITY

from ..rig import ROMO, VAN, bare, changed, ground, limits_of

G = GRAVITY
INF = float("inf")


def test_a_lateral_limit_on_a_flat_bend_is_the_root_of_acceleration_times_radius():
    limits = limits_of(extra=[Lateral(3.0)], parts=[], kappa=-1.0 / 50.0)
    # sqrt(3 * 50) = 12.247
    assert limits.v_max == pytest.approx(np.full(len(limits.s), 12.24744871), abs=1e-7)


@pytest.mark.parametrize(
    ("kappa", "bank", "expected"),
    [
        # left bend, right side higher (the bank helps): v^2 = 50 (3 + g sin 0.1) / cos 0.1
        (0.02, -0.1, np.sqrt(50 * (3.0 + 9.81 * 0.0998334) / 0.9950042)),
        # left bend, left side higher (it hinders)
        (0.02, 0.1, np.sqrt(50 * (3.0 - 9.81 * 0.0998334) / 0.9950042)),
        (-0.02, 0.1, np.sqrt(50 * (3.0 + 9.81 * 0.0998334) / 0.9950042)),
        (-0.02, -0.1, np.sqrt(50 * (3.0 - 9.81 * 0.0998334) / 0.9950042)),
    ],
)
def test_bank_helps_or_hinders_in_a_bend(kappa: float, bank: float, expected: float):
    limits = limits_of(extra=[Lateral(3.0)], parts=[], kappa=kappa, bank=bank)
    assert limits.speeds["lateral"] == pytest.approx(np.full(len(limits.s), expected), abs=1e-5)


@pytest.mark.parametrize(("kappa", "bank"), [(0.02, -0.1), (0.02, 0.1), (-0.03, 0.05), (0.04, 0.0)])
def test_passengers_feel_just_the_lateral_limit_at_the_bound(kappa: float, bank: float):
    v = limits_of(extra=[Lateral(2.5)], parts=[], kappa=kappa, bank=bank).speeds["lateral"][3]
    assert abs(kappa * v**2 * np.cos(bank) + G * np.sin(bank)) == pytest.approx(2.5, abs=1e-9)


@pytest.mark.parametrize(("kappa", "bank", "mu"), [(0.02, 0.0, 0.8), (0.02, -0.1, 0.8), (0.02, 0.1, 0.8), (-0.05, 0.06, 0.3), (-0.05, -0.06, 0.3)])
def test_grip_speed_is_where_tangential_force_reaches_friction_times_load(kappa: float, bank: float, mu: float):
    limits = limits_of(extra=[Grip(mu)], parts=[], kappa=kappa, bank=bank)

    def beyond(v: float) -> float:
        # forces per mass in the plane of the road and square to it, from the free body
        across = kappa * v**2 * np.cos(bank) + G * np.sin(bank)
        load = G * np.cos(bank) - kappa * v**2 * np.sin(bank)
        return abs(across) - mu * load

    # with the bank on the helping side the car slides inwards at rest only beyond tan(bank) = mu
    at_rest = np.sqrt(G * np.tan(abs(bank)) / abs(kappa)) if kappa * bank < 0 else 0.0
    expected = brentq(beyond, at_rest, 60.0, xtol=1e-12)
    assert limits.speeds["grip"][5] == pytest.approx(expected, rel=1e-9)


def test_grip_on_a_flat_bend_is_the_textbook_formula():
    limits = limits_of(extra=[Grip(0.8)], parts=[], kappa=0.02, friction=0.5)
    # half the friction of dry asphalt: sqrt(0.4 * 9.81 * 50)
    assert limits.speeds["grip"] == pytest.approx(np.full(len(limits.s), 14.0071410), abs=1e-6)


def test_grip_shares_the_weight_by_driven_axles():
    # the van drives its rear wheels; statics: the rear carries l_front / wheelbase = 1.92 / 3.75
    for vehicle, share in ((VAN, 1.92 / 3.75), (ROMO, 1.0), (msgspec.structs.replace(VAN, body=None), 0.5)):
        assert [limit.share for limit in limits_of(vehicle, extra=[Grip(0.5)], parts=[]).forces] == pytest.approx([share] * 2)
    grips = {limit.sign: limit for limit in limits_of(VAN, extra=[Grip(0.5)], parts=[]).forces}
    force = float(grips[1].ceiling(VAN, np.array([10.0]), tuple(np.zeros(1) + x for x in (0.5, 0.0, 0.0)))[0])
    assert force == pytest.approx(0.5 * 2650 * 9.81 * 0.512, rel=1e-3)
    with_brakes = {limit.sign: limit.share for limit in limits_of(VAN, extra=[FrictionBrakes(5e3), Grip(0.5)], parts=[]).forces}
    assert with_brakes == {1: pytest.approx(0.512), -1: 1.0}


def test_motor_forces_are_those_of_powertrain_at_every_speed():
    limits = limits_of(parts=[Motors()], length=200.0, step=5.0)
    v = np.linspace(0.2, 27.0, len(limits.ds))
    drive, regen = force_limits(ROMO, v)
    mass, resistance = ROMO.effective_mass, limits.resistance(v)
    assert limits.ceiling(v, 1) == pytest.approx((drive - resistance) / mass, rel=1e-12)
    assert limits.ceiling(v, -1) == pytest.approx((regen + resistance) / mass, rel=1e-12)


def electric(vehicle, force: float, v: float) -> float:
    """Power at the battery, auxiliaries included, from the loss model alone."""
    p, a = vehicle.drive, vehicle.electrics
    losses = sum(motor_losses(vehicle, force / (p.motor_count * vehicle.motor_ratio), v * vehicle.motor_ratio))
    return force * v + p.motor_count * losses + (0.0 if a is None else a.auxiliary_w / a.converter_efficiency + a.converter_constant_w)


@pytest.mark.parametrize("vehicle", [ROMO, VAN], ids=["romo", "van"])
@pytest.mark.parametrize("v", [1.0, 5.0, 13.0, 25.0])
def test_battery_power_leaves_the_force_whose_losses_add_up_to_it(vehicle, v: float):
    limits = limits_of(vehicle, extra=[BatteryPower(20e3, 12e3)], parts=[])
    at = np.full(len(limits.ds), v)
    mass, resistance = vehicle.effective_mass, float(limits.resistance(at)[0])
    expected = brentq(lambda f: electric(vehicle, f, v) - 20e3, 0.0, 1e6, xtol=1e-9)
    assert mass * limits.ceiling(at, 1)[0] + resistance == pytest.approx(expected, rel=1e-8)
    # braking: the power given back grows up to a vertex, beyond which braking harder gives back less
    grid = np.linspace(0.0, 4e4, 400_001)
    back = -electric(vehicle, -grid, v)
    if back.max() < 12e3:
        charge = next(limit for limit in limits.forces if limit.sign < 0)
        assert np.min(charge.ceiling(vehicle, at, charge.data)) >= UNBOUND
    else:
        expected = brentq(lambda f: -electric(vehicle, -f, v) - 12e3, 0.0, grid[np.argmax(back)], xtol=1e-9)
        assert mass * limits.ceiling(at, -1)[0] - resistance == pytest.approx(expected, rel=1e-8)


def test_battery_power_varies_from_interval_to_interval():
    count = len(limits_of(parts=[]).ds)
    power = np.linspace(5e3, 30e3, count)
    limits = limits_of(parts=[], extra=[BatteryPower(power, 1e4)])
    accelerations = limits.ceiling(np.full(count, 10.0), 1)
    assert np.all(np.diff(accelerations) > 0.0)
    for k in (0, count - 1):
        force = ROMO.effective_mass * accelerations[k] + float(limits.resistance(np.full(count, 10.0))[k])
        assert electric(ROMO, force, 10.0) == pytest.approx(power[k], rel=1e-9)


def test_battery_power_below_the_auxiliaries_leaves_no_force():
    limits = limits_of(VAN, extra=[BatteryPower(1.0, 1e4)], parts=[])
    v = np.full(len(limits.ds), 10.0)
    assert limits.ceiling(v, 1) * VAN.effective_mass + limits.resistance(v) == pytest.approx(np.zeros_like(v), abs=1e-6)


def test_friction_brakes_of_the_car_are_their_torques_over_the_radius():
    # two wheels on each axle
    assert limits_of(VAN, extra=[FrictionBrakes()]).brake == pytest.approx(2 * (3300 + 2400) / 0.3455)
    assert limits_of(VAN, extra=[FrictionBrakes(1234.0)]).brake == 1234.0
    with pytest.raises(VehicleError, match=r"no section \[brakes\]"):
        limits_of(msgspec.structs.replace(VAN, brakes=None), extra=[FrictionBrakes()])


def test_a_stop_is_zero_at_its_line_alone():
    limits = limits_of(extra=[Stop(101.3)])
    at = int(np.argmin(limits.speeds["stop"]))
    assert limits.s[at] == pytest.approx(101.3, abs=1e-12)
    assert np.sum(limits.v_max == 0.0) == 1
    assert limits.binding(at) == "stop"
    two = limits_of(extra=[Stop(50.0), Stop(120.0)])
    assert two.s[two.v_max == 0.0].tolist() == [50.0, 120.0]


def test_a_cap_holds_from_its_station_to_the_next_and_at_both_ends_of_its_intervals():
    limits = limits_of(extra=[SpeedCap([30.0, 60.0, 90.0], [8.0, INF, 12.0], "works")], parts=[])
    bound, s = limits.speeds["works"], limits.s
    assert np.all(bound[(s >= 30.0) & (s <= 60.0)] == 8.0)
    assert np.all(bound[(s < 30.0) | ((s > 60.0) & (s < 90.0))] == INF)
    assert np.all(bound[s >= 90.0] == 12.0)


def test_posted_limits_hold_in_the_whole_of_both_intervals_beside_their_change():
    limits = limits_of(length=100.0, step=10.0, posted=lambda s: np.where(s < 52.0, 20.0, 10.0))
    # the change lies within 50 to 60: both ends are bound by the lower value
    assert limits.speeds["posted"].tolist() == [20.0] * 5 + [10.0] * 6


def test_comfort_and_jerk_keep_the_strictest_of_several():
    limits = limits_of(extra=[Comfort(1.5, 3.0), Comfort(1.8, 1.2), Jerk(2.0), Jerk(0.7), Jerk(1.0)])
    assert set(limits.acceleration) == {1.5}
    assert set(limits.deceleration) == {1.2}
    assert limits.jerk == 0.7


def test_windows_are_kept_in_the_order_of_the_way():
    windows = limits_of(extra=[Arrival(150.0, 3.0, 40.0), Arrival(20.0)]).windows
    assert [tuple(window) for window in windows] == [(20.0, 0.0, INF), (150.0, 3.0, 40.0)]


PARTS = {
    "posted": Posted(), "lateral": Lateral(2.0), "comfort": Comfort(1.0, 1.5), "motors": Motors(), "battery": BatteryPower(2e4, 1e4),
    "jerk": Jerk(0.9), "stop": Stop(60.0), "cap": SpeedCap([0.0, 100.0], [9.0, 30.0]), "window": Arrival(100.0, 1.0, 90.0),
}  # fmt: skip


def assert_same(one: list[Part], other: list[Part], vehicle=ROMO) -> None:
    way = {"kappa": lambda s: 0.02 * np.sin(s / 20), "bank": 0.02, "height": lambda s: 0.03 * s, "through": [60.0, 100.0]}
    a, b = limits_of(vehicle, parts=one, **way), limits_of(vehicle, parts=other, **way)
    v = np.linspace(0.5, 20.0, len(a.ds))
    assert np.array_equal(a.s, b.s)
    assert np.array_equal(a.v_max, b.v_max)
    assert np.array_equal(a.acceleration, b.acceleration)
    assert np.array_equal(a.deceleration, b.deceleration)
    assert np.array_equal(a.ceiling(v, 1), b.ceiling(v, 1))
    assert np.array_equal(a.ceiling(v, -1), b.ceiling(v, -1))
    assert (a.jerk, a.windows, a.brake) == (b.jerk, b.windows, b.brake)


def test_the_order_of_the_parts_does_not_matter(rng: np.random.Generator):
    parts = [*PARTS.values(), Grip(0.7), Lateral(2.5), SpeedCap([40.0], [7.0], "cap")]
    for _ in range(6):
        assert_same(parts, [parts[k] for k in rng.permutation(len(parts))])


def test_the_order_of_grip_and_friction_brakes_does_not_matter():
    for one in permutations([Grip(0.4), FrictionBrakes(4000.0), Motors()]):
        assert_same([Motors(), FrictionBrakes(4000.0), Grip(0.4)], list(one), VAN)


def test_a_part_given_twice_changes_nothing():
    for part in PARTS.values():
        if not isinstance(part, Arrival):
            assert_same([Motors(), part], [Motors(), part, part])


def test_the_binding_limit_is_the_least_one():
    limits = limits_of(extra=[SpeedCap([0.0, 100.0], [25.0, 5.0])], kappa=lambda s: np.where(s < 50.0, 0.1, 0.0))
    assert limits.binding(2) == "lateral"
    assert limits.binding(len(limits.s) // 2 - 3) == "posted"
    assert limits.binding(-1) == "cap"


def test_scaling_touches_posted_speeds_the_car_and_accelerations_alone():
    limits = limits_of(extra=[SpeedCap([0.0], [15.0]), Stop(100.0)], kappa=0.02, start_speed=9.0)
    half = limits.scaled(0.5)
    assert np.array_equal(half.speeds["posted"], 0.5 * limits.speeds["posted"])
    assert np.array_equal(half.speeds["car"], 0.5 * limits.speeds["car"])
    assert np.array_equal(half.acceleration, 0.5 * limits.acceleration)
    assert np.array_equal(half.deceleration, 0.5 * limits.deceleration)
    for kept in ("lateral", "cap", "stop"):
        assert np.array_equal(half.speeds[kept], limits.speeds[kept])
    assert half.start_speed == 9.0
    assert limits.scaled(0.4).start_speed == pytest.approx(8.0)


def test_parts_leave_the_limits_they_are_given_as_they_were():
    limits = bare(ROMO, ground(np.linspace(0.0, 200.0, 41), kappa=0.01))
    for part in (*PARTS.values(), Grip(0.8), FrictionBrakes(1e3)):
        part.added(limits)
    assert set(limits.speeds) == {"car"}
    assert limits.forces == ()
    assert np.all(np.isinf(limits.acceleration))
    assert limits.jerk == INF


def test_a_car_without_recuperation_has_a_braking_force_of_zero():
    car = changed(ROMO, drive={"regen_torque_max_nm": 0.0, "regen_power_max_w": 0.0})
    limits = limits_of(car)
    v = np.full(len(limits.ds), 12.0)
    assert limits.ceiling(v, -1) == pytest.approx(limits.resistance(v) / car.effective_mass)
