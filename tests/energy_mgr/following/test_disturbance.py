"""The estimate of what acts beside the demanded accelerations, against motions that are known."""

import pytest

from energy_mgr.following.disturbance import Disturbance
from energy_mgr.motion import VehicleState

DT = 0.004
LIMITS = (1.0, 1.5, 1.0)


def slides(v_x: float, v_y: float, yaw_rate: float) -> VehicleState:
    return VehicleState(0.0, 0.0, 0.0, v_x, v_y, yaw_rate)


@pytest.mark.parametrize("yaw_rate", [0.5, -0.5])
@pytest.mark.parametrize("v_y", [0.8, -0.8])
def test_steady_sliding_in_a_bend_is_no_disturbance(v_y: float, yaw_rate: float):
    """d v_x/dt = a_x + r v_y and d v_y/dt = a_y - r v_x: velocities stay as they are under a_x = -r v_y and a_y = r v_x, which are asked for."""
    estimate, car = Disturbance(0.8, (0.0, 0.0, 0.0), LIMITS), slides(10.0, v_y, yaw_rate)
    for _ in range(1000):
        estimate.update(car, DT)
        estimate.asked(-yaw_rate * v_y, yaw_rate * 10.0, 0.0)
    # nothing was ever surprising: rounding of numbers up to 4 m/s^2 is left
    assert estimate.estimate == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)


@pytest.mark.parametrize("push", [(0.3, 0.0, 0.0), (0.0, -0.4, 0.0), (0.0, 0.0, 0.2)])
def test_a_steady_push_is_found_on_its_own_axis(push: tuple[float, float, float]):
    """The same sliding car, held in it by commands that make up for a push: what is asked is the push less than what the motion needs."""
    estimate, car, (x, y, r) = Disturbance(0.8, (0.0, 0.0, 0.0), LIMITS), slides(10.0, 0.5, 0.4), push
    for _ in range(4000):
        estimate.update(car, DT)
        estimate.asked(-0.4 * 0.5 - x, 0.4 * 10.0 - y, -r)
    # after 16 s at 0.8/s all but exp(-12.8), 3e-6 of it, is there
    assert estimate.estimate == pytest.approx(push, abs=1e-5)
