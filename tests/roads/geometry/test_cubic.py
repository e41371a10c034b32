import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from roads.geometry.cubic import interpolate


@pytest.mark.parametrize("count", [2, 3, 4, 5, 40])
def test_open_spline_is_scipys_not_a_knot_spline(rng: np.random.Generator, count: int):
    u = np.cumsum(rng.uniform(0.5, 2.0, count))
    points = rng.normal(size=(count, 2))
    ours, theirs = interpolate(u, points, closed=False), CubicSpline(u, points, bc_type="not-a-knot")
    at = np.linspace(u[0], u[-1], 500)
    for order, values in enumerate(ours(at, 3)):
        # third derivatives jump at breaks; elsewhere rounding is what separates the two
        assert np.max(np.abs(values - theirs(at, order))) < 1e-9 * max(1.0, np.max(np.abs(theirs(at, order))))
    assert np.allclose(ours.derivative(at).T, theirs(at, 1), atol=1e-9)


@pytest.mark.parametrize("count", [4, 5, 60])
def test_closed_spline_is_scipys_periodic_spline(rng: np.random.Generator, count: int):
    u = np.cumsum(rng.uniform(0.5, 2.0, count))
    points = rng.normal(size=(count, 2))
    points[-1] = points[0]
    ours, theirs = interpolate(u, points, closed=True), CubicSpline(u, points, bc_type="periodic")
    at = np.linspace(u[0], u[-1], 500)
    for order, values in enumerate(ours(at, 2)):
        assert np.max(np.abs(values - theirs(at, order))) < 1e-9 * max(1.0, np.max(np.abs(theirs(at, order))))
