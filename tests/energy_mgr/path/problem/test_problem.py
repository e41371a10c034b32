from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

import roads
from energy_mgr import End, PlanningError, Weights
from energy_mgr.path import CurvatureProblem
from energy_mgr.path.driving.window import Tables
from energy_mgr.path.solvers import ipopt
from roads import Road, RoadBuilder

MIX = Weights(length=1e-3, offset=1e-4, curvature_rate=30.0)


def problem_on(road: Road, *, spacing: float = 6.0, margin: float = 1.0, extent: str = "road", **options) -> CurvatureProblem:
    return CurvatureProblem.on(road.corridor(extent, margin), road.lane_centre(), spacing=spacing, **options)  # pyright: ignore[reportArgumentType]


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
@pytest.mark.parametrize("weights", [Weights(), MIX], ids=["curvature", "mix"])
@pytest.mark.parametrize("unit", [1.0, 0.05])
def test_gradient_is_that_of_central_differences(bend: Road, ring: Road, rng: np.random.Generator, closed: bool, weights: Weights, unit: float):
    problem = problem_on(ring if closed else bend, weights=weights, unit=unit)
    x = problem.initial() + 0.02 * rng.normal(size=3 * len(problem.q))
    model = problem.model(x)
    assert model.cost == pytest.approx(problem.cost(x), rel=1e-14)
    for column in rng.choice(len(x), 25, replace=False):
        step = np.zeros_like(x)
        step[column] = 1e-5
        numeric = (problem.cost(x + step) - problem.cost(x - step)) / 2e-5
        assert model.gradient[column] == pytest.approx(numeric, abs=1e-7 * np.max(np.abs(model.gradient)))


@pytest.mark.parametrize("closed", [False, True])
def test_cost_is_that_of_symbols_written_from_the_source(bend: Road, ring: Road, rng: np.random.Generator, closed: bool):
    # two implementations of the mix: arrays over basis functions here, symbols over (3.1) to (3.11) there
    problem = problem_on(ring if closed else bend, weights=MIX)
    x = problem.initial() + 0.02 * rng.normal(size=problem.spline.size)
    symbols = ca.SX.sym("x", len(x))
    cost = ca.Function("cost", [symbols], [ipopt._cost(problem, symbols)])
    assert float(cost(x)) == pytest.approx(problem.cost(x), rel=1e-12)


def test_gauss_newton_hessian_is_twice_the_squared_jacobian(bend: Road, rng: np.random.Generator):
    problem = problem_on(bend)
    x = problem.initial()
    hessian = problem.model(x).hessian
    direction = rng.normal(size=len(x))
    residuals = problem.objective.residuals
    moved = (residuals(x + 1e-6 * direction) - residuals(x - 1e-6 * direction)) / 2e-6
    assert direction @ (hessian @ direction) == pytest.approx(2.0 * np.sum(moved**2), rel=1e-6)


def test_cost_is_the_squared_curvature_of_the_curve(bend: Road):
    problem = problem_on(bend, spacing=2.0)
    x = problem.initial()
    assert problem.cost(x) == pytest.approx(problem.curve(x).squared_curvature(), rel=1e-4)


def test_mix_of_a_circle_has_its_closed_form():
    angle = np.linspace(0, 2 * np.pi, 300, endpoint=False)
    circle = Road.from_points("circle", 40 * np.column_stack([np.cos(angle), np.sin(angle)]), -3.0, 3.0, closed=True)
    problem = problem_on(circle, spacing=4.0, weights=Weights(length=1e-2, offset=1e-3))
    around = 2 * np.pi * 40
    # the lane's centre is the circle itself; 1 m inside it the offset costs 1e-3 per metre of road
    assert problem.cost(problem.initial()) == pytest.approx(2 * np.pi / 40 + 1e-2 * around, rel=1e-5)
    inside = replace(problem, start=np.full(len(problem.q), 1.0))
    assert inside.cost(inside.initial()) == pytest.approx(2 * np.pi / 39 + 1e-2 * 2 * np.pi * 39 + 1e-3 * around, rel=1e-4)


def test_curvature_rate_of_a_clothoid_has_its_closed_form():
    road = RoadBuilder("clothoid").clothoid(100, 0.0, 0.02).build()
    problem = problem_on(road, spacing=2.0, extent="lane", weights=Weights(curvature_rate=1e3))
    plain = problem_on(road, spacing=2.0, extent="lane")
    on_reference = [replace(p, start=0.0 * p.start) for p in (problem, plain)]
    rate = on_reference[0].cost(on_reference[0].initial()) - on_reference[1].cost(on_reference[1].initial())
    # int (kappa')^2 ds = (0.02 / 100)^2 * 100; the ends are along the road, whose clothoid is a sampled one
    assert rate == pytest.approx(1e3 * (0.02 / 100) ** 2 * 100, rel=2e-2)


def test_initial_point_keeps_the_equalities_and_follows_the_lane(bend: Road):
    problem = problem_on(bend, spacing=2.0)
    x = problem.initial()
    matrix, rhs = problem.equalities
    assert np.max(np.abs(matrix @ x - rhs)) < 1e-9
    curve = problem.curve(x)
    s = np.linspace(1, curve.length - 1, 100)
    _, offset = bend.lane_centre().project(curve.position(s), s)
    assert np.max(np.abs(offset)) < 0.01


def test_curve_is_smooth_to_the_second_derivative_where_the_equalities_hold(bend: Road, rng: np.random.Generator):
    problem = problem_on(bend)
    x = replace(problem, start=problem.start + 0.3 * rng.normal(size=len(problem.q))).initial()
    breaks = problem.q[1:-1]
    before, after = problem.curve(x).pieces(breaks - 1e-9, 2), problem.curve(x).pieces(breaks + 1e-9, 2)
    for left, right in zip(before, after, strict=True):
        assert np.allclose(left, right, atol=1e-6)


def test_sizes_are_those_of_the_publication(figure):
    # 88 knots and 3 control points: A 176 x 264 and 698 inequalities, control points and both bounds on every fraction counted
    road = roads.open_road("descent")
    problem = problem_on(road, spacing=road.length / 87, control_points=3)
    assert len(problem.q) == 88
    matrix, _ = problem.equalities
    inequalities = 2 * problem.rows.matrix.shape[0] + 2 * 88
    figure("P1 sizes", (*matrix.shape, inequalities), "A {} x {}, {} inequalities", published="A 176 x 264, 698 inequalities")
    # the publication's four end conditions, and the places of both ends, which are fixed by two rows more
    assert matrix.shape == (176 + 2, 264)
    assert np.linalg.matrix_rank(matrix.toarray()) == 178
    assert inequalities == 2 * 3 * 87 + 2 * 88 == 698


def test_ends_of_an_open_road_lie_on_the_lane_along_the_road(bend: Road):
    problem = problem_on(bend, spacing=3.0)
    curve, lane = problem.curve(problem.initial()), bend.lane_centre()
    for s, lane_s in ((0.0, 0.0), (curve.length, lane.length)):
        assert np.allclose(curve.position(s), lane.position(lane_s), atol=1e-6)
        assert np.allclose(curve.tangent(s), lane.tangent(lane_s), atol=1e-4)


@pytest.mark.parametrize("speed", [None, 1.1])
def test_prescribed_ends_are_met(bend: Road, speed: float | None):
    from energy_mgr.path.solvers import solve

    first, last = End(0.7, 0.05, 0.01, speed), End(None, -0.02)
    problem = problem_on(bend, spacing=4.0, ends=(first, last))
    curve = problem.curve(solve(problem, problem.initial()).x)
    assert np.allclose(curve.position(0.0), bend.reference.position(0.0) + 0.7 * bend.reference.normal(0.0), atol=1e-7)
    assert float(curve.heading(0.0) - bend.reference.heading(0.0)) == pytest.approx(0.05, abs=1e-7)
    assert float(curve.curvature(0.0)) == pytest.approx(0.01, abs=1e-7)
    assert float(curve.heading(curve.length) - bend.reference.heading(bend.length)) == pytest.approx(-0.02, abs=1e-7)


def test_ends_that_say_too_little_are_refused():
    with pytest.raises(PlanningError, match="curvature .* needs a prescribed offset and heading"):
        End(curvature=0.01)
    with pytest.raises(PlanningError, match="finite"):
        End(offset=np.nan)
    with pytest.raises(PlanningError, match=r"less than 1\.2 rad"):
        End(heading=1.5)


def test_control_point_rows_measure_the_offset(bend: Road):
    problem = problem_on(bend, spacing=3.0)
    x = problem.initial()
    rows = problem.rows
    right, left = problem.corridor.offsets(problem.row_q)
    value = rows.matrix @ x
    _, offset = bend.reference.project(problem.curve(x).pieces(problem.row_q)[0], problem.row_q)
    # the row measures along the normal at the parameter; the path slips a little along the road against it
    assert np.max(np.abs((value - rows.lower) - (offset - right))) < 2e-3
    assert np.max(np.abs((rows.upper - value) - (left - offset))) < 2e-3


def test_curvature_rows_are_the_derivatives_of_curvature(bend: Road, rng: np.random.Generator):
    problem = problem_on(bend, curvature_max=0.06)
    x = problem.initial() + 0.01 * rng.normal(size=problem.spline.size)
    assert len(problem.bend_q) > 4
    value, jacobian = problem.curvatures(x)
    assert np.allclose(value * 0.06 * 0.998, problem.curve(x).curvature(problem.curve(x).station(problem.bend_q)), atol=1e-9)
    direction = rng.normal(size=len(x))
    moved = (problem.curvatures(x + 1e-6 * direction)[0] - problem.curvatures(x - 1e-6 * direction)[0]) / 2e-6
    assert np.allclose(problem.bend_rows(jacobian) @ direction, moved, rtol=1e-5, atol=1e-6 * np.max(np.abs(moved)))


@pytest.mark.parametrize("closed", [False, True])
def test_window_is_the_problem_that_is_built_on_its_knots(bend: Road, ring: Road, rng: np.random.Generator, closed: bool):
    road = ring if closed else bend
    whole = problem_on(road, spacing=5.0, weights=MIX)
    first, last = (len(whole.q) - 6, len(whole.q) + 8) if closed else (4, 18)
    tables = Tables(whole)
    ends = End(0.1, 0.0, 0.01), End(heading=0.0)
    window = tables.window(first, last, ends)
    knots = tables.station(np.arange(first, last + 1))
    built = CurvatureProblem.on(whole.corridor, road.lane_centre(), knots=knots, weights=MIX, ends=ends, window=True)
    x = 0.1 * rng.normal(size=window.spline.size)
    # the scale of the second derivatives at the window's ends comes from one segment there and from two in the whole
    ours = built.spline.b_scale / window.spline.b_scale
    other = (x.reshape(-1, 3) * np.column_stack([ours, ours, np.ones_like(ours)])).ravel()
    assert window.cost(x) == pytest.approx(built.cost(other), rel=1e-9)
    assert np.allclose(window.rows.matrix @ x - window.rows.lower, built.rows.matrix @ other - built.rows.lower, atol=1e-9)
    assert np.allclose(window.equalities[0] @ x - window.equalities[1], built.equalities[0] @ other - built.equalities[1], atol=1e-8)
    assert np.allclose(window.borders, built.borders)
