import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from roads import PlanarCurve, RoadError


def circle(radius: float, count: int = 200, centre: tuple[float, float] = (0.0, 0.0)) -> PlanarCurve:
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return PlanarCurve.through(np.array(centre) + radius * np.column_stack([np.cos(angle), np.sin(angle)]), closed=True)


def test_circle_has_its_length_curvature_and_turning():
    curve = circle(20.0)
    s = np.linspace(0.0, curve.length, 1001)
    assert curve.length == pytest.approx(2 * np.pi * 20.0, rel=1e-8)
    # a cubic spline through 200 points of a circle is off by h^2 kappa^3 / 12, 8e-5 of the curvature
    assert np.max(np.abs(curve.curvature(s) - 0.05)) < 0.05 * 1e-4
    assert curve.heading(curve.length - 1e-9) - curve.heading(0.0) == pytest.approx(2 * np.pi, abs=1e-6)
    assert curve.heading(curve.length + 1.0) == pytest.approx(curve.heading(1.0) + 2 * np.pi, abs=1e-9)
    assert curve.squared_curvature() == pytest.approx(2 * np.pi / 20.0, rel=1e-5)


def test_seam_of_a_closed_curve_is_smooth():
    curve = circle(20.0, 37)
    ahead, behind = 1e-7, curve.length - 1e-7
    assert np.allclose(curve.position(ahead), curve.position(behind), atol=1e-6)
    assert np.allclose(curve.tangent(ahead), curve.tangent(behind), atol=1e-6)
    assert curve.curvature(ahead) == pytest.approx(float(curve.curvature(behind)), abs=1e-7)


def test_arc_length_is_right_to_a_micrometre_against_dense_chords():
    t = np.linspace(0.0, 3.0, 30)
    curve = PlanarCurve.through(np.column_stack([20 * t, 8 * np.sin(2 * t)]))
    s = np.linspace(0.0, curve.length, 200_001)
    chords = np.cumsum(np.hypot(*np.diff(curve.position(s), axis=0).T))
    assert np.max(np.abs(chords - s[1:])) < 1e-6


def test_station_is_the_inverse_of_parameter(rng: np.random.Generator):
    heading = np.cumsum(rng.uniform(-0.3, 0.3, 60))
    curve = PlanarCurve.through(np.cumsum(rng.uniform(3, 6, 60)[:, None] * np.column_stack([np.cos(heading), np.sin(heading)]), axis=0))
    s = np.linspace(0.0, curve.length, 333)
    assert np.max(np.abs(curve.station(curve.parameter(s)) - s)) < 1e-6


def test_curvature_rate_is_the_derivative_of_curvature():
    t = np.linspace(0.0, 3.0, 60)
    curve = PlanarCurve.through(np.column_stack([20 * t, 8 * np.sin(2 * t)]))
    s = 0.5 * (curve.breaks_s[1:] + curve.breaks_s[:-1])
    step = 1e-4
    numeric = (curve.curvature(s + step) - curve.curvature(s - step)) / (2 * step)
    assert np.allclose(curve.curvature_rate(s), numeric, atol=1e-7)


@settings(deadline=None, max_examples=40)
@given(angle=st.floats(-np.pi, np.pi), shift=st.floats(-1e6, 1e6))
def test_moving_the_frame_moves_the_curve_and_nothing_else(angle: float, shift: float):
    t = np.linspace(0.0, 3.0, 40)
    points = np.column_stack([20 * t, 8 * np.sin(2 * t)])
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    here, there = PlanarCurve.through(points), PlanarCurve.through(points @ turn.T + shift)
    s = np.linspace(0.0, here.length, 100)
    # 1e6 m from the origin positions carry 1e-10 m of rounding, which second differences over 1.5 m leave as 1e-10 1/m
    assert there.length == pytest.approx(here.length, abs=1e-6)
    assert np.allclose(there.curvature(s), here.curvature(s), atol=1e-6)


def test_projection_finds_offsets_on_both_sides(rng: np.random.Generator):
    curve = circle(50.0, 400)
    s, offset = rng.uniform(0, curve.length, 300), rng.uniform(-20, 20, 300)
    points = curve.position(s) + offset[:, None] * curve.normal(s)
    found_s, found_offset = curve.project(points, s + rng.uniform(-5, 5, 300))
    assert np.max(np.abs(found_offset - offset)) < 1e-6
    assert np.max(np.abs((found_s - s + 100) % curve.length - 100)) < 1e-5


@pytest.mark.parametrize(
    ("points", "words"),
    [
        ([[0.0, 0.0]], "at least 2 points"),
        ([[0.0, 0.0], [0.0, 0.0], [1.0, 0.0]], "points 0 and 1 of the curve are the same"),
        ([[0.0, 0.0], [np.nan, 0.0], [1.0, 0.0]], "point 1 of the curve is not finite"),
    ],
)
def test_bad_points_are_named(points: list[list[float]], words: str):
    with pytest.raises(RoadError, match=words):
        PlanarCurve.through(points)
