import math

import numpy as np
import pytest

import energy_mgr
from energy_mgr import PlanningError, Trajectory
from energy_mgr.following import LAWS, Follower, Projected
from energy_mgr.motion import MotionDemand, VehicleState
from roads import RoadBuilder
from tests.energy_mgr.following.rig import DT, LAGS, arc, at_rest, beside, circle, clothoid, drive, eight, straight, there_and_stop

EVERY = pytest.mark.parametrize("law", list(LAWS))


@EVERY
@pytest.mark.parametrize("projection", ["safe", "tipi"])
def test_a_restored_follower_goes_on_bit_for_bit(romo, law, projection):
    road = eight()
    follower = Follower(road, romo, law=law, projection=projection)
    first = drive(follower, beside(road, 3.0, 0.5), romo, 1.0)
    kept = follower.snapshot()
    car = VehicleState(first.x[-1], first.y[-1], 0.8, 8.0, 0.1, 0.1)
    cars = [car._replace(x=car.x + 0.02 * k, y=car.y + 0.02 * k) for k in range(100)]
    one = [follower.step(car, DT) for car in cars]
    follower.restore(kept)
    assert [follower.step(car, DT) for car in cars] == one
    assert follower.law.snapshot() is not None


@EVERY
@pytest.mark.parametrize("road", [eight(), there_and_stop(), arc(-15.0, 60.0, 6.0)], ids=["eight", "stop", "arc"])
def test_no_finite_state_makes_a_number_that_is_none(romo, rng, law, road):
    follower = Follower(road, romo, law=law)
    for k in range(600):
        size = 10.0 ** rng.uniform(-3, 300 if k % 10 == 0 else 3, 9)
        state = VehicleState(*(rng.choice([-1.0, 0.0, 1.0], 9) * size).tolist())
        out = follower.step(state, DT)
        given = MotionDemand(*(0.5 * value for value in out.demand))
        follower.achieved(given)
        assert all(map(math.isfinite, (*out.demand, out.e_v, *out.at[:5])))


@EVERY
def test_a_state_that_is_no_number_is_refused_counted_and_survived(romo, law):
    road = straight()
    follower = Follower(road, romo, law=law)
    assert follower.step(at_rest(x=math.nan), DT).demand == (0.0, 0.0, 0.0)
    good = follower.step(beside(road, 10.0, 0.3), DT)
    bad = follower.step(beside(road, 10.0)._replace(yaw_rate=math.inf), DT)
    assert (bad.demand, bad.supervised, follower.refused) == (good.demand, True, 2)
    assert follower.step(beside(road, 10.04, 0.3), DT).at.s == pytest.approx(10.04, abs=1e-4)


def test_the_preview_is_what_driving_on_the_trajectory_will_ask(romo):
    road = there_and_stop(cruise=6.0)
    follower = Follower(road, romo)
    s = float(road.at_time(2.0))
    follower.step(beside(road, s), DT)
    times = [0.0, 0.5, 1.5, 4.0, 100.0]
    preview = follower.preview(times)
    for time, demand, speed in list(zip(times, preview.demands, preview.speeds, strict=True))[:-1]:
        then = float(road.at_time(2.0 + time))
        alone = Follower(road, romo).step(beside(road, then), DT).demand
        assert demand == pytest.approx(alone, abs=1e-6)
        assert speed == pytest.approx(road.point(then).v, abs=1e-6)
    assert (preview.speeds[-1], preview.yaw_rates[-1], preview.demands[-1]) == (0.0, 0.0, (0.0, 0.0, 0.0))


def test_the_preview_of_a_circuit_goes_on_over_the_laps(romo):
    road = circle()
    follower = Follower(road, romo)
    follower.step(beside(road, 185.0), DT)
    preview = follower.preview([0.0, 3.0, 60.0])
    assert preview.yaw_rates == pytest.approx([10.0 / 30.0] * 3, rel=1e-6)
    assert [demand.a_y for demand in preview.demands] == pytest.approx([100.0 / 30.0] * 3, rel=1e-6)


def test_the_preview_turns_as_the_bend_tightens_and_as_the_car_slows_down(romo):
    """d(kappa v)/dt = kappa' v^2 + kappa a, written out for a clothoid at constant speed and for an arc that is braked on."""
    tightening = Follower(clothoid(sharpness=5e-4, v=12.0), romo)
    tightening.step(beside(tightening.trajectory, 10.0), DT)
    turns = [demand.yaw_acceleration for demand in tightening.preview([0.0, 1.0, 5.0]).demands]
    assert turns == pytest.approx([5e-4 * 12.0**2] * 3, rel=1e-9)
    # v dv/ds = -0.5
    slowing = Follower(arc(60.0, 80.0, v=np.sqrt(144.0 - np.linspace(0.0, 80.0, 41))), romo)
    slowing.step(beside(slowing.trajectory, 10.0), DT)
    turns = [demand.yaw_acceleration for demand in slowing.preview([0.0, 1.0, 4.0]).demands]
    assert turns == pytest.approx([-0.5 / 60.0] * 3, rel=1e-9)


def test_a_new_plan_while_driving_goes_on_where_the_car_is(romo):
    road = arc(60.0, 200.0)
    follower = Follower(road, romo)
    first = drive(follower, beside(road, 5.0), romo, 3.0)
    later = Trajectory.along(road.s + 500.0, road.x, road.y, road.psi, road.kappa, road.v)
    follower.replace(later)
    assert follower.projection.s == pytest.approx(500.0 + first.s[-1], abs=1e-4)
    assert follower.trajectory is later


def test_names_that_are_none_are_refused(romo):
    with pytest.raises(PlanningError, match="expected one of pd, geometric, linearising"):
        Follower(straight(), romo, law="lqr")
    with pytest.raises(PlanningError, match="expected safe or tipi"):
        Follower(straight(), romo, projection="magic")


@EVERY
def test_a_planned_road_is_followed_to_its_end(romo, law):
    road = RoadBuilder("bends").limit(14).straight(60).bend(30, 1.2, 15).straight(30).bend(25, -1.0, 15).straight(60).build()
    plan = energy_mgr.plan(road, romo)
    trajectory = plan.trajectory
    run = drive(
        Follower(trajectory, romo, law=law),
        beside(trajectory, 0.0, 0.3),
        romo,
        60.0,
        lags=LAGS,
        stop=lambda row: row[7] or row[3] >= trajectory.s[-1],
    )
    assert run.s[-1] > trajectory.s[-1] - 0.2
    assert np.max(np.abs(run.e_y[round(4.0 / DT) :])) < 0.1
    assert np.max(np.abs(run.v - trajectory.at(np.clip(run.s, trajectory.s[0], trajectory.s[-1])).v)) < 0.5


def test_projected_defaults_describe_an_endless_path():
    at = Projected(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, "newton", straight().point(0.0))
    assert (at.end, at.to_go) == (False, math.inf)
