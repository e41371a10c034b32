"""The car: a step of the plant interpreted, compiled and in batches; the whole car; a million losses. The peer is CommonRoad's multi-body model."""

import numpy as np
import pytest
from vehiclemodels.parameters_vehicle2 import parameters_vehicle2
from vehiclemodels.vehicle_dynamics_mb import vehicle_dynamics_mb

from powertrain import load_vehicle, motor_losses
from powertrain.chassis import DoubleTrack, Machine
from powertrain.errors import VehicleError
from powertrain.plant import Plant
from powertrain.tyre import MagicTyre, read_tir

CARS = 1000
STEP = "plant, one step of 1 ms (RK4, 42 states)"
MANY = f"plant, {CARS} cars by one step of 1 ms; figures are for all of them"


def driving():
    """A car in a bend, and what drives it."""
    plant = DoubleTrack(load_vehicle("romo"))
    machine = Machine(plant, 1e-3)
    u = np.array(plant.command(torque_cmd=20.0, steer_cmd_fl=0.02, steer_cmd_fr=0.02))
    x = np.array(plant.initial(10.0))
    for _ in range(500):
        x = machine.step(x, u)
    return machine, x, u


def compiled(machine):
    try:
        machine.compile_c()
    except VehicleError as error:
        pytest.skip(str(error))


@pytest.mark.parametrize("how", ["interpreted", "compiled C"])
def bench_step(benchmark, how):
    benchmark.group = STEP
    machine, x, u = driving()
    if how == "compiled C":
        compiled(machine)
    benchmark.pedantic(machine.step, args=(x, u), rounds=200, iterations=200, warmup_rounds=5)
    found = f"{machine._step.n_instructions()} operations; asked {'15' if how == 'interpreted' else '3'} us"
    benchmark.extra_info.update(method=f"ours, {how}", ours=how == "interpreted", found=found)


def bench_step_without_python(benchmark):
    """The compiled step alone, called through its buffers on arrays that stay where they are."""
    benchmark.group = STEP
    machine, x, u = driving()
    compiled(machine)
    machine.step(x, u)
    benchmark.pedantic(machine._run, rounds=200, iterations=200, warmup_rounds=5)
    benchmark.extra_info.update(method="ours, compiled C, arrays kept", ours=False, found="asked 3 us")


def bench_peer_step(benchmark):
    """CommonRoad's multi-body model (29 states) by the same RK4: it is plain Python and offers no faster call."""
    benchmark.group = STEP
    p = parameters_vehicle2()
    x = np.zeros(29)
    x[3], x[23:27] = 10.0, 10.0 / p.R_w
    # the axles sunk into their tyres, which carry the car
    x[[16, 21]] = 0.5 * 9.81 * p.m / 2.0 / p.K_zt
    h = 1e-3

    def step():
        k1 = np.array(vehicle_dynamics_mb(x.tolist(), [0.0, 0.0], p))
        k2 = np.array(vehicle_dynamics_mb((x + 0.5 * h * k1).tolist(), [0.0, 0.0], p))
        k3 = np.array(vehicle_dynamics_mb((x + 0.5 * h * k2).tolist(), [0.0, 0.0], p))
        k4 = np.array(vehicle_dynamics_mb((x + h * k3).tolist(), [0.0, 0.0], p))
        return x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)

    benchmark.pedantic(step, rounds=50, iterations=5, warmup_rounds=2)
    benchmark.extra_info.update(method="commonroad-vehicle-models MB", ours=False, found="29 states, plain Python")


@pytest.mark.parametrize("how", ["one by one, interpreted", "NumPy", "compiled C"])
def bench_batch(benchmark, how):
    benchmark.group = MANY
    machine, x, u = driving()
    many = np.ascontiguousarray(np.tile(x[:, None], (1, CARS)) * (1.0 + 1e-3 * np.random.default_rng(0).standard_normal((len(x), CARS))))
    if how == "compiled C":
        compiled(machine)

    def one_by_one():
        for k in range(CARS):
            machine.step(many[:, k], u)

    work = one_by_one if how.startswith("one") else lambda: machine.batch(many, u)
    benchmark.pedantic(work, rounds=15, warmup_rounds=2)
    benchmark.extra_info.update(method=f"ours, {how}", ours=how == "compiled C", found="asked: 20 times less per car than one by one")


def bench_whole_car(benchmark):
    """A step of the plant with its ledger and its battery, which follows every fourth step."""
    benchmark.group = "whole car with ledger and battery, one step of 1 ms"
    plant = Plant(load_vehicle("romo"), speed=10.0)
    u = np.array(plant.body.command(torque_cmd=10.0))
    benchmark.pedantic(plant.step, args=(u,), rounds=200, iterations=40, warmup_rounds=5)
    benchmark.extra_info.update(method="ours", ours=True, found="22 integrals beside 42 states")


def bench_losses(benchmark):
    benchmark.group = "a million operating points"
    car, rng = load_vehicle("romo"), np.random.default_rng(1)
    torque, speed = rng.uniform(-160.0, 160.0, 1_000_000), rng.uniform(0.0, 100.0, 1_000_000)
    benchmark.pedantic(lambda: sum(motor_losses(car, torque, speed)), rounds=15, warmup_rounds=2)
    benchmark.extra_info.update(method="motor losses (3.39)", ours=True, found="asked 0.1 s")


@pytest.mark.parametrize("model", ["magic", "MF 6.1"])
def bench_tyres(benchmark, model):
    benchmark.group = "a million operating points"
    tyre = load_vehicle("romo").tyre if model == "magic" else read_tir("car205_60r15")
    assert model != "magic" or isinstance(tyre, MagicTyre)
    rng = np.random.default_rng(1)
    kappa, alpha, load = rng.uniform(-0.1, 0.1, 1_000_000), rng.uniform(-0.1, 0.1, 1_000_000), rng.uniform(1e3, 6e3, 1_000_000)
    benchmark.pedantic(lambda: tyre.forces(kappa, alpha, load), rounds=5, warmup_rounds=1)
    benchmark.extra_info.update(method=f"tyre, {model}", ours=True, found="forces and moment, combined slip")
