"""Routes through towns made here are there exactly where a careful driver gets through, and can be driven."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ..towns import lanelets, layout, xodr
from . import driven, strips


def made(folder: Path, seed: int, *, big: bool = False) -> driven.Town:
    """A town of that seed; every other one has ramps, every third one keeps left."""
    rng = np.random.default_rng([20261128, seed])
    town = layout.town(rng, 4 if big else 3, 3 if big else 2, ramps=seed % 2 == 0, left_hand=seed % 3 == 0, dirt=0.1 * (seed % 4 > 0))
    path = folder / f"town{seed}.xodr"
    path.write_text(xodr.text(town))
    return driven.opened(path, strips.opendrive(path))


def made_of_lanelets(folder: Path, seed: int, *, big: bool = False) -> driven.Town:
    """The lanes of such a town in a file of lanelets."""
    path = folder / f"lanelets{seed}.xml"
    path.write_text(lanelets.text(made(folder, seed, big=big).judge.careful, np.random.default_rng(seed)))
    return driven.opened(path, strips.commonroad(path), rough=max(lanelets.LAST))


def pairs(town: driven.Town, count: int, rng: np.random.Generator) -> list[tuple[str, str]]:
    """Lanes from whose beginning to whose end the way is asked for; those where that hangs on the limits are left out."""
    names, found = list(town.names), []
    while len(found) < count:
        start, goal = (names[int(k)] for k in rng.integers(len(names), size=2))
        if town.judge(start, goal) is not None:
            found.append((start, goal))
    return found


def faults(town: driven.Town, count: int, seed: int) -> list[str]:
    missing = [name for name in town.judge.careful.real if name not in town.names]
    found = [f"no lane of the network lies where {name} does" for name in missing]
    for start, goal in pairs(town, count, np.random.default_rng(seed)):
        fault = driven.fault_of(town, start, goal)
        if fault is not None:
            found.append(f"{Path(town.network.path).name}: {town.names[start]} to {town.names[goal]}: {fault}")
    return found


@pytest.mark.parametrize("seed", range(4))
def test_lanes_that_are_connected_are_routed_and_no_others(tmp_path: Path, seed: int):
    assert faults(made(tmp_path, seed), 15, seed) == []


@pytest.mark.parametrize("seed", range(2))
def test_lanelets_that_are_connected_are_routed_and_no_others(tmp_path: Path, seed: int):
    assert faults(made_of_lanelets(tmp_path, seed), 15, seed) == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10, 20))
def test_lanes_of_larger_towns_are_routed_where_they_are_connected(tmp_path: Path, seed: int):
    assert faults(made(tmp_path, seed, big=True), 50, seed) == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20, 26))
def test_lanelets_of_larger_towns_are_routed_where_they_are_connected(tmp_path: Path, seed: int):
    assert faults(made_of_lanelets(tmp_path, seed, big=True), 50, seed) == []


def test_the_towns_hold_what_they_are_made_for(tmp_path: Path):
    """Both answers are frequent, tapers, slips and lies are there: a town of straight lanes would prove nothing."""
    verdicts, tapers, slips, missed = [], 0, 0, 0
    for seed in range(4):
        town = made(tmp_path, seed)
        careful = town.judge.careful
        rng = np.random.default_rng(seed)
        verdicts += [town.judge(*pair) for pair in pairs(town, 30, rng)]
        tapers += sum(not careful.open[name][[0, -1]].all() for name in careful.real)
        slips += sum(strip.tiny for strip in town.strips.values())
        missed += sum(not careful.onward[name] for name, strip in careful.real.items() if strip.ahead and careful.open[name][-1])
    assert 0.2 < np.mean(verdicts) < 0.8
    assert tapers > 40
    assert slips > 40
    assert missed > 10
