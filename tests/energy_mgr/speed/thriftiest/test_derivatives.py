"""The exact derivatives of intervals and jerk against differences, their values against the ledger."""

import numpy as np
import pytest

from energy_mgr.speed import (
    FrictionBrakes,
    Jerk,
)
from energy_mgr.speed.bounds.jerk import JerkModel, jerk_of
from energy_mgr.speed.thriftiest.interval import IntervalModel
from powertrain import drive_energy

from ..rig import VAN
from ..tiny_roads import KINDS, WEAK, tiny


def inner(model: IntervalModel, rng: np.random.Generator) -> np.ndarray:
    """Unknowns somewhere inside, off every kink."""
    e = rng.uniform(0.1, 0.9, (model.count, 2))
    return np.column_stack([e, rng.uniform(0.2, 2.0, model.count), rng.uniform(0.05, 1.0, model.count)])


def central(function, at: np.ndarray, width: float) -> np.ndarray:
    """(N, ..., 4) derivative by central differences; intervals do not depend on each other."""
    columns = []
    for k in range(4):
        step = np.zeros_like(at)
        step[:, k] = width
        columns.append((function(at + step) - function(at - step)) / (2.0 * width))
    return np.stack(columns, axis=-1)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("vehicle", [WEAK, VAN], ids=["weak", "van"])
def test_gradients_of_energy_time_and_rows_are_the_differences(kind: str, vehicle, rng: np.random.Generator):
    model = IntervalModel(tiny(vehicle, KINDS[kind]))
    at = inner(model, rng)
    slopes = model.slopes(at, np.zeros((model.count, model.rows)), np.zeros(model.count))
    energy = central(lambda x: model.values(x).energy, at, 1e-6)
    assert slopes.energy == pytest.approx(energy, rel=1e-6, abs=1e-8)
    time = central(lambda x: model.values(x).time, at, 1e-6)
    assert slopes.time == pytest.approx(time[:, :2], rel=1e-6, abs=1e-8)
    assert time[:, 2:] == pytest.approx(0.0, abs=1e-9)
    rows = central(lambda x: model.values(x).rows, at, 1e-6)
    assert slopes.rows == pytest.approx(rows, rel=1e-6, abs=1e-7)


@pytest.mark.parametrize("kind", KINDS)
def test_the_hessian_is_the_difference_of_the_lagrangians_gradient(kind: str, rng: np.random.Generator):
    model = IntervalModel(tiny(WEAK, KINDS[kind]))
    at = inner(model, rng)
    dual, price, weight = rng.uniform(0, 1, (model.count, model.rows)), rng.uniform(0, 1, model.count), 0.7

    def gradient(x: np.ndarray) -> np.ndarray:
        found = model.slopes(x, dual, price, weight)
        own = weight * found.energy + np.einsum("nk,nkj->nj", dual, found.rows)
        own[:, :2] += price[:, None] * found.time
        return own

    hessian = model.slopes(at, dual, price, weight).hessian
    assert hessian == pytest.approx(np.swapaxes(hessian, 1, 2), rel=1e-12)
    assert hessian == pytest.approx(central(gradient, at, 1e-6), rel=1e-5, abs=1e-6)


def test_the_energy_of_an_interval_is_that_of_the_ledger_when_z_is_the_magnitude_of_the_force():
    limits = tiny(VAN, (FrictionBrakes(2000.0),))
    model = IntervalModel(limits)
    v = np.array([0.0, 5.0, 7.0, 8.0, 6.0, 7.0, 5.0, 4.0, 0.0])
    brake = np.linspace(0.0, 300.0, 8)
    ledger = drive_energy(VAN, limits.s, v, limits.z, brake)
    e = 0.5 * v**2 / model.energy_scale
    unknown = np.column_stack([e[:-1], e[1:], np.abs(ledger.force) / model.force_scale, brake / model.force_scale])
    values = model.values(unknown)
    kinetic = 0.5 * VAN.effective_mass * np.diff(v**2)
    assert values.energy * model.unit + kinetic == pytest.approx(ledger.energy, rel=1e-7, abs=1e-2)
    assert values.time == pytest.approx(ledger.time, rel=1e-7)
    # F <= z and -F <= z: one of them is tight
    assert np.max(values.rows[:, 2:4], axis=1) == pytest.approx(0.0, abs=1e-9)


def test_jerk_rows_are_the_jerk_of_the_profile_over_its_limit(rng: np.random.Generator):
    limits = tiny(extra=(Jerk(0.8),), count=11)
    v = rng.uniform(3.0, 9.0, 11)
    model = JerkModel(limits, 50.0)
    rows = model.values(0.5 * v**2 / 50.0)
    assert rows[:, 0] == pytest.approx(jerk_of(limits.ds, v) / 0.8 - 1.0, rel=1e-9)
    assert rows[:, 0] + rows[:, 1] == pytest.approx(-2.0)


def test_jerk_of_a_profile_of_constant_jerk_tends_to_it():
    # v = v0 + a t + j t^2 / 2, s by integration; sampled ever finer
    errors = []
    for count in (51, 201):
        t = np.linspace(0.0, 5.0, count)
        s, v = 4.0 * t + 0.2 * t**2 + 0.6 * t**3 / 6.0, 4.0 + 0.4 * t + 0.3 * t**2
        errors.append(np.max(np.abs(jerk_of(np.diff(s), v) - 0.6)))
    assert errors[0] < 0.01
    assert errors[1] < errors[0] / 3.0


def test_derivatives_of_the_jerk_rows_are_differences(rng: np.random.Generator):
    limits = tiny(extra=(Jerk(0.8),), count=11)
    model, x, dual = JerkModel(limits, 50.0), rng.uniform(0.2, 0.9, 11), rng.uniform(0.0, 1.0, (9, 2))

    def lagrangian(x: np.ndarray) -> float:
        return float(np.sum(dual * model.values(x)))

    def gradient(x: np.ndarray) -> np.ndarray:
        found = np.zeros_like(x)
        model.add_gradient(found, x, dual)
        return found

    eye, width = np.eye(11), 1e-6
    numeric = np.array([(lagrangian(x + width * row) - lagrangian(x - width * row)) / (2 * width) for row in eye])
    assert gradient(x) == pytest.approx(numeric, rel=1e-6, abs=1e-7)
    direction = rng.normal(size=11)
    along = (model.values(x + width * direction) - model.values(x - width * direction)) / (2 * width)
    assert model.along(x, direction) == pytest.approx(along, rel=1e-6, abs=1e-7)
    # with vanishing barrier terms what is added to the band is the Hessian of the Lagrangian
    band, rhs = np.zeros((3, 11)), np.zeros(11)
    slack = np.full((9, 2), 1e12)
    model.add_curvature(band, rhs, x, slack, dual, 0.0, np.ones(11, dtype=bool))
    full = np.diag(band[2]) + np.diag(band[1, 1:], 1) + np.diag(band[1, 1:], -1) + np.diag(band[0, 2:], 2) + np.diag(band[0, 2:], -2)
    numeric = np.array([(gradient(x + width * row) - gradient(x - width * row)) / (2 * width) for row in eye])
    assert full == pytest.approx(numeric, rel=1e-5, abs=1e-5)
