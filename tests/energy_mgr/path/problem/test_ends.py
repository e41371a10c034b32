"""Which way a path points where it begins and ends, on a road whose lane leads aslant across its stations."""

import numpy as np
import pytest

from energy_mgr import plan_path
from roads import Road

#: The lane's middle lies so much further to the left (or right) with every metre.
ASLANT = 0.015


def aslant(side: float) -> Road:
    """200 m straight with one lane that grows wider on one side: its middle is a straight line as well, but not along the road."""
    s = np.arange(0.0, 201.0, 5.0)
    wide = 3.0 + 2.0 * ASLANT * s
    edges = (-3.0, wide) if side > 0.0 else (-wide, 3.0)
    return Road.from_points("aslant", np.column_stack([s, 0.0 * s]), *edges, lane_edges=[(1, *edges)])


@pytest.mark.parametrize("side", [1.0, -1.0], ids=["left", "right"])
def test_a_path_that_begins_and_ends_along_a_straight_lane_is_that_straight(side: float):
    """A straight line needs no curvature at all, so nothing is better; ends that point elsewhere would bend it."""
    path = plan_path(aslant(side), 1.05, extent="road")
    s = np.linspace(0.0, path.curve.length, 101)
    x, y = path.curve.position(s).T
    # a millimetre, as proofs and borders go; headings turned against the lane bring it 1.2 m off
    assert np.allclose(y, side * ASLANT * x, atol=1e-3)
    assert path.curve.heading(s[[0, -1]]) == pytest.approx(side * np.arctan(ASLANT), abs=1e-4)
    assert path.report.cost < 1e-6
