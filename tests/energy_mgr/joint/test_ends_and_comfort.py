"""Bounds of the joint programme that a symmetric drive cannot tell apart: speeds at both ends, accelerating and braking."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from powertrain import Vehicle

from .test_programme import bend, made


def test_an_open_road_is_entered_and_left_at_the_speeds_that_were_given(romo: Vehicle):
    programme, start = made(bend(), romo, step=12.0)
    v = replace(programme, start_speed=4.0, end_speed=7.0).solve(start).point.v
    assert (v[0], v[-1]) == pytest.approx((4.0, 7.0), abs=1e-6)


def test_a_car_that_may_brake_harder_than_accelerate_does_just_that(romo: Vehicle):
    """Hardly slower than the fastest drive both bounds are reached from rest to rest, each by its own sign."""
    limits = msgspec.structs.replace(romo.limits, acceleration_max_mps2=1.0, deceleration_max_mps2=2.0)
    programme, start = made(bend(), msgspec.structs.replace(romo, limits=limits), step=12.0, slower=1.01)
    found = programme.solve(start).point
    gain = np.diff(found.v**2) / (2.0 * programme.grid.lengths(found.x))
    # rows are scaled to the size of one and kept to IPOPT's tolerance
    assert np.max(gain) == pytest.approx(1.0, abs=1e-3)
    assert np.min(gain) == pytest.approx(-2.0, abs=1e-3)
