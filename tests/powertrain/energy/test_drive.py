"""Field weakening, layouts, loss maps and temperatures of the traction drive."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from powertrain import Vehicle, VehicleError, load_vehicle, motor_losses
from powertrain.description.sections import Drive, Thermal, Weakening
from powertrain.drive.machine import torque_constant, torque_limits, unreachable, voltage_limited_torque, weakening_current
from powertrain.drive.motor_map import MotorMap, read_map
from powertrain.energy.motor import copper_factor, inverter_factor
from powertrain.energy.thermal import continuous_torque, motor_heat, settled_temperature, temperature_after, temperature_rate
from powertrain.vehicle import SHELF

ROMO = load_vehicle("romo")
WEAK = Weakening(inductance_h=150e-6, current_max_a=400.0, dc_voltage_v=360.0)
FIELD = msgspec.structs.replace(load_vehicle("compact").drive, weakening=WEAK, magnet_flux_wb=0.045)


@pytest.mark.parametrize(
    ("count", "driven", "wheels"),
    [
        (1, "front", (0, 0, None, None)),
        (1, None, (None, None, 0, 0)),
        (2, "all", (0, 0, 1, 1)),
        (2, "front", (0, 1, None, None)),
        (2, "rear", (None, None, 0, 1)),
        (4, None, (0, 1, 2, 3)),
    ],
)
def test_layouts_say_which_motor_drives_which_wheel(romo: Vehicle, count: int, driven: str | None, wheels: tuple[int | None, ...]):
    drive = msgspec.structs.replace(romo.drive, motor_count=count, driven=driven)
    assert drive.motor_of_wheel == wheels
    assert drive.driven_wheels == tuple(motor is not None for motor in wheels)


@pytest.mark.parametrize(("count", "driven"), [(1, "all"), (4, "rear")])
def test_layouts_that_do_not_exist_are_refused(tmp_path: Path, count: int, driven: str):
    file = tmp_path / "car.toml"
    file.write_text((SHELF / "romo.toml").read_text().replace("motor_count = 4", f'motor_count = {count}\ndriven = "{driven}"'))
    with pytest.raises(VehicleError, match=r"car\.toml: drive: .*expected driven = "):
        load_vehicle(file)


def brute_force_torque(drive: Drive, weak: Weakening, speed: float) -> float:
    """Most torque over a fine grid of currents that keep voltage and current limit: the optimisation itself, not its solution."""
    i_d, i_q = np.meshgrid(np.linspace(-weak.current_max_a, 0.0, 1501), np.linspace(0.0, weak.current_max_a, 1501))
    electric = speed * drive.pole_pairs
    voltage = electric * np.hypot(weak.inductance_h * i_q, drive.magnet_flux_wb + weak.inductance_h * i_d)
    good = (voltage <= weak.dc_voltage_v / np.sqrt(3.0)) & (np.hypot(i_d, i_q) <= weak.current_max_a)
    return float(np.max(np.where(good, torque_constant(drive) * i_q, 0.0)))


@pytest.mark.parametrize("inductance", [150e-6, 60e-6])
@pytest.mark.parametrize("speed", [50.0, 400.0, 700.0, 1000.0, 1600.0, 4000.0])
def test_voltage_limited_torque_is_the_optimum_over_currents(speed: float, inductance: float):
    """Base range, field weakening, and (large inductance, high speed) most torque per voltage."""
    weak = msgspec.structs.replace(WEAK, inductance_h=inductance)
    drive = msgspec.structs.replace(FIELD, weakening=weak)
    most = float(voltage_limited_torque(drive, speed))
    assert most == pytest.approx(brute_force_torque(drive, weak, speed), rel=5e-3, abs=0.002 * torque_constant(drive) * weak.current_max_a)


def test_weakening_current_puts_the_voltage_on_its_limit_and_costs_copper_loss():
    speed, torque = 900.0, 60.0
    i_d = float(weakening_current(FIELD, torque, speed))
    assert i_d < 0.0
    flux = np.hypot(WEAK.inductance_h * torque / torque_constant(FIELD), FIELD.magnet_flux_wb + WEAK.inductance_h * i_d)
    assert speed * FIELD.pole_pairs * flux == pytest.approx(WEAK.dc_voltage_v / np.sqrt(3.0), rel=1e-12)
    assert float(weakening_current(FIELD, torque, 300.0)) == 0.0
    compact = load_vehicle("compact")
    plain = msgspec.structs.replace(compact, drive=msgspec.structs.replace(FIELD, weakening=None))
    # the car is refused as a whole where its envelope cannot be reached, so only the losses are looked at here
    weak = msgspec.structs.replace(plain, drive=msgspec.structs.replace(FIELD, power_max_w=60e3, torque_max_nm=100.0))
    more = motor_losses(weak, torque, speed).copper - motor_losses(plain, torque, speed).copper
    assert more == pytest.approx(1.5 * FIELD.phase_resistance_ohm * i_d**2)


@pytest.mark.parametrize(("torque", "speed"), [(60.0, 300.0), (60.0, 900.0), (-40.0, 1100.0), (0.0, 1100.0)])
def test_dq_power_is_shaft_power_plus_copper_loss(torque: float, speed: float):
    """3/2 (u_d i_d + u_q i_q) from the voltage equations of the stationary motor, against tau omega + copper loss: 1e-9."""
    car = msgspec.structs.replace(load_vehicle("compact"), drive=msgspec.structs.replace(FIELD, power_max_w=60e3, torque_max_nm=100.0))
    electric, r, i_d, i_q = (
        speed * FIELD.pole_pairs,
        FIELD.phase_resistance_ohm,
        float(weakening_current(FIELD, torque, speed)),
        torque / torque_constant(FIELD),
    )
    u_d = r * i_d - electric * WEAK.inductance_h * i_q
    u_q = r * i_q + electric * (WEAK.inductance_h * i_d + FIELD.magnet_flux_wb)
    assert 1.5 * (u_d * i_d + u_q * i_q) == pytest.approx(torque * speed + float(motor_losses(car, torque, speed).copper), rel=1e-9, abs=1e-9)


def test_an_envelope_beyond_voltage_and_current_is_refused(tmp_path: Path):
    text = (SHELF / "compact.toml").read_text()
    section = "\n[drive.weakening]\ninductance_h = 150e-6\ncurrent_max_a = 530.0\ndc_voltage_v = 200.0\n\n[limits]"
    file = tmp_path / "weak.toml"
    file.write_text(text.replace("\n[limits]", section))
    with pytest.raises(VehicleError, match=r"drive\.torque_max_nm and power_max_w ask for .* expected at most the .* drive\.weakening allows"):
        load_vehicle(file)
    assert unreachable(msgspec.structs.replace(FIELD, power_max_w=20e3, regen_power_max_w=20e3, torque_max_nm=100.0), 1200.0) is None


def test_torque_limits_are_torque_then_power_both_ways(romo: Vehicle):
    drive, regen = torque_limits(romo.drive, np.array([0.0, 50.0, 110.0, -110.0]))
    assert drive == pytest.approx([160.0, 160.0, 16000.0 / 110.0, 16000.0 / 110.0])
    assert np.array_equal(drive, regen)


def map_file(path: Path, drive: Vehicle, *, header: str = "torque_nm,speed_radps,loss_w", extra: str = "") -> Path:
    torque, speed = np.meshgrid(np.linspace(-160.0, 160.0, 17), np.linspace(0.0, 105.0, 12))
    loss = sum(motor_losses(drive, torque, speed))
    rows = "\n".join(f"{t:.6f},{w:.6f},{p:.9f}" for t, w, p in zip(torque.flat, speed.flat, loss.flat, strict=True))
    path.write_text(f"# ROMO\n{header}\n{rows}\n{extra}")
    return path


def test_a_map_made_of_the_model_gives_the_model_back(tmp_path: Path):
    """The map of (3.39) itself: fit, constants and interpolation must return what it was made of."""
    found = read_map(map_file(tmp_path / "map.csv", ROMO))
    fit = found.fit()
    assert fit.rmse < 1e-5
    assert fit.motoring[:2] == pytest.approx([inverter_factor(ROMO), copper_factor(ROMO)], rel=1e-6)
    assert fit.generating == pytest.approx(fit.motoring, abs=1e-6)
    torque, speed = np.array([-77.0, 0.0, 12.0, 150.0]), np.array([30.0, 0.0, 95.0, 60.0])
    assert fit.losses(torque, speed) == pytest.approx(sum(motor_losses(ROMO, torque, speed)), rel=1e-6)
    drive = found.drive(ROMO.drive)
    again = msgspec.structs.replace(ROMO, drive=drive)
    assert sum(motor_losses(again, torque, speed)) == pytest.approx(sum(motor_losses(ROMO, torque, speed)), rel=1e-6)
    assert found.at(-160.0, 0.0) == pytest.approx(sum(motor_losses(ROMO, 160.0, 0.0)), rel=1e-9)
    assert np.isnan(found.at(200.0, 50.0))


def test_a_fit_keeps_motoring_and_generating_apart_and_is_never_negative():
    rng = np.random.default_rng(1)
    torque, speed = rng.uniform(-200.0, 200.0, 600), rng.uniform(0.0, 1000.0, 600)
    drives = torque >= 0.0
    loss = 50.0 + 0.3 * speed + np.where(drives, 2.0, 5.0) * np.abs(torque) + 0.01 * torque**2 + 3.0 * rng.standard_normal(600)
    fit = MotorMap("measured", torque, speed, np.maximum(loss, 0.0)).fit()
    assert fit.motoring[0] == pytest.approx(2.0, abs=0.2)
    assert fit.generating[0] == pytest.approx(5.0, abs=0.2)
    assert fit.rmse == pytest.approx(3.0, rel=0.15)
    grid = np.meshgrid(np.linspace(-250.0, 250.0, 51), np.linspace(-1200.0, 1200.0, 51))
    assert np.min(fit.losses(*grid)) >= 0.0


def test_a_car_with_a_map_plans_with_its_losses(tmp_path: Path):
    """ROMO's own map with twice the losses, in rpm: the loaded car loses twice as much."""
    torque, rpm = np.meshgrid(np.linspace(-160.0, 160.0, 17), np.linspace(0.0, 1000.0, 12))
    loss = 2.0 * sum(motor_losses(ROMO, torque, rpm * np.pi / 30.0))
    rows = "\n".join(f"{t},{n},{p}" for t, n, p in zip(torque.flat, rpm.flat, loss.flat, strict=True))
    (tmp_path / "map.csv").write_text(f"torque_nm,speed_rpm,loss_w\n{rows}\n")
    (tmp_path / "car.toml").write_text((SHELF / "romo.toml").read_text().replace("motor_count = 4", 'motor_count = 4\nmap = "map.csv"'))
    car = load_vehicle(tmp_path / "car.toml")
    assert sum(motor_losses(car, 80.0, 50.0)) == pytest.approx(2.0 * sum(motor_losses(ROMO, 80.0, 50.0)), rel=1e-6)


BAD_MAPS = [
    ("torque_nm,speed_radps", "", "columns torque_nm, speed_radps, expected torque_nm, speed_radps or speed_rpm, loss_w or efficiency"),
    ("torque_nm,speed_radps,loss_w", "1.0,2.0\n", "line 207: 2 values, expected 3"),
    ("torque_nm,speed_radps,loss_w", "1.0,2.0,hot\n", r"line 207: found '1\.0, 2\.0, hot', expected numbers"),
    ("torque_nm,speed_radps,loss_w", "1.0,2.0,nan\n", "line 207: .*expected finite numbers"),
    ("torque_nm,speed_radps,loss_w", "1.0,2.0,-5\n", "line 207: loss -5 W, expected none below zero"),
    ("torque_nm,speed_radps,efficiency", "", "line 3: efficiency .*expected above 0 and at most 1"),
]


@pytest.mark.parametrize(("header", "extra", "words"), BAD_MAPS)
def test_bad_maps_are_refused_with_file_and_line(tmp_path: Path, header: str, extra: str, words: str):
    file = map_file(tmp_path / "map.csv", ROMO, header=header, extra=extra)
    with pytest.raises(VehicleError, match=words) as caught:
        read_map(file)
    assert str(caught.value).startswith(str(file))


def test_maps_that_are_no_maps_are_refused(tmp_path: Path):
    with pytest.raises(VehicleError, match="cannot be read as a loss map: No such file"):
        read_map(tmp_path / "none.csv")
    (tmp_path / "empty.csv").write_text("")
    with pytest.raises(VehicleError, match="empty, expected a header"):
        read_map(tmp_path / "empty.csv")
    (tmp_path / "short.csv").write_text("torque_nm,speed_radps,loss_w\n1,2,3\n")
    with pytest.raises(VehicleError, match="1 operating points, expected at least 12"):
        read_map(tmp_path / "short.csv")
    (tmp_path / "line.csv").write_text("torque_nm,speed_radps,loss_w\n" + "1,2,3\n" * 20)
    with pytest.raises(VehicleError, match="same torque or speed, or lie on a line"):
        read_map(tmp_path / "line.csv")


NODE = Thermal(heat_capacity_jpk=8000.0, resistance_kpw=0.12)
WARM = msgspec.structs.replace(ROMO, drive=msgspec.structs.replace(ROMO.drive, thermal=NODE))


def test_copper_loss_rises_with_temperature_and_is_the_given_one_at_the_reference():
    assert motor_losses(WARM, 80.0, 50.0, NODE.reference_k) == motor_losses(WARM, 80.0, 50.0)
    hot, warm = motor_losses(WARM, 80.0, 50.0, NODE.reference_k + 50.0), motor_losses(WARM, 80.0, 50.0)
    assert hot.copper == pytest.approx(1.1965 * warm.copper)
    assert hot[1:] == warm[1:]
    with pytest.raises(VehicleError, match=r"needs the section \[drive\.thermal\]"):
        motor_losses(load_vehicle("van"), 80.0, 50.0, 300.0)


def test_settled_temperature_balances_heat_and_cooling():
    settled = settled_temperature(WARM, 40.0, 80.0, 293.15)
    assert temperature_rate(NODE, settled, motor_heat(WARM, 40.0, 80.0, settled), 293.15) == pytest.approx(0.0, abs=1e-12)
    assert settled_temperature(WARM, 1000.0, 80.0, 293.15) == float("inf")
    with pytest.raises(VehicleError, match="expected finite numbers"):
        settled_temperature(WARM, float("nan"), 1.0, 293.15)


def test_temperature_follows_the_exponential_of_its_equation():
    fine, heat, dt = 293.15, 500.0, 0.5
    for _ in range(4000):
        k1 = temperature_rate(NODE, fine, heat, 293.15)
        k2 = temperature_rate(NODE, fine + 0.5 * dt * k1, heat, 293.15)
        fine += dt * k2
    assert temperature_after(NODE, 293.15, heat, 293.15, 2000.0) == pytest.approx(fine, abs=1e-3)


def test_continuous_torque_is_the_one_that_settles_at_the_limit():
    held = continuous_torque(ROMO, 80.0)
    node = ROMO.drive.thermal
    assert node is not None
    assert settled_temperature(ROMO, held, 80.0, 298.15) == pytest.approx(node.max_k, abs=1e-3)
    # section 2.2 of the source: 40 Nm continuous
    assert held == pytest.approx(40.0, rel=0.03)
    assert continuous_torque(ROMO, 1e6) == 0.0
    assert continuous_torque(WARM, 80.0) == ROMO.drive.torque_max_nm
