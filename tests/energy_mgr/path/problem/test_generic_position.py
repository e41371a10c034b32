"""Terms of the path's problem on a bent, uneven, aslant road with uneven knots and all weights, against what the curve itself says."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss

from energy_mgr import End, Weights
from energy_mgr.path import CurvatureProblem
from energy_mgr.path.driving.window import Tables
from energy_mgr.path.problem.offsets import drawn_in
from tests.roads.generic import generic

ALL = Weights(length=4e-4, offset=1e-3, curvature_rate=60.0)
Floats = np.ndarray
both = pytest.mark.parametrize("closed", [False, True])


def cross(a: Floats, b: Floats) -> Floats:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def problem_of(closed: bool, weights: Weights = ALL, **options) -> CurvatureProblem:
    road = generic(closed=closed)
    rng = np.random.default_rng(7)
    q = np.cumsum(rng.uniform(2.5, 9.0, 80))
    q = np.concatenate([[0.0], q[q < road.length - 3.0], [] if closed else [road.length]])
    return CurvatureProblem.on(road.corridor("road", 0.8), road.lane_centre(), knots=q, weights=weights, unit=0.7, **options)


def somewhere(problem: CurvatureProblem, much: float = 0.03) -> Floats:
    """A point that keeps the equalities, off the guess in all variables."""
    rng = np.random.default_rng(8)
    matrix, rhs = (np.asarray(part.todense()) if hasattr(part, "todense") else part for part in problem.equalities)
    aside = replace(problem, start=problem.start + 0.5 * np.sin(problem.q / 23.0 + 1.0))
    x = aside.initial() + much * rng.normal(size=problem.spline.size)
    return x - np.linalg.lstsq(matrix, matrix @ x - rhs, rcond=None)[0]


def residuals(problem: CurvatureProblem, x: Floats) -> dict[str, Floats]:
    """Square roots of the four integrands times those of the Gauss weights, from the curve's derivatives by the station."""
    nodes, shares = leggauss(4)
    breaks = problem.spline.breaks
    half = 0.5 * np.diff(breaks)[:, None]
    q = (breaks[:-1, None] + half * (1.0 + nodes)).ravel()
    root = np.sqrt(half * shares).ravel()
    place, d1, d2, d3 = problem.curve(x).pieces(q, 3)
    speed = np.hypot(*d1.T)
    n, along, third = cross(d1, d2), np.sum(d1 * d2, axis=1), cross(d1, d3)
    reference, weights = problem.corridor.reference, problem.objective.weights
    offset = np.sum((place - reference.position(q)) * reference.normal(q), axis=1)
    return {
        "curvature": root * np.sqrt(speed) * n / speed**3,
        "curvature_rate": root * np.sqrt(weights.curvature_rate * speed) * (third / speed**4 - 3.0 * n * along / speed**6),
        "length": root * np.sqrt(weights.length * speed),
        "offset": root * np.sqrt(weights.offset) * (offset - centre(problem, q)),
    }


def centre(problem: CurvatureProblem, q: Floats) -> Floats:
    """Offset of the lane's centre from the reference: where it crosses the normals, by halving."""
    road = generic(closed=problem.closed)
    curve, place, normal = road.lane_centre(), road.reference.position(q), road.reference.normal(q)
    tangent = np.column_stack([normal[:, 1], -normal[:, 0]])
    near = curve.locate(place)[0]
    low, high = near - 6.0, near + 6.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        before = np.sum((curve.position(middle) - place) * tangent, axis=1) < 0.0
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return np.sum((curve.position(low) - place) * normal, axis=1)


@both
def test_cost_is_the_sum_of_its_four_integrals_over_the_curve(closed: bool):
    problem = problem_of(closed)
    x = somewhere(problem)
    parts = {name: float(np.sum(values**2)) for name, values in residuals(problem, x).items()}
    # each of them matters
    assert min(parts.values()) > 0.01 * max(parts.values())
    # the lane's centre is found to 1e-9 m
    assert problem.cost(x) == pytest.approx(sum(parts.values()), rel=1e-8)
    assert problem.model(x).cost == pytest.approx(problem.cost(x), rel=1e-12)


@both
def test_gradient_and_hessian_are_the_differences_in_any_direction(closed: bool):
    problem = problem_of(closed)
    bent = problem_of(closed, Weights(curvature_rate=ALL.curvature_rate))
    x = somewhere(problem)
    model, of_bends = problem.model(x), bent.model(x)
    for direction in np.random.default_rng(9).normal(size=(6, len(x))):
        step = 1e-5 * direction
        ahead, behind = problem.model(x + step), problem.model(x - step)
        assert model.gradient @ direction == pytest.approx((ahead.cost - behind.cost) / 2e-5, rel=1e-5)
        # of length and distance from the centre the Hessian is exact
        change = (ahead.gradient - bent.model(x + step).gradient - behind.gradient + bent.model(x - step).gradient) / 2e-5
        own = (model.hessian - of_bends.hessian) @ direction
        assert own == pytest.approx(change, abs=1e-5 * np.max(np.abs(change)))
        # of the squares of curvature and its rate it is that of residuals that are linear
        moved = [(a - b) / 2e-5 for a, b in zip(*(residuals(bent, at).values() for at in (x + step, x - step)), strict=True)]
        assert direction @ (of_bends.hessian @ direction) == pytest.approx(2.0 * sum(np.sum(one**2) for one in moved[:2]), rel=1e-5)


ENDS = {
    "all": (End(0.9, 0.21, 0.013, 1.13), End(-1.1, -0.17, -0.019, 0.91)),
    "no speed": (End(0.9, 0.21, 0.013), End(-1.1, -0.17, -0.019)),
    "no curvature": (End(-0.8, -0.3), End(1.3, 0.25)),
    "heading alone": (End(heading=0.23), End(heading=-0.31)),
    "offset alone": (End(1.2), End(-0.7)),
    "lane": (None, None),
}


@pytest.mark.parametrize("kind", ENDS)
def test_ends_are_kept_by_every_curve_that_keeps_the_equalities(kind: str):
    problem = problem_of(False, ends=ENDS[kind])
    curve, reference = problem.curve(somewhere(problem)), problem.corridor.reference
    lane = generic().lane_centre()
    for q, given in zip((0.0, reference.length), ENDS[kind], strict=True):
        place, d1, d2 = (values[0] for values in curve.pieces(np.array([q]), 2))
        tangent, normal = reference.tangent(q), reference.normal(q)
        offset = float((place - reference.position(q)) @ normal)
        heading = float(np.arctan2(d1 @ normal, d1 @ tangent))
        speed = float(np.hypot(*d1))
        end = given or End(centre(problem, np.array([q]))[0], float(lane.heading(lane.length if q else 0.0) - reference.heading(q)))
        if end.offset is not None:
            assert offset == pytest.approx(end.offset, abs=1e-7)
        if end.heading is not None:
            assert heading == pytest.approx(end.heading, abs=1e-7)
        if end.curvature is not None:
            assert float(cross(d1, d2)) / speed**3 == pytest.approx(end.curvature, abs=1e-9)
        beside = 1.0 - float(reference.curvature(q)) * offset
        assert speed * np.cos(heading) == pytest.approx(beside if end.speed is None else end.speed * np.cos(heading), abs=1e-7)


@both
def test_curves_that_keep_the_equalities_are_smooth_and_others_jump_by_what_is_missing(closed: bool):
    problem = problem_of(closed)
    x = somewhere(problem)
    x_off = x + 0.02 * np.random.default_rng(4).normal(size=len(x))
    matrix, rhs = problem.equalities
    breaks, h = problem.spline.breaks, np.diff(problem.spline.breaks)
    count = len(problem.q) if closed else len(problem.q) - 2
    missing = (matrix @ x_off - rhs)[: 2 * count].reshape(-1, 2)
    for k in range(count):
        after, before = (k, (k - 1) % len(h)) if closed else (k + 1, k)
        normal, tangent = problem.corridor.reference.normal(breaks[after]), problem.corridor.reference.tangent(breaks[after])
        for point, jump in ((x, np.zeros(2)), (x_off, missing[k])):
            a, b, c, _ = problem.curve(point).pieces.coefficients[:, :, before]
            end = 3.0 * a * h[before] ** 2 + 2.0 * b * h[before] + c
            step = (end - problem.curve(point).pieces.coefficients[2][:, after]) * 0.5 * (h[before] + h[after])
            assert np.array([step @ tangent, step @ normal]) == pytest.approx(jump, abs=1e-8)


@both
def test_rows_and_bounds_are_the_room_to_the_borders_drawn_in(closed: bool):
    problem = problem_of(closed, tighter=0.03)
    x = somewhere(problem)
    reference, curve, rows = problem.corridor.reference, problem.curve(x), problem.rows
    value = rows.matrix @ x
    least, most = problem.bounds
    places = ((problem.row_q, rows.upper - value, value - rows.lower), (problem.q, (most - x)[2::3], (x - least)[2::3]))
    for q, to_left, to_right in places:
        offset = np.sum((curve.pieces(q)[0] - reference.position(q)) * reference.normal(q), axis=1)
        right, left = problem.corridor.offsets(q)
        kept = np.isfinite(to_left)
        assert np.count_nonzero(~kept) <= 2
        assert to_left[kept] == pytest.approx((left - 0.03 - offset)[kept], abs=1e-9)
        assert to_right[kept] == pytest.approx((offset - right - 0.03)[kept], abs=1e-9)
    assert drawn_in(np.array([-1.0, 0.5]), np.array([2.0, 0.54]), 0.03)[1] == pytest.approx([1.97, 0.53])


@both
def test_curvatures_and_their_rows_are_those_of_the_curve(closed: bool):
    problem = problem_of(closed, curvature_max=0.05)
    x = somewhere(problem)
    problem = problem.with_bends(np.linspace(0.3, problem.spline.breaks[-1] - 0.3, 37))
    value, jacobian = problem.curvatures(x)
    _, d1, d2 = problem.curve(x).pieces(problem.bend_q, 2)
    assert value * 0.998 * 0.05 == pytest.approx(cross(d1, d2) / np.hypot(*d1.T) ** 3, abs=1e-12)
    for direction in np.random.default_rng(2).normal(size=(4, len(x))):
        moved = (problem.curvatures(x + 1e-6 * direction)[0] - problem.curvatures(x - 1e-6 * direction)[0]) / 2e-6
        assert problem.bend_rows(jacobian) @ direction == pytest.approx(moved, abs=1e-6 * np.max(np.abs(moved)))


@both
def test_windows_that_follow_each_other_add_up_to_the_whole(closed: bool):
    whole = problem_of(closed, tighter=0.02)
    x = somewhere(whole).reshape(-1, 3)
    count = len(whole.q)
    # on a circuit from the middle over the seam to the middle again
    cuts = [20, 31, 46, count + 4, count + 20] if closed else [0, 17, 33, count - 1]
    tables, cost, seen = Tables(whole), 0.0, []
    length = whole.corridor.reference.length
    value = whole.rows.matrix @ x.ravel()
    free = (End(), End())
    for first, last in pairwise(cuts):
        window = tables.window(first, last, free)
        own = x[np.arange(first, last + 1) % count].ravel()
        cost += window.cost(own)
        assert window.model(own).cost == pytest.approx(window.cost(own), rel=1e-12)
        rows = [int(np.argmin(np.abs(np.mod(q, length) - whole.row_q))) for q in window.rows.q]
        seen += rows
        assert np.mod(window.rows.q, length) == pytest.approx(whole.row_q[rows], abs=1e-9)
        assert window.rows.matrix @ own - window.rows.lower == pytest.approx(value[rows] - whole.rows.lower[rows], abs=1e-9)
        assert window.rows.upper - window.rows.matrix @ own == pytest.approx(whole.rows.upper[rows] - value[rows], abs=1e-9)
        matrix, rhs = window.equalities
        assert (matrix @ own - rhs)[: 2 * (last - first - 1)] == pytest.approx(0.0, abs=1e-8)
        inside = slice(first, last + 1)
        curve, s = window.curve(own), np.linspace(window.q[0], window.q[-1], 50)
        assert curve.pieces(s)[0] == pytest.approx(whole.curve(x.ravel()).pieces(np.mod(s, length) if closed else s)[0], abs=1e-6)
        assert window.q == pytest.approx(np.append(whole.q, whole.q + length)[inside], abs=1e-9)
        for one, other in zip(window.borders, whole.borders, strict=True):
            assert one == pytest.approx(np.append(other, other)[inside], abs=1e-12)
    assert sorted(seen) == list(range(len(whole.row_q)))
    assert cost == pytest.approx(whole.cost(x.ravel()), rel=1e-10)
