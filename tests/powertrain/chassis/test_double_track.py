"""The plant's mechanics: conservation, closed forms, symmetry, what it refuses."""

import casadi as ca
import msgspec
import numpy as np
import pytest

from powertrain import load_vehicle, shipped
from powertrain.chassis import DoubleTrack, Machine
from powertrain.chassis.double_track import WHEELS
from powertrain.chassis.flows import ELECTRIC, FLOWS, KEPT, SINKS, SOURCES, flows, kept
from powertrain.energy.performance import axle_stiffness, understeer_gradient
from powertrain.vehicle import GRAVITY

from .rig import MACHINE, PLANT, ROMO, named, settle


def at_constant_speed(plant: DoubleTrack, machine: Machine, v: float, steer: dict[str, float], seconds: float):
    """Drive `seconds` with a torque that keeps the speed near `v`; the state at the end."""
    x, held = np.array(plant.initial(v)), 0.0
    for _ in range(round(seconds / machine.dt)):
        error = v - x[plant.states.index("v_x")]
        held += 2.0 * error * machine.dt
        u = plant.command(torque_cmd=200.0 * error + 100.0 * held, **steer)
        x = machine.step(x, u)
    return x, u


@pytest.mark.parametrize("name", shipped())
def test_power_balance_holds_at_every_instant_for_every_car(name: str):
    """d(stored)/dt from the states' derivatives equals the flows, at random states far from any equilibrium."""
    plant = DoubleTrack(load_vehicle(name))
    x, u = ca.SX.sym("x", len(plant.states)), ca.SX.sym("u", len(plant.inputs))
    xs, us = ca.vertsplit(x), ca.vertsplit(u)
    rate = ca.jtimes(kept(plant, xs), x, ca.vertcat(*plant.derivative(xs, us)))
    found = flows(plant, xs, us)
    balance = rate - sum(found[k] for k in SOURCES) + sum(found[k] for k in (*SINKS, *KEPT))
    turnover = sum(ca.fabs(found[k]) for k in (*SOURCES, *SINKS, *KEPT))
    function = ca.Function("balance", [x, u], [balance, turnover])
    rng = np.random.default_rng(5)
    for _ in range(300):
        state = np.array(plant.initial(rng.uniform(-5.0, 30.0))) + 0.1 * rng.standard_normal(len(plant.states))
        inputs = plant.command(torque_cmd=rng.uniform(-100, 100), brake_cmd=rng.uniform(0, 300), grade=0.1 * rng.standard_normal(), bank=0.02)
        off, size = (float(value) for value in function(state, inputs))
        assert abs(off) < 1e-9 * size


def test_energy_is_conserved_over_a_drive_and_losses_are_never_negative():
    names = (*FLOWS,)
    machine = Machine(PLANT, 1e-3, integrands=lambda x, u: list(flows(PLANT, x, u).values()))
    rng = np.random.default_rng(7)
    x, total, size = np.array(PLANT.initial(8.0)), np.zeros(len(names)), np.zeros(len(names))
    before = kept(PLANT, x)
    losses = [names.index(k) for k in (*SINKS, *ELECTRIC)]
    for k in range(20_000):
        if k % 800 == 0:
            steer = {f"steer_cmd_{wheel}": 0.03 * rng.standard_normal() for wheel in WHEELS}
            brake, grade = max(rng.uniform(-300, 100), 0.0), 0.02 * rng.standard_normal()
            u = PLANT.command(torque_cmd=rng.uniform(-60, 90), brake_cmd=brake, grade=grade, **steer)
        x = machine.step(x, u)
        assert np.all(machine.integrals[losses] >= 0.0)
        total += machine.integrals
        size += np.abs(machine.integrals)
    spent = dict(zip(names, total, strict=True))
    balance = sum(spent[k] for k in SOURCES) - sum(spent[k] for k in (*SINKS, *KEPT))
    assert kept(PLANT, x) - before == pytest.approx(balance, abs=1e-9 * float(np.sum(size)))


def test_left_and_right_are_mirror_images():
    left = named(PLANT, settle(PLANT, MACHINE, PLANT.initial(15.0), PLANT.command(torque_cmd=10.0, steer_cmd_fl=0.03, steer_cmd_fr=0.03), 2.0))
    right = named(PLANT, settle(PLANT, MACHINE, PLANT.initial(15.0), PLANT.command(torque_cmd=10.0, steer_cmd_fl=-0.03, steer_cmd_fr=-0.03), 2.0))
    for name in ("y", "psi", "v_y", "yaw_rate", "roll"):
        assert right[name] == pytest.approx(-left[name], abs=1e-9)
    for name in ("x", "v_x", "pitch"):
        assert right[name] == pytest.approx(left[name], abs=1e-9)
    assert left["yaw_rate"] > 0.0
    assert left["roll"] > 0.0


@pytest.mark.parametrize("name", shipped())
def test_small_steering_angles_turn_the_car_as_the_linear_bicycle_says(name: str, figure):
    """r = v delta / (L + K v^2): closed form in the linear limit, reached at 0.1 m/s^2.

    Without driving resistances: rolling resistance of the heavier outer wheels turns the car out by 0.5 % (ROMO), which the bicycle cannot know.
    """
    vehicle = load_vehicle(name)
    free = msgspec.structs.replace(vehicle.resistance, drag_coefficient=0.0, rolling_0=0.0, rolling_1=0.0, rolling_4=0.0)
    vehicle = msgspec.structs.replace(vehicle, resistance=free)
    plant = DoubleTrack(vehicle)
    machine, body = Machine(plant, 1e-3), plant.body
    v = 15.0
    delta = 0.1 * (body.wheelbase_m / v**2 + understeer_gradient(vehicle))
    x, _ = at_constant_speed(plant, machine, v, {"steer_cmd_fl": delta, "steer_cmd_fr": delta}, 12.0)
    state = named(plant, x)
    expected = state["v_x"] * delta / (body.wheelbase_m + understeer_gradient(vehicle) * state["v_x"] ** 2)
    figure(f"{name}: yaw rate off the closed form in the linear limit", abs(state["yaw_rate"] / expected - 1.0), "{:.1e}")
    assert state["yaw_rate"] == pytest.approx(expected, rel=1e-3)


def test_loads_carry_the_weight_and_shift_by_the_moment_of_the_centre_of_gravity():
    x, u = at_constant_speed(PLANT, MACHINE, 12.0, {"steer_cmd_fl": 0.05, "steer_cmd_fr": 0.05}, 8.0)
    s, c = PLANT.named(x, u)
    loads = [float(load) for load in PLANT.loads(s, c)]
    assert sum(loads) == pytest.approx(ROMO.chassis.mass_kg * GRAVITY, rel=1e-12)
    lateral = s["v_x"] * s["yaw_rate"]
    shift = 0.5 * (loads[1] + loads[3] - loads[0] - loads[2]) * PLANT.body.front_track_m
    lean = ROMO.chassis.mass_kg * GRAVITY * PLANT.body.cog_height_m * s["roll"]
    assert shift == pytest.approx(ROMO.chassis.mass_kg * lateral * PLANT.body.cog_height_m + lean, rel=1e-3)


def test_top_speed_and_sprint_of_the_plant_are_those_of_the_quasi_static_car():
    from powertrain.energy.performance import acceleration_time

    u, x, t = PLANT.command(torque_cmd=160.0), np.array(PLANT.initial(0.0)), 0.0
    while x[PLANT.states.index("v_x")] < 80.0 / 3.6:
        x, t = MACHINE.step(x, u), t + 1e-3
    # Table C.3: about 10 s; the plant adds slip and the time that torque takes to rise to the quasi-static quadrature
    assert t == pytest.approx(10.0, rel=0.1)
    assert t == pytest.approx(acceleration_time(ROMO, 80.0 / 3.6), rel=0.03)


def test_axle_stiffness_of_the_romo_is_that_of_the_specification():
    """B C D = 75.1 kN/rad per axle with the corrected D; the axles carry 0.985 and 1.015 of half the weight."""
    front, rear = axle_stiffness(ROMO)
    assert 0.5 * (front + rear) == pytest.approx(75.1e3, rel=1e-3)


def test_friction_bounds_what_the_tyres_give():
    ice = PLANT.command(torque_cmd=160.0, friction=0.1)
    x = settle(PLANT, MACHINE, PLANT.initial(5.0), ice, 1.0)
    s, c = PLANT.named(x, ice)
    for wheel in PLANT.wheels(s, c):
        # the curve's peak is 1.46 times the nominal load
        assert np.hypot(wheel.longitudinal, wheel.side) <= 0.1 * 1.46 * 1.3 * wheel.load * (1.0 + 1e-9)


def test_a_car_without_the_sections_it_needs_is_refused():
    from powertrain import VehicleError

    bare = msgspec.structs.replace(ROMO, body=None)
    with pytest.raises(VehicleError, match=r"ROMO: the description has no section \[body\]"):
        DoubleTrack(bare)
    with pytest.raises(KeyError, match="no input of the plant"):
        PLANT.command(throttle=1.0)
    with pytest.raises(KeyError, match="no state of the plant"):
        PLANT.initial(1.0, speed_x=1.0)


def test_steering_drives_are_given_the_forces_of_their_own_wheels():
    """The plant's steering power, wheel by wheel from the tyre model and (3.40), written out here."""
    steering = PLANT.steering
    rng = np.random.default_rng(9)
    x = np.array(PLANT.initial(12.0)) + 0.01 * rng.standard_normal(len(PLANT.states))
    u = PLANT.command(torque_cmd=20.0, steer_cmd_fl=0.05, steer_cmd_rr=-0.02)
    s, c = PLANT.named(x, u)
    rate = dict(zip(PLANT.states, PLANT.derivative(x, u), strict=True))
    work = 0.0
    for k, (name, wheel) in enumerate(zip(WHEELS, PLANT.wheels(s, c), strict=True)):
        pull = wheel.longitudinal * steering.scrub_radius_m * (1.0 if k % 2 == 0 else -1.0)
        # the aligning moment turns the wheel back, against its side force
        assert np.sign(wheel.aligning) == -np.sign(wheel.side)
        torque = wheel.side * steering.caster_trail_m - wheel.aligning + pull
        inertia = steering.wheel_yaw_inertia_kgm2 + steering.gear_ratio**2 * steering.motor_inertia_kgm2
        work += (torque + inertia * rate[f"delta_rate_{name}"]) * s[f"delta_rate_{name}"]
    assert flows(PLANT, x, u)["steering_work"] == pytest.approx(work, rel=1e-9)


def test_commands_beyond_the_actuators_are_cut_and_reverse_driving_has_the_same_quadrants():
    plant = DoubleTrack(load_vehicle("compact"))
    machine, at = Machine(plant, 1e-3), {state: k for k, state in enumerate(plant.states)}
    wild = plant.command(brake_cmd=-1e4, steer_cmd=3.0, torque_cmd=1e4)
    x = settle(plant, machine, plant.initial(5.0), wild, 2.0)
    assert np.all(np.isfinite(x))
    assert x[at["clamp_fl"]] == pytest.approx(0.0, abs=1e-9)
    assert x[at["delta_fl"]] <= plant.steering.angle_max_rad + 1e-3
    assert x[at["torque_1"]] <= 250.0 + 1e-6
    # backwards from rest with the full driving torque; at speed backwards, recuperating with no more than recuperation may take
    x = settle(plant, machine, plant.initial(0.0), plant.command(torque_cmd=-250.0), 0.5)
    assert x[at["torque_1"]] == pytest.approx(-250.0, rel=1e-3)
    assert x[at["v_x"]] < -0.5
    x = settle(plant, machine, plant.initial(-20.0), plant.command(torque_cmd=250.0), 0.3)
    speed = plant.motor_speeds(plant.named(x, wild)[0])[0]
    assert 0.0 < x[at["torque_1"]] * abs(speed) <= 50e3 * 1.01


def test_a_car_without_four_turning_wheels_is_refused():
    from powertrain import VehicleError

    for change in ({"wheel_count": 3}, {"wheel_inertia_kgm2": 0.0}):
        chassis = msgspec.structs.replace(ROMO.chassis, **change)
        with pytest.raises(VehicleError, match="expected four with inertia for the double track"):
            DoubleTrack(msgspec.structs.replace(ROMO, chassis=chassis))
