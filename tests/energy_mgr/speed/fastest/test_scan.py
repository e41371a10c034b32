"""The vectorised recurrences against a plain loop."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from energy_mgr.speed.fastest.scan import affine_climb, climb

SEEDS = st.integers(0, 2**32 - 1)
SIZES = st.integers(1, 300)


def looped(start: float, bound: np.ndarray, factor: np.ndarray, rise: np.ndarray) -> np.ndarray:
    found = [start]
    for c, a, b in zip(bound, factor, rise, strict=True):
        found.append(min(c, a * found[-1] + b))
    return np.array(found)


def bounds(rng: np.random.Generator, size: int) -> np.ndarray:
    bound = rng.uniform(0.0, 10.0, size)
    bound[rng.random(size) < 0.3] = np.inf
    return bound


@settings(max_examples=80, deadline=None)
@given(seed=SEEDS, size=SIZES)
def test_climb_is_the_loop(seed: int, size: int):
    rng = np.random.default_rng(seed)
    bound, rise, start = bounds(rng, size), rng.uniform(-0.5, 1.0, size), float(rng.uniform(0, 5))
    expected = looped(start, bound, np.ones(size), rise)
    # sums of at most 300 terms of order one, in another order
    assert climb(start, bound, rise) == pytest.approx(expected, abs=1e-11)


@settings(max_examples=80, deadline=None)
@given(seed=SEEDS, size=SIZES)
def test_affine_climb_is_the_loop(seed: int, size: int):
    rng = np.random.default_rng(seed)
    bound, rise, start = bounds(rng, size), rng.uniform(-0.5, 1.0, size), float(rng.uniform(0, 5))
    factor = rng.uniform(0.3, 1.1, size)
    expected = looped(start, bound, factor, rise)
    assert affine_climb(start, bound, factor, rise) == pytest.approx(expected, rel=1e-10, abs=1e-10)


@pytest.mark.parametrize("size", range(1, 40))
def test_affine_climb_has_no_seam_where_stretches_meet(size: int):
    rng = np.random.default_rng(size)
    bound, factor, rise = bounds(rng, size), rng.uniform(0.5, 1.5, size), rng.uniform(-1.0, 1.0, size)
    assert affine_climb(1.0, bound, factor, rise) == pytest.approx(looped(1.0, bound, factor, rise), rel=1e-11, abs=1e-11)


@pytest.mark.parametrize("size", [1, 2, 3, 15, 16, 17, 300])
def test_without_bounds_both_are_plain_sums(size: int):
    free, rise = np.full(size, np.inf), np.arange(1.0, size + 1.0)
    total = np.concatenate([[2.0], 2.0 + np.cumsum(rise)])
    assert np.array_equal(climb(2.0, free, rise), total)
    assert np.array_equal(affine_climb(2.0, free, np.ones(size), rise), total)


@pytest.mark.parametrize("size", [1, 5, 300])
def test_a_bound_of_zero_everywhere_gives_zero_and_the_start_is_not_bounded(size: int):
    for found in (climb(3.0, np.zeros(size), np.ones(size)), affine_climb(3.0, np.zeros(size), np.ones(size), np.ones(size))):
        assert found[0] == 3.0
        assert np.array_equal(found[1:], np.zeros(size))


def test_an_infinite_start_waits_for_the_first_bound():
    bound = np.array([np.inf, np.inf, 4.0, np.inf])
    found = affine_climb(np.inf, bound, np.full(4, 2.0), np.full(4, 1.0))
    assert found.tolist() == [np.inf, np.inf, np.inf, 4.0, 9.0]


def test_an_infinite_rise_leaves_the_bounds_alone():
    bound = np.array([3.0, 1.0, 5.0, 2.0, 7.0])
    assert affine_climb(0.0, bound, np.ones(5), np.full(5, np.inf)).tolist() == [0.0, *bound]


def test_the_largest_solution_is_found_no_other_feasible_one_is_higher():
    rng = np.random.default_rng(5)
    bound, factor, rise = rng.uniform(1, 3, 60), rng.uniform(0.8, 1.0, 60), rng.uniform(0.0, 0.3, 60)
    found = affine_climb(0.5, bound, factor, rise)
    for _ in range(50):
        other = [0.5]
        for c, a, b in zip(bound, factor, rise, strict=True):
            other.append(min(c, a * other[-1] + b) * rng.uniform(0.9, 1.0))
        assert np.all(np.array(other) <= found + 1e-12)


def test_arguments_are_left_as_they_were():
    bound, factor, rise = np.full(20, 2.0), np.full(20, 0.9), np.full(20, 0.2)
    affine_climb(0.0, bound, factor, rise)
    climb(0.0, bound, rise)
    assert np.all(bound == 2.0)
    assert np.all(factor == 0.9)
    assert np.all(rise == 0.2)
