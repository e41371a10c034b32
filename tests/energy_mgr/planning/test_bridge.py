"""A circuit that crosses itself is planned and driven: stations keep its passages apart."""

import numpy as np
import pytest

import energy_mgr
from roads import Road


@pytest.fixture(scope="module")
def plan() -> energy_mgr.Plan:
    # starts right where it crosses itself, the worst place to begin
    a = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)
    road = Road.from_points("eight", 45.0 * np.column_stack([np.sin(a), np.sin(a) * np.cos(a)]), -4.0, 4.0, closed=True)
    return energy_mgr.plan(road, "romo", corridor="road")


def test_its_path_is_proven_and_leaves_no_passage_out(plan: energy_mgr.Plan):
    path = plan.chosen.path
    assert path.report.certified
    # beside the reference station by station all along: nothing was cut short over the crossing
    assert path.curve.length == pytest.approx(plan.road.length, rel=0.03)
    station, offset = plan.road.reference.project(path.curve.position(path.knot_s), path.knot_road_s)
    assert np.all(np.diff(station) > 0.0)
    assert np.max(np.abs(offset)) < 4.0


@pytest.mark.slow
def test_it_is_driven_over_the_crossing_twice(plan: energy_mgr.Plan):
    drive = energy_mgr.simulate(plan.trajectory, plan.vehicle)
    assert drive.outcome == "arrived"
    assert drive.offset_max < 0.1
