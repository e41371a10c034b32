"""What cars can do, against closed forms and published figures."""

import msgspec
import numpy as np
import pytest

from powertrain import Vehicle, VehicleError, load_vehicle, shipped
from powertrain.description.sections import Body
from powertrain.energy.cycle import drive_cycle
from powertrain.energy.performance import (
    acceleration_time,
    axle_stiffness,
    characteristic_speed,
    spare_force,
    steepest_slope,
    top_speed,
    understeer_gradient,
)
from roads import cycles


def test_without_resistance_acceleration_is_torque_then_power(romo: Vehicle):
    """m v / F up to base speed, then energy over power: 4 x 160 Nm, 4 x 16 kW."""
    free = msgspec.structs.replace(romo.resistance, drag_coefficient=0.0, rolling_0=0.0, rolling_1=0.0, rolling_4=0.0)
    car = msgspec.structs.replace(romo, resistance=free)
    base = 100.0 * romo.chassis.wheel_radius_m
    mass = romo.effective_mass
    assert acceleration_time(car, base) == pytest.approx(mass * base / (640.0 / romo.chassis.wheel_radius_m), rel=1e-9)
    rest = acceleration_time(car, 27.7, base)
    assert rest == pytest.approx(0.5 * mass * (27.7**2 - base**2) / 64e3, rel=1e-5)


def test_the_romo_reaches_the_published_speeds(romo: Vehicle, figure):
    """Table C.3: 100 km/h; 0 to 80 km/h in about 10 s. The check of the specification, without resistances and wheel inertia, has 9.6 s."""
    assert top_speed(romo) == pytest.approx(100.0 / 3.6)
    free = msgspec.structs.replace(romo.resistance, drag_coefficient=0.0, rolling_0=0.0, rolling_1=0.0, rolling_4=0.0)
    bare = msgspec.structs.replace(romo, resistance=free, chassis=msgspec.structs.replace(romo.chassis, wheel_inertia_kgm2=0.0))
    found = acceleration_time(romo, 80.0 / 3.6), acceleration_time(bare, 80.0 / 3.6)
    figure("0 to 80 km/h of ROMO, without resistances and wheel inertia", found, "{:.2f} s, {:.2f} s", published="about 10 s")
    assert found == pytest.approx((10.6, 9.6), abs=0.06)


def test_top_speed_is_where_force_and_resistance_meet(romo: Vehicle):
    steep = 0.2
    v = top_speed(romo, steep)
    assert 0.0 < v < romo.limits.speed_max_mps
    assert float(spare_force(romo, v, steep)) == pytest.approx(0.0, abs=1.0)
    assert top_speed(romo, 0.5) == 0.0
    assert acceleration_time(romo, 10.0, slope=0.5) == float("inf")
    assert steepest_slope(romo) == pytest.approx(0.2263, abs=1e-3)


@pytest.mark.parametrize("name", [name for name in shipped() if name != "romo"])
def test_shipped_cars_come_near_their_published_acceleration(name: str):
    """0 to 100 km/h: 7.3 s (BMW i3), 4.7 s (Polestar 2). Up to 15 % quicker here: no launch, and power held to top speed. The van: none published."""
    published = {"compact": 7.3, "dual_motor": 4.7, "van": 11.0}[name]
    assert 0.82 * published < acceleration_time(load_vehicle(name), 100.0 / 3.6) < 1.02 * published


@pytest.mark.parametrize("name", shipped())
def test_understeer_gradient_and_characteristic_speed_are_the_closed_form(name: str):
    car = load_vehicle(name)
    front, rear = axle_stiffness(car)
    body = car.need("body", Body)
    gradient = understeer_gradient(car)
    loads = car.chassis.mass_kg * np.array([body.rear_axle_m, body.front_axle_m]) / body.wheelbase_m
    assert gradient == pytest.approx(loads[0] / front - loads[1] / rear, rel=1e-9, abs=1e-15)
    v = characteristic_speed(car)
    if gradient < 0.0:
        # there the yaw gain of an oversteering car has its pole
        assert body.wheelbase_m + gradient * v**2 == pytest.approx(0.0, abs=1e-9)
        return
    # there the yaw gain of an understeering car is largest
    gain = [u / (body.wheelbase_m + gradient * u**2) for u in (0.99 * v, v, 1.01 * v)]
    assert gain[1] > max(gain[0], gain[2])


def test_a_cycle_at_constant_speed_is_resistance_and_losses(romo: Vehicle):
    from powertrain import driving_resistance, motor_losses

    ledger = drive_cycle(romo, np.arange(0.0, 101.0), np.full(101, 15.0))
    force = driving_resistance(romo, 15.0, 0.0)
    losses = sum(motor_losses(romo, force / (4 * romo.motor_ratio), 15.0 * romo.motor_ratio))
    assert ledger.energy == pytest.approx(100.0 * (force * 15.0 + 4.0 * losses + 200.0 / 0.93 + 10.0), rel=1e-9)
    assert ledger.energy == pytest.approx(sum(ledger.components.values()))
    assert ledger.missed == 0.0


def test_standing_costs_inverters_and_auxiliaries_only(romo: Vehicle):
    t, v = np.arange(0.0, 10_001.0), np.zeros(10_001)
    v[1] = 1e-6
    ledger = drive_cycle(romo, t, v)
    # one second of two pushes against rolling resistance
    assert ledger.energy == pytest.approx(10_000.0 * (4.0 * 80.5 + 200.0 / 0.93 + 10.0), rel=5e-5)


def test_what_cannot_be_recuperated_is_braked():
    van = load_vehicle("van")
    ledger = drive_cycle(van, [0.0, 3.0], [30.0, 0.0])
    assert ledger.components["brake"] > 0.0
    assert -ledger.energy < van.drive.regen_power_max_w * 3.0


def consumption(car: Vehicle, name: str):
    cycle = cycles.load(name)
    return drive_cycle(car, cycle.t, np.minimum(cycle.v, car.limits.speed_max_mps))


@pytest.mark.parametrize(("name", "published"), [("compact", 11.1), ("dual_motor", 16.0), ("van", 26.2)])
def test_shipped_cars_consume_about_what_is_published(name: str, published: float):
    """kWh/100 km from the battery on the WLTC: usable energy over published range, for the compact the middle of its two ranges."""
    assert consumption(load_vehicle(name), "wltc_3b").consumption / 36.0 == pytest.approx(published, rel=0.1)


def test_range_is_of_the_published_order(romo: Vehicle, figure):
    """Published: about 100 km of 13 to 14 kWh, on which cycle is not said. Ours: 139 km of 80 % of 13.5 kWh on FTP-75, its own cycle.

    100 km would need 1 kW more of auxiliaries, which a research car's computers may well take; nothing in the source says so.
    """
    ledger = consumption(romo, "ftp75")
    way = figure("range of ROMO, FTP-75, 80 % of 13.5 kWh", ledger.range(0.8 * 13.5 * 3.6e6) / 1e3, "{:.0f} km", published="100 km")
    assert way == pytest.approx(139.0, abs=1.0)
    more = (0.8 * 13.5 * 3.6e6 / 100e3 - ledger.consumption) * ledger.distance / ledger.duration
    figure("auxiliaries that would make it 100 km", more / 1e3, "{:.2f} kW more")
    assert 0.7e3 < more < 1.2e3


BAD = [
    ([0.0, 1.0], [1.0], "expected|as many speeds"),
    ([0.0, 0.0], [1.0, 1.0], "expected increasing times"),
    ([0.0, 1.0], [1.0, float("nan")], "expected increasing times"),
    ([0.0, 1.0], [1.0, -1.0], "not negative"),
    ([0.0, 1.0], [0.0, 0.0], "not all zero"),
]


@pytest.mark.parametrize(("t", "v", "words"), BAD)
def test_cycles_that_are_none_are_refused(romo: Vehicle, t: list[float], v: list[float], words: str):
    with pytest.raises(VehicleError, match=words):
        drive_cycle(romo, t, v)


def test_slopes_of_another_length_are_refused(romo: Vehicle):
    with pytest.raises(VehicleError, match="expected one slope, or one per interval"):
        drive_cycle(romo, [0.0, 1.0, 2.0], [1.0, 1.0, 1.0], [0.1, 0.1, 0.1])


def test_impossible_speeds_are_refused(romo: Vehicle):
    with pytest.raises(VehicleError, match="expected finite speeds"):
        acceleration_time(romo, float("nan"))
    with pytest.raises(VehicleError, match="in order"):
        acceleration_time(romo, 5.0, 6.0)
