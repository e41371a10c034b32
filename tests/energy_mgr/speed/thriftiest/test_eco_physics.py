"""What physics says about the thriftiest drive: closed forms, shapes, symmetries, orderings."""

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from energy_mgr import InfeasibleError, PlanningError
from energy_mgr.speed import (
    Comfort,
    EcoSolver,
    Motors,
    Posted,
    SpeedCap,
    SpeedLimits,
    eco_profile,
    fastest_profile,
)
from energy_mgr.speed.comparison.cone_eco import cone_profile
from energy_mgr.speed.comparison.nlp import nlp_profile
from powertrain import Vehicle, drive_energy, driving_resistance, motor_losses

from ..rig import ROMO, VAN, changed, limits_of

CARS = {"romo": ROMO, "van": VAN}


def flat(car: Vehicle = ROMO, length: float = 3000.0, *, step: float = 10.0, posted: float = 33.0, **more) -> SpeedLimits:
    return limits_of(car, length=length, step=step, posted=posted, **more)


def energy(limits: SpeedLimits, v: np.ndarray, brake: np.ndarray | float | None = None) -> float:
    return drive_energy(limits.vehicle, limits.s, v, limits.z, 0.0 if brake is None else brake).total


def per_metre(car: Vehicle, v: float, slope: float = 0.0) -> float:
    """Energy per metre at constant speed, from resistance and losses alone, J/m."""
    force, count, ratio = float(driving_resistance(car, v, slope)), car.drive.motor_count, car.motor_ratio
    return force + count * float(sum(motor_losses(car, force / (count * ratio), v * ratio))) / v


def best_cruise(car: Vehicle, price: float, slope: float = 0.0, high: float = 33.0) -> float:
    """argmin of energy per metre plus price per speed."""
    return float(minimize_scalar(lambda v: per_metre(car, v, slope) + price / v, bounds=(1.0, high), method="bounded", options={"xatol": 1e-9}).x)


@pytest.mark.parametrize("car", CARS)
@pytest.mark.parametrize("price", [0.0, 500.0, 2000.0, 8000.0])
def test_the_cruise_speed_is_the_closed_form_optimum_for_the_price(car: str, price: float):
    vehicle = CARS[car]
    expected = best_cruise(vehicle, price)
    assert expected < 0.95 * min(33.0, vehicle.limits.speed_max_mps)
    profile = eco_profile(flat(vehicle, 6000.0, step=20.0), price=price)
    middle = profile.v[len(profile.v) // 3 : 2 * len(profile.v) // 3]
    assert middle == pytest.approx(np.full(len(middle), expected), rel=5e-3)


@pytest.mark.parametrize("price", [100.0, 1000.0, 5000.0])
def test_the_derivative_of_energy_and_price_vanishes_at_the_cruise_speed(price: float):
    cruise = float(np.median(eco_profile(flat(length=6000.0, step=20.0), price=price).v))

    def slope(v: float) -> float:
        return (per_metre(ROMO, v + 1e-4) - per_metre(ROMO, v - 1e-4)) / 2e-4 - price / v**2

    assert cruise == pytest.approx(brentq(slope, 2.0, 30.0), rel=5e-3)


@pytest.mark.parametrize("slope", [-0.01, 0.02])
def test_on_a_steady_slope_the_cruise_is_the_optimum_for_that_slope(slope: float):
    limits = flat(VAN, 5000.0, step=20.0, height=lambda s: slope * s)
    cruise = float(np.median(eco_profile(limits, price=3000.0).v))
    assert cruise == pytest.approx(best_cruise(VAN, 3000.0, slope), rel=5e-3)


def test_between_stops_the_car_accelerates_cruises_and_slows_down_and_each_once():
    profile = eco_profile(flat(), 1.4 * fastest_profile(flat()).journey_time)
    gain = profile.acceleration
    turns = np.flatnonzero(np.diff(np.sign(np.where(np.abs(gain) < 1e-3, 0.0, gain))))
    # rising, level, falling: at most two changes of sign, in this order
    assert len(turns) <= 2
    assert gain[0] > 0.1
    assert gain[-1] < -0.1
    assert np.max(np.abs(gain[len(gain) // 3 : 2 * len(gain) // 3])) < 5e-3


def test_slowing_down_it_coasts_first_and_recuperates_at_the_end():
    limits = flat(length=2000.0, step=5.0)
    profile = eco_profile(limits, 1.5 * fastest_profile(limits).journey_time)
    force = drive_energy(ROMO, limits.s, profile.v, limits.z).force
    assert force[-1] < -100.0
    # pulling, then (nearly) nothing, then braking: the force never rises from the cruise on
    late = force[len(force) // 2 :]
    assert np.all(np.diff(late) < 5.0)
    assert np.sum((late < 30.0) & (late > -30.0)) >= 3


def test_with_no_price_the_thriftiest_speed_is_driven_and_crawling_costs_more():
    limits = flat(length=6000.0, step=20.0)
    profile = eco_profile(limits, price=0.0)
    slow, fast = (energy(limits, np.sqrt(factor) * profile.v) for factor in (0.81, 1.1))
    least = energy(limits, profile.v)
    assert least < slow
    assert least < fast
    late = eco_profile(limits, 3.0 * profile.journey_time)
    assert late.status == "solved early"
    assert energy(limits, late.v) == pytest.approx(least, rel=1e-6)
    assert late.price == pytest.approx(0.0, abs=1.0)


def test_a_higher_price_arrives_earlier_and_costs_more():
    limits = flat()
    profiles = [eco_profile(limits, price=price) for price in (0.0, 100.0, 500.0, 2000.0, 1e4, 1e5, 1e6)]
    times, costs = np.array([p.journey_time for p in profiles]), np.array([energy(limits, p.v) for p in profiles])
    assert np.all(np.diff(times) < 0.0)
    assert np.all(np.diff(costs) > 0.0)


def test_a_price_without_measure_drives_the_fastest_profile():
    limits = flat(length=800.0, step=5.0, posted=15.0)
    assert eco_profile(limits, price=1e8).journey_time == pytest.approx(fastest_profile(limits).journey_time, rel=1e-3)


def test_with_hardly_any_time_to_spare_the_drive_is_nearly_the_fastest():
    limits = flat(length=800.0, step=5.0, posted=15.0)
    fast = fastest_profile(limits)
    differences = [np.max(np.abs(eco_profile(limits, factor * fast.journey_time).v - fast.v)) for factor in (1.05, 1.01, 1.001, 1.0001)]
    assert np.all(np.diff(differences) < 0.0)
    assert differences[-1] < 0.5
    assert np.array_equal(eco_profile(limits, fast.journey_time).v, fast.v)


def test_energy_falls_convexly_as_the_time_grows():
    limits = flat(VAN)
    least = fastest_profile(limits).journey_time
    times = least * np.linspace(1.02, 1.8, 7)
    profiles = [eco_profile(limits, float(t)) for t in times]
    costs = np.array([energy(limits, p.v) for p in profiles])
    assert np.all(np.diff(costs) < 0.0)
    assert np.all(np.diff(costs, 2) > 0.0)
    # what a second less costs is the slope of that curve
    inner = -np.gradient(costs, times)[1:-1]
    assert np.array([p.price for p in profiles])[1:-1] == pytest.approx(inner, rel=0.15)


def test_a_front_runs_from_the_fastest_to_the_thriftiest_drive():
    limits = flat(length=1500.0)
    front = EcoSolver(limits).front(8)
    assert np.all(np.diff(front.journey_time) > 0.0)
    assert np.all(np.diff(front.energy) < 1e-6 * front.energy[:-1])
    assert front.journey_time[0] == pytest.approx(fastest_profile(limits).journey_time, rel=1e-5)
    assert front.energy[-1] == pytest.approx(energy(limits, eco_profile(limits, price=0.0).v), rel=1e-4)
    for k in (2, 5):
        alone = eco_profile(limits, float(front.journey_time[k]))
        assert front.energy[k] == pytest.approx(energy(limits, alone.v), rel=1e-6)
    with pytest.raises(PlanningError, match="a front of 1 points, expected 2 or more"):
        EcoSolver(limits).front(1)


@pytest.mark.parametrize("car", CARS)
def test_two_other_solvers_find_no_less_energy(car: str):
    limits = flat(CARS[car], 1200.0, step=10.0, height=lambda s: 6.0 * np.sin(s / 150.0), kappa=lambda s: 0.01 * np.sin(s / 60.0))
    allowed = 1.2 * fastest_profile(limits).journey_time
    ours = energy(limits, eco_profile(limits, allowed).v)
    # Clarabel's sequence ends at changes of 2e-6 of the energy that moves, IPOPT at 1e-8
    assert ours <= energy(limits, cone_profile(limits, allowed).v) * (1 + 1e-5)
    assert ours == pytest.approx(energy(limits, nlp_profile(limits, allowed).v), rel=1e-4)


def test_left_and_right_bends_cost_the_same():
    one, other = (
        flat(length=900.0, kappa=lambda s, k=k: k * 0.03 * np.sin(s / 70.0), bank=lambda s, k=k: 0.05 * k * np.sin(s / 70.0)) for k in (1, -1)
    )
    allowed = 1.2 * fastest_profile(one).journey_time
    assert eco_profile(one, allowed).v == pytest.approx(eco_profile(other, allowed).v, abs=1e-6)


def test_a_car_without_resistance_and_losses_of_sign_drives_a_symmetric_profile():
    """Without resistance driving and braking ask for the same magnitude of force and lose the same: time may be reversed."""
    ideal = changed(ROMO, resistance={"rolling_0": 0.0, "rolling_1": 0.0, "rolling_4": 0.0, "drag_coefficient": 1e-9}, drive={"gear_efficiency": 1.0})
    limits = flat(ideal, 1000.0, step=10.0)
    profile = eco_profile(limits, 1.4 * fastest_profile(limits).journey_time)
    assert profile.v == pytest.approx(profile.v[::-1], abs=2e-2)


def test_the_fastest_profile_of_equal_limits_up_and_down_is_its_own_reverse():
    """Kinematic limits alone know no direction."""
    parts = [Posted(), Comfort(1.7, 1.7)]
    road = {"kappa": lambda s: 0.05 * np.sin(s / 31.0), "length": 700.0, "step": 3.0}
    one = fastest_profile(limits_of(parts=parts, **road))
    other = fastest_profile(limits_of(parts=parts, **{**road, "kappa": lambda s: 0.05 * np.sin((700.0 - s) / 31.0)}))
    assert one.v == pytest.approx(other.v[::-1], abs=1e-9)


def test_the_same_height_added_everywhere_changes_nothing():
    one, other = (flat(length=900.0, height=lambda s, z=z: z + 4.0 * np.sin(s / 90.0)) for z in (0.0, 500.0))
    assert eco_profile(one, price=2000.0).v == pytest.approx(eco_profile(other, price=2000.0).v, abs=1e-5)


def test_finer_stations_change_the_energy_little():
    costs = []
    for step in (20.0, 10.0, 5.0, 2.5):
        limits = flat(length=1500.0, step=step, height=lambda s: 5.0 * np.sin(s / 120.0))
        costs.append(energy(limits, eco_profile(limits, 110.0).v))
    assert costs == pytest.approx([costs[-1]] * 4, rel=5e-3)
    assert abs(costs[2] - costs[3]) < abs(costs[0] - costs[3])


def test_a_cap_that_does_not_bind_changes_nothing_and_one_that_does_costs_time():
    free = flat(length=1000.0, posted=20.0)
    loose, tight = (flat(length=1000.0, posted=20.0, through=[], extra=[SpeedCap([0.0], [v])]) for v in (30.0, 9.0))
    allowed = 1.3 * fastest_profile(free).journey_time
    assert eco_profile(loose, allowed).v == pytest.approx(eco_profile(free, allowed).v, abs=1e-6)
    with pytest.raises(InfeasibleError, match="least possible time"):
        eco_profile(tight, allowed)


def test_a_stronger_motor_never_costs_more():
    times, costs = [], []
    for power in (4e3, 8e3, 16e3):
        limits = flat(changed(ROMO, drive={"power_max_w": power}), 1500.0, parts=[Posted(), Comfort(), Motors()])
        times.append(fastest_profile(limits).journey_time)
        costs.append(energy(limits, eco_profile(limits, 120.0).v))
    assert np.all(np.diff(times) <= 0.0)
    assert np.all(np.diff(costs) <= 1e-6 * costs[0])


@pytest.mark.parametrize(("given", "words"), [({"journey_time": np.nan}, "arrival time nan s"), ({"journey_time": -3.0}, "arrival time -3.0 s"),
    ({"journey_time": np.inf}, "arrival time inf s"), ({"price": np.nan}, "price of time nan W"), ({"price": -1.0}, "price of time -1.0 W"),
    ({"price": np.inf}, "price of time inf W"), ({}, "expected either an arrival time or a price"),
    ({"journey_time": 100.0, "price": 3.0}, "expected either an arrival time or a price")])  # fmt: skip
def test_times_and_prices_that_make_no_sense_are_refused(given: dict, words: str):
    with pytest.raises(PlanningError, match=words):
        eco_profile(flat(length=500.0), **given)


@pytest.mark.parametrize("car", ["romo", "van"])
@pytest.mark.parametrize(("start", "end"), [(15.0, 15.0), (15.0, 0.0), (0.0, 15.0), (14.0, 10.0)])
@pytest.mark.parametrize("later", [1.2, 2.0])
def test_a_drive_that_passes_its_ends_slows_down_between_them(car: str, start: float, end: float, later: float):
    limits = limits_of(CARS[car], length=1500.0, step=4.0, posted=28.0, start_speed=start, end_speed=end)
    time = later * fastest_profile(limits).journey_time
    found = eco_profile(limits, time)
    assert found.status.startswith("solved")
    assert found.v[[0, -1]] == pytest.approx([start, end], abs=1e-6)
    # IPOPT on the same programme
    assert energy(limits, found.v) == pytest.approx(energy(limits, nlp_profile(limits, time).v), rel=1e-4, abs=5.0)
