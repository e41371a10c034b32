"""Plans on a road in generic position mirrored, turned and driven the other way. Plans stop 1e-6 of the cost above the least one."""

from dataclasses import replace

import numpy as np
import pytest

from energy_mgr import Path, PathOptions, Weights, plan_path
from roads import PlanarCurve, Road
from tests.roads.generic import generic

SHARES = np.linspace(0.0, 1.0, 300)
TURN = np.array([[np.cos(2.3), -np.sin(2.3)], [np.sin(2.3), np.cos(2.3)]])


def moved(road: Road, matrix: np.ndarray) -> Road:
    """The road with its points turned or mirrored; a mirror swaps the sides."""
    curve = PlanarCurve.through(road.reference.position(road.s) @ matrix.T, closed=road.closed)
    if np.linalg.det(matrix) > 0.0:
        return replace(road, reference=curve)
    lanes = tuple(replace(lane, right=-lane.left, left=-lane.right) for lane in road.lanes[::-1])
    return replace(road, reference=curve, right=-road.left, left=-road.right, lanes=lanes, bank=-road.bank)


def planned(road: Road) -> Path:
    weights = Weights(length=2e-4, offset=1e-5, curvature_rate=20.0)
    return plan_path(road, 0.9, extent="own", options=PathOptions(weights=weights, tolerance=1e-9))


@pytest.mark.parametrize("closed", [False, True])
def test_the_plan_moves_with_its_road(closed: bool):
    road = generic(closed=closed, even=True)
    # lanes for both directions, so that the same strip is free the other way
    road = replace(road, lanes=tuple(replace(lane, direction=0) for lane in road.lanes))
    path = planned(road)
    assert path.report.certified
    places = path.curve.position(SHARES * path.curve.length)
    mirror = np.array([[0.6, 0.8], [0.8, -0.6]])
    for matrix in (TURN, mirror):
        other = planned(replace(moved(road, matrix), left_hand=np.linalg.det(matrix) < 0.0))
        assert other.report.cost == pytest.approx(path.report.cost, rel=1e-6)
        # nearly flat optimum: a millionth of the cost is a tenth of a millimetre
        assert other.curve.position(SHARES * other.curve.length) @ matrix == pytest.approx(places, abs=1e-4)
    back = planned(replace(road.reversed(), left_hand=True))
    assert back.report.cost == pytest.approx(path.report.cost, rel=1e-5)
    assert back.curve.position((1.0 - SHARES) * back.curve.length) == pytest.approx(places, abs=1e-3)
