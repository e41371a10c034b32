"""Turning, shifting, mirroring or reversing a road does the same to its path. Asked for is 1e-6; rounding leaves some 1e-9 m."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from energy_mgr import Path, PathOptions, plan_path
from energy_mgr.path import CurvatureProblem
from energy_mgr.path.solvers import solve
from roads import Road, RoadBuilder

AWAY = np.array([1e6, -1e6])
SHARES = np.linspace(0.0, 1.0, 400)
TURN = np.array([[np.cos(1.0), -np.sin(1.0)], [np.sin(1.0), np.cos(1.0)]])


def drawn(seed: int) -> Road:
    rng = np.random.default_rng(seed)
    builder = RoadBuilder("drawn").straight(40)
    for _ in range(4):
        angle, radius = rng.uniform(0.3, 1.6) * rng.choice([-1, 1]), rng.uniform(12, 60)
        builder.bend(radius, angle, min(0.8 * radius * abs(angle), 12)).straight(rng.uniform(5, 40))
    road = builder.build()
    wide = rng.uniform(2.5, 4.5, 2)
    return Road.from_points("drawn", road.reference.position(road.s), -wide[0], wide[1])


def places(path: Path, shares: np.ndarray = SHARES) -> np.ndarray:
    return path.curve.position(shares * path.curve.length)


CASES: dict[str, tuple[Callable[[Road], Road], Callable[[Path], np.ndarray]]] = {
    "mirrored": (lambda r: Road.from_points("m", r.reference.position(r.s) * [1, -1], -r.left, -r.right), lambda p: places(p) * [1, -1]),
    "reversed": (
        lambda r: Road.from_points("r", r.reference.position(r.s)[::-1], -r.left[::-1], -r.right[::-1]),
        lambda p: places(p, 1.0 - SHARES),
    ),
    "rotated": (lambda r: Road.from_points("t", r.reference.position(r.s) @ TURN.T, r.right, r.left), lambda p: places(p) @ TURN),
    "shifted": (
        lambda r: Road.from_points("s", r.reference.position(r.s) + AWAY, r.right, r.left),
        lambda p: places(p) - AWAY,
    ),
}


@pytest.mark.parametrize("case", CASES)
@settings(deadline=None, max_examples=6, derandomize=True)
@given(seed=st.integers(0, 10_000))
def test_path_moves_with_its_road(case: str, seed: int):
    road = drawn(seed)
    moved, back = CASES[case]
    path, other = plan_path(road, 1.0, extent="road"), plan_path(moved(road), 1.0, extent="road")
    assert other.report.cost == pytest.approx(path.report.cost, rel=1e-6)
    assert np.max(np.abs(back(other) - places(path))) < 1e-6


@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_units_of_the_spline_parameter_change_nothing(unit: float):
    road = drawn(3)
    corridor, lane = road.corridor("road", 1.0), road.lane_centre()
    curves = []
    for one in (1.0, unit):
        problem = CurvatureProblem.on(corridor, lane, unit=one)
        curves.append(problem.curve(solve(problem, problem.initial()).x))
    s = np.linspace(0.0, curves[0].length, 400)
    assert np.max(np.abs(curves[0].position(s) - curves[1].position(s))) < 1e-6


def test_circuit_that_starts_elsewhere_has_the_same_path():
    angle = np.linspace(0.0, 2 * np.pi, 240, endpoint=False)
    radius = 60.0 + 12.0 * np.cos(2 * angle) + 6.0 * np.sin(3 * angle)
    points = radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    options = PathOptions(tolerance=1e-10)
    costs = [
        plan_path(Road.from_points("ring", np.roll(points, shift, axis=0), -4.0, 4.0, closed=True), 1.0, options=options).report.cost
        for shift in (0, 57, 131)
    ]
    # the knots move with the start, hence not the same spline
    assert np.ptp(costs) < 2e-4 * costs[0]
