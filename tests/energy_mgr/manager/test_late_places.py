"""Places and headings that belong to another time than the velocities that come with them, as those of a satellite receiver."""

import math

import pytest

from energy_mgr.manager import Measurements, Trust
from energy_mgr.manager.guard import Guard
from tests.energy_mgr.manager.rig import DT

SPEED, RADIUS = 10.0, 20.0


def circling(t: float, pose_time: float, **more: float) -> Measurements:
    """On a circle to the left about (0, 20): velocities of time `t`, place and heading of `pose_time`."""
    angle = SPEED / RADIUS * pose_time
    x, y = RADIUS * math.sin(angle), RADIUS * (1.0 - math.cos(angle))
    return Measurements(t, x, y, angle, SPEED, 0.0, SPEED / RADIUS, pose_time=pose_time)._replace(**more)


@pytest.mark.parametrize("outage", [0.2, 1.0, 2.5])
def test_the_first_place_after_an_outage_in_a_bend_is_believed(outage: float):
    guard, t = Guard(Trust(), 4, 4, 4), 3.0
    assert guard.reason(circling(t, t - outage - 0.2), t) == ""
    # the car has turned on between the two places, by up to 72 degrees, not between the two measurements
    assert guard.reason(circling(t + DT, t - 0.2), t + DT) == ""


def test_a_heading_from_before_the_bend_is_no_heading_from_within_it():
    guard, t = Guard(Trust(), 4, 4, 4), 3.0
    old = circling(t, t - 2.2)
    assert guard.reason(old, t) == ""
    assert guard.reason(circling(t + DT, t - 0.2, psi=old.psi), t + DT) == "jump"
