"""The speed: the cone programme against IPOPT on the true losses; forward-backward against TOPP-RA. Same stations, same limits."""

from functools import cache

import numpy as np
import pytest
import toppra
import toppra.algorithm
import toppra.constraint

import roads
from energy_mgr import SpeedLimits, plan_path
from energy_mgr.speed import eco_profile, fastest_profile
from energy_mgr.speed.nlp import nlp_profile
from powertrain import drive_energy, load_vehicle

ROADS = ("commute", "rural", "descent")


@cache
def limits_on(name):
    road = roads.open_road(name)
    return SpeedLimits.along(road, plan_path(road, 1.05, extent="road"), load_vehicle("romo"))


@pytest.mark.parametrize("name", ROADS)
@pytest.mark.parametrize("method", [eco_profile, nlp_profile])
def bench_least_energy(benchmark, name, method):
    benchmark.group = f"least energy, {name}, 2 m"
    limits = limits_on(name)
    allowed = 1.08 * fastest_profile(limits).journey_time
    profile = benchmark.pedantic(method, args=(limits, allowed), rounds=5, warmup_rounds=1)
    energy = drive_energy(limits.vehicle, profile.s, profile.v, limits.z).total / 3.6e6
    label = {"eco_profile": "cone programmes, Clarabel", "nlp_profile": "IPOPT, true losses, with building"}[method.__name__]
    benchmark.extra_info.update(method=label, ours=method is eco_profile, found=f"{energy:.8f} kWh in {profile.journey_time:.3f} s")


@pytest.mark.parametrize("name", ROADS)
def bench_forward_backward(benchmark, name):
    benchmark.group = f"least time, {name}, 2 m"
    profile = benchmark(fastest_profile, limits_on(name))
    benchmark.extra_info.update(method="forward-backward, with motor limits", ours=True, found=f"{profile.journey_time:.4f} s")


@pytest.mark.parametrize("name", ROADS)
def bench_toppra(benchmark, name):
    benchmark.group = f"least time, {name}, 2 m"
    limits = limits_on(name)
    bound = np.sqrt(2 * limits.energy_max) + 1e-9

    def solve():
        path = toppra.SplineInterpolator(limits.s, limits.s[:, None])
        speed = toppra.constraint.JointVelocityConstraintVarying(lambda s: np.array([[-1.0, 1.0]]) * np.interp(s, limits.s, bound))
        grip = toppra.constraint.JointAccelerationConstraint(np.array([[-2.0, 2.0]]))
        solver = toppra.algorithm.TOPPRA([speed, grip], path, gridpoints=limits.s, solver_wrapper="seidel")
        return solver.compute_parameterization(0.0, 0.0)[1]

    rates = benchmark.pedantic(solve, rounds=5, warmup_rounds=1)
    benchmark.extra_info.update(method="TOPP-RA, seidel, without motor limits", found=f"{np.sum(2 * limits.ds / (rates[1:] + rates[:-1])):.4f} s")
