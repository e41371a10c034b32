"""The path: Gauss-Newton SQP against IPOPT with exact derivatives on the same problem, from the same start."""

import pytest

import roads
from energy_mgr.path import CurvatureProblem, gauss_newton, ipopt

ROADS = ("commute", "rural", "descent")


def problem_on(name):
    road = roads.open_road(name)
    return CurvatureProblem.on(road.corridor("road", 1.05), road.lane_centre(), spacing=4.0, control_points=3)


@pytest.mark.parametrize("name", ROADS)
@pytest.mark.parametrize(("qp", "building"), [("piqp", False), ("piqp", True), ("clarabel", False)])
def bench_gauss_newton(benchmark, name, qp, building):
    benchmark.group = f"path, {name}, 4 m knots"
    made = problem_on(name)
    start = made.initial()
    gauss_newton.solve(made, start, iterations=1)  # fills in what the problem computes once

    def run():
        if not building:
            return gauss_newton.solve(made, start, qp=qp)
        problem = problem_on(name)
        return gauss_newton.solve(problem, problem.initial(), qp=qp)

    found = benchmark.pedantic(run, rounds=7, warmup_rounds=1)
    label = f"Gauss-Newton, {qp}, {'with reading the road and building' if building else 'without building'}"
    benchmark.extra_info.update(method=label, ours=qp == "piqp" and not building, found=f"{found.cost:.8f} 1/m")


@pytest.mark.parametrize("name", ROADS)
@pytest.mark.parametrize("building", [False, True])
def bench_ipopt(benchmark, name, building):
    benchmark.group = f"path, {name}, 4 m knots"
    problem = problem_on(name)
    start = problem.initial()
    solver = None if building else ipopt.build(problem)
    found = benchmark.pedantic(ipopt.solve, args=(problem, start, solver), rounds=5, warmup_rounds=1)
    benchmark.extra_info.update(method=f"IPOPT, exact Hessian, {'with' if building else 'without'} building", found=f"{found.cost:.8f} 1/m")
