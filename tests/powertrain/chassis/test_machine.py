"""The machine: order of the integrator, integrals, batches, machine code, the adaptive reference."""

import numpy as np
import pytest

from powertrain import VehicleError, load_vehicle
from powertrain.chassis import DoubleTrack, Machine, compiled

from ...timing import least_time


class Oscillator:
    """x'' = -x + u."""

    states = ("x", "v")
    inputs = ("u",)

    def derivative(self, x, u):
        return [x[1], u[0] - x[0]]


def test_one_step_has_the_local_error_of_fourth_order():
    for dt in (0.1, 0.05):
        x = Machine(Oscillator(), dt).step([1.0, 0.0], [0.0])
        assert abs(x[0] - np.cos(dt)) < dt**6 / 500.0
        assert abs(x[1] + np.sin(dt)) < dt**5 / 100.0


def test_substeps_are_steps():
    one, many = Machine(Oscillator(), 0.05), Machine(Oscillator(), 0.2, substeps=4)
    x = np.array([1.0, 0.3])
    for _ in range(4):
        x = one.step(x, [0.2])
    assert many.step([1.0, 0.3], [0.2]) == pytest.approx(x, abs=1e-15)
    assert many.batch(np.array([[1.0, 2.0], [0.3, 0.1]]), [0.2])[:, 0] == pytest.approx(x, abs=1e-14)


def test_integrals_are_those_of_the_trajectory():
    """Integral of v is the change of x, to rounding; that of x^2 by closed form."""
    machine = Machine(Oscillator(), 0.01, integrands=lambda x, u: [x[1], x[0] * x[0]])
    x, total = np.array([1.0, 0.0]), np.zeros(2)
    for _ in range(100):
        x = machine.step(x, [0.0])
        total += machine.integrals
    assert total[0] == pytest.approx(x[0] - 1.0, abs=1e-14)
    assert total[1] == pytest.approx(0.5 + 0.25 * np.sin(2.0), abs=1e-9)


def test_the_reference_is_the_closed_form():
    assert Machine(Oscillator(), 0.1).reference([1.0, 0.0], [0.0], 5.0) == pytest.approx([np.cos(5.0), -np.sin(5.0)], abs=1e-7)


def test_a_step_neither_keeps_nor_changes_what_it_was_given():
    machine = Machine(Oscillator(), 0.1)
    x, u = np.array([1.0, 0.0]), np.array([0.5])
    first = machine.step(x, u)
    machine.step(first, [7.0])
    assert np.array_equal(x, [1.0, 0.0])
    assert np.array_equal(u, [0.5])
    assert np.array_equal(first, machine.step(x, u))


def has_compiler() -> bool:
    try:
        compiled.compiler()
    except VehicleError:
        return False
    return True


@pytest.mark.skipif(not has_compiler(), reason="no C compiler here; none is needed to use the package")
def test_machine_code_gives_the_interpreted_step():
    plant = DoubleTrack(load_vehicle("romo"))
    machine = Machine(plant, 1e-3)
    rng = np.random.default_rng(2)
    many = np.array(plant.initial(12.0))[:, None] + 0.01 * rng.standard_normal((len(plant.states), 333))
    u = np.array(plant.command(torque_cmd=30.0, brake_cmd=5.0, steer_cmd_fl=0.03, grade=0.02))
    expected = np.array([machine.step(many[:, k], u) for k in range(333)]).T
    machine.compile_c()
    assert machine.step(many[:, 5], u) == pytest.approx(expected[:, 5], rel=1e-11, abs=1e-12)
    assert machine.batch(many, u) == pytest.approx(expected, rel=1e-11, abs=1e-12)


@pytest.mark.timing
@pytest.mark.skipif(not has_compiler(), reason="no C compiler here; none is needed to use the package")
def test_batches_in_machine_code_are_fast():
    plant = DoubleTrack(load_vehicle("romo"))
    machine = Machine(plant, 1e-3)
    many, u = np.tile(np.array(plant.initial(12.0))[:, None], 333), np.array(plant.command(torque_cmd=30.0))
    interpreted = least_time(lambda: [machine.step(many[:, k], u) for k in range(333)], rounds=7)
    machine.compile_c()
    # asked for: 20 times per car, which the benchmark measures; here a bound that a busy machine keeps
    assert interpreted > 6.0 * least_time(lambda: [machine.batch(many, u) for _ in range(10)], rounds=7) / 10.0


def test_a_missing_compiler_is_said(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(compiled.shutil, "which", lambda name: None)
    with pytest.raises(VehicleError, match="no C compiler"):
        Machine(Oscillator(), 0.1).compile_c()


def test_unknown_words_are_refused():
    with pytest.raises(ValueError, match="expected step or derivative"):
        Machine(Oscillator(), 0.1).jacobian([0.0, 0.0], [0.0], of="output")
