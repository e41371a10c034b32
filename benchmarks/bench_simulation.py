"""The simulation: how many seconds of driving one core does in a second."""

from __future__ import annotations

import time
from unittest import mock

import pytest

from energy_mgr.simulation import drive, simulate
from powertrain import VehicleError, load_vehicle
from powertrain.chassis.compiled import compiler

from .bench_manager import planned

pytestmark = pytest.mark.benchmark(timer=time.process_time)

#: How the commute is driven.
DRIVES = {
    "plant in machine code": {"compiled": True},
    "plant interpreted": {"compiled": False},
    "plant in machine code, published sensors": {"compiled": True, "sensors": "real"},
}


@pytest.mark.parametrize("how", DRIVES)
def bench_commute(benchmark, how):
    """Control every 4 ms, plant every 1 ms; the drive alone, and all of `simulate`, which also builds plant and manager, and compiles."""
    benchmark.group = "simulation of the commute (2.5 km), edge to edge"
    if DRIVES[how]["compiled"] and not _has_compiler():
        pytest.skip("no C compiler")
    trajectory, car, spent = planned("commute", corridor="road"), load_vehicle("romo"), []
    run = drive._Loop.run

    def timed(*given):
        cpu, wall = time.process_time(), time.perf_counter()
        try:
            return run(*given)
        finally:
            spent.append((time.process_time() - cpu, time.perf_counter() - wall))

    began = time.perf_counter()
    with mock.patch.object(drive._Loop, "run", timed):
        driven = benchmark.pedantic(simulate, args=(trajectory, car), kwargs=DRIVES[how], rounds=2)
    whole = (time.perf_counter() - began) / len(spent)
    cpu, wall = (min(times) for times in zip(*spent, strict=True))
    words = [
        f"{driven.duration:.1f} s {driven.outcome}",
        f"best of 2: {driven.duration / cpu:.1f} times real time by CPU, {driven.duration / wall:.1f} by the clock",
        f"{driven.duration / whole:.1f} by the clock with building and compiling",
    ]
    benchmark.extra_info.update(method=how, ours=how == "plant in machine code", found="; ".join([*words, "asked 15"]))


def _has_compiler() -> bool:
    try:
        compiler()
    except VehicleError:
        return False
    return True
