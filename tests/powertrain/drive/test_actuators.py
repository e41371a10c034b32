"""Steering drive M2, brake M9, DC/DC converter M7, backup battery M8."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from powertrain import load_vehicle
from powertrain.description.sections import Brakes, Electrics, Steering
from powertrain.drive.brake import brake_torque, hold_rate, stored
from powertrain.drive.machine import copper_per_torque
from powertrain.drive.steering import Contact, aligning_torque, bore_torque, steering_power
from powertrain.drive.supply import backup_flow, converter_input, converter_loss

ROMO = load_vehicle("romo")
STEERING = ROMO.need("steering", Steering)
BRAKES = ROMO.need("brakes", Brakes)
ELECTRICS = ROMO.need("electrics", Electrics)


def test_derived_constant_of_the_steering_motor_is_that_of_the_specification():
    """Torque constant 0.089286 Nm/A and b = 15.410 W/Nm^2 [CHK]."""
    assert 1.5 * STEERING.pole_pairs * STEERING.magnet_flux_wb == pytest.approx(0.089286, abs=5e-7)
    assert copper_per_torque(STEERING) == pytest.approx(15.410, abs=5e-4)


def test_bore_torque_is_that_of_a_pressed_disc_at_rest_and_fades_as_the_wheel_rolls():
    at_rest = bore_torque(STEERING, 1.4, Contact(0.0, 0.0, 2484.0, 0.0))
    assert at_rest == pytest.approx(2.0 / 3.0 * 2484.0 * STEERING.contact_radius_m, rel=1e-4)
    assert bore_torque(STEERING, 1.4, Contact(0.0, 0.0, 2484.0, 15.0)) < 0.01 * at_rest
    assert bore_torque(STEERING, 0.0, Contact(0.0, 0.0, 2484.0, 0.0)) == 0.0
    assert bore_torque(STEERING, -1.4, Contact(0.0, 0.0, 2484.0, 0.0)) == -at_rest


def test_aligning_torque_is_force_times_trail():
    contact = Contact(side=1000.0, longitudinal=500.0, load=2484.0, speed=10.0, aligning=-30.0)
    assert aligning_torque(STEERING, contact) == pytest.approx(1000.0 * 0.02516 + 500.0 * 0.00229 + 30.0)


def test_the_published_motor_turns_the_standing_wheel_at_full_rate_within_its_power():
    """370 W turn 80 degrees/s against the bore torque of a standing wheel (sections 2.2, M2)."""
    power = steering_power(STEERING, STEERING.rate_max_radps, 0.0, Contact(0.0, 0.0, 2484.0, 0.0))
    shaft = power.bore + power.gear + power.friction
    assert 100.0 < shaft < 370.0


@given(rate=st.floats(-1.4, 1.4), acceleration=st.floats(-50, 50), side=st.floats(-3000, 3000), load=st.floats(0, 6000), speed=st.floats(0, 28))
def test_steering_power_is_shaft_power_plus_motor_losses_and_no_loss_is_negative(rate, acceleration, side, load, speed):
    """(3.41): the electrical power from the motor's own torque and speed, computed apart from the split."""
    contact = Contact(side, 100.0, load, speed, -0.02 * side)
    power = steering_power(STEERING, rate, acceleration, contact)
    assert min(power.bore, power.gear, power.copper, power.iron, power.inverter, power.friction) >= 0.0
    p, i = STEERING, STEERING.gear_ratio
    load_torque = p.wheel_yaw_inertia_kgm2 * acceleration + bore_torque(p, rate, contact) + aligning_torque(p, contact)
    torque = load_torque / i + p.motor_inertia_kgm2 * i * acceleration + (1.0 - p.gear_efficiency) * abs(load_torque / i) * np.sign(rate)
    omega = i * rate
    losses = p.friction_nm * abs(omega) + p.hysteresis_nm * abs(omega) + p.eddy_nms * omega**2 + copper_per_torque(p) * torque**2
    assert power.total == pytest.approx(torque * omega + losses, rel=1e-9, abs=1e-9)


def test_a_clamped_brake_slides_with_its_torque_and_holds_with_what_is_asked():
    hold = 0.0
    for _ in range(5000):
        hold += 1e-4 * float(hold_rate(BRAKES, 300.0, 20.0, hold))
    assert brake_torque(BRAKES, 300.0, 20.0, hold) == pytest.approx(300.0, rel=1e-6)
    assert float(hold_rate(BRAKES, 300.0, 0.0, 0.4)) == 0.0
    assert brake_torque(BRAKES, 300.0, 0.0, 0.4) == pytest.approx(120.0)
    # let go, the pad forgets: pressed on again it does not push the car
    assert float(hold_rate(BRAKES, 0.0, 0.0, 1.0)) == pytest.approx(-20.0)
    assert brake_torque(BRAKES, 0.0, 20.0, 1.0) == 0.0


@given(speed=st.floats(-100, 100), share=st.floats(0, 1))
def test_braking_heat_is_never_negative_while_the_pad_follows_the_wheel(speed: float, share: float):
    hold = share * np.sign(speed)
    rate = hold_rate(BRAKES, 200.0, speed, hold)
    heat = brake_torque(BRAKES, 200.0, speed, hold) * speed - 200.0 * BRAKES.presliding_rad * hold * rate
    assert heat >= -1e-9
    assert stored(BRAKES, 200.0, hold) >= 0.0


def test_converter_draws_what_it_delivers_and_loses():
    """Part H: P_HV = P_LV / 0.93 + 10 W."""
    assert converter_input(ELECTRICS, 200.0) == pytest.approx(200.0 / 0.93 + 10.0)
    assert converter_input(ELECTRICS, 200.0) - converter_loss(ELECTRICS, 200.0) == pytest.approx(200.0)
    assert converter_loss(ELECTRICS, 0.0) == 10.0


@given(power=st.floats(-3000, 3000))
def test_backup_battery_gives_the_power_that_is_asked_and_its_loss_is_never_negative(power: float):
    flow = backup_flow(ELECTRICS, power, 298.15, 298.15)
    terminal = (ELECTRICS.voltage_v - ELECTRICS.backup_resistance_ohm * flow.current) * flow.current
    assert terminal == pytest.approx(power, rel=1e-9, abs=1e-9)
    assert flow.loss >= 0.0
    assert ELECTRICS.voltage_v * flow.current == pytest.approx(terminal + flow.loss, rel=1e-12, abs=1e-9)
    assert np.sign(flow.soc_rate) == -np.sign(flow.current)


def test_backup_battery_beyond_its_largest_power_stays_at_it():
    most = ELECTRICS.voltage_v**2 / (4.0 * ELECTRICS.backup_resistance_ohm)
    assert backup_flow(ELECTRICS, 2.0 * most, 298.15, 298.15).current == backup_flow(ELECTRICS, most, 298.15, 298.15).current
