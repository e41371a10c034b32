import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

import roads
from energy_mgr import InfeasibleError, Path, plan_path
from energy_mgr.path import CurvatureProblem, gauss_newton, ipopt
from roads import Road, RoadBuilder
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
    assert path.report.max_violation_m <= 1e-3
    # the nearest of points 0.02 m apart misses the foot by at most 0.01 m, which in a 12 m bend changes the offset by 0.01^2 / 2 / 12, 4 um
    assert violation_every_decimetre(road, path, extent, 1.05) <= 1e-3


@pytest.mark.parametrize("name", NAMES)
def test_cost_is_that_of_ipopt_with_exact_derivatives(name: str):
    road = roads.open_road(name)
    problem = CurvatureProblem.on(road.corridor("road", 1.05), road.lane_centre(), spacing=4.0, control_points=3)
    start = problem.initial()
    ours, theirs = gauss_newton.solve(problem, start), ipopt.solve(problem, start)
    assert ours.converged
    # asked for: 0.1 %; both stop at about 1e-6
    assert ours.cost <= theirs.cost * (1 + 1e-5)
    assert problem.worst_row(ours.x)[0] < 1e-6


def test_both_qp_solvers_find_the_same_path():
    road = roads.open_road("commute")
    piqp, clarabel = (plan_path(road, 1.05, extent="road", qp=qp) for qp in ("piqp", "clarabel"))  # pyright: ignore[reportArgumentType]
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


def test_corridor_that_contradicts_itself_names_the_station():
    road = RoadBuilder("gate").straight(200).build()
    problem = CurvatureProblem.on(road.corridor("road", 1.0), road.lane_centre(), spacing=4.0, control_points=3)
    closed_gate = problem.with_rows(np.array([101.0]), np.array([3.0]))
    with pytest.raises(InfeasibleError, match=r"gate: no smooth path .* near s = 101\.0 m.* give way by 0\.50 m"):
        gauss_newton.solve(closed_gate, closed_gate.initial())


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
