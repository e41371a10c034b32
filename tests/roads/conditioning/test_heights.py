"""Heights: the rise of the road that was driven, whatever the receiver made of it."""

import numpy as np
import pytest

from roads import open_road
from roads.conditioning.conditioned import conditioned
from roads.conditioning.heights import smoothed_heights, told_in
from roads.conditioning.wish import Wish

from .drives import Receiver, gain, recorded


@pytest.mark.parametrize(
    "receiver", [Receiver(2.5, 0.5), Receiver(2.5, 2.0), Receiver(1.0, 0.3, 1.0), Receiver(0.0, 1.0, 0.0, 0.2), Receiver(5.0, 3.0)]
)
@pytest.mark.parametrize("name", ["rural", "descent"])
def test_rise_and_fall_are_those_of_the_road(name: str, receiver: Receiver):
    road = open_road(name)
    z = road.height_at(np.arange(0.0, road.length, 5.0))
    rise, fall = [], []
    for seed in range(5):
        made = conditioned(recorded(road, receiver, seed), Wish(), False)
        rise.append(gain(made.height) - gain(z))
        fall.append(gain(-made.height) - gain(-z))
    # a fifth is what is promised; on a road that only falls a rise of half a metre in 120 m is noise that was taken for the road
    assert abs(np.median(rise)) < max(0.1 * gain(z), 0.5)
    assert abs(np.median(fall)) < max(0.1 * gain(-z), 0.5)


def test_jitter_on_a_level_way_is_no_rise():
    rises = []
    for seed in range(9):
        rng = np.random.default_rng(seed)
        s = np.arange(0.0, 1000.0)
        found = smoothed_heights(s, 520.0 + rng.uniform(-0.5, 0.5, 1000), s, None)
        rises.append(gain(found.height) + gain(-found.height))
        assert np.abs(found.height - 520.0).max() < 0.2
        assert not found.wrong.any()
    # a slope through 1,000 heights that scatter by 0.29 m has an error of 0.03 m from end to end; what merely foretells best gives 0.07 m
    assert np.median(rises) < 0.06


def test_noise_alone_is_no_building():
    for seed in range(5):
        rng = np.random.default_rng(seed)
        s = np.arange(0.0, 3000.0, 14.0)
        assert not smoothed_heights(s, 20.0 * np.sin(s / 300.0) + rng.normal(0.0, 2.0, len(s)), s, None).wrong.any()


@pytest.mark.parametrize(("first", "count", "by"), [(40, 2, 18.0), (60, 12, 25.0), (20, 1, -12.0), (0, 3, 15.0), (131, 3, 30.0)])
@pytest.mark.parametrize("noise", [0.0, 0.7])
def test_a_building_in_the_heights_is_no_hill(first: int, count: int, by: float, noise: float):
    rng = np.random.default_rng(1)
    s = np.arange(134) * 15.0
    truth = 35.0 + 4.0 * np.sin(s / 300.0)
    z = truth + rng.normal(0.0, noise, 134)
    z[first : first + count] += by
    found = smoothed_heights(s, z, s, None)
    assert found.wrong[first : first + count].all()
    assert np.count_nonzero(found.wrong) <= count + 2
    inner = slice(3, -3)
    assert np.abs(found.height - truth)[inner].max() < 0.5 + 2.0 * noise
    assert gain(found.height) < gain(truth) + 1.0 + 2.0 * noise


def test_a_steep_road_is_a_road():
    s = np.arange(0.0, 600.0, 5.0)
    z = np.interp(s, [0.0, 200.0, 400.0, 600.0], [100.0, 100.0, 150.0, 150.0])
    found = smoothed_heights(s, z, s, None)
    assert not found.wrong.any()
    assert gain(found.height) == pytest.approx(50.0, abs=0.5)


def test_stairs_of_whole_metres_are_a_slope():
    s = np.arange(0.0, 2000.0, 4.0)
    z = np.round(0.03 * s)
    found = smoothed_heights(s, z, s, None)
    assert found.step == 1.0
    slope = np.diff(found.height) / np.diff(s)
    # raw, the slope is 0 or 25 %
    assert np.abs(slope[10:-10] - 0.03).max() < 0.01


@pytest.mark.parametrize(
    ("values", "step"),
    [
        ([1.0, 2.0, 5.0, 7.0, 9.0], 1.0),
        ([0.5, 1.0, 3.0, 4.5, 6.0], 0.5),
        ([1.03, 2.0, 3.0, 4.0, 5.0], 0.0),
        ([7.0, 7.0], 0.0),
        ([10.0, 30.0], 0.0),
    ],
)
def test_the_step_that_heights_are_told_in(values: list[float], step: float):
    assert told_in(np.array(values)) == step


def test_the_stated_accuracy_of_heights_bounds_what_they_move():
    rng = np.random.default_rng(4)
    s = np.arange(0.0, 3000.0, 10.0)
    z = 20.0 * np.sin(s / 200.0) + rng.normal(0.0, 0.5, len(s))
    found = smoothed_heights(s, z, s, 1.0)
    assert 0.5 < np.sqrt(np.mean((found.height - z) ** 2)) <= 1.05
