"""Where the knots of a path lie."""

import numpy as np
import pytest

from energy_mgr.path.problem.knots import knots_by_need
from roads import Road


@pytest.mark.parametrize("moving", ["right", "left", "both"])
def test_knots_lie_close_where_a_border_comes_nearer_on_whatever_side(moving: str):
    x = np.arange(0.0, 401.0, 2.0)
    closer = np.clip((x - 190.0) / 10.0, 0.0, 1.0)
    right, left = (-3.5 + closer * (moving != "left"), 3.5 - closer * (moving != "right"))
    q = knots_by_need(Road.from_points("ramp", np.column_stack([x, 0.0 * x]), right, left).corridor("road", 1.0))
    gaps, middle = np.diff(q), 0.5 * (q[1:] + q[:-1])
    # on the straight 16 m, where a border moves 4 m; in between spreading by a quarter of the way
    assert np.max(gaps[(middle > 190.0) & (middle < 200.0)]) < 5.0
    assert np.max(gaps[middle < 120.0]) > 12.0
