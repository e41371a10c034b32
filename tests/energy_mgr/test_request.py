"""What a user asks of a plan: checked when it is made, equal by value, the same after a way through a file."""

import json
from typing import Any, get_type_hints

import numpy as np
import pytest

from energy_mgr import DriveRules, End, PathOptions, PlanningError, PlanRequest, Weights, plan, plan_front
from energy_mgr.joint import joint_plan
from energy_mgr.request import PlanWishes, requested
from energy_mgr.speed import Stop, Window
from powertrain import load_vehicle
from roads import RoadBuilder

RICH = PlanRequest(
    corridor="road",
    journey_time=95.5,
    margin=0.35,
    rules=DriveRules(2.0, 1.0, stops=[120.0], windows=[Window(300.0, 20.0, 31.5)], jerk=1.5, grip=0.9, friction_brakes=True, step=3.0),
    path_options=PathOptions(knots=4.0, qp="clarabel", weights=Weights(length=1e-4), ends=(End(offset=-1.75, heading=0.0), None), curvature_max=0.2),
)


@pytest.mark.parametrize("request_", [PlanRequest(), RICH, PlanRequest(price=3000.0), PlanRequest(soc=0.5, rules=DriveRules(windows=[Window(9.0)]))])
def test_it_comes_back_equal_from_json(request_: PlanRequest):
    assert PlanRequest.from_dict(json.loads(json.dumps(request_.to_dict()))) == request_


def test_defaults_are_not_written_down():
    assert PlanRequest().to_dict() == {}
    assert PlanRequest(margin=0.3, rules=DriveRules(jerk=1.0)).to_dict() == {"margin": 0.3, "rules": {"jerk": 1.0}}


def test_two_requests_for_the_same_are_equal_and_found_in_a_dictionary():
    again = PlanRequest.from_dict(RICH.to_dict())
    assert {RICH: 1}[again] == 1
    assert DriveRules(stops=[5.0]) == DriveRules(stops=(5.0,))


@pytest.mark.parametrize(
    ("found", "words"),
    [
        ({"margins": 0.2}, r"unknown key 'margins', expected one of corridor, path, "),
        ({"rules": {"jerks": 1}}, r"unknown key 'rules\.jerks', expected one of rules\.start_speed"),
        ({"rules": 3}, r"rules is 3, expected a table"),
        ({"margin": "wide"}, r"margin is 'wide', expected a number"),
        ({"margin": True}, r"margin is True, expected a number"),
        ({"margin": float("nan")}, r"margin is nan, expected a number"),
        ({"corridor": "field"}, r"corridor 'field', expected one of lane, own, road"),
        ({"corridor": 3}, r"corridor is 3, expected a word"),
        ({"rules": {"stops": 5}}, r"rules\.stops has 5, expected a list"),
        ({"rules": {"windows": [[1.0]]}}, r"rules\.windows has \[1\.0\], expected a list of 2 or 3"),
        ({"rules": {"friction_brakes": 1}}, r"rules\.friction_brakes is 1, expected true or false"),
        ({"path_options": {"control_points": 2.5}}, r"path_options\.control_points is 2\.5, expected a whole number"),
        ({"path_options": {"weights": {"length": -1}}}, r"path_options\.weights: "),
        ({"path_options": {"knots": "many"}}, r"path_options: knots 'many', expected 'need' or"),
        ({"rules": {"parts": []}}, r"unknown key 'rules\.parts'"),
    ],
)
def test_what_is_wrong_in_a_file_is_named_with_its_key(found: dict[str, Any], words: str):
    with pytest.raises(PlanningError, match=words):
        PlanRequest.from_dict(found)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"speed": "slow"}, "speed 'slow', expected one of fast, toppra, eco"),
        ({"margin": float("nan")}, "margin nan m"),
        ({"margin": "wide"}, "margin 'wide', expected a number"),
        ({"margin": None}, "margin None, expected a number"),
        ({"rules": None}, "rules None, expected DriveRules"),
        ({"soc": float("nan")}, "state of charge nan, expected 0 to 1"),
        ({"soc": 5.0, "method": "joint"}, "state of charge 5.0, expected 0 to 1"),
        ({"price": float("nan")}, "price of time nan W"),
        ({"journey_time": 0.0}, "arrival time 0.0 s"),
        ({"price": 1.0, "journey_time": 9.0}, "price of time 1.0 W with speed eco, arrival time 9.0"),
        ({"method": "joint", "path": "lane"}, "method joint with path lane"),
        ({"speed": "fast", "rules": DriveRules(jerk=1.0)}, "speed fast knows no limit of jerk"),
        ({"speed": "dp", "soc": 0.5}, "a state of charge with speed dp"),
    ],
)
def test_wishes_that_make_no_sense_are_refused_before_anything_is_planned(wrong: dict[str, Any], words: str):
    with pytest.raises(PlanningError, match=words):
        PlanRequest(**wrong)


def test_parts_of_ones_own_cannot_be_written_down():
    with pytest.raises(PlanningError, match=r"rules\.parts are code"):
        PlanRequest(rules=DriveRules(parts=[Stop(5.0)])).to_dict()


def test_keywords_are_the_fields_of_a_request():
    assert set(PlanWishes.__annotations__) == set(PlanRequest.__dataclass_fields__)
    assert get_type_hints(PlanWishes) == {name: kind for name, kind in get_type_hints(PlanRequest).items() if name in PlanWishes.__annotations__}
    with pytest.raises(TypeError, match="unexpected keyword 'colour', expected one of corridor"):
        plan("commute", colour="red")  # pyright: ignore[reportCallIssue]


def test_keywords_go_over_a_request_and_none_leaves_it_as_it_is():
    assert requested(RICH, {"margin": 0.1, "soc": None}) == PlanRequest(**{**vars(RICH), "margin": 0.1})
    assert requested(RICH, {}) is RICH
    assert requested(None, {}) == PlanRequest()


def test_a_plan_knows_what_was_asked_and_a_request_plans_what_keywords_plan():
    road, car = RoadBuilder("bend").straight(60).bend(30, 1.0, 10).straight(60).build(), load_vehicle("romo")
    short, long = plan(road, car, corridor="lane", margin=0.3), plan(road, car, PlanRequest(corridor="lane", margin=0.3))
    assert short.request == long.request
    assert (short.corridor, short.margin) == ("lane", 0.3)
    assert short.energy_kwh == pytest.approx(long.energy_kwh, rel=1e-9)
    assert short.journey_time == pytest.approx(long.journey_time, rel=1e-9)


def test_the_car_bounds_the_paths_curvature_and_its_width_the_clearance():
    car = load_vehicle("romo")
    assert PlanRequest(margin=0.3).clearance(car) == pytest.approx(0.5 * car.chassis.width_m + 0.3)
    radius = car.limits.turning_radius_min_m
    asked = PathOptions(curvature_max=0.05)
    assert PlanRequest(path_options=asked).options_for(car).curvature_max == 0.05
    if radius is not None:
        assert PlanRequest().options_for(car).curvature_max == pytest.approx(1.0 / radius)


def test_numbers_of_numpy_come_out_as_plain_ones_and_what_json_and_toml_lack_is_left_out():
    rich = PlanRequest(
        margin=np.float32(0.25),
        journey_time=np.float64(90.0),
        rules=DriveRules(stops=np.array([3.0, 4.0]), windows=[Window(9.0, 2.0)]),
        path_options=PathOptions(ends=[None, End(offset=0.5)], density=2.0),
    )
    found = rich.to_dict()
    assert json.loads(json.dumps(found, allow_nan=False)) == {
        "margin": 0.25,
        "journey_time": 90.0,
        "rules": {"stops": [3.0, 4.0], "windows": [[9.0, 2.0]]},
        "path_options": {"ends": [{}, {"offset": 0.5}]},
    }
    assert PlanRequest.from_dict(found) == PlanRequest(**{**vars(rich), "path_options": PathOptions(ends=(None, End(offset=0.5)))})
    assert hash(rich.path_options) is not None


@pytest.mark.parametrize("ends", [(), (None,), (None, None, None)])
def test_a_path_has_two_ends(ends: tuple[None, ...]):
    with pytest.raises(PlanningError, match="expected two"):
        PathOptions(ends=ends)  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize(("wish", "value"), [("price", 500.0), ("soc", 0.3), ("speed", "fast"), ("path", "lane")])
def test_wishes_that_mean_nothing_for_a_joint_plan_are_refused(wish: str, value: Any):
    road = RoadBuilder("straight").straight(100).build()
    with pytest.raises(PlanningError, match=f"{wish} .* means nothing for a joint plan"):
        joint_plan(road, load_vehicle("romo"), **{wish: value})


def test_an_arrival_time_means_nothing_for_a_front():
    with pytest.raises(PlanningError, match="journey_time 95.0 means nothing for a front"):
        plan_front(RoadBuilder("straight").straight(100).build(), journey_time=95.0)
