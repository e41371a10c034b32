"""The plant in the machine: steps against the adaptive reference, batches, derivatives."""

import numpy as np
import pytest

from powertrain import Vehicle
from powertrain.chassis import Machine

from .rig import MACHINE, PLANT, settle


def test_fixed_step_agrees_with_the_adaptive_reference():
    """A step steer of all wheels while accelerating; RK4 of 1 ms against CVODES at 1e-11."""
    u = PLANT.command(torque_cmd=60.0, steer_cmd_fl=0.04, steer_cmd_fr=0.04, steer_cmd_rl=-0.02, steer_cmd_rr=-0.02)
    x = settle(PLANT, MACHINE, PLANT.initial(12.0), u, 1.0)
    reference = MACHINE.reference(PLANT.initial(12.0), u, 1.0, tolerance=1e-11)
    assert np.max(np.abs(x - reference) / np.maximum(np.abs(reference), 1.0)) < 1e-6


def test_halving_the_step_shrinks_the_error_sixteenfold():
    u = PLANT.command(torque_cmd=30.0, steer_cmd_fl=0.02, steer_cmd_fr=0.02)
    start = PLANT.initial(15.0)
    reference = MACHINE.reference(start, u, 0.4, tolerance=1e-12)
    error = [np.max(np.abs(settle(PLANT, Machine(PLANT, dt), start, u, 0.4) - reference)[:10]) for dt in (2e-3, 1e-3)]
    assert 8.0 < error[0] / error[1] < 32.0


def test_numbers_arrays_and_symbols_give_the_same_derivative():
    rng = np.random.default_rng(3)
    x = np.array(PLANT.initial(10.0))[:, None] + 0.01 * rng.standard_normal((len(PLANT.states), 7))
    u = np.array(PLANT.command(torque_cmd=20.0, brake_cmd=10.0))
    many = np.array(PLANT.derivative(list(x), list(u[:, None] * np.ones((1, 7)))))
    for k in range(7):
        assert MACHINE.derivative(x[:, k], u) == pytest.approx(many[:, k], rel=1e-11, abs=1e-9)


def test_batch_and_single_steps_agree():
    rng = np.random.default_rng(4)
    x = np.array(PLANT.initial(10.0))[:, None] + 0.01 * rng.standard_normal((len(PLANT.states), 5))
    u = np.array(PLANT.command(torque_cmd=20.0))
    after = MACHINE.batch(x, u)
    for k in range(5):
        assert after[:, k] == pytest.approx(MACHINE.step(x[:, k], u), rel=1e-11, abs=1e-11)


def test_jacobians_are_those_of_differences():
    x, u = np.array(PLANT.initial(12.0, v_y=0.3, yaw_rate=0.2)), np.array(PLANT.command(torque_cmd=15.0, steer_cmd_fl=0.01))
    for of, function in (("step", MACHINE.step), ("derivative", MACHINE.derivative)):
        by_x, by_u = MACHINE.jacobian(x, u, of=of)
        for jacobian, where, k in ((by_x, x, 4), (by_x, x, 10), (by_u, u, 0), (by_u, u, 8)):
            up, down = where.copy(), where.copy()
            up[k], down[k] = up[k] + 1e-6, down[k] - 1e-6
            pair = [function(*((p, u) if where is x else (x, p))) for p in (up, down)]
            assert jacobian[:, k] == pytest.approx((pair[0] - pair[1]) / 2e-6, rel=1e-4, abs=1e-4 * (1.0 + np.max(np.abs(jacobian[:, k]))))


def test_batches_of_the_wrong_shape_are_refused(romo: Vehicle):
    from powertrain import VehicleError

    with pytest.raises(VehicleError, match=r"batch of states \(3, 4\).*expected \(42, N\)"):
        MACHINE.batch(np.zeros((3, 4)), np.zeros(15))
    with pytest.raises(VehicleError, match="expected a positive time"):
        Machine(PLANT, 0.0)
