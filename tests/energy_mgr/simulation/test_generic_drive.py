"""Odd cars driven over a winding, climbing, leaning road: mirrored, and their account against sums over the log."""

from functools import cache

import numpy as np
import pytest

from energy_mgr.simulation import Event, simulate
from energy_mgr.simulation.log import Drive
from powertrain.chassis.double_track import WHEELS
from powertrain.energy.motor import motor_losses
from tests.energy_mgr.winding import winding
from tests.odd_cars import ODD

CARS = pytest.mark.parametrize("name", ODD)
SECONDS = 2.5
#: Columns that change their sign in a mirror; torques, clamps, spins and the like change sides.
_TURNS = ("y_m", "psi_rad", "v_y", "yaw_", "roll", "w_", "delta", "steer_", "e_y", "e_psi", "kappa", "bank", "a_y")
_OTHER = {"fl": "fr", "fr": "fl", "rl": "rr", "rr": "rl"}


@cache
def driven(name: str, *, mirror: bool = False) -> Drive:
    """From 30 cm beside the road, with friction that falls and a weak motor and brake on its way; whoever drives knows the friction."""
    motor = {"four": ("motor_4", "motor_3"), "two": ("motor_1", "motor_1")}[name][mirror]
    events = [
        Event(part="friction", kind="value", share=0.8, time_s=0.8),
        Event(part=motor, kind="weak", share=0.6, time_s=1.2),
        Event(part="brake_fr" if mirror else "brake_fl", kind="weak", share=0.5, time_s=1.4),
        Event(part="measurement", kind="jump", size=-0.4 if mirror else 0.4, time_s=1.6, duration_s=0.1),
    ]
    road = winding(mirror=mirror)
    offset = -0.3 if mirror else 0.3
    return simulate(road, ODD[name], events=events, offset=offset, compiled=False, longest=SECONDS, knows_friction=True, soc=0.6)


def mirrored(column: str) -> str:
    """The column of the other side."""
    for own, other in _OTHER.items():
        if f"_{own}" in column:
            return column.replace(f"_{own}", f"_{other}")
    for own, other in {"1": "2", "2": "1", "3": "4", "4": "3"}.items():
        if column in (f"torque_{own}_nm", f"torque_cmd_{own}_nm"):
            return column.replace(own, other)
    return column


@CARS
def test_a_mirrored_road_is_driven_in_the_mirror(name: str):
    one, two = driven(name), driven(name, mirror=True)
    assert one.statuses == two.statuses
    for column, values in one.columns.items():
        if column in ("step_time_s", "residual", "iterations"):
            continue
        there = mirrored(column)
        there = there if there in two.columns else column
        sign = -1.0 if column.startswith(_TURNS) else 1.0
        size = 1e-3 + float(np.max(np.abs(values)))
        # a solver that is right to 1e-6 of a command's scale, in a loop that forgets such differences
        assert np.max(np.abs(values - sign * two[there])) < 2e-3 * size, column


@CARS
def test_logged_accelerations_and_rates_are_those_of_the_motion(name: str):
    run = driven(name)
    t, psi, turn = run["t_s"], run["psi_rad"], run["yaw_rate_radps"]
    velocity = (run["v_x_mps"] + 1j * run["v_y_mps"]) * np.exp(1j * psi)
    gained = np.diff(velocity) / np.diff(t) * np.exp(-0.5j * (psi[1:] + psi[:-1]))
    # velocities of the period's end in the products: half a period of 10 m/s^2 times a turning of 0.3 rad/s
    assert run["a_x_mps2"][1:] == pytest.approx(gained.real, abs=0.03)
    assert run["a_y_mps2"][1:] == pytest.approx(gained.imag, abs=0.06)
    place = run["x_m"] + 1j * run["y_m"]
    middle = 0.5 * (velocity[1:] + velocity[:-1])
    assert np.diff(place) / np.diff(t) == pytest.approx(middle, abs=1e-3)
    assert np.diff(psi) / np.diff(t) == pytest.approx(0.5 * (turn[1:] + turn[:-1]), abs=1e-3)
    # the true offset, from the road's own places
    road = run.trajectory.at(run["s_m"])
    off = (place - road.x - 1j * road.y) * np.exp(-1j * road.psi)
    assert run["e_y_m"] == pytest.approx(off.imag, abs=1e-6)
    assert np.max(np.abs(off.real)) < 1e-4
    assert run["bank_rad"] == pytest.approx(road.bank, abs=1e-9)
    assert run["slope"] == pytest.approx(road.slope, abs=1e-9)


@CARS
def test_the_account_is_the_sum_over_the_log(name: str):
    """Every flow that the log's columns determine, by the trapezoidal rule over periods, and what they leave in the battery."""
    run, car = driven(name), ODD[name]
    t, energy, r = run["t_s"], run.ledger.energy, car.resistance

    def summed(power: np.ndarray) -> float:
        return float(np.trapezoid(power, t)) + float(power[-1]) * (run.duration - float(t[-1]))

    v, spins = run["v_x_mps"], [run[f"omega_{wheel}_radps"] for wheel in WHEELS]
    ratio = car.drive.gear_ratio
    turning = [ratio * spin for spin in spins] if name == "four" else [0.5 * ratio * (spins[2] + spins[3])]
    torques = [run[f"torque_{k + 1}_nm"] for k in range(len(turning))]
    losses = [motor_losses(car, torque, speed) for torque, speed in zip(torques, turning, strict=True)]
    powers = {"motor": sum(torque * speed for torque, speed in zip(torques, turning, strict=True))}
    powers |= {
        part: sum(np.broadcast_to(getattr(loss, part), t.shape) for loss in losses) for part in ("copper", "iron", "inverter", "friction", "gear")
    }
    powers["drag"] = 0.5 * r.air_density_kgpm3 * r.drag_coefficient * r.frontal_area_m2 * np.abs(v) ** 3
    across = np.tan(run["bank_rad"])
    weight = car.chassis.mass_kg * 9.81 / np.sqrt(1.0 + run["slope"] ** 2 + across**2)
    powers["slope"] = weight * (run["slope"] * v + across * run["v_y_mps"])
    body = car.body
    powers["damping"] = body.roll_damping_nmsprad * run["roll_rate_radps"] ** 2 + body.pitch_damping_nmsprad * run["pitch_rate_radps"] ** 2
    passed = summed(np.abs(powers["motor"]))
    for part, power in powers.items():
        # slope, bank and commands are held over a period of the loop; the log has them at its beginning
        assert energy[part] == pytest.approx(summed(power), rel=0.01, abs=2e-3 * passed), part
    # the battery's column is the mean over its own step of 20 ms, at whose end it is written
    assert energy["terminal"] == pytest.approx(summed(run["battery_power_w"]), rel=0.03, abs=5e-3 * passed)
    converter = car.electrics.auxiliary_w / car.electrics.converter_efficiency + car.electrics.converter_constant_w
    assert energy["auxiliary"] + energy["converter"] == pytest.approx(converter * run.duration, rel=0.01)
    drives = sum(energy[part] for part in ("motor", "copper", "iron", "inverter", "friction", "gear", "steering", "steering_work"))
    assert run.drive_energy == pytest.approx(drives, abs=5e-3 * passed)
    # begun in a bend, beside the road: the account counts from there
    assert max(run.ledger.imbalance.values()) < 1e-7
