"""Windows, stops, jerk and brakes in the thriftiest drive."""

import numpy as np
import pytest

from energy_mgr import InfeasibleError
from energy_mgr.speed import (
    Arrival,
    EcoSolver,
    FrictionBrakes,
    Jerk,
    SpeedLimits,
    Stop,
    eco_profile,
    fastest_profile,
)
from energy_mgr.speed.bounds.jerk import jerk_of
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


@pytest.mark.parametrize(("earliest", "latest"), [(0.0, 60.0), (95.0, 110.0), (75.0, 76.0)])
def test_a_window_is_met_and_costs_energy_when_it_binds(earliest: float, latest: float):
    limits, free = flat(length=1500.0, extra=[Arrival(750.0, earliest, latest)]), flat(length=1500.0, through=[750.0])
    at = int(np.argmin(np.abs(limits.s - 750.0)))
    profile, without = eco_profile(limits, 150.0), eco_profile(free, 150.0)
    t = float(np.concatenate([[0.0], np.cumsum(profile.interval_time)])[at])
    assert earliest - 1e-3 <= t <= latest + 1e-3
    assert profile.journey_time <= 150.0 + 1e-3
    assert energy(limits, profile.v) >= energy(free, without.v) * (1 - 1e-6)


def test_two_lights_one_after_the_other_are_passed_when_green():
    limits = flat(length=1500.0, extra=[Arrival(500.0, 40.0, 55.0), Arrival(1000.0, 95.0, 100.0)])
    profile = eco_profile(limits, 170.0)
    t = np.interp([500.0, 1000.0], limits.s, np.concatenate([[0.0], np.cumsum(profile.interval_time)]))
    assert 40.0 - 1e-3 <= t[0] <= 55.0 + 1e-3
    assert 95.0 - 1e-3 <= t[1] <= 100.0 + 1e-3


def test_a_window_that_closes_too_early_is_refused_with_the_amount():
    limits = flat(length=1500.0, extra=[Arrival(750.0, 0.0, 20.0)])
    arrival = float(np.interp(750.0, limits.s, np.concatenate([[0.0], np.cumsum(fastest_profile(limits).interval_time)])))
    with pytest.raises(
        InfeasibleError, match=rf"the window at s = 750 m( of the path)? ends at 20.00 s, .* {arrival:.2f} s, {arrival - 20.0:.2f} s too late"
    ):
        eco_profile(limits, 150.0)


def test_a_window_that_opens_too_late_for_the_arrival_is_refused():
    limits = flat(length=1500.0, extra=[Arrival(750.0, 140.0, 200.0)])
    with pytest.raises(
        InfeasibleError,
        match=r"arrival after 150.00 s cannot be met from the window at s = 750 m( of the path)?: the least possible time is .* s more",
    ):
        eco_profile(limits, 150.0)


def test_stops_are_stops_and_energy_at_a_stop_is_recuperated():
    limits = flat(length=1500.0, extra=[Stop(700.0)])
    profile = eco_profile(limits, 1.3 * fastest_profile(limits).journey_time)
    at = int(np.argmin(np.abs(limits.s - 700.0)))
    assert profile.v[at] == 0.0
    assert np.all(profile.v[1:-1][np.arange(1, len(profile.v) - 1) != at] > 0.0)
    force = drive_energy(ROMO, limits.s, profile.v, limits.z).force
    assert force[at - 1] < 0.0


@pytest.mark.parametrize(("most", "factor"), [(0.3, 1.01), (0.8, 1.0005)])
def test_jerk_is_kept_and_costs_time_and_energy(most: float, factor: float):
    free, limits = flat(length=800.0, step=5.0, posted=15.0), flat(length=800.0, step=5.0, posted=15.0, extra=[Jerk(most)])
    solver = EcoSolver(limits)
    assert solver.least_time > fastest_profile(free).journey_time
    allowed = factor * solver.least_time
    profile = solver.arriving(allowed)
    largest = np.max(np.abs(jerk_of(limits.ds, profile.v)))
    # so little time to spare that the limit binds
    assert 0.9 * most <= largest <= most * (1 + 1e-3)
    assert np.max(np.abs(jerk_of(free.ds, fastest_profile(free).v))) > most
    assert energy(limits, profile.v) >= energy(free, eco_profile(free, allowed).v) * (1 - 1e-7)
    with pytest.raises(InfeasibleError, match="the least possible time is"):
        solver.arriving(0.99 * solver.least_time)


def test_jerk_and_a_window_do_not_let_the_fastest_profile_through_unchecked():
    limits = flat(length=800.0, step=5.0, posted=15.0, extra=[Jerk(0.5), Arrival(400.0, 0.0, 500.0)])
    with pytest.raises(InfeasibleError, match="the least possible time is"):
        eco_profile(limits, fastest_profile(limits).journey_time)


@pytest.mark.parametrize("factor", [1.05, 1.4])
def test_friction_brakes_stay_off_on_the_flat_where_motors_can_take_it(factor: float):
    limits = flat(extra=[FrictionBrakes(5000.0)])
    profile = eco_profile(limits, factor * fastest_profile(limits).journey_time)
    assert profile.brake is not None
    assert np.max(profile.brake) < 5.0
    without = flat()
    assert energy(limits, profile.v, profile.brake) == pytest.approx(energy(without, eco_profile(without, profile.journey_time).v), rel=1e-4)


def test_friction_brakes_help_only_where_motors_alone_cannot():
    weak = changed(ROMO, drive={"regen_torque_max_nm": 8.0, "regen_power_max_w": 1500.0})
    limits, without = (flat(weak, 1500.0, extra=extra) for extra in ([FrictionBrakes(5000.0)], []))
    assert fastest_profile(limits).journey_time < fastest_profile(without).journey_time
    allowed = 1.01 * fastest_profile(limits).journey_time
    profile = eco_profile(limits, allowed)
    assert np.max(profile.brake) > 100.0
    # where the brakes work, the motors take what they can: recuperated energy is not thrown away
    force = drive_energy(weak, limits.s, profile.v, limits.z, profile.brake).force
    working = profile.brake > 50.0
    assert np.all(force[working] < -0.9 * np.minimum(4 * 8 * weak.motor_ratio, 6000.0 / np.maximum(profile.v[:-1], profile.v[1:])[working]))


def test_without_recuperation_coasting_is_longer():
    with_it, without = (flat(car, 1500.0) for car in (ROMO, changed(ROMO, drive={"regen_torque_max_nm": 0.0, "regen_power_max_w": 0.0})))
    allowed = 1.5 * fastest_profile(without).journey_time
    a, b = eco_profile(with_it, allowed), eco_profile(without, allowed)
    assert energy(with_it, a.v) < energy(without, b.v)
    assert np.argmax(a.v) > 0
    # the motors never brake
    assert np.min(drive_energy(without.vehicle, without.s, b.v, without.z).force) > -5.0
