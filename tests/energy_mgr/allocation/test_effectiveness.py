"""Which motion the commands give, against closed forms, differences and mirrors."""

import math

import numpy as np
import pytest

from energy_mgr import PlanningError
from energy_mgr.allocation import Effectiveness
from powertrain import load_vehicle, shipped
from tests.energy_mgr.allocation.rig import Car, random_state

CARS = pytest.mark.parametrize("name", shipped())


def commands(rng, car):
    layout = car.layout
    u = layout.lower + rng.random(layout.size) * (layout.upper - layout.lower)
    u[layout.steers] *= 0.4
    return u


@CARS
def test_the_columns_of_linear_tyres_are_those_of_the_specification(rng, name):
    """A1m: columns (dF_x/m, dF_y/m, (X dF_y - Y dF_x)/J_z) with the derivatives written out."""
    car = Car(load_vehicle(name), "linear")
    run, layout, J = Effectiveness(car.layout, "linear"), car.layout, car.body.yaw_inertia_kgm2
    for _ in range(50):
        u, x = commands(rng, car), random_state(rng)[3:]
        expected = np.zeros((3, layout.size))
        for k, (along, side, d, *_) in enumerate(car.wheels(u, x)):

            def column(fx, fy, k=k):
                return np.array([fx / car.mass, fy / car.mass, (car.X[k] * fy - car.Y[k] * fx) / J])

            by_force = column(math.cos(d) / car.radius, math.sin(d) / car.radius)
            expected[:, layout.brakes.start + k] = -by_force
            if car.motor_of_wheel[k] is not None:
                expected[:, car.motor_of_wheel[k]] += car.share * by_force
            if k in layout.steered:
                c = float(car.tyres[k].cornering_stiffness(car.loads(0.0, 0.0)[k]))
                turned = column(
                    -along * math.sin(d) - side * math.cos(d) - c * math.sin(d), along * math.cos(d) - side * math.sin(d) + c * math.cos(d)
                )
                expected[:, layout.steers.start + layout.steered.index(k)] = turned
        b, B = run(u, x)
        assert b == pytest.approx(car.motion(u, x), rel=1e-9, abs=1e-9)
        assert pytest.approx(expected, rel=1e-9, abs=1e-9) == B


@CARS
@pytest.mark.parametrize("tyre", ["load", "own"])
def test_the_jacobian_is_the_limit_of_differences(rng, name, tyre):
    car = Car(load_vehicle(name), tyre)
    run, scale = Effectiveness(car.layout, tyre), car.layout.scale
    for _ in range(30):
        u, x = commands(rng, car), random_state(rng)[3:]
        b, B = run(u, x)
        steps = 1e-4 * np.diag(scale)
        differences = np.array([(run(u + h, x)[0] - run(u - h, x)[0]) / (2 * h.max()) for h in steps]).T
        assert np.max(np.abs(differences - B) * scale) < 2e-5 * max(1.0, float(np.max(np.abs(B) * scale)))
        assert np.all(np.isfinite(b))


@CARS
def test_the_own_tyre_is_that_of_the_vehicle(rng, name):
    car = Car(load_vehicle(name))
    run = Effectiveness(car.layout, "own")
    for _ in range(30):
        u, x = commands(rng, car), random_state(rng)[3:]
        b, B = run(u, x)
        assert b == pytest.approx(car.motion(u, x), rel=1e-7, abs=1e-7)
        assert pytest.approx(car.jacobian(u, x) * car.layout.scale, rel=2e-4, abs=2e-4) == B * car.layout.scale


@CARS
def test_load_dependent_tyres_follow_the_load_as_the_own_ones_do_at_small_slip(name):
    """In a steady bend at rest-of-slip: slope of the lateral force over the steering angle at the loads of that bend."""
    car = Car(load_vehicle(name))
    x, u = (15.0, 0.0, 0.0, 0.0, 2.0, 1.0), np.zeros(car.layout.size)
    linear, load, own = (Effectiveness(car.layout, kind)(u, x)[1][1, car.layout.steers] for kind in ("linear", "load", "own"))
    # the load moves by a fifth: what is left between `load` and `own` is of second order
    assert np.max(np.abs(load / own - 1.0)) < 0.02
    assert np.max(np.abs(load / own - 1.0)) <= np.max(np.abs(linear / own - 1.0)) + 1e-12


@CARS
@pytest.mark.parametrize("tyre", ["linear", "load", "own"])
def test_nothing_fails_at_and_around_standstill(rng, name, tyre):
    car = Car(load_vehicle(name))
    run = Effectiveness(car.layout, tyre)
    for v in (0.0, 1e-300, 1e-9, 1e-3, 0.1, 1.0, -0.5):
        for side in (0.0, 0.05):
            b, B = run(commands(rng, car), (v, side, 0.02 * side, 0.0, 0.0, 1.0))
            assert np.all(np.isfinite(b))
            assert np.all(np.isfinite(B))
            # a wheel's angle never has more effect than the stiffest tyre allows, and always one
            column = np.abs(B[1, car.layout.steers])
            assert np.all(column < 300.0)


@CARS
@pytest.mark.parametrize("tyre", ["linear", "load", "own"])
def test_the_mirrored_car_moves_in_the_mirror(rng, name, tyre):
    car = Car(load_vehicle(name))
    layout, run = car.layout, Effectiveness(car.layout, tyre)
    names = list(layout.names)
    swap = {"fl": "fr", "fr": "fl", "rl": "rr", "rr": "rl"}
    order, sign = [], np.ones(layout.size)
    for k, own in enumerate(names):
        if own.startswith("torque"):
            wheels = [w for w in range(4) if car.motor_of_wheel[w] == k]
            order.append(k if len(wheels) == 2 else car.motor_of_wheel[wheels[0] ^ 1])
        else:
            order.append(names.index(own[:-2] + swap[own[-2:]]))
            sign[k] = -1.0 if own.startswith("steer") else 1.0
    flip = np.array([1.0, -1.0, -1.0])
    for _ in range(20):
        u, x = commands(rng, car), random_state(rng)[3:]
        b, B = run(u, x)
        mirrored_b, mirrored_B = run(sign * u[order], (x[0], -x[1], -x[2], x[3], -x[4], x[5]))
        assert mirrored_b == pytest.approx(flip * b, rel=1e-9, abs=1e-9)
        assert mirrored_B == pytest.approx(flip[:, None] * B[:, order] * sign, rel=1e-8, abs=1e-9)


def test_a_tyre_of_another_name_is_refused(romo):
    with pytest.raises(PlanningError, match=r"tyre of the allocation 'rubber', expected linear, load or own"):
        Effectiveness(Car(romo).layout, "rubber")  # type: ignore[arg-type]
