import numpy as np
import pytest
from scipy.spatial import cKDTree

import roads
from energy_mgr import InfeasibleError, PlanningError, plan_path
from energy_mgr.joint import JointPlan, joint_plan
from energy_mgr.joint.start import problem_of, variables_of
from energy_mgr.path import Path, PathOptions, Weights
from energy_mgr.speed import SpeedLimits, eco_profile, fastest_profile
from powertrain import Vehicle, drive_energy
from roads import Road, RoadBuilder
from roads.road import Extent
from tests.conftest import DATA

CLEARANCE = 1.05


@pytest.fixture(scope="module")
def handling(romo: Vehicle) -> JointPlan:
    return joint_plan(roads.open_road("handling"), romo, corridor="road")


def beyond(road: Road, path: Path, extent: Extent) -> float:
    """How much too close the path comes to a border, every decimetre; by the nearest of points 2 cm apart, not by the planner's proof."""
    points = path.curve.position(np.arange(0.0, path.curve.length, 0.1))
    fine = np.linspace(0.0, road.length, int(road.length / 0.02))
    line, normal = road.reference.position(fine), road.reference.normal(fine)
    _, nearest = cKDTree(line).query(points)
    offset = np.sum((points - line[nearest]) * normal[nearest], axis=1)
    right, left = road.corridor(extent).borders(fine[nearest])
    return float(np.max(np.maximum(offset - left, right - offset))) + CLEARANCE


def energy_on(road: Road, path: Path, vehicle: Vehicle, duration: float) -> float:
    limits = SpeedLimits.along(road, path, vehicle)
    profile = eco_profile(limits, duration)
    return drive_energy(vehicle, profile.s, profile.v, limits.z).total / 3.6e6


def test_on_a_straight_road_the_sequential_plan_is_kept(romo: Vehicle):
    road = RoadBuilder("straight").limit(15.0).straight(300).build()
    quickest = joint_plan(road, romo)
    assert quickest.status == "sequential kept"
    # the least time leaves no choice, and the programme's own stations miss it by a hair: it must have a solution all the same
    assert quickest.iterations < 50
    duration = 1.1 * quickest.profile.journey_time
    made = joint_plan(road, romo, journey_time=duration)
    assert made.status == "sequential kept"
    assert made.path is made.sequential[0]
    assert made.note
    assert made.extra_percent == 0.0
    # a path as long driven with the same choice of speeds: the two discretisations, 4 m and 2 m, differ by 0.2 % at most
    assert made.programme_kwh == pytest.approx(made.energy_kwh, rel=2e-3)


def test_where_bends_bind_no_speed_the_path_is_the_shortest(romo: Vehicle):
    """At 5 m/s a bend of 40 m radius costs no speed, so that only length counts: the path is that of least length, found by another method."""
    road = RoadBuilder("slow bend").limit(5.0).straight(50).bend(40, 1.2, 15).straight(50).build()
    made = joint_plan(road, romo, corridor="road", journey_time=40.0, start_speed=5.0, end_speed=5.0)
    short = plan_path(road, CLEARANCE, extent="road", options=PathOptions(weights=Weights(length=10.0)))
    assert made.status == "solved"
    assert made.path.curve.length < made.sequential[0].curve.length - 0.05
    assert made.path.curve.length == pytest.approx(short.curve.length, abs=0.02)
    # and symmetric, as the road is: one end's mirror image is the other end
    s = np.linspace(0.0, 0.5 * made.path.curve.length, 50)
    offset = made.path.curve.curvature(s) - made.path.curve.curvature(made.path.curve.length - s)
    ends = [road.reference.project(made.path.curve.position(at), at)[1] for at in (s, made.path.curve.length - s)]
    assert np.max(np.abs(ends[0] - ends[1])) < 0.02
    assert np.sqrt(np.mean(offset**2)) < 1e-3


def test_mirrored_road_gives_mirrored_plan(romo: Vehicle):
    made = []
    for turn in (1.0, -1.0):
        road = RoadBuilder("bend").limit(20.0).straight(60).bend(30, turn * 1.2, 12).straight(60).build(lanes=((1, -3.5, 3.5),))
        made.append(joint_plan(road, romo))
    assert made[0].energy_kwh == pytest.approx(made[1].energy_kwh, rel=1e-5)
    places = [one.path.curve.position(np.linspace(0.0, 1.0, 200) * one.path.curve.length) for one in made]
    assert np.max(np.abs(places[0] - places[1] * [1.0, -1.0])) < 1e-3


def test_joint_plan_is_thriftier_inside_the_borders_and_on_time(handling: JointPlan, romo: Vehicle):
    road, path = roads.open_road("handling"), handling.path
    assert handling.status == "solved"
    assert path.report.certified
    assert beyond(road, path, "road") <= 1e-5
    assert handling.extra_percent is not None
    assert handling.extra_percent > 10.0
    assert handling.profile.journey_time == pytest.approx(handling.sequential[1].journey_time, abs=1e-2)
    for own, kwh in ((path, handling.energy_kwh), (handling.sequential[0], handling.sequential_energy_kwh)):
        assert energy_on(road, own, romo, handling.sequential[1].journey_time) == pytest.approx(kwh, rel=1e-6)


def test_the_time_by_default_is_one_that_the_lanes_centre_can_make_too(handling: JointPlan, romo: Vehicle):
    road = roads.open_road("handling")
    lane = plan_path(road, CLEARANCE, extent="road", kind="lane")
    slow, quick = (fastest_profile(SpeedLimits.along(road, path, romo)).journey_time for path in (lane, handling.sequential[0]))
    assert slow > 1.02 * quick
    # profiles keep their time to 0.01 s
    assert handling.profile.journey_time == pytest.approx(slow, abs=1e-2)


def test_no_path_towards_the_sequential_or_the_shortest_one_is_thriftier(handling: JointPlan, romo: Vehicle):
    """Optimality, judged by the cone programme for the speed, not by the joint problem itself; between paths in a corridor lie paths in it."""
    road, options = roads.open_road("handling"), PathOptions(curvature_max=1.0 / 2.6)
    problem = problem_of(road, handling.path, CLEARANCE, "road", options)
    best, gentle = variables_of(problem, handling.path), variables_of(problem, handling.sequential[0])
    short = variables_of(problem, plan_path(road, CLEARANCE, extent="road", options=PathOptions(knots="need", weights=Weights(length=1e-3))))
    for other in (gentle, short):
        for share in (0.05, 0.2):
            curve = problem.curve((1.0 - share) * best + share * other)
            path = Path(curve, curve.breaks_s, problem.spline.breaks, handling.path.report)
            # the programme knows limits at places 2 m apart, the profile between them too: that is worth up to 0.1 % here
            assert energy_on(road, path, romo, handling.profile.journey_time) > handling.energy_kwh * (1.0 - 1e-3)


@pytest.mark.parametrize("start", ["lane", "short"])
def test_other_starts_lead_to_the_same_optimum(start, handling: JointPlan, romo: Vehicle):
    made = joint_plan(roads.open_road("handling"), romo, corridor="road", start=start)
    assert made.energy_kwh == pytest.approx(handling.energy_kwh, rel=1e-3)


def test_failure_of_the_joint_problem_keeps_the_sequential_plan(romo: Vehicle, monkeypatch: pytest.MonkeyPatch):
    road = RoadBuilder("bend").limit(20.0).straight(60).bend(30, 1.2, 12).straight(60).build()
    monkeypatch.setattr("energy_mgr.joint.programme._OPTIONS", {"print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes", "ipopt.max_iter": 2})
    made = joint_plan(road, romo)
    assert made.status == "sequential kept"
    assert "Maximum_Iterations_Exceeded" in made.note
    assert made.path is made.sequential[0]


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"margin": float("nan")}, "margin nan m"),
        ({"step": 0.0}, "step of the joint plan 0.0 m"),
        ({"journey_time": float("nan")}, "arrival time nan s"),
        ({"start": "nowhere"}, "start of the joint plan 'nowhere'"),
    ],
)
def test_arguments_out_of_range_are_refused(wrong, words: str, romo: Vehicle):
    with pytest.raises(PlanningError, match=words):
        joint_plan(roads.open_road("handling"), romo, **wrong)


def test_too_early_an_arrival_is_refused_with_the_least_time(romo: Vehicle):
    with pytest.raises(InfeasibleError):
        joint_plan(roads.open_road("handling"), romo, corridor="road", journey_time=20.0)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["commute", "rural", "descent"])
def test_shipped_roads_gain(name: str, romo: Vehicle):
    road = roads.open_road(name)
    made = joint_plan(road, romo)
    assert made.status == "solved"
    assert made.energy_kwh < made.sequential_energy_kwh
    assert made.path.report.certified
    assert beyond(road, made.path, "own") <= 1e-5


@pytest.mark.slow
@pytest.mark.skipif(not (DATA / "roads" / "tum").is_dir(), reason="real tracks are not there")
@pytest.mark.parametrize("name", ["Norisring", "Oschersleben"])
def test_real_tracks_gain(name: str, romo: Vehicle):
    road = roads.open_road(DATA / "roads" / "tum" / f"{name}.csv", closed=True)
    lane = plan_path(road, CLEARANCE, extent="road", kind="lane")
    made = joint_plan(road, romo, corridor="road")
    assert made.extra_percent is not None
    assert made.extra_percent > 2.0
    assert made.profile.journey_time == pytest.approx(fastest_profile(SpeedLimits.along(road, lane, romo)).journey_time, abs=1e-2)
