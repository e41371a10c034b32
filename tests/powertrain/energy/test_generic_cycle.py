"""Cycles of odd cars: their account against quadrature of an independent equation of motion, and the charge of cells side by side."""

import numpy as np
import pytest

from powertrain import drive_cycle
from powertrain.battery import PackModel, load_cell
from powertrain.energy.cycle_charge import charge_over_cycle
from powertrain.energy.motor import motor_losses
from tests.odd_cars import ODD

CARS = pytest.mark.parametrize("name", ODD)


def cycle() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Two minutes of speeds that change all the time, harder braking than these motors recuperate, slopes of up to 5 %; unequal steps."""
    t = np.concatenate([[0.0], np.cumsum(np.random.default_rng(95).uniform(0.5, 1.5, 120))])
    v = 12.0 + 6.0 * np.sin(0.31 * t) + 3.5 * np.sin(0.9 * t)
    return t, v, 0.05 * np.sin(0.2 * t[1:])


@CARS
def test_each_part_of_the_account_is_its_power_summed_over_time(name: str):
    """Between rows the speed is linear; forces by hand at the mean of each interval, motors in their quadrants, the brakes the rest."""
    car, (t, v, slope) = ODD[name], cycle()
    found, r, d, radius = drive_cycle(car, t, v, slope), car.resistance, car.drive, car.chassis.wheel_radius_m
    dt, mean, mass = np.diff(t), 0.5 * (v[1:] + v[:-1]), car.chassis.mass_kg
    turning = 4 * car.chassis.wheel_inertia_kgm2 / radius**2 + d.motor_count * d.rotor_inertia_kgm2 * (d.gear_ratio / radius) ** 2
    x, squares = mean * 3.6 / 100, 0.5 * (v[1:] ** 2 + v[:-1] ** 2)
    forces = {
        "rolling": mass * 9.81 * (r.rolling_0 + r.rolling_1 * x + r.rolling_4 * x**4),
        "drag": 0.5 * r.air_density_kgpm3 * r.drag_coefficient * r.frontal_area_m2 * squares,
        "slope": mass * 9.81 * slope,
        "kinetic": (mass + turning) * np.diff(v) / dt,
    }
    speed = mean * d.gear_ratio / radius
    torque = sum(forces.values()) * radius / (d.gear_ratio * d.motor_count)
    least, most = np.minimum(d.regen_torque_max_nm, d.regen_power_max_w / speed), np.minimum(d.torque_max_nm, d.power_max_w / speed)
    taken = np.maximum(torque, -least)
    forces["brake"] = (taken - torque) * d.gear_ratio * d.motor_count / radius
    # both happen: brakes that close, and demands beyond the motors
    assert np.sum(forces["brake"] > 0.0) > 5
    powers = {part: force * mean for part, force in forces.items()}
    powers |= {part: d.motor_count * np.broadcast_to(loss, dt.shape) for part, loss in motor_losses(car, taken, speed)._asdict().items()}
    powers["auxiliary"] = np.full_like(dt, car.electrics.auxiliary_w / car.electrics.converter_efficiency + car.electrics.converter_constant_w)
    assert found.components == pytest.approx({part: float(np.sum(power * dt)) for part, power in powers.items()}, rel=1e-9)
    assert found.power == pytest.approx(sum(powers.values()), rel=1e-9, abs=1e-6)
    lacking = np.maximum(torque - most, 0.0) * d.gear_ratio * d.motor_count / radius / (mass + turning) * dt
    assert found.missed == pytest.approx(float(np.max(lacking)), rel=1e-9, abs=1e-12)
    assert found.distance == pytest.approx(float(np.sum(mean * dt)), rel=1e-12)


@CARS
@pytest.mark.parametrize("soc", [0.6, 0.97])
def test_charge_of_a_cycle_is_that_of_an_ode_of_a_single_cell(name: str, soc: float):
    """One cell under its share of the power, in small steps of Heun's method; full batteries refuse part of it, and the brakes take that."""
    car, (t, v, slope) = ODD[name], cycle()
    found, demand = charge_over_cycle(car, t, v, slope, soc=soc), drive_cycle(car, t, v, slope)
    series, parallel = car.battery.series, car.battery.parallel
    cell = load_cell(car.battery.cell)
    single = PackModel(cell, 1, 1, 1e9)
    x = np.array(single.rest(soc, 298.15), dtype=float)
    charge, energy = 0.0, 0.0
    for power, dt in zip(found.power / (series * parallel), np.diff(t), strict=True):
        for _ in range(4):
            h = dt / 4

            def rate(state: np.ndarray, power: float = power) -> tuple[np.ndarray, float]:
                current = float(single.current_from_power(power, list(state)).current)
                slopes = np.array([float(value) for value in single.derivative(list(state), current, 298.15)])
                slopes[-1] = 0.0  # the temperature is held
                return slopes, current

            one, first = rate(x)
            two, second = rate(x + h * one)
            x = x + 0.5 * h * (one + two)
            charge, energy = charge + 0.5 * h * (first + second), energy + h * power
    # held currents over about a second against continuous ones
    swing = np.ptp(found.soc)
    assert found.soc[-1] == pytest.approx(x[0], abs=5e-3 * swing)
    assert found.charge_ah == pytest.approx(parallel * charge / 3600.0, abs=5e-3 * swing * cell.capacity * parallel / 3600.0)
    assert found.energy == pytest.approx(series * parallel * energy, rel=1e-9)
    # every row: what the battery gives and refuses is what the cycle asks for
    refused = found.power - demand.power
    assert found.refused == pytest.approx(float(np.sum(np.maximum(refused, 0.0) * np.diff(t))), rel=1e-9, abs=1e-6)
    assert found.unserved == pytest.approx(float(np.sum(np.maximum(-refused, 0.0) * np.diff(t))), rel=1e-9, abs=1e-6)
    assert sum(found.components.values()) == pytest.approx(found.energy + found.unserved, rel=1e-9)
    for part, value in demand.components.items():
        assert found.components[part] == pytest.approx(value + (found.refused if part == "brake" else 0.0), rel=1e-9)
    assert (found.refused > 0.0) == (soc > 0.9)


def test_cells_side_by_side_spend_their_time_at_peak_current_each_for_itself():
    """A climb that asks more than one cell's steady current of a row of two, for long, leaves them all of their peak time afterwards."""
    car = ODD["two"]
    t = np.arange(61.0)
    slope = np.where(t[1:] <= 25.0, 0.2, 0.44)
    found = charge_over_cycle(car, t, np.full(61, 15.0), slope, soc=0.8)
    limits = load_cell(car.battery.cell).limits
    assert limits.discharge_max_a < found.current[20] < 2.0 * limits.discharge_max_a < found.current[30] < 2.0 * limits.discharge_peak_a
    assert found.shortage is not None
    assert (found.shortage.time, found.shortage.reason) == (25.0 + limits.peak_duration_s, "current")
    assert found.current[35] == pytest.approx(2.0 * limits.discharge_max_a, rel=1e-6)
