import numpy as np
import pytest

import roads
from energy_mgr import InfeasibleError, PlanningError
from energy_mgr.path import CurvatureProblem
from energy_mgr.path.solvers import METHODS, solve
from energy_mgr.path.solvers.backends import Qp, qp_solver
from energy_mgr.path.solvers.baselines import all_coefficients, lateral_fractions
from energy_mgr.path.solvers.feasible import nearest_feasible
from roads import Road, RoadBuilder


@pytest.fixture(scope="module")
def road() -> Road:
    return RoadBuilder("s").straight(30).bend(20, 1.2, 10).straight(15).bend(25, -1.0, 10).straight(30).build()


def problem_on(road: Road, **options) -> CurvatureProblem:
    return CurvatureProblem.on(road.corridor("road", 1.0), road.lane_centre(), **{"spacing": 6.0, **options})


@pytest.fixture(scope="module")
def optimum(road: Road) -> float:
    problem = problem_on(road)
    return solve(problem, problem.initial(), "ipopt", tolerance=1e-10).cost


#: How far above IPOPT's optimum each may end: Gauss-Newton and the dense solvers by their tolerances, the gradient as the source's (1.31 %), the
#: linearised curvature by what it leaves out.
ABOVE = {"gauss-newton": 1e-6, "ipopt": 1e-8, "slsqp": 1e-5, "trust-constr": 2e-3, "gradient": 1.3e-2, "linearised": 0.5}


@pytest.mark.parametrize("method", METHODS)
def test_every_method_keeps_the_constraints_and_comes_near_the_optimum(road: Road, optimum: float, method: str):
    problem = problem_on(road)
    found = solve(problem, problem.initial(), method, tolerance=1e-9)  # pyright: ignore[reportArgumentType]
    assert problem.worst_row(found.x)[0] < 2e-6
    matrix, rhs = problem.equalities
    assert np.max(np.abs(matrix @ found.x - rhs)) < 1e-6
    assert found.cost == pytest.approx(problem.cost(found.x))
    assert optimum * (1 - 1e-6) <= found.cost <= optimum * (1 + ABOVE[method])


@pytest.mark.parametrize("method", ["gauss-newton", "ipopt", "slsqp", "trust-constr"])
def test_bound_on_curvature_is_kept_where_it_binds(road: Road, method: str):
    free = problem_on(road)
    most = float(np.max(np.abs(free.curve(solve(free, free.initial()).x).curvature(np.linspace(0, 100, 1000)))))
    problem = problem_on(road, curvature_max=0.9 * most)
    problem = problem.with_bends(np.linspace(0.0, road.length, 200))
    found = solve(problem, problem.initial(), method, tolerance=1e-8)  # pyright: ignore[reportArgumentType]
    assert np.max(np.abs(problem.curvatures(found.x)[0])) <= 1.0 + 1e-4
    reference = solve(problem, problem.initial(), "ipopt")
    assert found.cost == pytest.approx(reference.cost, rel=2e-3 if method == "trust-constr" else 1e-4)
    assert found.cost > solve(free, free.initial()).cost


def test_curvature_that_cannot_be_kept_names_the_station(road: Road):
    problem = problem_on(road, curvature_max=0.02).with_bends(np.linspace(0.0, road.length, 200))
    with pytest.raises(
        InfeasibleError, match=r"s: no path was found .* the curvature below 0\.02 1/m, radius 50\.00 m; it breaks it near s = \d+\.\d m"
    ):
        solve(problem, problem.initial())


@pytest.mark.parametrize("method", ["linearised", "gradient"])
def test_methods_that_keep_no_bound_on_curvature_refuse_one(road: Road, method: str):
    problem = problem_on(road, curvature_max=0.05)
    with pytest.raises(PlanningError, match="no bound on curvature, use gauss-newton"):
        solve(problem, problem.initial(), method)  # pyright: ignore[reportArgumentType]


def test_unknown_names_are_refused(road: Road):
    problem = problem_on(road)
    with pytest.raises(PlanningError, match="method 'newton', expected one of gauss-newton"):
        solve(problem, problem.initial(), "newton")  # pyright: ignore[reportArgumentType]
    with pytest.raises(PlanningError, match="QP solver 'gurobi2' is not installed, expected one of"):
        solve(problem, problem.initial(), qp="gurobi2")


def program_at(problem: CurvatureProblem, x: np.ndarray) -> Qp:
    """The QP of a Gauss-Newton step."""
    model = problem.model(x)
    matrix, rhs = problem.equalities
    rows = problem.rows
    scale = 1e4 / model.cost
    return Qp(model.hessian * scale, (model.gradient - model.hessian @ x) * scale, matrix, rhs, rows.matrix, rows.lower, rows.upper, *problem.bounds)


@pytest.mark.parametrize("backend", ["piqp", "clarabel", "osqp"])
def test_qp_back_ends_agree_and_their_multipliers_close_the_kkt_system(road: Road, backend: str):
    problem = problem_on(road)
    program = program_at(problem, problem.initial())
    reference = qp_solver("clarabel").solve(program, 1e-10)
    found = qp_solver(backend).solve(program, 1e-9)
    assert found is not None
    assert reference is not None
    assert program.residual(found) < 1e-5

    def value(x) -> float:
        return float(0.5 * x @ (program.P @ x) + program.c @ x)

    assert value(found.x) == pytest.approx(value(reference.x), rel=1e-6)


def test_kkt_residual_shows_a_point_that_is_not_the_minimiser(road: Road):
    problem = problem_on(road)
    program = program_at(problem, problem.initial())
    found = qp_solver("piqp").solve(program, 1e-9)
    assert found is not None
    assert program.residual(found._replace(x=found.x + 0.01)) > 1e-3
    assert program.residual(found._replace(rows=found.rows + 100.0)) > 1e-3


def test_nearest_feasible_point_keeps_all_constraints():
    road = roads.open_road("descent")[1000:1600]
    problem = CurvatureProblem.on(road.corridor("road", 1.05), road.lane_centre(), spacing=25.0)
    start = problem.initial()
    assert problem.worst_row(start)[0] > 0.05
    x = nearest_feasible(problem, start)
    assert problem.worst_row(x)[0] < 1e-7


def test_lateral_fractions_equal_the_linearised_problem_without_control_points(road: Road):
    problem = problem_on(road, control_points=0)
    ours, reduced = lateral_fractions(problem), solve(problem, problem.initial(), "linearised")
    assert ours.kkt_residual < 1e-6
    assert ours.cost == pytest.approx(reduced.cost, rel=1e-4)


def test_lateral_fractions_leave_the_road_between_knots():
    # the reported deficiency of P0b: nothing is kept between two knots
    road = roads.open_road("descent")[0:2000]
    problem = CurvatureProblem.on(road.corridor("road", 1.05), road.lane_centre(), spacing=road.length / 87)
    x = lateral_fractions(problem).x
    assert problem.worst_row(x)[0] > 0.3
    assert np.all(problem.fractions(x) > -1e-6)


def test_all_coefficients_work_on_a_straight_road_and_refuse_a_bend(road: Road):
    straight = RoadBuilder("straight", heading=0.6).straight(160).build()
    problem = problem_on(straight, spacing=20.0)
    curve = all_coefficients(problem)
    assert curve.squared_curvature() < 1e-12
    assert np.allclose(curve.position([0.0, 160.0]), straight.lane_centre().position([0.0, 160.0]), atol=1e-6)
    with pytest.raises(InfeasibleError, match=r"s: the borders' coefficients change their order in \d+ of \d+ segments, first at s = "):
        all_coefficients(problem_on(road))


def test_corridor_that_contradicts_itself_names_the_station():
    road = RoadBuilder("gate").straight(200).build()
    problem = CurvatureProblem.on(road.corridor("road", 1.0), road.lane_centre(), spacing=4.0, control_points=3)
    lower, upper = problem.row_borders
    at = int(np.argmin(np.abs(problem.row_q - 101.0)))
    closed_gate = problem.with_rows(problem.row_q[at : at + 1], np.zeros(1))
    vars(closed_gate)["row_borders"] = tuple(np.insert(border, at, value) for border, value in ((lower, 0.5), (upper, 0.0)))
    with pytest.raises(InfeasibleError, match=r"gate: no smooth path .* near s = 101\.0 m.* give way by 0\.\d\d m"):
        solve(closed_gate, closed_gate.initial())
