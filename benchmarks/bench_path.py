"""The path: solvers of T 3.1 side by side, building and proving, and steps of the receding horizon."""

import time

import numpy as np
import pytest

import roads
from energy_mgr.path import CurvatureProblem, PathPlanner, Prover, plan_path
from energy_mgr.path.solvers import ipopt, solve
from powertrain import load_vehicle

ROADS = ("commute", "rural", "descent")

#: Method, tolerance, what T 3.1 of the source printed for it (seconds, iterations, per cent above its best), rounds.
T31 = {
    "gauss-newton": (1e-6, "-", 15),
    "linearised": (1e-9, "QP 0.09 s, 1, 38.7 %", 9),
    "gradient": (1e-7, "NG 2.67 s, 73, 1.31 %", 5),
    "trust-constr": (1e-6, "fmincon 7.13 s, 201, 2.07 %", 3),
    "slsqp": (1e-10, "SQP 38.6 s, 481, reference", 1),
    "ipopt": (1e-9, "-", 3),
}


def problem_on(name):
    road = roads.open_road(name)
    return CurvatureProblem.on(road.corridor("road", 1.05), road.lane_centre(), spacing=4.0, control_points=3)


@pytest.fixture(scope="module")
def published():
    road = roads.open_road("descent")[0:2000]
    return CurvatureProblem.on(road.corridor("road", 1.05), road.lane_centre(), spacing=road.length / 87)


@pytest.fixture(scope="module")
def best(published):
    return solve(published, published.initial(), "ipopt").cost


@pytest.mark.parametrize("method", T31)
def bench_solvers(benchmark, published, best, method):
    benchmark.group = "T 3.1: descent, 2 km, 88 knots, k = 3"
    tolerance, printed, rounds = T31[method]
    start = published.initial()
    found = benchmark.pedantic(solve, args=(published, start, method), kwargs={"tolerance": tolerance}, rounds=rounds, warmup_rounds=int(rounds > 1))
    above = 100 * (found.cost / best - 1)
    benchmark.extra_info.update(
        method=method, ours=method == "gauss-newton", found=f"{found.iterations} iterations, {above:+.4f} % (published: {printed})"
    )


@pytest.mark.parametrize("name", ROADS)
@pytest.mark.parametrize("qp", ["piqp", "clarabel", "osqp"])
def bench_gauss_newton(benchmark, name, qp):
    benchmark.group = f"path, {name}, 4 m knots"
    made = problem_on(name)
    start = made.initial()
    solve(made, start, qp=qp)  # fills in what the problem computes once
    found = benchmark.pedantic(solve, args=(made, start), kwargs={"qp": qp}, rounds=7 if qp != "osqp" else 1, warmup_rounds=0)
    benchmark.extra_info.update(method=f"Gauss-Newton, {qp}", ours=qp == "piqp", found=f"{found.cost:.8f} 1/m")


@pytest.mark.parametrize("name", ROADS)
def bench_ipopt(benchmark, name):
    benchmark.group = f"path, {name}, 4 m knots"
    problem = problem_on(name)
    start = problem.initial()
    solver = ipopt.build(problem)
    found = benchmark.pedantic(ipopt.solve, args=(problem, start, solver), rounds=5, warmup_rounds=1)
    benchmark.extra_info.update(method="IPOPT, exact Hessian, without building", found=f"{found.cost:.8f} 1/m")


@pytest.mark.parametrize("name", ROADS)
def bench_whole_plan(benchmark, name):
    benchmark.group = f"path, {name}, from road to proven path"
    road = roads.open_road(name)
    path = benchmark.pedantic(plan_path, args=(road, 1.05), kwargs={"extent": "road"}, rounds=7, warmup_rounds=1)
    benchmark.extra_info.update(method=f"{path.report.knots} knots by need", ours=True, found=f"{path.report.cost:.8f} 1/m, certified")


def bench_proof(benchmark):
    benchmark.group = "proof of a path, commute, 2.5 km"
    road = roads.open_road("commute")
    problem = problem_on("commute")
    pieces = problem.spline.pieces(solve(problem, problem.initial()).x)
    prover = Prover(road.corridor("road", 1.05))
    benchmark.pedantic(prover.prove, args=(pieces, 0.2), rounds=15, warmup_rounds=1)
    benchmark.extra_info.update(method="chords with proven sag", ours=True)


def bench_horizon(benchmark):
    """10,000 steps of 200 m on the circuit, a metre apart: the car at 25 m/s and 25 Hz."""
    benchmark.group = "receding horizon, 200 m, handling"
    planner = PathPlanner(roads.open_road("handling"), load_vehicle("romo"), extent="road")
    planner.step(0.0)
    place, solving, every = 0.0, [], []

    def run():
        nonlocal place
        place += 1.0
        started = time.perf_counter()
        step = planner.step(place)
        every.append(step.milliseconds)
        if step.iterations:
            solving.append(1e3 * (time.perf_counter() - started))

    benchmark.pedantic(run, rounds=10_000, warmup_rounds=0)
    text = f"steps that solve: {len(solving)}, median {np.median(solving):.2f} ms; processor time of all: p99.9 {np.percentile(every, 99.9):.1f} ms"
    benchmark.extra_info.update(method="PathPlanner.step", ours=True, found=text)


@pytest.mark.parametrize("kilometres", [10, 100])
def bench_length(benchmark, kilometres):
    from tests.acceptance.test_paths import long_road

    benchmark.group = f"path, {kilometres} km"
    road = long_road(kilometres)
    path = benchmark.pedantic(plan_path, args=(road, 1.05), kwargs={"extent": "road"}, rounds=3, warmup_rounds=0)
    benchmark.extra_info.update(method="plan_path", ours=True, found=f"{path.report.knots} knots, {path.report.status}, certified")
