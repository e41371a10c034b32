"""Routes through real maps, where the data folder is at hand, are there exactly where the independent search gets through."""

from __future__ import annotations

from pathlib import Path

import pytest

from ...conftest import DATA
from . import driven, strips
from .test_routes_of_towns import faults

MAPS = sorted((DATA / "roads" / "opendrive").glob("*.xodr")) + sorted((DATA / "roads" / "commonroad").glob("*.xml"))
#: The search reads no links without a contact point, which the reader leads to the nearer end.
UNREAD = ("soderleden",)

pytestmark = [pytest.mark.slow, pytest.mark.skipif(not MAPS, reason="roads of ENERGY_MGR_DATA not there")]


@pytest.mark.parametrize("path", [path for path in MAPS if path.stem not in UNREAD], ids=lambda path: path.stem)
def test_lanes_of_a_real_map_are_routed_where_they_are_connected(path: Path):
    town = driven.opened(path, strips.opendrive(path)) if path.suffix == ".xodr" else driven.opened(path, strips.commonroad(path), rough=0.3)
    assert faults(town, 40, 1) == []
