import numpy as np
import pytest

import roads
from energy_mgr.path import CurvatureProblem
from roads import Road, RoadBuilder


def problem_on(road: Road, *, spacing: float = 6.0, margin: float = 1.0, extent: str = "road", control_points: int = 3) -> CurvatureProblem:
    return CurvatureProblem.on(road.corridor(extent, margin), road.lane_centre(), spacing=spacing, control_points=control_points)  # pyright: ignore[reportArgumentType]


@pytest.fixture(scope="module")
def bend() -> Road:
    return RoadBuilder("bend").straight(40).bend(20, 1.5, 10).straight(20).bend(25, -1.0, 10).straight(40).build()


@pytest.fixture(scope="module")
def ring() -> Road:
    oval = RoadBuilder("oval")
    for _ in range(2):
        oval.straight(60).bend(25, np.pi, 15)
    return oval.build(closed=True)


@pytest.mark.parametrize("closed", [False, True])
def test_gradient_is_that_of_central_differences(bend: Road, ring: Road, rng: np.random.Generator, closed: bool):
    problem = problem_on(ring if closed else bend)
    x = problem.initial() + 0.02 * rng.normal(size=3 * len(problem.q))
    cost, gradient, _ = problem.gauss_newton(x)
    assert cost == pytest.approx(problem.cost(x), rel=1e-14)
    for column in rng.choice(len(x), 25, replace=False):
        step = np.zeros_like(x)
        step[column] = 1e-5
        numeric = (problem.cost(x + step) - problem.cost(x - step)) / 2e-5
        assert gradient[column] == pytest.approx(numeric, abs=1e-7 * np.max(np.abs(gradient)))


def test_gauss_newton_hessian_is_twice_the_squared_jacobian(bend: Road, rng: np.random.Generator):
    problem = problem_on(bend)
    x = problem.initial()
    _, _, hessian = problem.gauss_newton(x)
    direction = rng.normal(size=len(x))
    moved = (problem.residuals(x + 1e-6 * direction) - problem.residuals(x - 1e-6 * direction)) / 2e-6
    assert direction @ (hessian @ direction) == pytest.approx(2.0 * np.sum(moved**2), rel=1e-6)


def test_cost_is_the_squared_curvature_of_the_curve(bend: Road):
    problem = problem_on(bend, spacing=2.0)
    x = problem.initial()
    assert problem.cost(x) == pytest.approx(problem.curve(x).squared_curvature(), rel=1e-4)


def test_circular_lane_has_the_curvature_of_its_circle(ring: Road):
    angle = np.linspace(0, 2 * np.pi, 300, endpoint=False)
    circle = Road.from_points("circle", 40 * np.column_stack([np.cos(angle), np.sin(angle)]), -3.0, 3.0, closed=True)
    problem = problem_on(circle, spacing=4.0)
    assert problem.cost(problem.initial()) == pytest.approx(2 * np.pi / 40, rel=1e-5)


def test_initial_point_keeps_the_equalities_and_follows_the_lane(bend: Road):
    problem = problem_on(bend, spacing=2.0)
    x = problem.initial()
    matrix, rhs = problem.equalities
    assert np.max(np.abs(matrix @ x - rhs)) < 1e-9
    curve = problem.curve(x)
    s = np.linspace(1, curve.length - 1, 100)
    _, offset = bend.lane_centre().project(curve.position(s), s)
    assert np.max(np.abs(offset)) < 0.01


def test_curve_is_smooth_to_the_second_derivative(bend: Road, rng: np.random.Generator):
    problem = problem_on(bend)
    x = problem.initial()
    breaks = problem.breaks[1:-1]
    before, after = problem.curve(x).pieces(breaks - 1e-9, 2), problem.curve(x).pieces(breaks + 1e-9, 2)
    for left, right in zip(before, after, strict=True):
        assert np.allclose(left, right, atol=1e-6)


def test_sizes_are_those_of_the_publication():
    # 88 knots and 3 control points: A 176 x 264 and 698 inequalities, control points and both bounds on every fraction counted
    road = roads.open_road("descent")
    problem = problem_on(road, spacing=road.length / 87, control_points=3)
    assert len(problem.q) == 88
    matrix, _ = problem.equalities
    # the publication's four end conditions, and the fractions at both ends, which are fixed by two rows more
    assert matrix.shape == (176 + 2, 264)
    assert np.linalg.matrix_rank(matrix.toarray()) == 178
    assert 2 * problem.rows[0].shape[0] + 2 * 88 == 2 * 3 * 87 + 2 * 88 == 698


def test_ends_of_an_open_road_lie_on_the_lane_along_the_road(bend: Road):
    problem = problem_on(bend, spacing=3.0)
    curve, lane = problem.curve(problem.initial()), bend.lane_centre()
    for s, lane_s in ((0.0, 0.0), (curve.length, lane.length)):
        assert np.allclose(curve.position(s), lane.position(lane_s), atol=1e-6)
        assert np.allclose(curve.tangent(s), lane.tangent(lane_s), atol=1e-4)


def test_control_point_rows_measure_the_offset(bend: Road, rng: np.random.Generator):
    problem = problem_on(bend, spacing=3.0)
    x = problem.initial()
    matrix, lower, upper = problem.rows
    right, left = problem.corridor.offsets(problem.row_q)
    value = matrix @ x
    _, offset = bend.reference.project(problem.curve(x).pieces(problem.row_q)[0], problem.row_q)
    # the row measures along the normal at the parameter; the path slips a little along the road against it
    assert np.max(np.abs((value - lower) - (offset - right))) < 2e-3
    assert np.max(np.abs((upper - value) - (left - offset))) < 2e-3
