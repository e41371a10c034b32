import msgspec
import numpy as np
import pytest

import roads
from energy_mgr import InfeasibleError, PlanningError, plan_path
from energy_mgr.speed import SpeedLimits, fastest_profile
from energy_mgr.speed.bounds.grip import Grip
from energy_mgr.speed.bounds.parts import Arrival, BatteryPower, FrictionBrakes, Jerk, Part, Stop
from energy_mgr.speed.fastest.time_optimal import toppra_profile
from powertrain import Vehicle, load_vehicle
from roads import Road, RoadBuilder

ROMO = load_vehicle("romo")
WEAK = msgspec.structs.replace(ROMO, drive=msgspec.structs.replace(ROMO.drive, power_max_w=4000.0))

WEAKER = msgspec.structs.replace(ROMO, drive=msgspec.structs.replace(ROMO.drive, power_max_w=1500.0))


def limits_on(road: Road, vehicle: Vehicle = ROMO, *extra: Part, **options: float) -> SpeedLimits:
    return SpeedLimits.along(road, plan_path(road, 1.0, kind="lane", extent="road"), vehicle, extra=extra, **options)


def straight(length: float = 600.0, limit: float = 15.0, slope: float = 0.0) -> Road:
    return RoadBuilder("straight").limit(limit).straight(length).build(height=lambda s: slope * s)


def oval() -> Road:
    builder = RoadBuilder("oval")
    for _ in range(2):
        builder.straight(150).bend(25, np.pi, 15)
    return builder.build(closed=True)


def test_fastest_drive_between_stops_is_the_closed_form():
    profile = toppra_profile(limits_on(straight(800.0)))
    assert profile.method == "toppra"
    # 0 to 15 m/s and back at 2 m/s^2: 7.5 s and 56.25 m each, which is not a whole number of 2 m intervals
    assert profile.journey_time == pytest.approx(2 * 7.5 + (800 - 2 * 56.25) / 15.0, abs=1e-3)


def ring() -> Road:
    builder = RoadBuilder("ring")
    for _ in range(2):
        builder.straight(30).bend(80, np.pi, 27)
    return builder.build(closed=True)


CASES = {
    "circuit at the end of its power": lambda: limits_on(ring(), WEAKER),
    "entered fast, on little power": lambda: limits_on(straight(400.0, 25.0), WEAK, start_speed=24.0, end_speed=20.0),
    "climb on little power": lambda: limits_on(straight(600.0, 27.0, 0.05), WEAK),
    "stop line": lambda: limits_on(straight(), ROMO, Stop(301.0)),
    "slippery, with friction brakes": lambda: limits_on(straight(limit=30.0), ROMO, Grip(0.2), FrictionBrakes(8000.0)),
    "cold battery": lambda: limits_on(straight(slope=0.03), ROMO, BatteryPower(15e3, 5e3)),
    "rolling start and end": lambda: limits_on(straight(), start_speed=10.0, end_speed=5.0),
    "circuit": lambda: limits_on(oval()),
    "ramp that needs momentum": lambda: limits_on(RoadBuilder("ramp").limit(20).straight(600).build(height=lambda s: 0.4 * np.clip(s - 400, 0, 20))),
    "handling": lambda: limits_on(roads.open_road("handling")),
}


@pytest.mark.parametrize("case", CASES)
def test_reachability_analysis_and_forward_backward_find_the_same_profile(case: str):
    limits = CASES[case]()
    theirs, ours = toppra_profile(limits), fastest_profile(limits)
    # asked for: 0.1 %; the tangents settle to 1e-5 m/s
    assert theirs.journey_time == pytest.approx(ours.journey_time, rel=1e-5)
    assert np.max(np.abs(theirs.v - ours.v)) < 1e-3


def test_slope_that_cannot_be_climbed_is_refused():
    with pytest.raises(InfeasibleError, match="TOPP-RA finds no profile with 0.00 and 0.00 m/s at its ends"):
        toppra_profile(limits_on(straight(slope=0.4)))


@pytest.mark.parametrize(("part", "words"), [(Jerk(1.0), "a jerk limit of 1 m/s"), (Arrival(100.0, 20.0, 30.0), "a window at s = 100 m")])
def test_what_toppra_does_not_know_is_refused_by_name(part: Part, words: str):
    with pytest.raises(PlanningError, match=words):
        toppra_profile(limits_on(straight(), ROMO, part))
