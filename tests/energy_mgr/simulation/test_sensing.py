"""What the sensors say of a car whose motion is known."""

import numpy as np
import pytest

from energy_mgr.simulation.sensing import RealSensing
from powertrain import Plant, Vehicle
from powertrain.sensors import GnssDescription

PERIOD = 0.004


@pytest.fixture(scope="module")
def plant(romo: Vehicle) -> Plant:
    return Plant(romo, speed=10.0)


@pytest.mark.parametrize("jitter", [0.0, 0.05])
def test_place_and_heading_of_the_receiver_are_those_of_the_time_it_names(plant: Plant, jitter: float):
    speed, turning = 10.0, 0.5
    at = [plant.body.states.index(name) for name in ("x", "y", "psi")]
    plant.state[at] = 0.0
    sensing = RealSensing(plant, np.random.default_rng(3), GnssDescription(delay_s=0.2, jitter_s=jitter, deviation_m=0.02))

    def pose(t: float) -> np.ndarray:
        radius, psi = speed / turning, turning * t
        return np.array([radius * np.sin(psi), radius * (1.0 - np.cos(psi)), psi])

    stamps = []
    for k in range(600):
        t = PERIOD * k
        plant.state[at] = pose(t)
        m = sensing.measure(t, plant, 0.0, speed * turning, 1.0)
        stamps.append(m.pose_time)
        assert m.pose_time is not None
        assert t - m.pose_time >= (0.2 - 1e-9 if m.pose_time > 0.0 else 0.0)
        # five standard deviations of receiver and compass; headings are remembered once a period
        assert np.abs(np.array([m.x, m.y]) - pose(m.pose_time)[:2]) == pytest.approx(0.0, abs=5 * 0.02)
        assert m.psi == pytest.approx(pose(m.pose_time)[2], abs=5 * 0.003 + turning * PERIOD)
    assert len(set(stamps)) >= 10  # five a second, but for what is still on its way
