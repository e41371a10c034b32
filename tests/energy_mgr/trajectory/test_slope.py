"""The slope at the seam of a circuit whose stations are unevenly far apart."""

import numpy as np
import pytest

from energy_mgr import Trajectory


def test_slope_at_the_seam_is_that_of_the_parabola_through_the_rows_beside_it():
    radius = 30.0
    # 2 m before the seam, 9 m after it
    s = np.concatenate([np.arange(0.0, 180.0, 9.0), 2.0 * np.pi * radius - np.arange(6.0, 0.0, -2.0), [2.0 * np.pi * radius]])
    angle = s / radius
    x, y, z = radius * np.sin(angle), -radius * np.cos(angle), 2.0 * np.sin(angle + 0.7)
    x[-1], y[-1], z[-1] = x[0], y[0], z[0]
    ring = Trajectory.along(s, x, y, angle, np.full(len(s), 1.0 / radius), np.full(len(s), 10.0), z=z, closed=True)
    before, after = s[-1] - s[-2], s[1] - s[0]
    assert after == pytest.approx(4.5 * before)
    through = np.polyfit([-before, 0.0, after], [z[-2], z[0], z[1]], 2)
    # its derivative at the seam itself; the fit of three points is exact to rounding
    assert ring.slope[[0, -1]] == pytest.approx(through[1], abs=1e-9)
