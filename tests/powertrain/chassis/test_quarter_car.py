"""Quarter car against the closed forms of the linear two-mass oscillator, and its energy."""

import numpy as np
import pytest

from powertrain.chassis import Machine, QuarterCar

CAR = QuarterCar()
LINEAR = QuarterCar(friction_n=0.0)


def matrix(car: QuarterCar, damping: float) -> np.ndarray:
    """The linear system over (z_w, v_w, z_b, v_b), from the textbook."""
    i2 = car.rocker_ratio**2
    k, d, kt, dt, mw, mb = car.spring_npm * i2, damping * i2, car.tyre_npm, car.tyre_nspm, car.wheel_mass_kg, car.body_mass_kg
    return np.array([[0, 1, 0, 0], [-(k + kt) / mw, -(d + dt) / mw, k / mw, d / mw], [0, 0, 0, 1], [k / mb, d / mb, -k / mb, -d / mb]])


def test_eigenvalues_are_those_of_the_two_mass_oscillator():
    machine = Machine(LINEAR, 1e-3)
    by_x, _ = machine.jacobian(np.zeros(5), [0.0, 0.0], of="derivative")
    found = np.sort_complex(np.linalg.eigvals(by_x[:4, :4]))
    assert found == pytest.approx(np.sort_complex(np.linalg.eigvals(matrix(LINEAR, LINEAR.damper_soft_nspm))), rel=1e-9)
    # body near 1.3 Hz, wheel near 10 Hz
    hertz = np.sort(np.abs(found.imag))[[0, 3]] / (2.0 * np.pi)
    assert 1.0 < hertz[0] < 1.8
    assert 8.0 < hertz[1] < 13.0


def test_frequency_response_is_the_closed_form():
    """Body acceleration over road height at 3 Hz from a long run, against (i w - A)^-1."""
    w, dt = 2.0 * np.pi * 3.0, 1e-3
    machine = Machine(LINEAR, dt)
    x, rows = np.zeros(5), []
    for k in range(12_000):
        t = k * dt
        # the shaping filter is driven such that the road is a sine: z_r' = w cos(w t)
        u = [0.3, 0.01 * (w * np.cos(w * (t + 0.5 * dt)) + LINEAR.road_pole_radps * np.sin(w * (t + 0.5 * dt)))]
        x = machine.step(x, u)
        rows.append(LINEAR.output(x, u)[0])
    damping = 0.7 * LINEAR.damper_soft_nspm + 0.3 * LINEAR.damper_hard_nspm
    system = matrix(LINEAR, damping)
    drive = np.array([0.0, (LINEAR.tyre_npm + 1j * w * LINEAR.tyre_nspm) / LINEAR.wheel_mass_kg, 0.0, 0.0])
    response = np.linalg.solve(1j * w * np.eye(4) - system, drive)
    amplitude = 0.5 * np.ptp(rows[-2000:])
    assert amplitude == pytest.approx(0.01 * abs(1j * w * response[3]), rel=5e-3)


def test_energy_only_falls_on_a_level_road():
    machine, x = Machine(CAR, 1e-3), np.array([0.0, 0.0, 0.05, 0.0, 0.0])

    def energy(x) -> float:
        spring = CAR.spring_npm * CAR.rocker_ratio**2 * (x[2] - x[0]) ** 2 + CAR.tyre_npm * x[0] ** 2
        return 0.5 * (spring + CAR.wheel_mass_kg * x[1] ** 2 + CAR.body_mass_kg * x[3] ** 2)

    last = energy(x)
    for _ in range(4000):
        x = machine.step(x, [0.0, 0.0])
        assert energy(x) <= last + 1e-9
        last = energy(x)
    assert last < 1e-3


def test_static_contact_force_is_the_weight():
    assert CAR.output([0.0] * 5, [0.0, 0.0])[3] == pytest.approx((202.6 + 50.65) * 9.81)


def test_harder_damping_calms_the_wheel_and_friction_opposes_motion():
    ring = []
    for setting in (0.0, 1.0):
        machine, x = Machine(LINEAR, 1e-3), np.array([0.01, 0.0, 0.0, 0.0, 0.0])
        for _ in range(300):
            x = machine.step(x, [setting, 0.0])
        ring.append(abs(x[0]) + abs(x[1]) / 60.0)
    assert ring[1] < ring[0]
    assert CAR.derivative([0.0, 0.0, 0.0, 1.0, 0.0], [0.0, 0.0])[3] < LINEAR.derivative([0.0, 0.0, 0.0, 1.0, 0.0], [0.0, 0.0])[3]
