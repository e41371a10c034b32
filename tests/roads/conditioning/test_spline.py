"""Penalised splines against SciPy's smoothing spline, and the smoothness that is found."""

import numpy as np
import pytest
from scipy.interpolate import make_smoothing_spline

from roads.conditioning.spline import Smoother, cross_validated, noise_of, within


def data(noise: float, seed: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    u = np.sort(rng.uniform(0.0, 300.0, 240))
    truth = 5.0 * np.sin(u / 30.0) + 0.02 * u
    return u, truth, truth + rng.normal(0.0, noise, len(u))


@pytest.mark.parametrize("lam", [1.0, 100.0, 1e5])
def test_without_outliers_it_is_the_cubic_smoothing_spline(lam: float):
    u, _, y = data(0.3)
    fit = Smoother(u, y[:, None], 0.5, 2, np.ones(len(u))).fit(lam, rounds=0)
    # differences of coefficients stand for the second derivative: off by the square of the knots' distance over the wave's length, and at the ends
    inner = (u > 10.0) & (u < 290.0)
    assert np.abs(fit(u)[:, 0] - make_smoothing_spline(u, y, lam=lam)(u))[inner].max() < 0.01


def test_a_parabola_is_no_change_of_bend():
    u = np.linspace(0.0, 100.0, 60)
    y = np.column_stack([u, 0.01 * u**2])
    for sharp in (False, True):
        fit = Smoother(u, y, 3.0, 3, np.ones(60), sharp=sharp).fit(1e4)
        assert np.abs(fit(u) - y).max() < 1e-6
        assert fit(u, 1)[:, 0] == pytest.approx(1.0, abs=1e-6)
        assert fit(u, 2)[:, 1] == pytest.approx(0.02, abs=1e-6)


def test_an_outlier_moves_the_curve_little():
    u, truth, y = data(0.1)
    y[100] += 50.0
    smoother = Smoother(u, y[:, None], 3.0, 2, np.ones(len(u)))
    lam = cross_validated(u, y[:, None], 3.0, 2, np.ones(len(u)))
    fit = smoother.fit(lam)
    assert abs(fit(u)[100, 0] - truth[100]) < 0.3
    assert fit.weight[100] < 0.02
    # the fault that it guards against: everything counted alike
    assert abs(smoother.fit(lam, rounds=0)(u)[100, 0] - truth[100]) > 1.0


@pytest.mark.parametrize("noise", [0.05, 0.5, 2.0])
def test_the_smoothness_found_takes_most_of_the_noise(noise: float):
    left = []
    for seed in range(5):
        u, truth, y = data(noise, seed)
        lam = cross_validated(u, y[:, None], 3.0, 2, np.ones(len(u)))
        left.append(np.sqrt(np.mean((Smoother(u, y[:, None], 3.0, 2, np.ones(len(u))).fit(lam)(u)[:, 0] - truth) ** 2)))
    # 240 data on some 5 waves: about 20 free values, hence sqrt(20 / 240) = 0.29 of the noise, and what outliers and the search cost
    assert np.median(left) < 0.45 * noise


def test_within_an_accuracy_it_is_as_smooth_as_can_be():
    u, _, y = data(0.5)
    smoother = Smoother(u, y[:, None], 1.0, 2, np.ones(len(u)))
    rough, smooth = within(smoother, 0.4), within(smoother, 1.0)
    assert rough.lam < smooth.lam
    for fit, accuracy in ((rough, 0.4), (smooth, 1.0)):
        assert np.sqrt(np.mean(smoother.residual(fit.coefficients) ** 2)) <= accuracy


def test_noise_is_told_from_what_changes_slowly():
    rng = np.random.default_rng(1)
    x = np.arange(400) * 5.0
    way = np.column_stack([x, 80.0 * np.sin(x / 200.0)])
    assert noise_of(way) < 1e-3
    # the median of 800 magnitudes scatters by some 5 %
    assert noise_of(way + rng.normal(0.0, 2.0, way.shape)) == pytest.approx(2.0, rel=0.15)
