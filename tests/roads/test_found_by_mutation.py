"""Maps that once ended in a traceback, in gigabytes or in a lane without width: found by mutation and in made towns, cut down to what it takes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import roads
from roads import RoadError
from roads.check import check

from .formats.test_mutated_maps import bounded_memory
from .formats.test_opendrive import lane, road, section, write
from .networks.test_reachable import linked
from .samples import commonroad

WIDE = linked(-1, -1, -1) + linked(-2, -2, -2)


@pytest.mark.parametrize("size", [0.0, 1e-9, 1e-7, 1e-5, 1e-4, 0.003, 0.02])
@pytest.mark.parametrize("at", [0.0, 50.0, 100.0])
def test_sections_of_no_length_change_nothing(tmp_path: Path, size: float, at: float):
    starts = [*sorted({0.0, at} - {100.0}), at + size if at < 100.0 else 100.0 - size]
    rows = "".join(section("", WIDE, s=s) for s in starts)
    network = roads.read_network(write(tmp_path, road(lanes=rows)))
    for link in network.links.values():
        left, right = link.borders
        assert np.allclose(np.hypot(*(left - right)[:, :2].T), 3.5, atol=1e-6), link.id
    made = network.road("1")
    s = np.linspace(0.0, 100.0, 2001)
    drive = made.driving_lane()
    assert np.allclose(np.interp(s, made.s, drive.left), -3.5, atol=1e-6)
    assert np.allclose(np.interp(s, made.s, drive.right), -7.0, atol=1e-6)
    way = network.route((1.0, -1.75), (99.0, -1.75))
    assert way.length == pytest.approx(98.0, abs=1e-6)
    assert not [finding for finding in check(network.path) if finding.severity == "error"]


@pytest.mark.parametrize("size", [0.0, 1e-7, 0.003, 0.02, 0.3])
def test_a_short_section_with_other_numbers_leads_on(tmp_path: Path, size: float):
    ghost = lane(-1, '<width sOffset="0" a="0" b="0" c="0" d="0"/>', "none")
    rows = section("", linked(-1, after=-2)) + section("", ghost + linked(-2, -1, -1), s=50.0) + section("", linked(-1, -2), s=50.0 + size)
    network = roads.read_network(write(tmp_path, road(lanes=rows)))
    assert network.route((1.0, -1.75), (99.0, -1.75)).length == pytest.approx(98.0, abs=1e-6)


def test_a_road_may_begin_with_a_ramp(tmp_path: Path):
    rows = section("", linked(-1, after=-1, kind="entry")) + section("", linked(-1, before=-1), s=50.0)
    made = roads.read(write(tmp_path, road(lanes=rows)))
    assert made.length == pytest.approx(100.0)
    assert np.allclose(made.driving_lane().right, -3.5, atol=1e-6)


@pytest.mark.parametrize("spiral", [("9", "0.1"), ("0", "9"), ("-9", "9")])
def test_a_spiral_of_hundreds_of_turns_takes_no_gigabytes(tmp_path: Path, spiral: tuple[str, str]):
    shape = '<spiral curvStart="{}" curvEnd="{}"/>'.format(*spiral)
    path = write(tmp_path, road(f'<geometry s="0" x="0" y="0" hdg="0" length="300">{shape}</geometry>', length=300.0))
    with bounded_memory(300 << 20):
        try:
            assert roads.read(path).length == pytest.approx(300.0, rel=0.01)
        except RoadError as error:
            assert str(path) in str(error)  # noqa: PT017  both ends are right


def test_a_file_without_a_lane_for_cars_is_checked(tmp_path: Path):
    path = write(tmp_path, road(lanes=section("", lane(-1, kind="sidewalk"))))
    assert "no lane for cars" in " ".join(finding.message for finding in check(path))
    with pytest.raises(RoadError, match="made"):
        roads.read_network(path).route((10.0, 0.0), (90.0, 0.0))


def test_lanes_that_lead_nowhere_may_still_be_changed_between(tmp_path: Path):
    network = roads.read_network(write(tmp_path, road(lanes=section("", lane(-1) + lane(-2)))))
    assert network.route("1/0/-1", "1/0/-2").length == pytest.approx(100.0, abs=0.5)


def test_a_place_on_a_lane_too_narrow_to_drive(tmp_path: Path):
    narrow = '<width sOffset="0" a="1.5" b="0" c="0" d="0"/>'
    network = roads.read_network(write(tmp_path, road(lanes=section("", lane(-1) + lane(-2, narrow)))))
    try:
        assert network.route((10.0, -4.25), (90.0, -1.75)).length == pytest.approx(80.0, abs=1.0)
    except RoadError as error:
        assert "-2" in str(error)  # noqa: PT017  both ends are right


@pytest.mark.parametrize("length", np.arange(9.0, 18.0, 0.5).tolist())
@pytest.mark.parametrize("bend", [0.04, -0.04])
def test_a_change_in_a_bend_needs_its_way_on_both_lanes(tmp_path: Path, length: float, bend: float):
    """The outer lane of a bend is longer: what is too short on the inner one is no change, what is long enough on both is one."""
    plan = f'<geometry s="0" x="0" y="0" hdg="0" length="{length + 20.0}"><arc curvature="{bend}"/></geometry>'
    rows = section("", linked(-1) + linked(-2, after=-2)) + section("", linked(-1) + linked(-2, before=-2), s=length)
    network = roads.read_network(write(tmp_path, road(plan, rows, length + 20.0)))
    both = [length * (1.0 + side * bend) for side in (1.75, 5.25)]
    try:
        made = network.route("1/0/-1", "1/1/-2")
    except RoadError:
        assert min(both) < 12.0 + 0.3
    else:
        assert max(both) > 12.0 - 0.3
        assert made.length > 0.75 * (length + 20.0)


def test_borders_with_a_point_twice_at_opposite_ends(tmp_path: Path):
    """The left border repeats its first point, the right one its last: pairs by number lie a point apart along the way."""
    text = commonroad(tmp_path).read_text()
    path = tmp_path / "twice.xml"
    lanelet = text[text.index('<lanelet id="2">') :]
    (first, *_), right = lanelet.split("<leftBound>")[1].split("</point>"), lanelet[lanelet.index("<rightBound>") : lanelet.index("</rightBound>")]
    last = right.rsplit("<point>", 1)[1]
    made = lanelet.replace("<leftBound>", f"<leftBound>{first}</point>", 1).replace("</rightBound>", f"<point>{last}</rightBound>", 1)
    path.write_text(text.replace(lanelet, made))
    plain, twice = (roads.read_network(file).route("1", "2") for file in (tmp_path / "bend2020a.xml", path))
    s = np.linspace(0.0, plain.length, 200)
    lane_s = np.interp(s, twice.s, twice.driving_lane().left - twice.driving_lane().right)
    assert twice.length == pytest.approx(plain.length, abs=0.05)
    assert np.allclose(lane_s, 3.5, atol=0.05)
