import msgspec
import numpy as np
import pytest

from energy_mgr import PlanningError, plan_path
from energy_mgr.speed import SpeedLimits, eco_profile, fastest_profile
from energy_mgr.speed.bounds.grip import Grip
from energy_mgr.speed.bounds.jerk import jerk_of
from energy_mgr.speed.bounds.parts import Arrival, BatteryPower, FrictionBrakes, Jerk, Part, Stop
from energy_mgr.speed.checks import arrival_times
from energy_mgr.speed.comparison.nlp import nlp_profile
from powertrain import Vehicle, drive_energy, driving_resistance, load_vehicle, motor_losses
from roads import Road, RoadBuilder

ROMO = load_vehicle("romo")
WEAK_RECUPERATION = msgspec.structs.replace(ROMO, drive=msgspec.structs.replace(ROMO.drive, regen_torque_max_nm=20.0, regen_power_max_w=3000.0))


def limits_on(road: Road, vehicle: Vehicle = ROMO, *extra: Part, **options: float) -> SpeedLimits:
    return SpeedLimits.along(road, plan_path(road, 1.0, kind="lane", extent="road"), vehicle, extra=extra, **options)


def straight(length: float = 600.0, limit: float = 15.0, slope: float = 0.0) -> Road:
    return RoadBuilder("straight").limit(limit).straight(length).build(height=lambda s: slope * s)


def hilly() -> Road:
    builder = RoadBuilder("hilly").limit(20).straight(150).bend(30, 1.2, 12).straight(120).limit(14).straight(150)
    return builder.build(height=lambda s: 4 * np.sin(s / 80))


def oval() -> Road:
    builder = RoadBuilder("oval")
    for _ in range(2):
        builder.straight(150).bend(25, np.pi, 15)
    return builder.build(closed=True)


def energy(limits: SpeedLimits, profile) -> float:
    return drive_energy(limits.vehicle, limits.s, profile.v, limits.z, 0.0 if profile.brake is None else profile.brake).total


def test_with_all_the_time_in_the_world_the_cruise_is_at_the_thriftiest_speed():
    limits = limits_on(straight(3000.0, 25.0), step=10.0)
    profile = nlp_profile(limits, 5e3)
    assert profile.status == "solved early"
    speeds = np.linspace(3, 25, 4401)
    force = driving_resistance(ROMO, speeds, 0.0)
    per_metre = force + 4 * sum(motor_losses(ROMO, force / (4 * ROMO.motor_ratio), speeds * ROMO.motor_ratio)) / speeds
    assert float(np.median(profile.v)) == pytest.approx(speeds[np.argmin(per_metre)], rel=0.01)


CASES = {
    "hills": lambda: limits_on(hilly()),
    "stop line": lambda: limits_on(hilly(), ROMO, Stop(301.0)),
    "friction brakes": lambda: limits_on(hilly(), WEAK_RECUPERATION, FrictionBrakes(8000.0)),
    "grip": lambda: limits_on(hilly(), ROMO, Grip(0.35)),
    "battery": lambda: limits_on(hilly(), ROMO, BatteryPower(12e3, 6e3)),
    "circuit": lambda: limits_on(oval()),
    "rolling start and end": lambda: limits_on(hilly(), start_speed=8.0, end_speed=5.0),
}


@pytest.mark.parametrize("case", CASES)
def test_ipopt_and_the_interior_point_method_of_our_own_find_the_same_energy(case: str):
    limits = CASES[case]()
    allowed = 1.15 * fastest_profile(limits).journey_time
    reference, ours = nlp_profile(limits, allowed), eco_profile(limits, allowed)
    # both are solved to about 1e-8 of the energy that moves
    assert energy(limits, reference) == pytest.approx(energy(limits, ours), rel=1e-5)
    assert reference.journey_time <= allowed + 1e-4


def test_jerk_and_windows_are_kept():
    limits = limits_on(straight(), ROMO, Jerk(0.8), Arrival(300.0, 45.0, 50.0))
    profile = nlp_profile(limits, 80.0)
    assert np.max(np.abs(jerk_of(limits.ds, profile.v))) <= 0.8 * (1 + 1e-6)
    passing = float(np.interp(300.0, limits.s, arrival_times(limits, profile.v)))
    assert 45.0 - 1e-5 <= passing <= 50.0 + 1e-5
    free = limits_on(straight(), step=2.0)
    assert energy(free, nlp_profile(free, 80.0)) < energy(limits, profile)


def test_jerk_is_refused_on_a_circuit():
    with pytest.raises(PlanningError, match="a limit of jerk needs an open road"):
        limits_on(oval(), ROMO, Jerk(0.5))
