import math

import numpy as np
import pytest

from energy_mgr import Trajectory
from energy_mgr.following import LAWS, Follower, LinearisingGains, LinearisingLaw, PathProjection, PdGains, PdLaw
from energy_mgr.following.linearising import approach
from energy_mgr.motion import MotionDemand
from tests.energy_mgr.following.rig import DT, arc, beside, circle, clothoid, drive, straight

EVERY = pytest.mark.parametrize("law", list(LAWS))


# -- E0: initial displacement --------------------------------------------------------------------------------------------------------


@EVERY
@pytest.mark.parametrize("v", [5.0, 10.0, 20.0])
@pytest.mark.parametrize("bend", [0, 1, -1], ids=["straight", "left", "right"])
@pytest.mark.parametrize("e_y", [2.0, -2.0])
def test_two_metres_beside_the_path_decay_without_overshoot(romo, law, v, bend, e_y):
    road = arc(bend * max(60.0, v * v / 3.5), 220.0, v) if bend else straight(220.0, v)
    run = drive(Follower(road, romo, law=law), beside(road, 1.0, e_y), romo, 5.0)
    offset = run.e_y * math.copysign(1.0, e_y)
    assert offset[-1] < 0.1
    assert offset[round(3.6 / DT)] < 0.1
    assert offset.min() > -0.01 * 2.0
    assert np.max(np.abs(run.e_psi)) < 0.05
    assert np.max(np.abs(run.v - v)) < 0.15


def test_slower_actuators_than_expected_are_borne(romo):
    road = arc(60.0, 220.0, 12.0)
    run = drive(Follower(road, romo), beside(road, 1.0, 2.0), romo, 5.0, lags=(0.03, 0.1, 0.1))
    assert run.e_y.min() > -0.02
    assert abs(run.e_y[-1]) < 0.01


def test_the_approach_stays_within_its_limits_and_says_so(romo):
    road = straight(300.0, 15.0)
    follower = Follower(road, romo)
    run = drive(follower, beside(road, 1.0, 12.0), romo, 14.0)
    # the correction's own limit and the compensation of lag, which is a tenth of it
    assert np.max(np.abs(run.a_y)) < 2.5 * 1.1
    assert run.supervised[0]
    assert not run.supervised[-1]
    assert run.e_y.min() > -0.02
    assert abs(run.e_y[-1]) < 0.02


def test_a_slippery_road_is_asked_for_no_more_than_it_gives(romo):
    road = straight(300.0, 15.0)
    run = drive(Follower(road, romo), beside(road, 1.0, 6.0, 0.3)._replace(friction=0.2), romo, 12.0)
    assert np.max(np.hypot(run.a_x, run.a_y)) < 8.0 * 0.2 + 0.3  # and driving resistances
    assert abs(run.e_y[-1]) < 0.05


def test_a_bend_too_fast_for_the_road_gets_the_grip_first_and_brakes_with_the_rest(romo):
    road = circle(30.0, v=12.0)
    car = beside(road, 3.0, 1.0, v=16.0)._replace(friction=0.5)
    at = PathProjection(road).update(car, DT)
    demand = LinearisingLaw(romo).demand(car, at, DT)
    assert demand.a_y > 0.9 * 8.0 * 0.5
    assert demand.a_x < -0.2 * 8.0 * 0.5


# -- the error dynamics --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("road", "e_y"), [(straight(200.0, 12.0), 0.3), (arc(60.0, 200.0, 12.0), -0.3), (clothoid(), 0.25)])
def test_without_lag_the_error_decays_with_the_placed_poles(romo, road: Trajectory, e_y: float):
    gains = LinearisingGains(integral=0.0)
    follower = Follower(road, romo, gains=gains)
    state = beside(road, 5.0, e_y)
    # the rigid car in path coordinates, without lag and friction: integrated from what is demanded
    run = drive(follower, state, romo, 2.5, lags=(1e-3, 1e-3, 1e-3))
    p, q = gains.offset
    t = DT * np.arange(len(run.e_y))
    # at the offset the car's heading error rate is not zero on bends, but its offset's is: closed form of two real poles from rest
    exact = e_y * (q * np.exp(-p * t) - p * np.exp(-q * t)) / (q - p)
    # zero-order hold of 4 ms and the lag of 1 ms: a delay of 3 ms at a slope of 0.3 m/s
    assert run.e_y == pytest.approx(exact, abs=4e-3)


def test_the_linearised_accelerations_are_those_of_the_path_coordinates(romo, rng: np.random.Generator):
    """e_y'' from the demand, by differencing the motion in the plane, is the one that was placed: any heading error, any curvature."""
    gains = LinearisingGains(integral=0.0, correction=(99.0, 99.0, 99.0), grip=999.0, yaw_max=999.0, approach=(99.0, 99.0), approach_angle=1.5)
    road = clothoid(5e-4, 100.0, 10.0)
    for _ in range(50):
        car = beside(road, rng.uniform(20, 80), rng.uniform(-1, 1), rng.uniform(-0.3, 0.3))
        car = car._replace(v_y=rng.uniform(-1, 1), yaw_rate=rng.uniform(-0.5, 0.5))
        exact = PathProjection(road)
        at = exact.update(car, DT)
        law = LinearisingLaw(romo, gains)
        law._resistances.demand = lambda a_x, a_y, yaw, state, at: MotionDemand(a_x, a_y, yaw)
        demand = law.demand(car, at, DT)
        rate = car.v_x * math.sin(at.e_psi) + car.v_y * math.cos(at.e_psi)
        speed = math.hypot(car.v_x, car.v_y)
        p = min(gains.offset[0], speed / gains.length)
        q = 2 * p
        wanted = -(p + q) * rate - p * q * at.e_y
        before, now, after = (moved_on(road, car, demand, h) for h in (-1e-3, 0.0, 1e-3))
        # third derivatives over a millisecond
        second = (before - 2 * now + after) / 1e-6
        assert second[0] == pytest.approx(wanted, abs=2e-2)
        turn = car.yaw_rate - at.point.kappa * at.sdot
        p, q = (min(pole, pole / gains.heading[0] * speed / gains.length * 2) for pole in gains.heading)
        assert second[1] == pytest.approx(-(p + q) * turn - p * q * at.e_psi, abs=2e-2)
        assert (after[2] - before[2]) / 2e-3 == pytest.approx(gains.speed * (10.0 - now[2]), abs=2e-2)


def moved_on(road, car, demand, h) -> np.ndarray:
    """e_y, e_psi and the speed along the path after `h` seconds of motion with the accelerations held in the plane."""
    c, s = math.cos(car.psi), math.sin(car.psi)
    vx, vy = car.v_x * c - car.v_y * s, car.v_x * s + car.v_y * c
    ax, ay = demand.a_x * c - demand.a_y * s, demand.a_x * s + demand.a_y * c
    psi = car.psi + h * car.yaw_rate + h * h / 2 * demand.yaw_acceleration
    at = PathProjection(road).update(car._replace(x=car.x + h * vx + h * h / 2 * ax, y=car.y + h * vy + h * h / 2 * ay, psi=psi), DT)
    along = at.point.psi
    return np.array([at.e_y, at.e_psi, (vx + h * ax) * math.cos(along) + (vy + h * ay) * math.sin(along)])


@pytest.mark.parametrize("braking", [0.5, 3.0])
def test_the_approach_never_needs_more_than_its_braking(braking: float):
    e, rate, h, hardest = 20.0, 0.0, 1e-3, 0.0
    for _ in range(40000):
        acceleration, _far = approach(e, rate, 1.5, 3.0, braking, 4.0)
        acceleration = max(acceleration, -2.0)
        hardest = max(hardest, acceleration)
        e, rate = e + h * rate, rate + h * acceleration
        assert e > -1e-9
    # entering the braking from the speed limit the two slopes meet with a kink: a few per cent
    assert hardest <= braking * 1.05
    assert e < 1e-6


def test_pd_is_the_printed_law(romo, rng: np.random.Generator):
    """(3.23), (3.24) and yaw written down again with vectors; derivatives of the errors by differencing."""
    road, gains = clothoid(), PdGains(feedforward=False)
    law = PdLaw(romo, gains)
    for _ in range(20):
        car = beside(road, rng.uniform(20, 80), rng.uniform(-1, 1), rng.uniform(-0.3, 0.3))
        car = car._replace(v_x=9.0, v_y=rng.uniform(-1, 1), yaw_rate=rng.uniform(-0.5, 0.5))
        at = PathProjection(road).update(car, DT)

        def errors(h, car=car, at=at):
            c, s = math.cos(car.psi), math.sin(car.psi)
            x, y = car.x + h * (car.v_x * c - car.v_y * s), car.y + h * (car.v_x * s + car.v_y * c)
            psi, p = car.psi + h * car.yaw_rate, road.point(at.s + h * at.sdot)
            return np.array([-(p.x - x) * math.sin(psi) + (p.y - y) * math.cos(psi), p.psi - psi])

        value, rate = errors(0.0), (errors(1e-5) - errors(-1e-5)) / 2e-5
        demand = law.demand(car, at, DT)
        kappa, sharpness = at.point.kappa, 5e-4
        assert demand.a_y == pytest.approx(kappa * 81.0 + gains.k_py * value[0] + gains.k_dy * rate[0], abs=1e-4)
        assert demand.yaw_acceleration == pytest.approx(sharpness * 81.0 + gains.k_ppsi * value[1] + gains.k_dpsi * rate[1], abs=1e-3)
        assert demand.a_x == pytest.approx(gains.k_px * (10.0 - 9.0) - gains.k_dx * car.yaw_rate * car.v_y, abs=1e-9)


# -- integral action -----------------------------------------------------------------------------------------------------------------


def test_what_the_model_does_not_know_leaves_no_offset(romo):
    road = straight(300.0, 10.0)
    run = drive(Follower(road, romo), beside(road, 1.0), romo, 15.0, push=(-0.5, 0.6, 0.2))
    assert abs(run.e_y[-1]) < 1e-3
    assert abs(run.e_psi[-1]) < 1e-3
    assert run.v[-1] == pytest.approx(10.0, abs=1e-2)
    without = drive(Follower(road, romo, gains=LinearisingGains(integral=0.0)), beside(road, 1.0), romo, 15.0, push=(0.0, 0.6, 0.0))
    assert without.e_y[-1] == pytest.approx(0.6 / (1.6 * 3.2), rel=0.02)  # what the poles leave


def test_a_saturated_allocator_winds_nothing_up(romo):
    road = straight(400.0, 10.0)
    run = drive(Follower(road, romo), beside(road, 1.0, 2.0, v=0.0), romo, 20.0, most=0.8)
    assert run.e_y.min() > -0.02
    assert run.v.max() < 10.05
    assert abs(run.e_y[-1]) < 1e-3


def test_without_being_told_the_same_saturation_does_wind_up(romo):
    """The call of `achieved` is what does it."""
    road = straight(400.0, 10.0)
    follower = Follower(road, romo)
    follower.achieved = lambda given: None
    told, untold = drive(Follower(road, romo), beside(road, 1.0, v=0.0), romo, 8.0, most=0.8), None
    untold = drive(follower, beside(road, 1.0, v=0.0), romo, 25.0, most=0.8)
    assert told.v.max() < 10.05
    assert untold.v.max() > told.v.max() + 0.02


def test_a_car_that_faces_backwards_turns_without_reversing_far(romo):
    road = straight(400.0, 10.0)
    run = drive(Follower(road, romo), beside(road, 150.0, 3.0, 3.0, v=3.0), romo, 15.0)
    assert abs(run.e_psi[-1]) < 0.01
    assert abs(run.e_y[-1]) < 0.05
    assert run.v[-1] == pytest.approx(10.0, abs=0.1)
