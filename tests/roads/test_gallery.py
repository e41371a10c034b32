import re
from pathlib import Path

import numpy as np
import pytest

import roads
from roads.gallery.archetypes import ROADS, roundabout
from roads.gallery.shelf import find

NUMBER = re.compile(r"-?\d+\.?\d*(?:e-?\d+)?")


def assert_same_file(made: Path, stored: Path):
    """The same text but for rounding: sines of other processors differ in their last digits."""
    texts = made.read_text(), stored.read_text()
    assert NUMBER.sub("#", texts[0]) == NUMBER.sub("#", texts[1])
    ours, theirs = (np.array(NUMBER.findall(text), dtype=float) for text in texts)
    # places in m up to some thousand, with which 1e-12 of a heading grows
    assert np.allclose(ours, theirs, rtol=1e-10, atol=1e-9)


@pytest.mark.parametrize("make", ROADS)
def test_stored_file_is_what_the_builder_makes(make, tmp_path: Path):
    made = make()
    roads.write(made, tmp_path / "again.xodr")
    assert_same_file(tmp_path / "again.xodr", find(made.name))
    stored = roads.open_road(made.name)
    s = np.linspace(0.0, made.length, 3001)
    assert np.max(np.hypot(*(made.reference.position(s) - stored.reference.position(s)).T)) < 1e-4
    assert np.max(np.abs(made.height_at(s) - stored.height_at(s))) < 1e-3
    inner = s[1:-1] + 0.3
    assert np.mean(made.speed_limit_at(inner) != stored.speed_limit_at(inner)) < 0.002


def test_stored_network_is_what_the_builder_makes(tmp_path: Path):
    roundabout().write(tmp_path / "again.xodr")
    assert_same_file(tmp_path / "again.xodr", find("roundabout"))


def test_handling_course_closes_smoothly():
    road = roads.open_road("handling")
    assert road.closed
    before, after = road.length - 1e-6, 1e-6
    assert np.allclose(road.reference.position(before), road.reference.position(after), atol=1e-5)
    assert road.reference.heading(road.length) - road.reference.heading(0.0) == pytest.approx(2 * np.pi, abs=1e-6)


def test_archetypes_have_the_features_of_the_published_roads():
    commute, rural, descent = (roads.open_road(name) for name in ("commute", "rural", "descent"))
    assert [round(road.length) for road in (commute, rural, descent)] == [2500, 3000, 3000]
    assert np.ptp(commute.height) == 0.0
    assert 20.0 < np.ptp(rural.height) <= 40.0
    assert descent.height[0] - descent.height[-1] == pytest.approx(120.0, abs=1e-6)
    # integral of squared curvature of the published descent, calibrated in the specification to about 0.72 1/m over 2 km
    assert 0.5 < descent.lane_centre().squared_curvature() < 0.9
