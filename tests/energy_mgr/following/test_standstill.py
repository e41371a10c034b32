"""Laws at rest: starting, stopping, standing."""

import math

import numpy as np
import pytest

from energy_mgr import Trajectory
from energy_mgr.following import LAWS, Follower
from tests.energy_mgr.following.rig import DT, arc, at_rest, beside, drive, there_and_stop

EVERY = pytest.mark.parametrize("law", list(LAWS))


@EVERY
@pytest.mark.parametrize("grade", [0.0, 0.06, -0.06])
@pytest.mark.parametrize("noise", [None, 0.02])
def test_from_rest_it_starts_and_at_the_end_it_stands(romo, rng, law, grade, noise):
    road = there_and_stop(grade=grade)
    run = drive(Follower(road, romo, law=law), at_rest(), romo, 18.0, slope=grade, noise=noise and (rng, noise))
    assert np.argmax(run.v > 0.5) * DT < 0.5
    assert run.x[-1] == pytest.approx(60.0, abs=0.2)
    assert run.x.max() < 60.2
    assert run.v.min() > -0.01
    assert run.done[-1]
    assert np.ptp(run.x[-round(1.0 / DT) :]) < 0.02
    assert np.argmax(run.done) * DT == pytest.approx(road.journey_time, abs=1.5)


@EVERY
def test_it_starts_from_before_its_start_too(romo, law):
    run = drive(Follower(there_and_stop(), romo, law=law), at_rest(x=-1.0), romo, 4.0)
    assert run.s[-1] > 8.0


@EVERY
def test_a_stop_on_the_way_holds_nobody(romo, law):
    s = np.linspace(0.0, 80.0, 41)
    v = np.sqrt(2 * 1.5 * np.minimum(np.abs(s - 40.0), 12.0))
    road = Trajectory.along(s, s, 0 * s, 0 * s, 0 * s, v)
    run = drive(Follower(road, romo, law=law), beside(road, 1.0), romo, 16.0)
    near = np.abs(run.s - 40.0) < 0.3
    assert run.v[near].min() < 0.35
    assert run.s[-1] > 60.0


@pytest.mark.parametrize(("e_y", "e_psi"), [(0.0, 0.0), (2.0, 0.0), (-3.0, 0.5), (0.0, 3.0)])
def test_a_standing_car_is_asked_for_nothing_aside(romo, e_y, e_psi):
    road = arc(30.0, 100.0, 8.0)
    follower = Follower(road, romo)
    car = beside(road, 30.0, e_y, e_psi, v=0.0)
    for _ in range(200):
        demand = follower.step(car, DT).demand
    if abs(e_psi) < 0.1:
        assert abs(demand.a_y) < 1e-9
    # whatever is asked ahead along the path has a part aside at a heading error, and no more
    assert abs(demand.a_y) <= 2.5 * abs(math.sin(e_psi)) + 1e-9
    kappa_s = road.point(30.0).kappa * abs(demand.a_x) * 1.3 / (1 - e_y / 30.0)
    assert abs(demand.yaw_acceleration) <= kappa_s + 1e-6
