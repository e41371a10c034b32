import mpmath
import numpy as np
import pytest

from roads import RoadError
from roads.geometry.clothoid import clothoid, many
from roads.geometry.plan_view import Clothoid, Cubic, PlanView


def exact(length: float, kappa: float, rate: float) -> complex:
    """The integral in 30 digits."""
    with mpmath.workdps(30):
        panels = int(abs(kappa * length) + abs(rate) * length**2) + 2
        return complex(
            mpmath.quad(lambda s: mpmath.e ** (1j * (mpmath.mpf(kappa) * s + mpmath.mpf(rate) * s * s / 2)), mpmath.linspace(0, length, panels))
        )


CASES = [
    (100.0, 0.0, 1e-3),
    (30.0, 0.05, -3.3e-3),
    (500.0, 1e-5, 1e-12),
    (2.0, -0.3, 0.15),
    (1000.0, 0.002, -1e-6),
    (50.0, 0.1, 1e-9),
    (80.0, 0.0, -8e-3),
]


@pytest.mark.parametrize(("length", "kappa", "rate"), CASES)
def test_clothoid_agrees_with_mpmath(length: float, kappa: float, rate: float):
    places, psi = clothoid(np.array([0.5 * length, length]), kappa, rate)
    for s, place, angle in zip((0.5 * length, length), places, psi, strict=True):
        assert abs(complex(*place) - exact(s, kappa, rate)) < 1e-9 * length
        assert angle == pytest.approx(kappa * s + 0.5 * rate * s * s, rel=1e-14, abs=1e-14)


def test_clothoid_agrees_with_mpmath_over_orders_of_magnitude(rng: np.random.Generator):
    for _ in range(40):
        length, kappa, rate = (
            10 ** rng.uniform(-1, 3),
            rng.choice([-1, 0, 1]) * 10 ** rng.uniform(-6, -0.7),
            rng.choice([-1, 1]) * 10 ** rng.uniform(-12, -2),
        )
        if abs(kappa * length) + abs(rate) * length**2 / 2 < 30.0:
            assert abs(complex(*clothoid(np.array([length]), kappa, rate)[0][0]) - exact(length, kappa, rate)) < 1e-9 * max(length, 1.0)


def test_many_clothoids_are_the_single_ones(rng: np.random.Generator):
    s, kappa, rate = rng.uniform(1, 30, 50), rng.uniform(-0.05, 0.05, 50), rng.uniform(-1e-3, 1e-3, 50)
    single = [complex(*clothoid(s[k : k + 1], kappa[k], rate[k])[0][0]) for k in range(50)]
    assert np.max(np.abs(many(s, kappa, rate) - single)) < 1e-12


def test_spline_through_the_samples_keeps_the_tolerance_at_steps_of_curvature():
    from roads import PlanarCurve

    # straight, arc of 10 m radius, straight: curvature jumps by 0.1 1/m twice
    arc = Clothoid(30.0, 0.0, 0.0, 15.0, 0.1, 0.1)
    (end,), (heading,) = arc.at(np.array([15.0]))
    elements = [Clothoid(0.0, 0.0, 0.0, 30.0), arc, Clothoid(*end, heading, 30.0)]
    view = PlanView(elements, np.array([False, True, True]))
    index, s = view.samples()
    places, _ = view.at(index, s)
    starts = np.array([0.0, 30.0, 45.0])
    _, first = np.unique(starts[index] + s, return_index=True)
    curve = PlanarCurve.through(places[first])
    fine = np.linspace(0.0, 75.0, 7501)
    at = np.searchsorted(starts, fine, side="right") - 1
    truth, _ = view.at(at, fine - starts[at])
    assert np.max(np.hypot(*(curve.position(fine) - truth).T)) < 1e-4
    assert len(first) < 120


def test_cubic_runs_at_its_length_or_at_its_parameter():
    circle = Cubic(1.0, 2.0, 0.3, 10.0, (0.0, 10.0, 0.0, -1.6), (0.0, 0.0, 5.0, -0.8), 1.0, "arc")
    true = circle.by_arc_length()
    s = np.linspace(0.0, true.length, 400)
    places, heading = true.at(s)
    steps = np.hypot(*np.diff(places, axis=0).T)
    # equal steps of the station are equal steps along the curve
    assert np.ptp(steps) < 1e-4 * steps[0]
    assert np.allclose(np.arctan2(*np.diff(places, axis=0).T[::-1]), 0.5 * (heading[1:] + heading[:-1]), atol=1e-4)
    unit = Cubic(0.0, 0.0, 0.0, 5.0, (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 0.02, 0.0), 5.0, "unit")
    assert np.allclose(unit.at(np.array([3.0]))[0], [[3.0, 0.18]])
    assert unit.curvature(np.array([0.0]))[0] == pytest.approx(0.04)


def test_a_spiral_of_many_turns_takes_work_in_proportion_and_no_more():
    import tracemalloc

    s = np.linspace(0.0, 300.0, 8000)
    tracemalloc.start()
    points, _ = clothoid(s, 9.0, -8.9 / 300.0)
    assert tracemalloc.get_traced_memory()[1] < 50e6
    tracemalloc.stop()
    # a finer sum of the same integral: the trapezoid over 1e-4 m misses it by about kappa^2 h^2 / 12 of the length
    fine = np.linspace(0.0, 300.0, 3_000_001)
    psi = (9.0 - 0.5 * 8.9 / 300.0 * fine) * fine
    way = np.concatenate([[0.0], np.cumsum(0.5 * (np.exp(1j * psi[1:]) + np.exp(1j * psi[:-1])) * 1e-4)])
    assert np.abs(points[:, 0] + 1j * points[:, 1] - np.interp(s, fine, way)).max() < 1e-5
    with pytest.raises(RoadError, match="turns by 1e\\+06 rad"):
        clothoid(np.array([0.0, 1e6]), 1.0, 1e-12)
