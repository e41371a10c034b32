"""Small inputs of the kinds that users bring, each with the value that it was made from; they lie beside the data folder, not in the project.

Their kinds are tested on generated inputs too: tests/roads/conditioning, tests/roads/formats.
"""

import numpy as np
import pytest
from scipy.spatial import cKDTree

import roads
from energy_mgr import plan
from roads.formats.geodesy import to_degrees, to_plane

from ..conftest import DATA

CASES = DATA.parent / "cases"
pytestmark = pytest.mark.skipif(not CASES.is_dir(), reason="the cases beside ENERGY_MGR_DATA are not there")

#: File, length in m that it was made with and by how much it may miss, closed, a word of what is told of it.
TABLE = [
    ("antimeridian.gpx", 797.3, 0.5, False, "one lane of 3.5 m"),
    ("building_spike.gpx", 2026.6, 0.5, False, "no road could reach"),
    # the step of a degree printed with seven digits is a centimetre: 1,000 of them
    ("canal_jitter.gpx", 1000.9, 0.5, False, "heights smoothed"),
    ("gps_noise.gpx", 1559.0, 6.0, False, "line smoothed"),
    ("no_ele.gpx", 2026.6, 0.5, False, "taken as level"),
    ("out_and_back.gpx", 808.7, 0.5, False, "turns back on its own line at 809 m"),
    ("standstill_cloud.gpx", 799.0, 3.0, False, "1 stop drawn together"),
    ("two_segments_gap.gpx", 2026.6, 0.5, False, "gap of 77 m"),
    ("comma_decimal.csv", 766.0, 1.0, True, ""),
    # edges are straight between cones: the middle lies some centimetres inside
    ("cones_both_edges.csv", 40.0 * np.pi, 1.0, True, "left edge"),
]


@pytest.mark.parametrize(("name", "length", "miss", "closed", "word"), TABLE, ids=[row[0] for row in TABLE])
def test_a_case_is_the_road_that_it_was_made_from_and_is_planned(name: str, length: float, miss: float, closed: bool, word: str):
    road = roads.read(CASES / name)
    assert road.length == pytest.approx(length, abs=miss)
    assert road.closed is closed
    assert word in "\n".join(str(finding) for finding in road.findings)
    # all of them are level
    assert float(np.sum(np.abs(np.diff(road.height)))) < 0.3
    made = plan(road)
    assert made.chosen.path.report.certified
    assert made.chosen.profile.status.startswith("solved")


def test_the_noisy_line_lies_within_the_receivers_accuracy_of_the_truth():
    road = roads.read(CASES / "gps_noise.gpx")
    assert road.origin is not None
    lon, lat = to_degrees(road.reference.position(np.arange(0.0, road.length, 2.0)), road.origin).T
    points, _ = to_plane(lat, lon, (48.1, 11.3))
    x = np.arange(-30.0, 1530.0, 0.1)
    off, _ = cKDTree(np.column_stack([x, 80.0 * np.sin(x / 200.0)])).query(points)
    # 2.5 m of noise in 125 points
    assert np.sqrt(np.mean(off**2)) < 1.5
    assert off.max() < 3.5
