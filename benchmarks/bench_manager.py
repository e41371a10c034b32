"""The energy manager: its step in closed loop with the plant, over 100 000 periods, and by part.

Processor time of one thread. The closed loop is what a step lives in: between two steps the plant has had the caches.
"""

from __future__ import annotations

import contextlib
import gc
import math
import os
import sys
import time
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import energy_mgr
from energy_mgr import Trajectory
from energy_mgr.manager import EnergyManager, Measurements, WheelCommands
from energy_mgr.simulation.sensing import IdealSensing
from powertrain import Plant, VehicleError, load_vehicle

pytestmark = pytest.mark.benchmark(timer=time.process_time)

#: Periods of the long run, and those after which memory is taken for settled.
STEPS, WARM = 100_000, 2000
#: Periods that parts are timed over.
PART = 5000
_PLANE = ("x", "y", "psi", "v_x", "v_y", "yaw_rate")


@cache
def planned(road: str, **options: str) -> Trajectory:
    return energy_mgr.plan(road, "romo", **options).trajectory


class ClosedLoop:
    """Laps of `handling`: plant (in machine code where there is a compiler), ideal sensors, manager; nothing is recorded."""

    def __init__(self, **options) -> None:
        trajectory, car = planned("handling"), load_vehicle("romo")
        self.manager = EnergyManager(car, trajectory, **options)
        start = trajectory.point(float(trajectory.s[0]))
        self.plant = Plant(car, speed=start.v, dt=1e-3, battery_every=20)
        with contextlib.suppress(VehicleError):
            self.plant.compile_c()
        self._plane = [self.plant.body.states.index(name) for name in _PLANE]
        self.plant.state[self._plane[:3]] = start.x, start.y, start.psi
        self.plant.state[self._plane[5]] = start.kappa * start.v
        self._sensing, self._before, self._accelerations = IdealSensing(self.plant), (start.v, 0.0), (0.0, 0.0)

    def measured(self) -> tuple[Measurements, float]:
        """What the manager's step takes."""
        t = self.plant.time
        return self._sensing.measure(t, self.plant, *self._accelerations, 1.0), t

    def drive(self, commands: WheelCommands) -> None:
        """One period under `commands`."""
        point, period = self.manager.following.at.point, self.manager.period
        self.plant.advance([*commands.inputs, point.slope, math.tan(point.bank), 1.0], round(period / self.plant.dt))
        v_x, v_y, yaw_rate = self.plant.state[self._plane[3:]].tolist()
        self._accelerations = (v_x - self._before[0]) / period - yaw_rate * v_y, (v_y - self._before[1]) / period + yaw_rate * v_x
        self._before = v_x, v_y

    def steps(self, spent: np.ndarray) -> np.ndarray:
        """As many steps as `spent` (steps, 2) has rows; it takes their CPU and wall times, ns."""
        manager, cpu, wall = self.manager, time.thread_time_ns, time.perf_counter_ns
        for k in range(len(spent)):
            m, t = self.measured()
            began, clock = wall(), cpu()
            commands = manager.step(m, t)
            spent[k] = cpu() - clock, wall() - began
            self.drive(commands)
        return spent


def times(count: int) -> np.ndarray:
    """Room for the times of so many steps, written to, so that its pages are there."""
    return np.full((count, 2), -1, dtype=np.int64)


# -- the whole step -----------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("heap", ["as it is", "frozen"])
def bench_long_run(benchmark, heap):
    """From the first step on, with garbage collection as a user has it; `frozen`: for who calls `gc.freeze` before driving."""
    benchmark.group = f"manager, {STEPS} steps in closed loop; figures are for one"
    gc.enable()
    loop, spent = ClosedLoop(), times(STEPS)
    if heap == "frozen":
        gc.collect()
        gc.freeze()
    loop.steps(spent[:WARM])
    memory = _memory()
    loop.steps(spent[WARM:])
    gc.collect()
    grown = [after - before for after, before in zip(_memory(), memory, strict=True)]
    gc.unfreeze()
    cpu, wall = 1e-3 * spent.T
    manager = loop.manager
    assert manager.errors == 0
    assert not any(manager.refused.values())
    report(benchmark, 1e-6 * cpu)
    words = [
        f"CPU: {_spread(cpu)}, {int(np.sum(cpu > 1e3))} above 1 ms",
        f"by the clock: {_spread(wall)}",
        f"memory {grown[0] / 1024:+.0f} KiB resident, {grown[1]:+d} blocks of Python",
        f"{_resolution():.2f} us of it are the timer's",
        "asked: median 150, p99.9 1000 us",
    ]
    benchmark.extra_info.update(method=f"ours, heap {heap}", ours=heap == "as it is", found="; ".join(words))


def _spread(us) -> str:
    return f"median {np.median(us):.0f}, p99.9 {np.quantile(us, 0.999):.0f}, max {us.max():.0f} us"


def _memory() -> tuple[int, int]:
    """Resident bytes, and blocks that Python has allocated."""
    resident = int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    return resident, sys.getallocatedblocks()


def _resolution() -> float:
    """Of the clock that is used, from one call to the next, us: the times are too long by this."""
    ticks = np.array([time.thread_time_ns() for _ in range(10_000)])
    return 1e-3 * float(np.median(np.diff(ticks)))


@pytest.mark.parametrize("allocator", ["efficient", "preview", "two-step", "weighted", "minimum-norm", "equal-split"])
def bench_step(benchmark, allocator):
    benchmark.group = "manager, one step in closed loop, by allocator"
    step_in_loop(benchmark, ClosedLoop(allocator=allocator))
    benchmark.extra_info.update(method=f"linearising, {allocator}", ours=allocator == "efficient")


@pytest.mark.parametrize("law", ["geometric", "pd"])
def bench_law(benchmark, law):
    benchmark.group = "manager, one step in closed loop, by allocator"
    step_in_loop(benchmark, ClosedLoop(follower=law))
    benchmark.extra_info.update(method=f"{law}, efficient", ours=False)


def step_in_loop(benchmark, loop: ClosedLoop) -> None:
    """Time `step`; the plant drives between rounds, with the commands of the round before."""
    last: list[WheelCommands] = []

    def setup():
        if last:
            loop.drive(last.pop())
        return loop.measured(), {}

    benchmark.pedantic(lambda m, t: last.append(loop.manager.step(m, t)), setup=setup, rounds=PART, warmup_rounds=200)


# -- by part ------------------------------------------------------------------------------------------------------------------------------

PARTS = ("step", "guard", "observer", "monitor", "follower", "projection", "allocate", "commands")


@pytest.mark.parametrize("part", PARTS)
def bench_part(benchmark, part):
    """One part of the step, timed in the closed loop, one at a time so that no timer is within another."""
    benchmark.group = "manager, parts of a step in closed loop"
    loop = ClosedLoop()
    manager = loop.manager
    place, name = {
        "step": (manager, "step"),
        "guard": (manager._guard, "reason"),
        "observer": (manager._observer, "update"),
        "monitor": (manager._monitor, "update"),
        "follower": (manager.follower, "step"),
        "projection": (manager.follower.projection, "update"),
        "allocate": (manager.allocator, "allocate"),
        "commands": (manager, "_commands"),
    }[part]
    work, calls = getattr(place, name), []
    loop.steps(times(200))
    clock = time.process_time

    def timed(*given):
        began = clock()
        answer = work(*given)
        calls.append(clock() - began)
        return answer

    setattr(place, name, timed)
    loop.steps(times(PART))
    report(benchmark, calls)
    within = " (within follower)" if part == "projection" else ""
    benchmark.extra_info.update(method=f"{part}{within}", ours=part == "step", found=f"p99.9 {1e6 * np.quantile(calls, 0.999):.0f} us")


def report(benchmark, seconds) -> None:
    """Give pytest-benchmark times that were taken already."""
    ticks = iter(np.cumsum(np.column_stack([np.zeros(len(seconds)), seconds]).ravel()).tolist())
    benchmark._timer = lambda: next(ticks)
    benchmark.pedantic(lambda: None, rounds=len(seconds))
