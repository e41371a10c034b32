"""The speed while driving: a point car that does what it is told, and is disturbed."""

import numpy as np
import pytest

import roads
from energy_mgr import InfeasibleError, PlanningError, plan_path
from energy_mgr.speed import Arrival, Jerk, SpeedCap, SpeedLimits, SpeedPlanner, Stop, fastest_profile
from energy_mgr.speed.bounds.jerk import jerk_of
from powertrain import load_vehicle

ROMO = load_vehicle("romo")


def limits_on(name: str, *extra, car=ROMO, step: float = 4.0) -> SpeedLimits:
    road = roads.open_road(name)
    return SpeedLimits.along(road, plan_path(road, 1.05, kind="lane", extent="road"), car, extra=extra, step=step)


@pytest.fixture(scope="module")
def commute() -> SpeedLimits:
    return limits_on("commute")


def drive(planner: SpeedPlanner, rng: np.random.Generator, noise: float, held_up: float = 0.0) -> tuple[float, float, set[str]]:
    """Steps of a second to the end of the road; speeds pushed about by `noise` m/s, the clock once by `held_up` s."""
    s = v = t = 0.0
    end, said, held = float(planner.limits.s[-1]), set(), False
    while s < end - 0.5 and t < 3.0 * planner.journey_time:
        step = planner.step(s, v, t)
        said.add(step.status)
        for _ in range(10):
            v = max(step.speed_at(min(s + 0.1 * max(v, 0.5), float(step.s[-1]))), 0.3)
            s, t = s + 0.1 * v, t + 0.1
        v = max(v + noise * float(rng.standard_normal()), 0.0)
        if held_up and not held and t > 50.0:
            t, held = t + held_up, True
    return s, t, said


@pytest.mark.parametrize(("noise", "held_up"), [(0.0, 0.0), (0.3, 0.0), (0.2, 6.0)])
def test_the_car_arrives_on_time_although_it_is_disturbed(commute: SpeedLimits, noise: float, held_up: float, figure):
    planned = 1.15 * fastest_profile(commute).journey_time
    planner = SpeedPlanner(commute, planned, budget=5.0)
    s, t, said = drive(planner, np.random.default_rng(4), noise, held_up)
    figure(f"commute, noise {noise:g} m/s, held up {held_up:g} s: arrives off the plan by", t - planned, "{:+.1f} s")
    assert s == pytest.approx(commute.s[-1], abs=3.0)
    # the point car creeps at 0.3 m/s at the end and steps by a tenth of a second
    assert t == pytest.approx(planned, abs=2.0)
    assert "kept" not in said


def test_a_car_that_cannot_catch_up_goes_as_fast_as_the_limits_allow(commute: SpeedLimits):
    planner = SpeedPlanner(commute, 1.02 * fastest_profile(commute).journey_time, budget=5.0)
    step = planner.step(300.0, 10.0, 100.0)
    assert step.status == "late"
    assert step.lateness > 50.0
    fastest = fastest_profile(commute)
    assert np.all(step.v <= np.interp(step.s, fastest.s, fastest.v) + 0.3)


def test_a_stop_line_is_kept_however_close_it_is():
    limits = limits_on("commute", Stop(1000.0))
    planner = SpeedPlanner(limits, 1.1 * fastest_profile(limits).journey_time, budget=5.0)
    for gap in (0.1, 0.3, 0.45, 0.6, 5.0):
        v = 0.9 * np.sqrt(2.0 * 2.0 * gap)
        step = planner.step(1000.0 - gap, v, 80.0)
        assert step.speed_at(1000.0) == pytest.approx(0.0, abs=1e-6)


def test_a_window_is_met_by_a_car_that_is_early_or_late():
    free = limits_on("commute")
    planned = 1.2 * fastest_profile(free).journey_time
    passes = SpeedPlanner(free, planned)._time_at(1000.0)
    limits = limits_on("commute", Arrival(1000.0, passes - 1.0, passes + 4.0))
    planner = SpeedPlanner(limits, planned, budget=5.0)
    for off in (-8.0, 3.0):
        step = planner.step(600.0, 12.0, planner._time_at(600.0) + off)
        here = np.searchsorted(step.s, 1000.0) + 1
        duration = float(np.sum(2.0 * np.diff(step.s[:here]) / (step.v[1:here] + step.v[: here - 1])))
        arrival = planner._time_at(600.0) + off + duration
        assert step.status == "planned"
        assert passes - 1.1 <= arrival <= passes + 4.1


def test_jerk_is_kept_in_what_is_planned():
    limits = limits_on("commute", Jerk(0.8))
    planner = SpeedPlanner(limits, 230.0, budget=10.0)
    for s in (200.0, 600.0, 1300.0):
        step = planner.step(s, planner._last.speed_at(s), planner._time_at(s))
        assert step.status == "planned"
        count = int(np.searchsorted(step.s, s + 900.0))
        assert np.max(np.abs(jerk_of(np.diff(step.s[:count]), step.v[:count]))) <= 0.8 * 1.001


def test_too_fast_for_what_lies_ahead_means_braking():
    limits = limits_on("commute", SpeedCap([1000.0, 1100.0], [5.0, np.inf]))
    planner = SpeedPlanner(limits, 1.2 * fastest_profile(limits).journey_time)
    step = planner.step(990.0, 15.0, 60.0)
    assert step.status == "braking"
    assert np.max(-np.diff(step.v**2) / (2.0 * np.diff(step.s))) <= 2.0 * 1.001


@pytest.mark.parametrize(
    "bad", [(np.nan, 1.0, 1.0), (1e9, 1.0, 1.0), (10.0, -5.0, 1.0), (10.0, 1e200, 1.0), (None, 1.0, 1.0), ("x", 1.0, 1.0), (np.ones(2), 1.0, 1.0)]
)
def test_a_bad_measurement_is_counted_and_the_last_profile_goes_on(commute: SpeedLimits, bad: tuple):
    planner = SpeedPlanner(commute, 200.0, horizon=300.0, budget=5.0)
    good = planner.step(100.0, 8.0, planner._time_at(100.0))
    kept = planner.step(*bad)
    assert (kept.status, planner.rejected) == ("kept", 1)
    assert np.array_equal(kept.v, good.v)
    # beyond the horizon the journey's plan goes on: the car stops at the end of the road
    assert kept.speed_at(float(commute.s[-1])) == pytest.approx(0.0)


def test_no_time_at_all_keeps_the_last_profile(commute: SpeedLimits):
    planner = SpeedPlanner(commute, 200.0, budget=1e-9)
    assert planner.step(100.0, 8.0, 20.0).status == "kept"


def test_a_battery_that_runs_low_bounds_the_next_kilometre(commute: SpeedLimits):
    planner = SpeedPlanner(commute, 1.1 * fastest_profile(commute).journey_time, soc=0.5, budget=5.0)
    full, low = planner.step(500.0, 10.0, 60.0, 0.5), planner.step(500.0, 10.0, 60.0, 0.0505)
    assert np.max(np.diff(low.v[:40] ** 2)) < 0.5 * np.max(np.diff(full.v[:40] ** 2))


@pytest.mark.parametrize("cold", [False, True])
@pytest.mark.parametrize("share", [1.05, 1.2, 1.5])
def test_steps_with_a_battery_are_planned_from_the_last_solution_and_from_none(share: float, cold: bool):
    limits = limits_on("commute", step=2.0)  # with these stations a start that jumps at the ends of the stretch is caught
    planner = SpeedPlanner(limits, share * fastest_profile(limits).journey_time, soc=0.6, budget=60.0)
    for s in (0.0, 200.0, 412.0, 1000.0, 1500.0):
        if cold:
            planner._warm = None
        step = planner.step(s, float(np.sqrt(np.interp(s, planner.plan.s, planner.plan.v**2))), planner._time_at(s), 0.6)
        assert step.status == "planned"
        # on time, at the plan's own speed and far from what the battery gives, the plan is still the best there is
        there = s + 300.0
        assert step.speed_at(there) == pytest.approx(np.sqrt(np.interp(there, planner.plan.s, planner.plan.v**2)), rel=0.01)


def test_what_makes_no_sense_is_refused():
    with pytest.raises(PlanningError, match="this is a circuit"):
        SpeedPlanner(limits_on("handling"), 100.0)
    with pytest.raises(InfeasibleError, match="gives no power at a state of charge of 0.01"):
        SpeedPlanner(limits_on("commute"), 200.0, soc=0.01)
    with pytest.raises(PlanningError, match="horizon 0"):
        SpeedPlanner(limits_on("commute"), 200.0, horizon=0.0)
