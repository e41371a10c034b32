"""Allocation for odd cars in random situations: forces, motion and its slopes, limits and power, each against the car written a second time."""

import numpy as np
import pytest

from energy_mgr.allocation import ALLOCATORS, Faults
from energy_mgr.allocation.effectiveness import Effectiveness, Model
from tests.energy_mgr.allocation.rig import Car, led, random_faults, random_situation
from tests.energy_mgr.allocation.test_random_situations import MET, assert_inside, assert_rows_kept
from tests.odd_cars import ODD

CARS = pytest.mark.parametrize("name", ODD)


@CARS
def test_motion_and_its_slopes_are_those_of_the_wheels_put_together_anew(name: str):
    car, rng = Car(ODD[name]), np.random.default_rng(81)
    effect = Effectiveness(car.layout)
    for _ in range(60):
        now = random_situation(rng, car)
        state = np.array(now.state[3:])
        b, B = effect(now.before, state)
        assert b == pytest.approx(car.motion(now.before, state), rel=1e-9, abs=1e-9)
        scale = car.layout.scale
        slopes = car.jacobian(now.before, state) * scale
        # central differences of steps of 1e-5 of the scale, whose cubic part is least
        assert pytest.approx(slopes, abs=1e-5 * (1.0 + np.max(np.abs(slopes)))) == B * scale


@CARS
def test_loads_spins_and_moments_of_single_wheels_are_their_own(name: str):
    """Wheel by wheel what the sum hides: load, speed, spin, slip angle and stiffness at the wheel's own place."""
    car, rng = Car(ODD[name]), np.random.default_rng(82)
    model = Model(car.layout)
    for _ in range(60):
        now = random_situation(rng, car)
        state = now.state[3:]
        for k, (wheel, mine) in enumerate(zip(model.wheels(now.before, state), car.wheels(now.before, state), strict=True)):
            along, side, _, alpha, load, speed, spin = mine
            tyre = car.tyres[k]
            aligning = float(tyre.forces(along / tyre.slip_stiffness(load), alpha, load, friction=state[5]).aligning)
            expected = (along, side, alpha, load, speed, spin, float(tyre.slip_stiffness(load)), aligning)
            found = (wheel.along, wheel.side, wheel.alpha, wheel.load, wheel.speed, wheel.spin, wheel.stiffness, wheel.aligning)
            assert [float(value) for value in found] == pytest.approx(expected, rel=1e-9, abs=1e-9)


@CARS
def test_what_commands_may_follow_is_bounded_wheel_by_wheel_with_faults(name: str):
    car, rng = Car(ODD[name]), np.random.default_rng(83)
    for _ in range(200):
        spins, faults = [rng.uniform(-60.0, 130.0) for _ in range(4)], random_faults(rng, car.layout)
        before = rng.uniform(-1.0, 1.0, car.layout.size) * car.layout.upper
        before[car.layout.brakes] = np.abs(before[car.layout.brakes])
        dt = float(rng.choice([0.004, 0.02, 0.3]))
        low, high = car.layout.box(before.tolist(), spins, dt, car.layout.packed(faults).tolist())
        least, most = car.box(before, spins, faults, dt)
        assert low == pytest.approx(least, rel=1e-12, abs=1e-12)
        assert high == pytest.approx(most, rel=1e-12, abs=1e-12)


@CARS
def test_answers_keep_limits_grip_and_battery_and_tell_what_the_tyres_will_give(name: str):
    car, rng = Car(ODD[name]), np.random.default_rng(84)
    allocator = ALLOCATORS["efficient"](car.vehicle)
    asked = 3 if len(car.layout.steered) == 4 else 2
    for k in range(100):
        now = random_situation(rng, car)
        found = allocator.allocate(now)
        assert found.status in ("solved", "limited")
        assert_inside(car, now, found.command)
        if k % 2 == 0:
            assert_rows_kept(car, now, found.command)
        # `given` is the line through the present commands, in the state when the steering will have turned
        state = led(car, now)
        line = car.motion(now.before, state) + car.jacobian(now.before, state) @ (found.command - now.before)
        assert list(found.given) == pytest.approx(line, abs=1e-4 * (1.0 + np.max(np.abs(line))))
        missed = max(abs(a - b) for a, b in list(zip(found.given, now.demand, strict=True))[:asked])
        assert (found.status == "limited") == (missed > MET)


@CARS
def test_a_car_mirrored_left_and_right_is_allocated_the_mirrored_commands(name: str):
    car, rng = Car(ODD[name]), np.random.default_rng(85)
    layout, n = car.layout, car.layout.size
    motors = {"1": "2", "2": "1", "3": "4", "4": "3"} if layout.motors == 4 else {"1": "1"}
    swap = {"fl": "fr", "fr": "fl", "rl": "rr", "rr": "rl"} | motors
    other = [layout.names.index(f"{label[: label.rindex('_')]}_{swap[label[label.rindex('_') + 1 :]]}") for label in layout.names]
    sign = np.where(np.arange(n) >= layout.steers.start, -1.0, 1.0)
    one, two = (ALLOCATORS["efficient"](car.vehicle) for _ in range(2))
    for _ in range(40):
        now = random_situation(rng, car)._replace(faults=Faults())
        v = now.state
        state = v._replace(v_y=-v.v_y, yaw_rate=-v.yaw_rate, a_y=-v.a_y)
        demand = now.demand._replace(a_y=-now.demand.a_y, yaw_acceleration=-now.demand.yaw_acceleration)
        spins = [now.wheel_speeds[k] for k in (1, 0, 3, 2)]
        there = one.allocate(now)
        here = two.allocate(now._replace(state=state, demand=demand, before=sign * now.before[other], wheel_speeds=spins))
        # the solver is right to 1e-6 of each command's scale
        assert sign * here.command[other] / layout.scale == pytest.approx(there.command / layout.scale, abs=1e-4)
