import numpy as np
import pytest

import roads
from energy_mgr import PathOptions, PlanningError, SolverError, plan_path
from energy_mgr.path import PathPlanner, PathState, receding_path
from energy_mgr.path.proof.certificate import Prover
from powertrain import load_vehicle
from roads import Narrowing, Road, RoadBuilder

#: Half of ROMO's width and the default margin.
CLEARANCE = 1.05


def planner_on(road: Road, **options) -> PathPlanner:
    return PathPlanner(road, load_vehicle("romo"), extent="road", **{"budget_ms": 1e3, **options})


def state_beside(planner: PathPlanner, s: float, offset: float, turn: float = 0.0, kappa: float = 0.0) -> PathState:
    """A car beside the path in force."""
    path = planner.path
    assert path is not None
    place, first = (value[0] for value in path.pieces(np.array([s]), 1))
    first = first / np.hypot(*first)
    x, y = place + offset * np.array([-first[1], first[0]])
    return PathState(float(x), float(y), float(np.arctan2(first[1], first[0])) + turn, kappa)


@pytest.mark.parametrize(("name", "laps"), [("commute", 1.0), ("handling", 1.3)])
def test_every_step_gives_a_proven_path_that_goes_on_from_the_last_one(name: str, laps: float):
    road = roads.open_road(name)
    planner, corridor = planner_on(road), road.corridor("road", CLEARANCE)
    last = None
    for s in np.arange(0.0, laps * road.length - 30.0, 17.0):
        step = planner.step(s % road.length if road.closed else s)
        assert step.status in ("solved", "kept")
        assert step.pieces is not None
        assert step.clear_to >= min(s + 150.0, road.length - 1e-6)
        found = Prover(corridor, s - 60.0, step.clear_to + 30.0).prove(step.pieces, start=max(s, step.pieces.breaks[0]), end=step.clear_to)
        assert found.certified
        if last is not None:
            # where the car is nothing jumps: place, heading and curvature are those of the path before
            for order, tolerance in ((0, 1e-6), (1, 1e-6), (2, 1e-5)):
                new, old = (pieces(np.array([s]), 2)[order][0] for pieces in (step.pieces, last))
                assert np.allclose(new, old, atol=tolerance)
        last = step.pieces


def test_stitches_are_smooth_to_the_curvature():
    road = roads.open_road("descent")[0:1200]
    path = receding_path(planner_on(road, horizon=120.0), 30.0)
    breaks = path.breaks_s[1:-1]
    turn = path.heading(breaks + 1e-7) - path.heading(breaks - 1e-7)
    assert np.max(np.abs(turn)) < 1e-5
    assert np.max(np.abs(path.curvature(breaks + 1e-7) - path.curvature(breaks - 1e-7))) < 1e-4


def test_horizon_of_the_whole_road_is_the_plan_of_the_whole_road():
    road = roads.open_road("descent")[0:800]
    step = planner_on(road, horizon=1e4).step(0.0)
    assert step.curve is not None
    # more knots and borders drawn in by 1.5 mm more than in a plan made once
    assert step.curve.squared_curvature() == pytest.approx(plan_path(road, CLEARANCE, extent="road").report.cost, rel=4e-3)


def test_unchanged_window_is_not_solved_again():
    planner = planner_on(roads.open_road("descent")[0:800])
    # one QP per step, until the first window from the knot ahead of the car has converged
    assert sum(planner.step(100.0).iterations > 0 for _ in range(8)) < 6
    again = planner.step(100.1)
    assert (again.status, again.iterations) == ("solved", 0)
    assert planner.step(115.0).iterations > 0


def test_truck_that_appears_is_passed_and_forgotten():
    road = RoadBuilder("street").straight(400).build()
    planner, truck = planner_on(road), Narrowing(120.0, 132.0, right=-0.6)
    planner.step(0.0)
    step = planner.step(20.0, corridor_update=[truck])
    assert step.status == "solved"
    assert step.pieces is not None
    assert Prover(road.corridor("road", CLEARANCE).narrowed(truck)).prove(step.pieces).inside
    assert float(step.pieces(np.array([126.0]))[0][0, 1]) > 0.4
    planner.step(24.0, corridor_update=[])
    after = planner.step(36.0)
    assert after.status == "solved"
    assert after.curve is not None
    assert step.curve is not None
    assert after.curve.squared_curvature() < 0.8 * step.curve.squared_curvature()


def test_blocked_road_keeps_the_last_path_up_to_the_obstacle_and_says_so():
    road = RoadBuilder("street").straight(400).build()
    planner = planner_on(road)
    free = planner.step(0.0)
    wall = [Narrowing(120.0, 132.0, right=1.0), Narrowing(125.0, 140.0, left=-1.0)]
    step = planner.step(20.0, corridor_update=wall)
    assert step.status == "blocked"
    assert "street: " in step.reason
    assert 110.0 < step.clear_to < 120.0
    assert step.pieces is not None
    assert step.pieces.breaks[-1] == pytest.approx(step.clear_to)
    assert free.pieces is not None
    at = np.linspace(20.0, step.clear_to, 50)
    assert np.allclose(step.pieces(at)[0], free.pieces(at)[0], atol=1e-9)
    assert Prover(road.corridor("road", CLEARANCE).narrowed(*wall)).prove(step.pieces).inside
    # nothing changes while the wall stands; the way is free again when it is gone
    assert planner.step(30.0).status == "blocked"
    assert planner.step(40.0).clear_to <= step.clear_to
    assert planner.step(45.0, corridor_update=[]).status == "solved"


@pytest.mark.parametrize("kappa", [0.0, 0.01])
def test_car_beside_its_path_gets_one_from_where_it_is(kappa: float):
    planner = planner_on(roads.open_road("commute"))
    planner.step(0.0)
    state = state_beside(planner, 40.0, 0.8, 0.03, kappa)
    step = planner.step(40.0, state)
    assert step.status == "solved"
    curve = step.curve
    assert curve is not None
    assert np.allclose(curve.position(0.0), [state.x, state.y], atol=1e-6)
    assert float(curve.heading(0.0)) == pytest.approx(state.psi, abs=1e-6)
    assert float(curve.curvature(0.0)) == pytest.approx(kappa, abs=1e-6)
    # and the next step goes on from there
    assert planner.step(50.0).status == "solved"


def test_car_a_little_beside_its_path_keeps_it():
    planner = planner_on(roads.open_road("commute"))
    before = planner.step(0.0)
    step = planner.step(20.0, state_beside(planner, 20.0, 0.1))
    assert step.status == "solved"
    assert before.pieces is not None
    assert step.pieces is not None
    assert np.allclose(step.pieces(np.array([20.0]))[0], before.pieces(np.array([20.0]))[0], atol=1e-9)


def test_car_off_the_road_is_lost_until_it_is_back():
    planner = planner_on(roads.open_road("commute"))
    planner.step(0.0)
    step = planner.step(30.0, state_beside(planner, 30.0, 15.0))
    assert step.status == "lost"
    assert step.pieces is None
    assert "the car is at" in step.reason
    assert planner.step(30.0).status == "solved"


def test_measurements_that_cannot_be_are_rejected_and_counted():
    planner = planner_on(roads.open_road("commute"))
    assert planner.step(float("nan")).status == "lost"  # nothing to keep yet
    good = planner.step(10.0)
    for s, state in ((float("nan"), None), (20.0, PathState(float("inf"), 0.0, 0.0)), (1e6, None)):
        step = planner.step(s, state)
        assert "expected" in step.reason
    assert planner.rejected == 4
    bad = planner.step(12.0, corridor_update=[Narrowing(50.0, 40.0, left=1.0)])
    assert "expected an end after the start" in bad.reason
    assert planner.rejected == 5
    again = planner.step(12.0)
    assert again.status == "solved"
    assert again.clear_to >= good.clear_to


def test_jump_backward_is_proven_before_it_is_trusted():
    road = RoadBuilder("street").straight(600).build()
    wall = [Narrowing(140.0, 146.0, right=0.8), Narrowing(141.0, 147.0, left=-0.8)]
    planner = planner_on(road)
    planner.step(100.0)
    assert planner.step(150.0, corridor_update=wall).status == "solved"  # the wall is behind the car
    step = planner.step(135.0)
    assert step.status == "blocked"
    assert step.clear_to < 140.0


def test_update_that_comes_with_a_bad_measurement_counts():
    road = RoadBuilder("street").straight(600).build()
    planner = planner_on(road)
    planner.step(100.0)
    step = planner.step(float("nan"), corridor_update=[Narrowing(140.0, 146.0, right=0.8), Narrowing(141.0, 147.0, left=-0.8)])
    assert step.status == "blocked"
    assert step.clear_to < 140.0


@pytest.mark.parametrize("s", [380.0, 390.0, 396.0, 399.0, 400.9])
def test_car_beside_its_path_near_the_end_of_the_road_is_told_so(s: float):
    planner = planner_on(RoadBuilder("street").straight(400).build())
    for first in (None, 300.0):
        if first is not None:
            planner.step(first)
        step = planner.step(s, PathState(min(s, 400.0), -0.6, 0.0))
        assert step.status in ("solved", "lost")
        assert step.status == "solved" or "the road ends" in step.reason or "expected" in step.reason


def test_path_from_beside_the_plan_is_stitched_where_it_has_a_knot():
    planner = planner_on(roads.open_road("handling"))
    planner.step(100.0)
    first = planner.step(120.0, state_beside(planner, 120.0, 0.9, 0.1))
    assert first.status == "solved"
    second = planner.step(first.s + 0.2)
    for step in (first, second):
        assert step.curve is not None
        breaks = step.curve.pieces.breaks[1:-1]
        before, after = step.curve.pieces(breaks - 1e-9), step.curve.pieces(breaks + 1e-9)
        assert np.max(np.abs(before[0] - after[0])) < 1e-6


def test_bound_on_curvature_is_kept_while_driving():
    road = roads.open_road("descent")[900:1700]
    planner = planner_on(road, options=PathOptions(curvature_max=0.05))
    statuses = []
    for s in np.arange(0.0, 560.0, 8.0):
        step = planner.step(s)
        statuses.append(step.status)
        assert step.curve is not None
        assert np.max(np.abs(step.curve.curvature(np.linspace(0.0, step.curve.length, 2000)))) <= 0.05
    assert statuses.count("solved") > 0.8 * len(statuses)


def test_what_an_obstacle_has_taught_is_forgotten_with_it():
    road = RoadBuilder("s").straight(60).bend(30, 1.2, 12).straight(60).bend(30, -1.2, 12).straight(80).build()
    planner, fresh = planner_on(road), planner_on(road)
    for s in np.arange(0.0, 100.0, 10.0):
        planner.step(s, corridor_update=[Narrowing(s + 30.0, s + 36.0, right=-0.5)])
    planner.step(100.0, corridor_update=[])
    again, once = planner.step(0.0), fresh.step(0.0)
    assert again.curve is not None
    assert once.curve is not None
    assert again.curve.squared_curvature() == pytest.approx(once.curve.squared_curvature(), rel=1e-2)


def test_step_stays_within_its_budget_of_processor_time():
    # a budget that is spent before the second solve: the path in force is kept, and the step ends
    planner = planner_on(roads.open_road("descent")[0:1500], budget_ms=1e3)
    planner.step(0.0)
    planner.budget_ms = 1e-3
    steps = [planner.step(s) for s in np.arange(10.0, 120.0, 10.0)]
    assert all(step.iterations <= 1 for step in steps)
    assert all(step.status in ("solved", "kept") for step in steps)


def test_arguments_out_of_range_are_refused():
    road = roads.open_road("commute")
    with pytest.raises(PlanningError, match="horizon 1.0 m"):
        planner_on(road, horizon=1.0)
    with pytest.raises(PlanningError, match="budget 0.0 ms"):
        planner_on(road, budget_ms=0.0)
    with pytest.raises(PlanningError, match="method 'ipopt': a receding horizon has its own"):
        planner_on(road, options=PathOptions(method="ipopt"))
    with pytest.raises(SolverError, match="a horizon study needs a road with an end"):
        receding_path(planner_on(roads.open_road("handling")))
