import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from powertrain import Vehicle, force_limits, load_vehicle, motor_losses
from powertrain.energy.motor import copper_factor, inverter_factor

ROMO = load_vehicle("romo")


def test_derived_constants_are_those_of_the_specification(romo: Vehicle):
    assert inverter_factor(romo) == pytest.approx(1.68491, abs=5e-6)
    assert copper_factor(romo) == pytest.approx(0.0291952, abs=5e-8)


@pytest.mark.parametrize(
    ("kmh", "torque", "loss", "efficiency"), [(50, 20, 136, 0.882), (50, 40, 205, 0.908), (50, 160, 1108, 0.880), (100, 160, 1118, 0.936)]
)
def test_losses_and_efficiency_are_the_hand_values_of_the_specification(romo: Vehicle, kmh: float, torque: float, loss: float, efficiency: float):
    speed = kmh / 3.6 * romo.motor_ratio
    found = sum(motor_losses(romo, torque, speed))
    assert found == pytest.approx(loss, abs=0.5)
    assert torque * speed / (torque * speed + found) == pytest.approx(efficiency, abs=5e-4)


@given(torque=st.floats(-160, 160), speed=st.floats(0, 110))
def test_losses_are_never_negative_and_the_same_for_driving_and_braking(torque: float, speed: float):
    losses = motor_losses(ROMO, torque, speed)
    assert min(losses) >= 0.0
    assert losses == motor_losses(ROMO, -torque, speed)


def test_the_same_line_serves_numbers_arrays_and_symbols(romo: Vehicle):
    torque, speed = ca.SX.sym("torque"), ca.SX.sym("speed")
    symbolic = ca.Function("loss", [torque, speed], [sum(motor_losses(romo, torque, speed))])
    torques, speeds = np.array([-100.0, 0.0, 35.0]), np.array([90.0, 10.0, 0.0])
    numeric = sum(motor_losses(romo, torques, speeds))
    for k in range(3):
        assert float(symbolic(torques[k], speeds[k])) == pytest.approx(numeric[k])


def test_force_limits_follow_torque_then_power(romo: Vehicle):
    drive, regen = force_limits(romo, np.array([0.0, 10.0, 27.0, 27.7]))
    assert drive[0] == pytest.approx(4 * 160 / 0.27365)
    assert np.array_equal(drive, regen)
    assert drive[1] == drive[0]
    assert drive[3] == pytest.approx(4 * 16000 / 27.7)
    for v, force in zip((0.0, 10.0, 27.0, 27.7), drive, strict=True):
        assert force_limits(romo, v) == (pytest.approx(force), pytest.approx(force))
