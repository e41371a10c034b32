from itertools import product

import msgspec
import numpy as np
import pytest

from energy_mgr import InfeasibleError, PlanningError, plan_path
from energy_mgr.speed import SpeedLimits, SpeedProfile, eco_profile, fastest_profile
from energy_mgr.speed.bounds.grip import Grip
from energy_mgr.speed.bounds.parts import Arrival, FrictionBrakes, Jerk, Part, Stop
from energy_mgr.speed.checks import check_profile
from energy_mgr.speed.comparison.dp import dp_profile
from energy_mgr.speed.comparison.nlp import nlp_profile
from powertrain import Vehicle, drive_energy, driving_resistance, load_vehicle, motor_losses
from powertrain.energy.balance import balance
from roads import Road, RoadBuilder

ROMO = load_vehicle("romo")
WEAK_RECUPERATION = msgspec.structs.replace(ROMO, drive=msgspec.structs.replace(ROMO.drive, regen_torque_max_nm=20.0, regen_power_max_w=3000.0))


def limits_on(road: Road, vehicle: Vehicle = ROMO, *extra: Part, **options: float) -> SpeedLimits:
    return SpeedLimits.along(road, plan_path(road, 1.0, kind="lane", extent="road"), vehicle, extra=extra, **options)


def straight(length: float = 400.0, limit: float = 15.0, slope: float = 0.0) -> Road:
    return RoadBuilder("straight").limit(limit).straight(length).build(height=lambda s: slope * s)


def hilly() -> Road:
    return RoadBuilder("hilly").limit(18).straight(150).bend(30, 1.2, 12).straight(120).build(height=lambda s: 4 * np.sin(s / 80))


def oval() -> Road:
    builder = RoadBuilder("oval")
    for _ in range(2):
        builder.straight(60).bend(25, np.pi, 15)
    return builder.build(closed=True)


def energy(limits: SpeedLimits, profile: SpeedProfile) -> float:
    return drive_energy(limits.vehicle, limits.s, profile.v, limits.z, 0.0 if profile.brake is None else profile.brake).total


def test_where_time_is_all_that_counts_the_drive_between_stops_is_the_closed_form():
    profile = dp_profile(limits_on(straight()), price=1e8, levels=50, refinements=0)
    # 0 to 15 m/s and back at 2 m/s^2: 7.5 s and 56.25 m each, which is not a whole number of 2 m intervals
    assert profile.journey_time == pytest.approx(2 * 7.5 + (400 - 2 * 56.25) / 15.0, abs=1e-3)


def test_where_time_is_free_the_cruise_is_at_the_thriftiest_speed():
    profile = dp_profile(limits_on(straight(2000.0, 25.0), step=10.0), price=0.0, levels=100)
    speeds = np.linspace(3, 25, 4401)
    force = driving_resistance(ROMO, speeds, 0.0)
    per_metre = force + 4 * sum(motor_losses(ROMO, force / (4 * ROMO.motor_ratio), speeds * ROMO.motor_ratio)) / speeds
    assert float(np.median(profile.v)) == pytest.approx(speeds[np.argmin(per_metre)], rel=0.01)


@pytest.mark.parametrize("price", [0.0, 3000.0, 30000.0])
def test_no_other_way_on_a_small_grid_is_cheaper(price: float):
    limits = limits_on(straight(60.0, 9.0, slope=0.03), step=12.0)
    fastest = fastest_profile(limits).v
    found = dp_profile(limits, price=price, levels=12, refinements=0)
    step = fastest.max() / 12
    inner = [np.append(step * np.arange(1.0, np.ceil(top / step - 1e-9)), top) for top in fastest[1:-1]]
    ways = np.array([(0.0, *way, 0.0) for way in product(*inner)])
    gain = np.diff(ways**2) / (2.0 * limits.ds)
    kept = np.all((gain <= limits.acceleration + 1e-6) & (-gain <= limits.deceleration + 1e-6), axis=1)
    assert 100 < np.sum(kept) < len(ways)
    drives = balance(ROMO, limits.ds, ways[kept, :-1], ways[kept, 1:], np.diff(limits.z))
    costs = np.sum(sum(drives.energies.values()) + price * drives.time, axis=1)
    assert energy(limits, found) + price * found.journey_time == pytest.approx(float(np.min(costs)), rel=1e-6)


CASES = {
    "hills": lambda: limits_on(hilly()),
    "stop line": lambda: limits_on(hilly(), ROMO, Stop(201.0)),
    "grip": lambda: limits_on(hilly(), ROMO, Grip(0.35)),
    "rolling start and end": lambda: limits_on(hilly(), start_speed=8.0, end_speed=5.0),
    "circuit": lambda: limits_on(oval()),
    "friction brakes": lambda: limits_on(hilly(), WEAK_RECUPERATION, FrictionBrakes(8000.0)),
}


@pytest.mark.parametrize("case", CASES)
def test_the_least_energy_of_ipopt_is_confirmed_and_never_undercut(case: str):
    limits = CASES[case]()
    allowed = 1.15 * fastest_profile(limits).journey_time
    grid = dp_profile(limits, allowed, levels=80)
    check_profile(limits, grid.v, grid.brake)
    assert allowed - 0.05 <= grid.journey_time <= allowed
    # at the grid's own arrival time, so that nothing is owed to an early arrival
    best = energy(limits, nlp_profile(limits, grid.journey_time))
    moved = sum(abs(x) for x in drive_energy(limits.vehicle, limits.s, grid.v, limits.z).components.values())
    assert -1e-6 * moved <= energy(limits, grid) - best <= 5e-3 * moved


def test_energy_falls_towards_the_least_as_the_grid_gets_finer():
    limits = limits_on(hilly(), step=4.0)
    price = eco_profile(limits, 1.15 * fastest_profile(limits).journey_time).price
    cost = []
    for levels in (40, 80, 160, 320):
        profile = dp_profile(limits, price=price, levels=levels, refinements=0)
        cost.append(energy(limits, profile) + price * profile.journey_time)
    # each grid holds the one before
    assert np.all(np.diff(cost) < 0.0)
    best = eco_profile(limits, price=price)
    least = energy(limits, best) + price * best.journey_time
    assert -1e-6 * least < cost[-1] - least < 0.2 * (cost[0] - least)
    refined = dp_profile(limits, price=price, levels=160)
    assert energy(limits, refined) + price * refined.journey_time == pytest.approx(least, rel=2e-4)


def test_the_price_is_what_a_second_less_costs():
    limits = limits_on(hilly())
    allowed = 1.15 * fastest_profile(limits).journey_time
    grid, best = dp_profile(limits, allowed, levels=100), eco_profile(limits, allowed)
    assert grid.price == pytest.approx(best.price, rel=0.1)


def test_times_too_short_and_at_the_least_one():
    limits = limits_on(straight())
    fastest = fastest_profile(limits)
    with pytest.raises(InfeasibleError, match="least possible time is"):
        dp_profile(limits, 0.9 * fastest.journey_time)
    assert np.array_equal(dp_profile(limits, fastest.journey_time).v, fastest.v)
    barely = dp_profile(limits, 1.001 * fastest.journey_time, levels=60)
    assert barely.journey_time <= 1.001 * fastest.journey_time


def test_with_more_time_than_is_thrifty_it_arrives_earlier():
    profile = dp_profile(limits_on(straight(), step=5.0), 1e4, levels=60)
    assert profile.status == "solved early"
    assert profile.price == 0.0
    assert profile.journey_time < 200.0


@pytest.mark.parametrize(("part", "words"), [(Jerk(1.0), "a jerk limit of 1 m/s"), (Arrival(100.0, 20.0, 30.0), "a window at s = 100 m")])
def test_what_the_grid_does_not_know_is_refused_by_name(part: Part, words: str):
    with pytest.raises(PlanningError, match=words):
        dp_profile(limits_on(straight(), ROMO, part), 60.0)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "either an arrival time or a price"),
        ({"journey_time": 60.0, "price": 1.0}, "either an arrival time or a price"),
        ({"journey_time": float("nan")}, "arrival time nan s"),
        ({"price": -1.0}, "price of time -1.0 W"),
        ({"journey_time": 60.0, "levels": 3}, "3 levels of speed"),
        ({"journey_time": 60.0, "refinements": 9}, "9 refinements"),
    ],
)
def test_numbers_out_of_range_are_refused(given: dict[str, float], words: str):
    with pytest.raises(PlanningError, match=words):
        dp_profile(limits_on(straight()), **given)
