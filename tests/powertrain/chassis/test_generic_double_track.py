"""The double track of odd cars at random states: Newton's and Euler's equations written a second time, and the balance of power with every input."""

import math

import casadi as ca
import numpy as np
import pytest

from powertrain.chassis import DoubleTrack
from powertrain.chassis.double_track import WHEELS
from powertrain.chassis.flows import KEPT, SINKS, SOURCES, flows, kept
from tests.odd_cars import ODD

G = 9.81


def random_inputs(plant: DoubleTrack, rng: np.random.Generator) -> dict[str, float]:
    """Every input by name, each wheel and motor with its own; some beyond what the actuators can do."""
    most = plant.vehicle.drive.torque_max_nm
    sizes = {
        "torque_cmd": lambda: rng.uniform(-1.2, 1.2) * most,
        "brake_cmd": lambda: rng.uniform(-100, 900),
        "steer_cmd": lambda: rng.uniform(-0.5, 0.5),
    }
    named = {name: sizes[name[: name.rindex("_")]]() for name in plant.inputs[:-3]}
    return named | {"grade": rng.uniform(-0.15, 0.15), "bank": rng.uniform(-0.15, 0.15), "friction": rng.uniform(0.4, 1.1)}


def random_state(plant: DoubleTrack, rng: np.random.Generator, v: float) -> dict[str, float]:
    """A car at `v` m/s that slides, leans, slips and brakes, each wheel differently."""
    s = dict(zip(plant.states, plant.initial(v), strict=True))
    sizes = {
        "omega": 0.02 * abs(v) + 0.5,
        "u": 4e-3,
        "w": 0.01,
        "delta": 0.1,
        "delta_rate": 0.4,
        "hold": 0.3,
        "torque": 0.4 * plant.vehicle.drive.torque_max_nm,
    }
    for name in s:
        kind = name[: name.rindex("_")] if "_" in name else name
        s[name] += sizes.get(kind, 0.0) * rng.uniform(-1, 1)
        if kind == "clamp":
            s[name] = rng.uniform(50, 400)
    own = {
        "x": 9.0,
        "y": 9.0,
        "psi": 3.0,
        "v_y": 0.05 * abs(v) + 0.2,
        "yaw_rate": 0.4,
        "roll": 0.02,
        "pitch": 0.01,
        "roll_rate": 0.1,
        "pitch_rate": 0.1,
    }
    return s | {name: size * rng.uniform(-1, 1) for name, size in own.items()}


def second_time(plant: DoubleTrack, s: dict[str, float], c: dict[str, float]) -> dict[str, float]:
    """Rates of the body and the wheels' spins: geometry, loads, forces and moments written anew with vectors; tyres' curves are the car's own."""
    car = plant.vehicle
    b, mass, radius, r = plant.body, car.chassis.mass_kg, car.chassis.wheel_radius_m, car.resistance
    arms = np.array([[b.front_axle_m, 1], [b.front_axle_m, -1], [-b.rear_axle_m, 1], [-b.rear_axle_m, -1]])
    arms[:, 1] *= np.repeat([b.front_track_m / 2, b.rear_track_m / 2], 2)
    normal = mass * G / math.sqrt(1 + c["grade"] ** 2 + c["bank"] ** 2)
    # what springs and dampers hold, as couples on front and rear, left and right
    roll = b.roll_stiffness_nmprad * s["roll"] + b.roll_damping_nmsprad * s["roll_rate"]
    pitch = b.pitch_stiffness_nmprad * s["pitch"] + b.pitch_damping_nmsprad * s["pitch_rate"]
    base, forces, spins, rolls = b.front_axle_m + b.rear_axle_m, [], [], []
    speed = abs(s["v_x"]) * 3.6 / 100
    coefficient = r.rolling_0 + r.rolling_1 * speed + r.rolling_4 * speed**4
    tyres = car.tyres()
    for k, name in enumerate(WHEELS):
        front = k < 2
        axle = normal * (b.rear_axle_m if front else b.front_axle_m) / base + (pitch if front else -pitch) / base
        share, track = (b.roll_front_share, b.front_track_m) if front else (1 - b.roll_front_share, b.rear_track_m)
        load = axle / 2 + (-1) ** (k + 1) * share * roll / track
        assert load > 100.0  # no wheel lifts
        patch = s["v_x"] - b.cog_height_m * s["pitch_rate"] + 1j * (s["v_y"] + b.cog_height_m * s["roll_rate"])
        patch += 1j * s["yaw_rate"] * (arms[k, 0] + 1j * arms[k, 1])
        turn = np.exp(1j * s.get(f"delta_{name}", 0.0))
        own = patch / turn  # velocity ahead and aside in the wheel's frame
        tyre = tyres[0 if front else 1]
        sigma = tyre.relaxation(load)
        standing = 0.01 / (1 + own.real**4)
        slip = (s[f"u_{name}"] + standing * (s[f"omega_{name}"] * radius - own.real)) / sigma[0]
        side = math.atan((s[f"w_{name}"] - standing * own.imag) / sigma[1])
        found = tyre.forces(slip, side, load, friction=c["friction"])
        forces.append(complex(found.longitudinal + 1j * found.lateral) * turn)
        spins.append(float(found.longitudinal) * radius)
        rim = s[f"omega_{name}"] * radius / 0.05
        rolls.append(coefficient * load * radius * rim / math.sqrt(1 + rim**2))
    total = sum(forces)
    moment = sum((np.conj(arms[k, 0] + 1j * arms[k, 1]) * forces[k]).imag for k in range(4))
    drag = 0.5 * r.air_density_kgpm3 * r.drag_coefficient * r.frontal_area_m2 * s["v_x"] * abs(s["v_x"])
    a = (total - drag - normal * (c["grade"] + 1j * c["bank"])) / mass - 1j * s["yaw_rate"] * (s["v_x"] + 1j * s["v_y"])
    place = (s["v_x"] + 1j * s["v_y"]) * np.exp(1j * s["psi"])
    rate = {"x": place.real, "y": place.imag, "psi": s["yaw_rate"], "v_x": a.real, "v_y": a.imag, "yaw_rate": moment / b.yaw_inertia_kgm2}
    heel = mass * G * b.cog_height_m
    rate["roll_rate"] = (b.cog_height_m * total.imag + heel * s["roll"] - roll) / b.roll_inertia_kgm2
    rate["pitch_rate"] = (-b.cog_height_m * total.real + heel * s["pitch"] - pitch) / b.pitch_inertia_kgm2
    return rate | {"roll": s["roll_rate"], "pitch": s["pitch_rate"]} | spun(plant, s, np.array(spins) + rolls)


def spun(plant: DoubleTrack, s: dict[str, float], against: np.ndarray) -> dict[str, float]:
    """Spin rates by Lagrange: wheels and rotors as one matrix of inertia, torques of motors through the same gears."""
    car, brakes = plant.vehicle, plant.brakes
    ratio = car.drive.gear_ratio
    to_motor = {"odd romo": ratio * np.eye(4), "odd compact": ratio * np.array([[0.0, 0.0, 0.5, 0.5]])}[car.name]
    inertia = car.chassis.wheel_inertia_kgm2 * np.eye(4) + car.drive.rotor_inertia_kgm2 * to_motor.T @ to_motor
    torques = to_motor.T @ [s[f"torque_{k + 1}"] for k in range(len(to_motor))] - against
    for k, name in enumerate(WHEELS):
        turning, hold = s[f"omega_{name}"], s[f"hold_{name}"]
        stretch = (turning - abs(turning) * hold) / (brakes.presliding_rad + abs(turning) * brakes.sliding_time_s)
        torques[k] -= s[f"clamp_{name}"] * (hold + 0.004 * stretch)
    return {f"omega_{name}": rate for name, rate in zip(WHEELS, np.linalg.solve(inertia, torques), strict=True)}


def actuators(plant: DoubleTrack, s: dict[str, float], c: dict[str, float]) -> dict[str, float]:
    """Rates of torques, clamps and steering angles, forwards at speed."""
    car, rate = plant.vehicle, {}
    d, p = car.drive, plant.steering
    for k in range(d.motor_count):
        spins = [s[f"omega_{name}"] for name in WHEELS]
        turning = d.gear_ratio * (spins[k] if d.motor_count == 4 else 0.5 * (spins[2] + spins[3]))
        most, least = min(d.torque_max_nm, d.power_max_w / turning), min(d.regen_torque_max_nm, d.regen_power_max_w / turning)
        gap = (min(max(c[f"torque_cmd_{k + 1}"], -least), most) - s[f"torque_{k + 1}"]) / d.torque_lag_s
        rate[f"torque_{k + 1}"] = gap / math.hypot(1, gap / d.torque_rate_nmps)
    for k, name in enumerate(WHEELS):
        most = plant.brakes.front_torque_max_nm if k < 2 else plant.brakes.rear_torque_max_nm
        rate[f"clamp_{name}"] = (min(max(c[f"brake_cmd_{name}"], 0.0), most) - s[f"clamp_{name}"]) / plant.brakes.lag_s
    for name in plant.steered:
        gap = (min(max(c[f"steer_cmd_{name}"], -p.angle_max_rad), p.angle_max_rad) - s[f"delta_{name}"]) / p.lag_s
        wanted = gap / math.hypot(1, gap / p.rate_max_radps)
        rate[f"delta_{name}"], rate[f"delta_rate_{name}"] = s[f"delta_rate_{name}"], 4 * (wanted - s[f"delta_rate_{name}"]) / p.lag_s
    return rate


@pytest.mark.parametrize("name", ODD)
def test_rates_of_body_wheels_and_actuators_are_those_of_newton_and_euler(name: str):
    plant, rng = DoubleTrack(ODD[name]), np.random.default_rng(61)
    for _ in range(60):
        s, c = random_state(plant, rng, rng.uniform(3.0, 30.0)), random_inputs(plant, rng)
        rate = dict(zip(plant.states, plant.derivative(list(s.values()), list(c.values())), strict=True))
        expected = second_time(plant, s, c) | actuators(plant, s, c)
        assert {key for key in rate if key.split("_")[0] not in ("u", "w", "hold")} == expected.keys()
        for key, value in expected.items():
            # the same sums in another order: rounding of accelerations of up to 1e4 rad/s^2
            assert rate[key] == pytest.approx(value, rel=1e-9, abs=1e-9), key


@pytest.mark.parametrize("name", ODD)
def test_deflections_of_tyres_settle_at_the_slip_of_their_wheels(name: str):
    """A fast wheel's deflection grows by what its patch slides beyond its slip: u' = omega R - v - |v| u / sigma, w' = -v_y - |v| w / sigma."""
    plant, rng = DoubleTrack(ODD[name]), np.random.default_rng(62)
    for _ in range(40):
        s, c = random_state(plant, rng, rng.uniform(25.0, 35.0)), random_inputs(plant, rng)
        rate = dict(zip(plant.states, plant.derivative(list(s.values()), list(c.values())), strict=True))
        for k, (wheel, load) in enumerate(zip(WHEELS, plant.loads(s, c), strict=True)):
            b = plant.body
            patch = s["v_x"] - b.cog_height_m * s["pitch_rate"] + 1j * (s["v_y"] + b.cog_height_m * s["roll_rate"])
            patch = (patch + 1j * s["yaw_rate"] * (b.wheel_x[k] + 1j * b.wheel_y[k])) * np.exp(-1j * s.get(f"delta_{wheel}", 0.0))
            sigma = plant.tyres[k].relaxation(load)
            sliding = s[f"omega_{wheel}"] * plant.vehicle.chassis.wheel_radius_m - patch.real
            # shedding and damping of the standing tyre have faded to 1/(1 + 25^4) here
            assert rate[f"u_{wheel}"] == pytest.approx(sliding - abs(patch.real) * s[f"u_{wheel}"] / sigma[0], abs=1e-4)
            assert rate[f"w_{wheel}"] == pytest.approx(-patch.imag - abs(patch.real) * s[f"w_{wheel}"] / sigma[1], abs=1e-4)


@pytest.mark.parametrize("name", ODD)
def test_power_balances_on_banked_slopes_of_any_friction_from_standstill_to_speed_and_backwards(name: str):
    plant = DoubleTrack(ODD[name])
    x, u = ca.SX.sym("x", len(plant.states)), ca.SX.sym("u", len(plant.inputs))
    xs, us = ca.vertsplit(x), ca.vertsplit(u)
    stored = ca.jtimes(kept(plant, xs), x, ca.vertcat(*plant.derivative(xs, us)))
    found = flows(plant, xs, us)
    function = ca.Function("balance", [x, u], [stored, ca.vertcat(*(found[key] for key in (*SOURCES, *SINKS, *KEPT)))])
    rng, signs = np.random.default_rng(63), np.array([1.0] * len(SOURCES) + [-1.0] * len((*SINKS, *KEPT)))
    for _ in range(200):
        s, c = random_state(plant, rng, rng.choice([0.0, 0.3, 1.0]) * rng.uniform(-10.0, 30.0)), random_inputs(plant, rng)
        rate, parts = (np.array(part).ravel() for part in function(list(s.values()), list(c.values())))
        assert rate[0] == pytest.approx(signs @ parts, abs=1e-9 * np.sum(np.abs(parts)))
        # what the slope takes is weight times the rise of the road under the car's own motion
        weight = plant.vehicle.chassis.mass_kg * G / math.sqrt(1 + c["grade"] ** 2 + c["bank"] ** 2)
        assert parts[len((*SOURCES, *SINKS))] == pytest.approx(weight * (s["v_x"] * c["grade"] + s["v_y"] * c["bank"]), rel=1e-12)
        drives = sum(s[f"torque_{m}"] * w for m, w in zip(plant.motors, plant.motor_speeds(s), strict=True))
        assert parts[0] == pytest.approx(drives, rel=1e-12)
