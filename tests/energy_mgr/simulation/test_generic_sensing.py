"""Sensors of an odd car in motion: each signal with its own bias and delay, each wheel with its own spin, the battery with all of its cells."""

import numpy as np
import pytest

from energy_mgr.simulation.sensing import IdealSensing, RealSensing
from powertrain import Plant
from powertrain.chassis.double_track import WHEELS
from powertrain.sensors import TABLE_C2
from tests.odd_cars import ODD


@pytest.mark.parametrize("name", ODD)
def test_each_signal_has_its_own_truth_bias_and_delay(name: str):
    plant = Plant(ODD[name], speed=12.0, soc=0.6)
    ideal, real = IdealSensing(plant), RealSensing(plant, np.random.default_rng(91))
    steer = {f"steer_cmd_{wheel}": 0.02 + 0.01 * k for k, wheel in enumerate(plant.body.steered)}
    torques = {f"torque_cmd_{motor}": 40.0 + 15.0 * k for k, motor in enumerate(plant.body.motors)}
    u, rows = plant.body.command(**steer, **torques, bank=0.05), []
    for k in range(250):
        t, a = plant.time, (0.3 + 0.01 * k, -0.8 + 0.02 * k)
        rows.append((ideal.measure(t, plant, *a, 0.7), real.measure(t, plant, *a, 0.7)))
        plant.advance(u, 4)
    true, found = ([row[k] for row in rows] for k in (0, 1))
    state = dict(zip(plant.body.states, plant.state, strict=True))
    assert true[-1].friction == 0.7
    assert found[-1].friction == 1.0
    for signal, source in {"v_x": "oxts_v_x", "v_y": "oxts_v_y", "a_x": "oxts_a_x", "a_y": "oxts_a_y"}.items():
        sensor = TABLE_C2[source]
        off = np.array([getattr(m, signal) for m in found[20:]]) - [getattr(m, signal) for m in true[16:-4]]
        # four ticks late; means of 230 noises: 5 standard deviations
        assert np.mean(off) == pytest.approx(sensor.bias, abs=5.0 * sensor.deviation / 15.0), signal
        assert np.std(off) == pytest.approx(sensor.deviation, rel=0.25)
    for k, wheel in enumerate(WHEELS):
        sensor = TABLE_C2["wheel_speed"]
        off = np.array([m.wheel_speeds[k] for m in found[20:]]) - [m.wheel_speeds[k] for m in true[19:-1]]
        assert np.mean(off) == pytest.approx(sensor.bias, abs=5.0 * sensor.deviation / 15.0)
        assert true[-1].wheel_speeds[k] == pytest.approx(state[f"omega_{wheel}"], rel=0.01)
    # each place and heading is that of the time told with it, and two centimetres and three milliradians are the receiver's noise
    for m in found[20:]:
        then = true[round(m.pose_time / 0.004)]
        assert np.hypot(m.x - then.x, m.y - then.y) < 0.12
        assert m.psi == pytest.approx(then.psi, abs=0.02)
        assert 0.2 - 1e-9 <= m.t - m.pose_time < 0.41 or m.pose_time == 0.0
    for m in (true[-1], found[-1]):
        assert list(m.torques) == pytest.approx([state[f"torque_{motor}"] for motor in plant.body.motors], rel=0.01)
        assert list(m.angles) == pytest.approx([state[f"delta_{wheel}"] for wheel in plant.body.steered], rel=0.01)


@pytest.mark.parametrize("name", ODD)
def test_the_battery_is_believed_to_take_and_give_what_its_limits_make_of_all_cells(name: str):
    """Cells at rest, half full: their peak current at their open voltage, all of them together, but for what resistance and filters change of it."""
    plant = Plant(ODD[name], soc=0.6)
    m, pack, limits = IdealSensing(plant).measure(0.0, plant, 0.0, 0.0, 1.0), plant.pack, plant.pack.cell.limits
    cells = ODD[name].battery.series * ODD[name].battery.parallel
    open_voltage = float(np.asarray(pack.cell.ocv_v(0.6, 298.15)))
    assert m.power_max / (cells * limits.discharge_peak_a * open_voltage) == pytest.approx(1.0, abs=0.25)
    assert -m.power_min / (cells * limits.charge_peak_a * open_voltage) == pytest.approx(1.0, abs=0.25)
