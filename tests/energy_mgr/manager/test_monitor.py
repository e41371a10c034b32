"""What is made of drives that report something else than was commanded."""

import pytest

from energy_mgr.allocation import NO_FAULTS, Layout
from energy_mgr.manager.monitor import Monitor
from powertrain import Vehicle

DT = 0.004


@pytest.mark.parametrize("way", [1.0, -1.0], ids=["driving", "recuperating"])
def test_a_weak_motor_keeps_the_share_of_its_largest_torque_that_it_gives(romo: Vehicle, way: float):
    """Commanded 40 Nm of its 160 it gives 20: an eighth of the largest torque is what it is sure to have, not the half that was asked for."""
    layout = Layout(romo)
    monitor, command = Monitor(layout, DT), [0.0] * layout.size
    for k in range(layout.motors):
        command[k] = 40.0 * way
    good = (40.0 * way,) * layout.motors
    for _ in range(100):
        assert monitor.update(command, good, (), ()) is NO_FAULTS
    weak = (good[0], 20.0 * way, *good[2:])
    for _ in range(100):
        found = monitor.update(command, weak, (), ())
    assert found.motors == pytest.approx((1.0, 20.0 / 160.0, 1.0, 1.0), abs=1e-12)
