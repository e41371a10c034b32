import numpy as np
import pytest

from powertrain import VehicleError
from powertrain.sensors import BASE_CLOCK, TABLE_C2, Gnss, GnssDescription, Sensor, SensorBank


def test_table_c2_is_the_published_one():
    assert len(TABLE_C2) == 16
    assert TABLE_C2["oxts_v_x"] == Sensor(-1.183700305488312e-3, 1.214962752669004e-2, 0.016)
    # printed in mm
    assert TABLE_C2["wheel_travel"].bias == pytest.approx(3.372870728583747e-4)
    assert all(sensor.delay_s % BASE_CLOCK == pytest.approx(0.0, abs=1e-12) or sensor.delay_s in (0.016, 0.024) for sensor in TABLE_C2.values())


def test_sensors_report_with_bias_noise_and_delay(rng: np.random.Generator):
    """Mean, deviation and delay of 40,000 samples of a ramp."""
    bank = SensorBank({"v": TABLE_C2["correvit_v_x"]}, rng)
    t = BASE_CLOCK * np.arange(40_000)
    report = np.array([bank.sample({"v": float(time)})["v"] for time in t])
    assert np.all(np.isnan(report[:6]))
    error = report[6:] - (t[6:] - 0.024)
    sensor = TABLE_C2["correvit_v_x"]
    assert np.mean(error) == pytest.approx(sensor.bias, abs=4.0 * sensor.deviation / np.sqrt(len(error)))
    assert np.std(error) == pytest.approx(sensor.deviation, rel=0.02)


def test_the_same_seed_gives_the_same_noise():
    runs = []
    for _ in range(2):
        bank = SensorBank(TABLE_C2, np.random.default_rng(3))
        runs.append([bank.sample(dict.fromkeys(TABLE_C2, 1.0)) for _ in range(10)])
    assert repr(runs[0]) == repr(runs[1])


def test_fixes_come_late_out_of_order_and_not_during_outages(rng: np.random.Generator):
    receiver = Gnss(GnssDescription(period_s=0.2, delay_s=0.3, jitter_s=0.2, deviation_m=0.5, outages_s=((4.0, 6.0),)), rng)
    fixes = []
    for k in range(25_000):
        t = 0.004 * k
        for fix in receiver.step(t, 3.0 * t, -t):
            assert fix.arrival <= t + 1e-9
            fixes.append(fix)
    times = np.array([fix.time for fix in fixes])
    assert not np.any((times >= 4.0) & (times < 6.0))
    assert np.any(np.diff(times) < 0.0)
    assert np.all(np.diff([fix.arrival for fix in fixes]) >= 0.0)
    assert sorted(times)[:20] == pytest.approx(0.2 * np.arange(20), abs=1e-9)
    late = np.array([fix.arrival - fix.time for fix in fixes])
    assert np.min(late) >= 0.3
    assert np.mean(late) == pytest.approx(0.5, abs=0.05)
    assert np.std([fix.x - 3.0 * fix.time for fix in fixes]) == pytest.approx(0.5, rel=0.15)


BAD = [
    (lambda: Sensor(0.0, -1.0, 0.0), "neither deviation nor delay below zero"),
    (lambda: Sensor(float("nan"), 1.0, 0.0), "expected finite numbers"),
    (lambda: GnssDescription(period_s=0.0), "expected a positive period"),
    (lambda: GnssDescription(outages_s=((3.0, 2.0),)), "expected it to end after it begins"),
    (lambda: SensorBank({"v": Sensor(0.0, 0.0, 0.005)}, np.random.default_rng(0)), r"delay 0\.005 s, expected a multiple"),
]


@pytest.mark.parametrize(("make", "words"), BAD)
def test_descriptions_that_are_no_sensor_are_refused(make, words: str):
    with pytest.raises(VehicleError, match=words):
        make()


def test_a_missing_signal_is_named(rng: np.random.Generator):
    with pytest.raises(VehicleError, match="no value for correvit_v_x, .*expected one for each of oxts_a_x"):
        SensorBank(TABLE_C2, rng).sample({})
