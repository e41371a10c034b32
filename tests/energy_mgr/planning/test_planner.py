"""Many cars on one road: what depends on the road alone is made once, and nothing is driven that nobody asks for."""

import gc
import pickle

import msgspec
import pytest

from energy_mgr import DriveRules, PathOptions, Planner, PlanRequest, plan
from energy_mgr.planning import planner as module
from energy_mgr.speed.bounds import stations
from powertrain import Vehicle
from roads import Road, RoadBuilder


@pytest.fixture(scope="module")
def road() -> Road:
    return RoadBuilder("bends").straight(60).bend(30, 1.0, 10).bend(40, -1.0, 10).straight(80).build(height=lambda s: 0.01 * s)


def heavier(car: Vehicle, mass: float) -> Vehicle:
    return msgspec.structs.replace(car, chassis=msgspec.structs.replace(car.chassis, mass_kg=mass))


def wider(car: Vehicle, width: float) -> Vehicle:
    return msgspec.structs.replace(car, chassis=msgspec.structs.replace(car.chassis, width_m=width))


def test_cars_of_one_width_share_their_paths_and_others_do_not(road: Road, romo: Vehicle, monkeypatch: pytest.MonkeyPatch):
    found = []
    search = module.plan_path
    monkeypatch.setattr(module, "plan_path", lambda *args, **kwargs: found.append(kwargs["kind"]) or search(*args, **kwargs))
    planner = Planner(road)
    light, heavy = planner.plan(romo), planner.plan(heavier(romo, 1400.0))
    assert found == ["lane", "optimal"]
    assert heavy.chosen.path is light.chosen.path
    planner.plan(romo, PlanRequest(rules=DriveRules(jerk=2.0)))
    assert len(found) == 2
    broad = planner.plan(wider(romo, 1.9))
    assert len(found) == 4
    assert broad.chosen.path is not light.chosen.path
    planner.plan(romo, PlanRequest(corridor="lane"))
    assert len(found) == 6


def test_each_car_has_the_plan_that_it_would_have_alone(road: Road, romo: Vehicle):
    planner = Planner(road)
    for car in (romo, heavier(romo, 1400.0), wider(romo, 1.8)):
        shared, alone = planner.plan(car), plan(road, car)
        assert shared.energy_kwh == pytest.approx(alone.energy_kwh, rel=1e-9)
        assert shared.journey_time == pytest.approx(alone.journey_time, rel=1e-9)
        assert shared.baseline.energy_kwh == pytest.approx(alone.baseline.energy_kwh, rel=1e-9)


def test_ways_that_nobody_asks_for_are_not_driven(road: Road, romo: Vehicle, monkeypatch: pytest.MonkeyPatch):
    driven = []
    speeds = module.plan_speed
    monkeypatch.setattr(module, "plan_speed", lambda *args, **kwargs: driven.append(args[1]) or speeds(*args, **kwargs))
    made = Planner(road).plan(romo)
    assert driven == ["eco"]
    assert made.comparison.both is made.chosen
    assert driven == ["eco"]
    assert made.comparison.speed_only is not None
    assert driven == ["eco", "eco"]
    assert made.comparison.speed_only is made.comparison.speed_only


def test_a_front_is_that_of_the_planner(road: Road, romo: Vehicle):
    path, limits, front = Planner(road).front(romo, PlanRequest(corridor="lane"), count=3)
    assert len(front.journey_time) == 3
    assert front.journey_time[0] == pytest.approx(Planner(road).plan(romo, PlanRequest(corridor="lane", speed="fast")).journey_time, rel=1e-4)
    assert limits.s[-1] == pytest.approx(path.curve.length)


def test_a_path_is_looked_at_once_and_forgotten_with_it(road: Road, romo: Vehicle):
    planner = Planner(road)
    first = planner.plan(romo).chosen
    second = planner.plan(heavier(romo, 1400.0)).chosen
    assert first.limits.ground.samples.kappa is second.limits.ground.samples.kappa
    with pytest.raises(ValueError, match="read-only"):
        first.limits.ground.samples.kappa[0] = 1.0
    held = len(stations._SAMPLED)
    del planner, first, second
    gc.collect()
    assert len(stations._SAMPLED) < held


def test_a_plan_can_be_sent_to_another_process_and_still_be_compared(road: Road, romo: Vehicle):
    told: list[str] = []
    made = Planner(road, report=told.append).plan(romo)
    again = pickle.loads(pickle.dumps(made))
    count = len(told)
    assert again.energy_kwh == made.energy_kwh
    assert again.comparison.path_only.energy_kwh == made.comparison.path_only.energy_kwh
    # what is driven later is nobody's progress any more
    assert len(told) == count


def test_ends_may_come_as_a_list(road: Road, romo: Vehicle):
    asked = PlanRequest(path_options=PathOptions(ends=[None, None]))  # pyright: ignore[reportArgumentType]
    assert Planner(road).plan(romo, asked).chosen.path.report.certified
