"""The speed: forward-backward against TOPP-RA, eco against IPOPT, cone programmes and dynamic programming; growth with length; race tracks.

Processor time of one thread, on the same stations and limits. `found` says what else was asked for. Limits are made beforehand, not timed.
"""

from __future__ import annotations

import os
import time
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from unittest import mock

import casadi
import numpy as np
import pytest
import toppra
import toppra.algorithm
import toppra.constraint

import roads
from energy_mgr import SpeedLimits, plan_path
from energy_mgr.speed import Comfort, EcoSolver, Lateral, Posted, fastest_profile, plan_speed
from energy_mgr.speed.result import energy_of
from powertrain import load_vehicle

from .hilly_road import limits_on_hills
from .peers.plain_ipopt import plain_profile

pytestmark = pytest.mark.benchmark(timer=time.process_time)

ROADS = ("commute", "rural", "descent")
DATA = Path(os.environ.get("ENERGY_MGR_DATA", Path(__file__).parents[2] / "shared" / "data"))
TRACKS = sorted((DATA / "roads" / "tum").glob("*.csv"))
#: Arrival time over the least possible one.
LATER = 1.08
LENGTHS = (2.5, 5.0, 10.0, 25.0, 50.0, 100.0)
KWH = 3.6e6

#: What benchmarks of a session found, for those that compare: best energy in J by problem, seconds by kilometres.
ENERGIES: dict[str, float] = {}
SECONDS: dict[float, float] = {}


@cache
def limits_on(name: str) -> SpeedLimits:
    road = roads.open_road(name)
    return SpeedLimits.along(road, plan_path(road, 1.05, extent="road"), load_vehicle("romo"))


@cache
def limits_on_track(track: Path) -> SpeedLimits:
    road = roads.read(track)
    return SpeedLimits.along(road, plan_path(road, 1.05, extent="road"), load_vehicle("romo"))


# -- least time ---------------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [1000, 5000, 20000])
@pytest.mark.parametrize("motors", [False, True], ids=["speeds and accelerations", "with motors"])
def bench_forward_backward(benchmark, count, motors):
    benchmark.group = f"least time, {count} stations 2 m apart"
    limits = hills(count, motors=motors)
    profile = benchmark.pedantic(fastest_profile, args=(limits,), rounds=31, warmup_rounds=2)
    per_thousand = 1e6 * benchmark.stats.stats.median / count
    label = "forward-backward, with motors" if motors else "forward-backward"
    found = f"{profile.journey_time:.4f} s; {per_thousand:.2f} ms per 1000 stations"
    if motors:
        found += f"; {100 * (profile.journey_time / fastest_profile(hills(count)).journey_time - 1):+.4f} % time by motors"
    benchmark.extra_info.update(method=label, ours=not motors, found=found)


@pytest.mark.parametrize("count", [1000, 5000, 20000])
def bench_toppra(benchmark, count):
    benchmark.group = f"least time, {count} stations 2 m apart"
    limits = hills(count)
    rates = benchmark.pedantic(toppra_rates, args=(limits,), rounds=5 if count < 20000 else 3, warmup_rounds=1)
    duration = float(np.sum(2 * limits.ds / (rates[1:] + rates[:-1])))
    off = 100 * (fastest_profile(limits).journey_time / duration - 1)
    benchmark.extra_info.update(method="TOPP-RA, seidel", found=f"{duration:.4f} s; forward-backward {off:+.5f} %")


@pytest.mark.parametrize("count", [1000, 5000])
def bench_toppra_with_motors(benchmark, count):
    benchmark.group = f"least time, {count} stations 2 m apart"
    limits = hills(count, motors=True)
    profile = benchmark.pedantic(plan_speed, args=(limits, "toppra"), rounds=3, warmup_rounds=1)
    off = 100 * (fastest_profile(limits).journey_time / profile.journey_time - 1)
    label = f"TOPP-RA, with motors by tangents, {profile.iterations} solves"
    benchmark.extra_info.update(method=label, found=f"{profile.journey_time:.4f} s; forward-backward with motors {off:+.5f} %")


def hills(count: int, *, motors: bool = False) -> SpeedLimits:
    """Limits of the kinds that both methods know; or these and the motors'."""
    return limits_on_hills(0.002 * (count - 1), count, parts=None if motors else (Posted(), Lateral(), Comfort()))


def toppra_rates(limits: SpeedLimits) -> np.ndarray:
    """Speeds by TOPP-RA on a path that is its own length."""
    bound = np.sqrt(2 * limits.energy_max) + 1e-9
    most = float(limits.acceleration[0]), float(limits.deceleration[0])
    path = toppra.SplineInterpolator(limits.s, limits.s[:, None])
    speed = toppra.constraint.JointVelocityConstraintVarying(lambda s: np.array([[-1.0, 1.0]]) * np.interp(s, limits.s, bound))
    comfort = toppra.constraint.JointAccelerationConstraint(np.array([[-most[1], most[0]]]))
    solver = toppra.algorithm.TOPPRA([speed, comfort], path, gridpoints=limits.s, solver_wrapper="seidel")
    return solver.compute_parameterization(0.0, 0.0)[1]


# -- least energy -------------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ROADS)
@pytest.mark.parametrize("method", ["eco", "eco, kept", "nlp", "plain nlp", "socp", "dp"])
def bench_least_energy(benchmark, name, method):
    least_energy(benchmark, limits_on(name), method, name)


@pytest.mark.parametrize("track", TRACKS, ids=lambda path: path.stem)
@pytest.mark.parametrize("method", ["eco", "nlp"])
def bench_tracks(benchmark, track, method):
    least_energy(benchmark, limits_on_track(track), method, track.stem)


@pytest.mark.parametrize("name", ROADS)
def bench_front(benchmark, name):
    benchmark.group = f"front of 20 points, {name}, 2 m"
    limits = limits_on(name)
    front = benchmark.pedantic(lambda: EcoSolver(limits).front(20), rounds=3, warmup_rounds=0)
    text = f"{front.journey_time[0]:.1f} to {front.journey_time[-1]:.1f} s, {front.energy[0] / KWH:.4f} to {front.energy[-1] / KWH:.4f} kWh"
    benchmark.extra_info.update(method="eco, each from the last", ours=True, found=f"{text}, worst gap {100 * np.nanmax(front.gap):.1e} %")


LABELS = {
    "eco": "eco: interior point, true losses",
    "eco, kept": "eco, without building",
    "nlp": "nlp: IPOPT, true losses, mapped derivatives",
    "plain nlp": "IPOPT, true losses, derivatives by CasADi",
    "socp": "socp: cone programmes, Clarabel",
    "dp": "dp: grid of 200 speeds, refined 3 times",
}


def least_energy(benchmark, limits: SpeedLimits, method: str, name: str) -> None:
    """Time a method, and say how far its energy is from IPOPT's on the same problem."""
    benchmark.group = f"least energy, {name}, {len(limits.s)} stations"
    allowed = LATER * fastest_profile(limits).journey_time
    solver = EcoSolver(limits)
    run = {
        "eco, kept": lambda: solver.arriving(allowed),
        "plain nlp": lambda: plain_profile(limits, allowed),
    }.get(method, lambda: plan_speed(limits, method, journey_time=allowed))
    with timed_solvers() as inside:
        profile = benchmark.pedantic(run, rounds=1 if method in ("dp", "plain nlp") else 5, warmup_rounds=int(method != "dp"))
    energy = energy_of(limits, profile).total
    if name not in ENERGIES:
        ENERGIES[name] = energy_of(limits, plan_speed(limits, "nlp", journey_time=allowed)).total
    above = 100 * (energy - ENERGIES[name]) / abs(ENERGIES[name])
    words = [f"{energy / KWH:.8f} kWh in {profile.journey_time:.3f} s, {above:+.5f} % of nlp's"]
    if np.isfinite(profile.gap):
        words.append(f"gap {100 * profile.gap:.1e} %")
    if inside:
        words.append(f"solver without building {1e3 * np.median(inside):.0f} ms")
    benchmark.extra_info.update(method=LABELS[method], ours=method == "eco", found=", ".join(words))


@contextmanager
def timed_solvers():
    """Processor seconds of each call of a solver that CasADi builds meanwhile."""
    seconds, build = [], casadi.nlpsol

    class Timed:
        def __init__(self, *given):
            self.solver = build(*given)

        def __call__(self, **given):
            started = time.process_time()
            answer = self.solver(**given)
            seconds.append(time.process_time() - started)
            return answer

        def stats(self):
            return self.solver.stats()

    with mock.patch.object(casadi, "nlpsol", Timed):
        yield seconds


# -- growth -------------------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kilometres", LENGTHS)
def bench_length(benchmark, kilometres):
    benchmark.group = f"least energy, hilly road of {kilometres:g} km, 5 m"
    limits = limits_on_hills(kilometres, round(200 * kilometres) + 1)
    allowed = LATER * fastest_profile(limits).journey_time
    profile = benchmark.pedantic(plan_speed, args=(limits, "eco"), kwargs={"journey_time": allowed}, rounds=3, warmup_rounds=int(kilometres < 20))
    SECONDS[kilometres] = benchmark.stats.stats.median
    words = f"{energy_of(limits, profile).total / KWH:.4f} kWh, gap {100 * profile.gap:.1e} %, {profile.iterations} iterations, {profile.status}"
    if len(SECONDS) > 1:
        exponent = np.polyfit(np.log(list(SECONDS)), np.log(list(SECONDS.values())), 1)[0]
        words += f"; exponent from {min(SECONDS):g} km on {exponent:.2f}"
    benchmark.extra_info.update(method=LABELS["eco"], ours=True, found=words)
