"""The averaged speed that laws are given, by quadrature of the trajectory itself."""

import numpy as np
import pytest

from energy_mgr.following.smooth import SmoothSpeed
from tests.energy_mgr.following.rig import circle

RING = circle(radius=30.0, v=np.resize([9.0, 9.6, 10.4], 97))  # 96 stretches: the speed goes on over the seam


@pytest.mark.parametrize("lap", [-1, 0, 2])
@pytest.mark.parametrize("beyond", [-0.95, -0.3, 0.0, 0.4, 0.9, 60.0])
def test_speed_and_acceleration_are_averaged_over_the_seam_as_elsewhere(beyond: float, lap: int):
    s = RING.length * lap + beyond
    here = RING.point(s)
    v, a = SmoothSpeed(RING).at(s, here.v, here.a)
    half = 0.5 * 0.2 * here.v  # the way of a fifth of a second
    middles = s + half * ((np.arange(4000) + 0.5) / 2000.0 - 1.0)
    # kinks of v^2 fall anywhere between the places: half a millimetre of way times a step of slope of some m/s^2
    assert v == pytest.approx(np.sqrt(np.mean(RING.at(middles).v ** 2)), abs=1e-6)
    ahead, behind = RING.point(s + half), RING.point(s - half)
    assert a == pytest.approx((ahead.v**2 - behind.v**2) / (4.0 * half), abs=1e-9)
