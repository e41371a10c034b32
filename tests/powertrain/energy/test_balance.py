import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from powertrain import COMPONENTS, Vehicle, VehicleError, drive_energy, driving_resistance, load_vehicle, motor_losses

ROMO = load_vehicle("romo")


@settings(deadline=None)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(2, 200))
def test_components_add_up_to_the_total(seed: int, count: int):
    rng = np.random.default_rng(seed)
    s, v, z = np.cumsum(rng.uniform(0.5, 5, count)), rng.uniform(0.1, 27, count), np.cumsum(rng.normal(0, 0.1, count))
    ledger = drive_energy(ROMO, s, v, z)
    moved = sum(abs(value) for value in ledger.components.values())
    assert set(ledger.components) == set(COMPONENTS)
    assert sum(ledger.components.values()) == pytest.approx(ledger.total, abs=1e-9 * moved)
    assert all(ledger.components[name] >= 0.0 for name in ("rolling", "drag", "copper", "iron", "inverter", "friction"))
    assert float(np.sum(ledger.power * ledger.time)) == pytest.approx(ledger.total, abs=1e-9 * moved)


def test_constant_speed_on_the_flat_is_the_closed_form(romo: Vehicle):
    length, v = 5000.0, 15.0
    ledger = drive_energy(romo, np.linspace(0, length, 801), np.full(801, v))
    force = driving_resistance(romo, v, 0.0)
    torque, speed = force / (4 * romo.motor_ratio), v * romo.motor_ratio
    expected = force * length + 4 * sum(motor_losses(romo, torque, speed)) * length / v
    assert ledger.total == pytest.approx(expected, rel=1e-12)
    assert ledger.journey_time == pytest.approx(length / v)


def test_height_costs_its_potential_energy_whatever_the_profile(romo: Vehicle):
    s = np.linspace(0, 1000, 501)
    z = 30 * np.sin(s / 90) + 0.02 * s
    ledger = drive_energy(romo, s, np.full(501, 12.0), z)
    assert ledger.components["slope"] == pytest.approx(1013 * 9.81 * (z[-1] - z[0]), rel=1e-9)


def test_what_comes_back_is_less_than_what_went_in(romo: Vehicle):
    s = np.linspace(0, 400, 201)
    up_and_down = 2 + 0.05 * np.minimum(s, 400 - s)
    ledger = drive_energy(romo, s, up_and_down)
    assert ledger.force.min() < 0 < ledger.force.max()
    assert ledger.components["kinetic"] == pytest.approx(0.0, abs=1e-6)
    assert ledger.total > ledger.components["rolling"] + ledger.components["drag"]


@pytest.mark.parametrize(
    ("s", "v"),
    [([0, 1, 1], [1, 1, 1]), ([0, 1, 2], [1, -1, 1]), ([0, 1, 2], [1, 0, 0]), ([0, 1, 2], [1, np.nan, 1]), ([0], [1]), ([0, 1], [1, 1, 1])],
)
def test_drives_that_are_none_are_refused(romo: Vehicle, s: list[float], v: list[float]):
    with pytest.raises(VehicleError, match="drive"):
        drive_energy(romo, s, v)
