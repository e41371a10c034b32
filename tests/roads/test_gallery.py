from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import roads
from roads.gallery.archetypes import ROADS, roundabout
from roads.gallery.shelf import find


def assert_same(one: Path, other: Path) -> None:
    """Two XML files with the same elements and attributes; numbers may differ by what another processor's last digits grow to along a road."""
    here, there = (list(ElementTree.parse(path).iter()) for path in (one, other))
    assert [element.tag for element in here] == [element.tag for element in there]
    for mine, theirs in zip(here, there, strict=True):
        assert mine.attrib.keys() == theirs.attrib.keys()
        for key, value in mine.attrib.items():
            assert value == theirs.attrib[key] or float(value) == pytest.approx(float(theirs.attrib[key]), rel=1e-9, abs=1e-9), (mine.tag, key)


def test_a_number_a_name_or_an_element_that_differs_is_seen(tmp_path: Path):
    text = find("commute").read_text()
    for old, new in (('length="', 'length="1'), ('name="', 'name="x'), ("<geometry ", "<geometry2 ")):
        damaged = text.replace(old, new, 1).replace("</geometry>", "</geometry2>", 1 if "2" in new else 0)
        assert damaged != text
        (tmp_path / "damaged.xodr").write_text(damaged)
        with pytest.raises((AssertionError, ValueError)):
            assert_same(tmp_path / "damaged.xodr", find("commute"))


@pytest.mark.parametrize("make", ROADS)
def test_stored_file_is_what_the_builder_makes(make, tmp_path: Path):
    made = make()
    roads.write(made, tmp_path / "again.xodr")
    assert_same(tmp_path / "again.xodr", find(made.name))
    stored = roads.open_road(made.name)
    s = np.linspace(0.0, made.length, 3001)
    assert np.max(np.hypot(*(made.reference.position(s) - stored.reference.position(s)).T)) < 1e-4
    assert np.max(np.abs(made.height_at(s) - stored.height_at(s))) < 1e-3
    inner = s[1:-1] + 0.3
    assert np.mean(made.speed_limit_at(inner) != stored.speed_limit_at(inner)) < 0.002


def test_stored_network_is_what_the_builder_makes(tmp_path: Path):
    roundabout().write(tmp_path / "again.xodr")
    assert_same(tmp_path / "again.xodr", find("roundabout"))


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
