"""Routes through towns made by the tests are planned, and the plans are certified."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from energy_mgr import plan
from energy_mgr.speed.checks import check_profile
from powertrain import Vehicle

from ...roads.networks.driven import Town
from ...roads.networks.test_routes_of_towns import made, pairs

#: Shorter routes are no drive to plan, and narrower ones none for a car, m.
SHORTEST, NARROWEST = 40.0, 2.6
#: So many drives through each of ten towns.
DRIVES = 5


def drivable(town: Town, seed: int):
    """Routes wide enough for a car with what its driver keeps from the borders."""
    for start, goal in pairs(town, 400, np.random.default_rng(seed)):
        if town.judge(start, goal):
            road = town.network.route(town.names[start], town.names[goal])
            lane = road.driving_lane()
            if road.length >= SHORTEST and np.min(lane.left - lane.right) >= NARROWEST:
                yield f"{start} to {goal}", road


def certified_drives(folder: Path, seed: int, romo: Vehicle, count: int) -> None:
    drives = drivable(made(folder, seed), seed)
    for where, road in (next(drives) for _ in range(count)):
        chosen = plan(road, romo).chosen
        assert chosen.path.report.certified, where
        check_profile(chosen.limits, chosen.profile.v, chosen.profile.brake)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10, 20))
def test_plans_along_routes_are_certified(tmp_path: Path, seed: int, romo: Vehicle):
    certified_drives(tmp_path, seed, romo, DRIVES)
