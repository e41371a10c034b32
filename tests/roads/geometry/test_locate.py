import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from roads import PlanarCurve, Tracker, open_road


def brute(curve: PlanarCurve, points: np.ndarray) -> np.ndarray:
    """Distances to the curve by looking at every centimetre."""
    s = np.linspace(0.0, curve.length, int(curve.length * 100) + 1)
    line = curve.position(s)
    return np.array([np.min(np.hypot(*(line - point).T)) for point in points])


def eight() -> PlanarCurve:
    """A closed curve that crosses itself."""
    t = np.linspace(0.0, 2 * np.pi, 200, endpoint=False)
    return PlanarCurve.through(np.column_stack([60 * np.sin(t), 30 * np.sin(2 * t)]), closed=True)


def test_locate_finds_the_nearest_place_of_all(rng: np.random.Generator):
    for curve in (eight(), open_road("handling").reference, open_road("descent")[800:1300].reference):
        low, high = (
            np.min(curve.position(np.linspace(0, curve.length, 300)), axis=0),
            np.max(curve.position(np.linspace(0, curve.length, 300)), axis=0),
        )
        points = rng.uniform(low - 20, high + 20, (200, 2))
        s, offset = curve.locate(points)
        assert np.all(np.abs(offset) <= brute(curve, points) + 1e-4)
        assert np.allclose(np.hypot(*(curve.position(s) - points).T), np.abs(offset), atol=1e-6)


def test_near_a_crossing_each_branch_is_told_apart():
    curve = eight()
    s = np.concatenate([np.linspace(-3, 3, 41), 0.5 * curve.length + np.linspace(-3, 3, 41)]) % curve.length
    # 5 cm beside either branch, closer to it than to the other except within a decimetre of the crossing itself
    for side in (-0.05, 0.05):
        points = curve.position(s) + side * curve.normal(s)
        found, offset = curve.locate(points)
        assert np.all(np.abs(offset) <= 0.05 + 1e-9)
        clear = np.hypot(*points.T) > 0.3
        gap = np.abs(found - s)[clear]
        assert np.all(np.minimum(gap, curve.length - gap) < 1e-6)


def test_sides_and_seam_of_a_circle():
    t = np.linspace(0.0, 2 * np.pi, 100, endpoint=False)
    circle = PlanarCurve.through(50 * np.column_stack([np.cos(t), np.sin(t)]), closed=True)
    angle = np.linspace(-0.1, 0.1, 21)
    for radius, side in ((45.0, 5.0), (55.0, -5.0)):
        s, offset = circle.locate(radius * np.column_stack([np.cos(angle), np.sin(angle)]))
        assert np.allclose(offset, side, atol=1e-4)
        assert np.allclose(np.exp(1j * s / 50.0), np.exp(1j * angle), atol=1e-4)


def test_beyond_an_open_end_the_end_is_nearest():
    line = PlanarCurve.through([[0.0, 0.0], [50.0, 0.0], [100.0, 0.0]])
    s, offset = line.locate([[-3.0, 4.0], [103.0, -4.0], [50.0, 2.0]])
    assert np.allclose(s, [0.0, 100.0, 50.0])
    assert np.allclose(offset, [5.0, -5.0, 2.0])


def test_many_points_are_located_as_single_ones_are(rng: np.random.Generator):
    curve = open_road("handling").reference
    s = rng.uniform(0.0, curve.length, 50_000)
    points = curve.position(s) + rng.uniform(-3.0, 3.0, 50_000)[:, None] * curve.normal(s)
    together = curve.locate(points)
    apart = curve.locate(points[:500])
    assert np.array_equal(together[0][:500], apart[0])
    assert np.max(np.abs((together[0] - s + 100.0) % curve.length - 100.0)) < 1e-6


@settings(deadline=None, max_examples=15)
@given(speed=st.floats(0.001, 2.0), sway=st.floats(0.0, 3.0))
def test_tracker_follows_without_searching_anew(speed: float, sway: float):
    curve = open_road("handling").reference
    tracker = Tracker(curve)
    s = np.arange(0.0, 400.0 * speed, speed) + curve.length - 100.0 * speed
    points = curve.position(s) + (sway * np.sin(s / 7.0))[:, None] * curve.normal(s)
    wanted, offsets = curve.locate(points)
    for (x, y), place, offset in zip(points.tolist(), wanted, offsets, strict=True):
        found = tracker(x, y)
        assert abs((found[0] - place + 100.0) % curve.length - 100.0) < 1e-6
        assert found[1] == pytest.approx(offset, abs=1e-6)
    assert tracker.reacquired == 1


def test_tracker_stays_on_its_branch_at_a_crossing_and_finds_back_after_a_jump():
    curve = eight()
    tracker = Tracker(curve, window=5.0)
    s = np.linspace(curve.length - 30.0, curve.length + 30.0, 300)
    for place in s:
        found, _ = tracker(*curve.position(place).tolist())
        assert abs((found - place + 100.0) % curve.length - 100.0) < 1e-6
    assert tracker.reacquired == 1
    far = curve.position(0.3 * curve.length)
    assert tracker(*far.tolist())[0] == pytest.approx(0.3 * curve.length, abs=1e-6)
    assert tracker.reacquired == 2
