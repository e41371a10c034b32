"""Windows that reach up to the end of an open road."""

import numpy as np
import pytest

from energy_mgr.path import PathPlanner
from powertrain import Vehicle
from tests.energy_mgr.path.problem.test_ends import ASLANT, aslant


@pytest.mark.parametrize("side", [1.0, -1.0], ids=["left", "right"])
def test_a_window_up_to_the_end_of_the_road_ends_where_the_lane_does(romo: Vehicle, side: float):
    step = PathPlanner(aslant(side), romo, extent="road", horizon=1e3, budget_ms=1e3).step(0.0)
    assert step.status == "solved"
    assert step.pieces is not None
    place, slope = (value[0] for value in step.pieces(np.array([200.0]), 1))
    # the end is held by equalities, which the solver keeps far below a millimetre
    assert place == pytest.approx([200.0, side * ASLANT * 200.0], abs=1e-3)
    assert slope[1] / slope[0] == pytest.approx(side * ASLANT, abs=1e-4)
