"""A recorded drive, scored: against itself, against a plan, against closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from energy_mgr import PlanningError, PlanRequest, plan, score
from energy_mgr.planning.recorded import recorded_run
from energy_mgr.planning.score import recorded_ledger
from powertrain import KWH, drive_cycle, load_vehicle
from roads import Recorded, Road, RoadBuilder, open_road

STRAIGHT = RoadBuilder("level").straight(1000.0).build()


def driven(road: Road, speed: float) -> Road:
    """Along `road` at one speed."""
    t = np.linspace(0.0, road.length / speed, 200)
    return replace(road, recorded=Recorded(t, speed * t, np.full(200, speed)))


def of_plan(name: str, stop: float | None = None, stood: float = 0.0) -> Road:
    """A road along which a plan was recorded, on the lane's centre."""
    made = plan(name, path="lane", rules=replace(PlanRequest().rules, stops=() if stop is None else (stop,)))
    profile, path = made.chosen.profile, made.chosen.path
    t = np.concatenate([[0.0], np.cumsum(profile.interval_time)])
    s = np.interp(profile.s, path.knot_s, path.knot_road_s)
    v = profile.v.copy()
    if stop is not None:
        at = int(np.flatnonzero(v[1:-1] == 0.0)[0]) + 1
        t = np.concatenate([t[: at + 1], t[at:] + stood])
        s, v = np.insert(s, at, s[at]), np.insert(v, at, 0.0)
    return replace(made.road, recorded=Recorded(t, s, v))


def test_one_speed_on_the_level_takes_what_a_cycle_takes():
    car = load_vehicle("romo")
    ledger = recorded_ledger(driven(STRAIGHT, 15.0), car)
    by_hand = drive_cycle(car, [0.0, 1000.0 / 15.0], [15.0, 15.0])
    assert ledger.energy == pytest.approx(by_hand.energy, rel=1e-9)
    assert ledger.duration == pytest.approx(1000.0 / 15.0)


def test_heights_of_the_road_count():
    car = load_vehicle("romo")
    hill = driven(RoadBuilder("hill").straight(1000.0).build(height=lambda s: 0.03 * s), 15.0)
    more = recorded_ledger(hill, car).components["slope"] - recorded_ledger(driven(STRAIGHT, 15.0), car).components["slope"]
    assert more == pytest.approx(car.chassis.mass_kg * 9.81 * 30.0, rel=2e-3)


@pytest.mark.parametrize(("name", "stop"), [("rural", None), ("commute", 1000.0)])
def test_a_plan_that_was_recorded_has_nothing_left_to_save(name: str, stop: float | None):
    road = of_plan(name, stop, 20.0)
    made = score(road, "romo", PlanRequest(path="lane"))
    assert abs(made.late) < 0.02
    assert made.same_ends
    assert made.planned.duration == pytest.approx(made.recorded.duration, abs=0.02)
    # the plan keeps to its own stations, 2 m apart, and so did the one recorded: the same but for where a bend of the lane puts them
    assert made.saving_percent == pytest.approx(0.0, abs=0.15)
    assert made.recorded.components["auxiliary"] == pytest.approx(made.planned.components["auxiliary"], rel=1e-3)


def test_the_row_as_recorded_is_the_plan_that_was_recorded():
    road = of_plan("rural")
    made = plan(road, path="lane")
    assert made.comparison.recorded is not None
    assert made.comparison.recorded.journey_time == pytest.approx(made.journey_time, rel=1e-4)
    assert made.comparison.recorded.ledger.total == pytest.approx(made.chosen.ledger.total, rel=2e-3)
    assert made.comparison.journey_time == pytest.approx(road.recorded.moving_time if road.recorded else 0.0, rel=1e-4)


def test_a_drive_in_fits_and_starts_costs_more():
    road = of_plan("rural")
    assert road.recorded is not None
    even = score(road, "romo")
    drive = road.recorded
    wave = 1.0 + 0.25 * np.sin(drive.t / 6.0)
    v = drive.v * wave
    way = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(drive.t))])
    uneven = score(replace(road, recorded=Recorded(drive.t, way * (road.length / way[-1]), v * (road.length / way[-1]))), "romo")
    assert uneven.energy_kwh > 1.05 * even.energy_kwh
    assert (uneven.saving_percent or 0.0) > (even.saving_percent or 0.0) + 4.0
    # what is saved is told in kWh too, and adds up
    assert uneven.energy_kwh - uneven.planned_kwh == pytest.approx((uneven.recorded.energy - uneven.planned.energy) / KWH)


def test_a_drive_too_fast_for_the_car_is_no_comparison_at_equal_time():
    made = score(driven(open_road("commute"), 35.0), "romo")
    assert made.late > 10.0
    assert made.planned.duration == pytest.approx(made.recorded.duration + made.late, abs=0.02)


def test_friction_brakes_take_what_recuperation_cannot():
    car = load_vehicle("romo")
    t = np.array([0.0, 20.0, 21.5])
    v = np.array([20.0, 20.0, 0.0])
    s = np.array([0.0, 400.0, 415.0])
    road = replace(RoadBuilder("stop").straight(415.0).build(), recorded=Recorded(t, s, v))
    made = plan(replace(road, recorded=None), car, path="lane", rules=replace(PlanRequest().rules, start_speed=15.0))
    run = recorded_run(road, made.chosen.path, made.chosen.limits)
    assert run is not None
    assert run.ledger.components["brake"] == pytest.approx(recorded_ledger(road, car).components["brake"], rel=0.02)
    assert run.ledger.components["brake"] > 0.0


def test_without_a_record_there_is_nothing_to_score():
    with pytest.raises(PlanningError, match="records neither times nor speeds"):
        score(STRAIGHT)
    with pytest.raises(PlanningError, match="plans in the recorded time"):
        score(driven(STRAIGHT, 15.0), request=PlanRequest(journey_time=100.0))


def test_what_is_not_compared_like_with_like_is_said():
    from energy_mgr.report.plan.score import score_table

    slow = score(driven(STRAIGHT, 3.0), "romo")
    # going so slowly costs more than the plan's own pace
    assert slow.late < -10.0
    assert "earlier" in score_table(slow)
    assert "in the same time" not in score_table(slow)
    fast = score(driven(open_road("commute"), 35.0), "romo")
    assert not fast.same_ends
    assert "begins and ends with" in score_table(fast)


def test_a_drive_that_passes_its_ends_is_planned_so():
    made = score(driven(STRAIGHT, 15.0), "romo")
    assert made.same_ends
    assert made.plan.chosen.profile.v[[0, -1]] == pytest.approx([15.0, 15.0], abs=1e-3)
    assert made.planned.components["kinetic"] == pytest.approx(0.0, abs=100.0)
