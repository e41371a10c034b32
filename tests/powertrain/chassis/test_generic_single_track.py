"""The ESTM of odd cars at random states: Newton's and Euler's equations of two wheels on a stick, with complex numbers."""

import cmath
import math

import numpy as np
import pytest

from powertrain.chassis.single_track import SingleTrack
from tests.odd_cars import ODD


@pytest.mark.parametrize("name", ODD)
def test_motion_changes_by_the_forces_of_both_axles(name: str):
    car, rng = ODD[name], np.random.default_rng(64)
    # so slow a lower bound of the speed that it adds 1e-12 of it to the slip angles
    model, (front, rear), b, r = SingleTrack(car, v_min=1e-5), car.tyres(), car.body, car.resistance
    mass, radius, base = car.chassis.mass_kg, car.chassis.wheel_radius_m, b.front_axle_m + b.rear_axle_m
    for _ in range(200):
        beta, v, turn, psi = rng.uniform(-0.2, 0.2), rng.uniform(5.0, 30.0), rng.uniform(-0.5, 0.5), rng.uniform(-3.0, 3.0)
        torques, angles = rng.uniform(-150.0, 250.0, 4), rng.uniform(-0.15, 0.15, 2)
        velocity, speed = cmath.rect(v, beta), v * 3.6 / 100
        rolling = r.rolling_0 + r.rolling_1 * speed + r.rolling_4 * speed**4
        total, moment = -0.5 * r.air_density_kgpm3 * r.drag_coefficient * r.frontal_area_m2 * v**2 + 0j, 0.0
        axles = ((front, b.front_axle_m, b.rear_axle_m, torques[:2]), (rear, -b.rear_axle_m, b.front_axle_m, torques[2:]))
        for (tyre, arm, other, pair), angle in zip(axles, angles, strict=True):
            load = mass * 9.81 * other / base
            course = cmath.phase(velocity + 1j * turn * arm)
            side = 2.0 * float(tyre.forces(0.0, angle - course, load / 2).lateral)
            force = complex(sum(pair) / radius - rolling * load, side) * cmath.rect(1.0, angle)
            total, moment = total + force, moment + arm * force.imag
        # along and across the velocity itself
        gained = total / mass * cmath.rect(1.0, -beta)
        expected = [gained.imag / v - turn, gained.real, moment / b.yaw_inertia_kgm2, turn, v * math.cos(psi + beta), v * math.sin(psi + beta)]
        found = model.derivative([beta, v, turn, psi, 3.0, 4.0], [*torques, *angles])
        assert [float(value) for value in found] == pytest.approx(expected, rel=1e-9, abs=1e-9)
