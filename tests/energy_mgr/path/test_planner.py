import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

import roads
from energy_mgr import InfeasibleError, Path, PathOptions, PlanningError, plan_path
from energy_mgr.path import CurvatureProblem
from energy_mgr.path.solvers import gauss_newton, ipopt
from roads import Narrowing, Road, RoadBuilder
from roads.road import Extent

NAMES = roads.shipped()


def violation_every_decimetre(road: Road, path: Path, extent: Extent, clearance: float) -> float:
    """How far the path leaves the corridor; independent of the planner's own check: nearest point on a polyline of the reference by a k-d tree."""
    s = np.arange(0.0, path.curve.length, 0.1)
    points = path.curve.position(s)
    fine = np.linspace(0.0, road.length, int(road.length / 0.02))
    line, normal = road.reference.position(fine), road.reference.normal(fine)
    _, nearest = cKDTree(line).query(points)
    offset = np.sum((points - line[nearest]) * normal[nearest], axis=1)
    right, left = road.corridor(extent).borders(fine[nearest])
    return float(np.max(np.maximum(offset - left, right - offset))) + clearance


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("extent", ["lane", "own", "road"])
def test_shipped_roads_are_solved_inside_their_borders(name: str, extent: Extent):
    road = roads.open_road(name)
    path = plan_path(road, 1.05, extent=extent)
    assert path.report.status == "solved"
    assert path.report.cost < path.report.cost_centre
    assert path.report.certified
    assert path.report.max_violation_m <= 0.0
    # the nearest of points 0.02 m apart misses the foot by at most 0.01 m, which in a 12 m bend changes the offset by 0.01^2 / 2 / 12, 4 um
    assert violation_every_decimetre(road, path, extent, 1.05) <= 1e-5


@pytest.mark.parametrize("name", NAMES)
def test_cost_is_that_of_ipopt_with_exact_derivatives(name: str, figure):
    road = roads.open_road(name)
    problem = CurvatureProblem.on(road.corridor("road", 1.05), road.lane_centre(), spacing=4.0, control_points=3)
    start = problem.initial()
    ours, theirs = gauss_newton.solve(problem, start), ipopt.solve(problem, start)
    assert ours.converged
    figure(f"{name}: path above IPOPT's on the same knots", 100.0 * (ours.cost / theirs.cost - 1.0), "{:+.6f} %", asked="0.02 %")
    # both stop at about 1e-6
    assert ours.cost <= theirs.cost * (1 + 1e-5)
    assert problem.worst_row(ours.x)[0] < 2e-6


def test_both_qp_solvers_find_the_same_path():
    road = roads.open_road("commute")
    piqp, clarabel = (plan_path(road, 1.05, extent="road", options=PathOptions(qp=qp)) for qp in ("piqp", "clarabel"))
    assert (piqp.report.qp, clarabel.report.qp) == ("piqp", "clarabel")
    assert piqp.report.cost == pytest.approx(clarabel.report.cost, rel=1e-5)


def test_straight_road_gives_a_straight_path():
    path = plan_path(RoadBuilder("straight").straight(300).build(), 1.0)
    assert path.report.status == "solved"
    assert path.report.cost < 1e-9
    assert path.curve.length == pytest.approx(300.0, abs=1e-6)


def test_wide_ring_is_driven_on_the_outside_circle():
    # without obstacles the largest circle has least integral of squared curvature: 2 pi / r
    angle = np.linspace(0, 2 * np.pi, 300, endpoint=False)
    ring = Road.from_points("ring", 40 * np.column_stack([np.cos(angle), np.sin(angle)]), -4.0, 4.0, closed=True)
    path = plan_path(ring, 1.0)
    assert path.report.cost == pytest.approx(2 * np.pi / 43.0, rel=1e-4)


@settings(deadline=None, max_examples=8)
@given(seed=st.integers(0, 10_000))
def test_mirrored_road_has_the_mirrored_path(seed: int):
    rng = np.random.default_rng(seed)
    turns = rng.uniform(0.3, 1.4, 3) * rng.choice([-1, 1], 3)
    radii = rng.uniform(15, 60, 3)
    paths = []
    for sign in (1.0, -1.0):
        builder = RoadBuilder("m").straight(40)
        for turn, radius in zip(turns, radii, strict=True):
            builder.bend(radius, sign * turn, 0.8 * min(radius * abs(turn), 12)).straight(30)
        paths.append(plan_path(builder.build(lanes=((1, -3.5, 3.5),)), 1.0))
    s = np.linspace(0, paths[0].curve.length, 300)
    one, other = (path.curve.position(s) for path in paths)
    assert paths[0].report.cost == pytest.approx(paths[1].report.cost, rel=1e-5)
    assert np.max(np.abs(one - other * [1, -1])) < 0.02


def test_too_narrow_road_names_the_station_and_the_widths():
    s = np.arange(0.0, 101.0, 1.0)
    left = np.where((s > 60) & (s < 70), 0.6, 2.0)
    road = Road.from_points("alley", np.column_stack([s, 0 * s]), -1.0, left)
    with pytest.raises(InfeasibleError, match=r"alley: .*narrower than the car .* at s = 6[0-9]\.\d m: .* needs 2\.10 m"):
        plan_path(road, 1.05)


def test_lane_centre_outside_the_corridor_is_refused():
    s = np.arange(0.0, 101.0, 1.0)
    road = Road.from_points("offset", np.column_stack([s, 0 * s]), -3.0, 3.0, lane_edges=((1, -3.0, -2.0), (-1, -2.0, 3.0)))
    with pytest.raises(InfeasibleError, match="lane's centre leaves the corridor by 0.500 m"):
        plan_path(road, 1.0, extent="road", kind="lane")


def test_knots_by_need_give_more_for_fewer():
    # as many equal knots cost 0.2 to 3 % more; 626 of them, 4 m apart, are as good as 240 by need
    for name in ("commute", "rural", "descent"):
        road = roads.open_road(name)
        need = plan_path(road, 1.05, extent="road").report
        equal = plan_path(road, 1.05, extent="road", options=PathOptions(knots=road.length / need.knots)).report
        fine = plan_path(road, 1.05, extent="road", options=PathOptions(knots=1.5)).report
        assert need.cost < 1.0015 * fine.cost
        assert equal.cost > need.cost


def test_path_passes_a_parked_truck_with_its_clearance():
    road = RoadBuilder("street").straight(200).build()
    truck = Narrowing(95.0, 107.0, right=-0.5)
    path = plan_path(road, 1.0, extent="road", narrowings=[truck])
    assert path.report.certified
    s = np.linspace(90.0, 112.0, 2000)
    points = path.curve.position(s)
    corner = np.array([road.reference.position(at) - 0.5 * road.reference.normal(at) for at in (95.0, 107.0)])
    beside = points[(points[:, 0] > corner[0, 0]) & (points[:, 0] < corner[1, 0])]
    assert np.min(beside[:, 1]) >= corner[0, 1] + 1.0 - 1e-9
    assert np.min(np.hypot(*(points - corner[0]).T)) >= 1.0 - 1e-3  # the step of the border is a millimetre long
    assert path.report.cost > plan_path(road, 1.0, extent="road").report.cost


def test_truck_that_leaves_no_room_is_named():
    road = RoadBuilder("street").straight(200).build()
    with pytest.raises(InfeasibleError, match=r"street: the corridor is narrower than the car .* at s = 9[45]\.\d m: 1\.50 m wide, needs 2\.00 m"):
        plan_path(road, 1.0, extent="road", narrowings=[Narrowing(95.0, 107.0, right=2.0)])


@pytest.mark.parametrize("bound", [0.041, 0.038])
def test_bound_on_curvature_holds_every_decimetre(bound: float):
    road = RoadBuilder("bend").straight(40).bend(15, 1.6, 10).straight(40).build()
    free = plan_path(road, 1.0, extent="road")
    path = plan_path(road, 1.0, extent="road", options=PathOptions(curvature_max=bound))
    assert path.report.certified
    s = np.arange(0.0, path.curve.length, 0.1)
    assert np.max(np.abs(path.curve.curvature(s))) <= bound
    assert free.report.max_curvature > 0.042
    assert path.report.cost >= free.report.cost * (1 - 1e-6)


def test_bound_on_curvature_that_the_road_does_not_allow_is_refused():
    road = RoadBuilder("bend").straight(40).bend(8, 1.6, 6).straight(40).build()
    with pytest.raises(
        InfeasibleError, match=r"bend: no path was found .* the curvature below 0\.04 1/m, radius 25\.00 m; it breaks it near s = \d+"
    ):
        plan_path(road, 1.0, extent="lane", options=PathOptions(curvature_max=0.04))


def test_weight_of_length_shortens_and_weight_of_offset_centres():
    from energy_mgr import Weights

    road = RoadBuilder("s").straight(40).bend(30, 1.2, 12).straight(30).bend(30, -1.2, 12).straight(40).build()
    paths = {
        name: plan_path(road, 1.0, extent="road", options=PathOptions(weights=weights))
        for name, weights in {
            "none": Weights(),
            "length": Weights(length=0.01),
            "offset": Weights(offset=0.01),
            "rate": Weights(curvature_rate=2000.0),
        }.items()
    }
    assert all(path.report.certified for path in paths.values())
    assert paths["length"].curve.length < paths["none"].curve.length - 0.2
    lane = road.lane_centre()

    def off_centre(path: Path) -> float:
        s = np.linspace(0, path.curve.length, 200)
        return float(np.mean(lane.project(path.curve.position(s), s)[1] ** 2))

    def jerk(path: Path) -> float:
        s = np.linspace(0, path.curve.length, 2000)
        return float(np.mean(path.curve.curvature_rate(s) ** 2))

    assert off_centre(paths["offset"]) < 0.3 * off_centre(paths["none"])
    assert jerk(paths["rate"]) < 0.95 * jerk(paths["none"])
    assert all(paths["none"].report.cost < path.report.cost for name, path in paths.items() if name != "none")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"knots": 0.0}, "knots 0.0, expected 'need' or a distance"),
        ({"knots": float("nan")}, "knots nan"),
        ({"control_points": -1}, "-1 control points"),
        ({"curvature_max": 0.0}, "bound on curvature 0.0"),
        ({"curvature_max": float("nan")}, "bound on curvature nan"),
        ({"tolerance": 0.0}, "tolerance 0.0"),
        ({"knots": "many"}, "knots 'many'"),
        ({"control_points": 2.5}, "2.5 control points"),
        ({"method": "newton"}, "method 'newton', expected one of gauss-newton"),
        ({"qp": "nosuch"}, "QP solver 'nosuch' is not installed"),
    ],
)
def test_options_out_of_range_are_refused(options, message):
    with pytest.raises(PlanningError, match=message):
        PathOptions(**options)


def test_clearance_that_is_no_number_is_refused():
    with pytest.raises(PlanningError, match="clearance nan m"):
        plan_path(RoadBuilder("straight").straight(100).build(), float("nan"))


@pytest.mark.parametrize("weights", [{"length": -1.0}, {"offset": float("nan")}, {"curvature_rate": float("inf")}])
def test_weights_out_of_range_are_refused(weights):
    from energy_mgr import Weights

    with pytest.raises(PlanningError, match="expected numbers from 0 on"):
        Weights(**weights)


def test_methods_that_stop_above_the_optimum_do_not_call_it_solved():
    road = RoadBuilder("bend").straight(40).bend(30, 1.2, 12).straight(40).build()
    for method in ("linearised", "gradient"):
        report = plan_path(road, 1.0, options=PathOptions(method=method)).report  # pyright: ignore[reportArgumentType]
        assert (report.status, report.certified) == ("approximate", True)


def test_end_that_bends_more_than_the_bound_is_refused():
    from energy_mgr import End

    road = RoadBuilder("bend").straight(40).bend(30, 1.2, 12).straight(40).build()
    options = PathOptions(curvature_max=0.05, ends=(End(offset=0.0, heading=0.0, curvature=0.1), None))
    with pytest.raises(PlanningError, match=r"bend: curvature 0\.1 1/m at an end, expected at most 0\.05 1/m"):
        plan_path(road, 1.0, options=options)
