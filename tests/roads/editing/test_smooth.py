import numpy as np
import pytest

from roads import PlanarCurve, Road, RoadError, open_road
from roads.conditioning.bounded import smooth_points
from roads.editing.smooth import smoothed

from ...timing import least_time


@pytest.mark.parametrize(("noise", "bound"), [(0.05, 0.3), (0.15, 0.3), (0.15, 0.8)])
@pytest.mark.parametrize("name", ["handling", "commute"])
def test_noise_goes_and_the_bound_is_kept(name: str, noise: float, bound: float, rng: np.random.Generator):
    road = open_road(name)
    true = road.reference
    s = np.linspace(0.0, true.length, 1200, endpoint=not road.closed)
    noisy = true.position(s) + rng.normal(0.0, noise, (1200, 2)) / np.sqrt(2.0)
    made = smooth_points(noisy, bound, closed=road.closed)
    assert np.max(np.hypot(*(made - noisy).T)) <= bound
    before, after = (PlanarCurve.through(line, closed=road.closed).squared_curvature() for line in (noisy, made))
    assert after < 0.4 * before
    # nothing of the road's own shape is lost: corners are not cut beyond the bound, and the curvature is of the road's size
    assert after < 1.6 * true.squared_curvature()
    _, off = true.locate(made)
    assert np.sqrt(np.mean(off**2)) < 0.5 * bound


def test_a_bound_far_below_the_noise_is_kept_too(rng: np.random.Generator):
    road = open_road("handling")
    s = np.linspace(0.0, road.length, 900, endpoint=False)
    noisy = road.reference.position(s) + rng.normal(0.0, 0.2, (900, 2))
    made = smooth_points(noisy, 0.02, closed=True)
    assert np.max(np.hypot(*(made - noisy).T)) <= 0.02


def test_straight_lines_and_few_points_stay():
    line = np.column_stack([np.arange(50.0), np.zeros(50)])
    assert np.max(np.abs(smooth_points(line, 0.5) - line)) < 1e-6
    assert np.array_equal(smooth_points(line[:4], 0.5), line[:4])
    with pytest.raises(RoadError, match="largest deviation"):
        smooth_points(line, 0.0)


def test_road_moves_its_reference_and_nothing_else(rng: np.random.Generator):
    road = open_road("commute")
    s = np.linspace(0.0, road.length, 1000)
    noise = rng.normal(0.0, 0.05, 1000)
    noise[[0, -1]] = 0.0
    noisy = type(road).from_points(
        "noisy",
        road.reference.position(s) + noise[:, None] * road.reference.normal(s),
        -3.5 - noise,
        3.5 - noise,
        lane_edges=[(1, -3.5 - noise, -noise), (-1, -noise, 3.5 - noise)],
    )
    made, report = smoothed(noisy, 0.2)
    assert len(made.lanes) == 2
    assert report.squared_curvature_after < 0.2 * report.squared_curvature_before
    assert max(report.largest_left, report.largest_right) <= 0.2
    for which in ("left", "right"):
        edge = getattr(made, which)
        points = made.reference.position(made.s) + edge[:, None] * made.reference.normal(made.s)
        # the edges are where they were: 3.5 m beside the road without noise, but for what a line between noisy points cuts off
        _, off = road.reference.locate(points)
        assert np.max(np.abs(np.abs(off) - 3.5)) < 0.05


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_report_tells_to_which_side_the_line_moved(side: float):
    x = np.arange(0.0, 201.0, 2.0)
    bump = 0.1 * side * np.exp(-(((x - 100.0) / 2.0) ** 2))
    made, report = smoothed(Road.from_points("bump", np.column_stack([x, bump]), -3.5, 3.5), 0.3)
    # a place that juts out to one side is drawn back to the other; along x offsets are differences of y, as slopes are below 0.05
    back = side * (bump[50] - made.reference.position(made.reference.locate([[100.0, 0.0]])[0])[0, 1])
    assert back > 0.05
    towards, away = (report.largest_right, report.largest_left)[:: int(side)]
    assert towards == pytest.approx(back, abs=2e-3)
    assert away < 0.5 * back
    assert (report.rms_right > report.rms_left) == (side > 0.0)


@pytest.mark.timing
def test_time_grows_with_the_number_of_points():
    def took(count: int) -> float:
        x = 3.0 * np.arange(count)
        points = np.column_stack([x, 50.0 * np.sin(x / 100.0)]) + np.random.default_rng(1).normal(0.0, 0.1, (count, 2))
        return least_time(lambda: smooth_points(points, 0.5), rounds=3)

    small, large = took(4000), took(32000)
    # eight times the points; quadratic time would be 64 times as long
    assert large < 20.0 * small
