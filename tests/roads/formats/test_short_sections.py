"""Lane sections too short to drive on, and values that no lane has: both are read past."""

from __future__ import annotations

import random
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

import roads
from roads import RoadError
from roads.formats.opendrive.reader import read_network

from .. import samples
from .test_opendrive import lane, read, road, section, write

WIDE = '<width sOffset="0" a="3.5" b="0" c="0" d="0"/>'


def linked(number: int, before: int | None = None, after: int | None = None, width: str = WIDE, more: str = "") -> str:
    ends = "".join(f'<{tag} id="{end}"/>' for tag, end in (("predecessor", before), ("successor", after)) if end is not None)
    return lane(number, width, more=f"<link>{ends}</link>{more}")


def line(x: float, length: float = 100.0) -> str:
    return f'<geometry s="0" x="{x}" y="0" hdg="0" length="{length}"><line/></geometry>'


@pytest.mark.parametrize("sliver", [0.0, 1e-7, 1e-5, 1e-3, 0.049])
def test_lanes_are_linked_across_a_sliver_that_numbers_them_anew(tmp_path: Path, sliver: float):
    # in the sliver a lane of no width lies inside: what was -1 is -2 there, and -1 again behind it
    nothing = '<width sOffset="0" a="0" b="0" c="0" d="0"/>'
    lanes = section("", linked(-1, after=-2)) + section("", linked(-1, width=nothing) + linked(-2, -1, -1), 40.0)
    lanes += section("", linked(-1, -2), 40.0 + sliver)
    network = roads.read_network(write(tmp_path, road(lanes=lanes)))
    # sections keep the numbers that they have in the file
    assert network.links["1/0/-1"].successors == ["1/2/-1"]
    assert list(network.links) == ["1/0/-1", "1/2/-1"]
    assert any("is skipped" in finding.message for finding in network.check())
    made = network.road("1")
    assert len(made.lanes) == 1
    assert np.allclose(made.lanes[0].right, -3.5)
    assert made.length == pytest.approx(100.0)


@pytest.mark.parametrize("count", [1, 3])
def test_slivers_at_the_ends_of_roads_lead_on_to_other_roads(tmp_path: Path, count: int):
    # road 1 ends, and road 2 begins, with slivers in which the lane is number -2; -1 is a lane that is only there
    def slivers(start: float, before: int, after: int) -> str:
        numbers = [before, *([-2] * (count - 1)), after]
        return "".join(section("", linked(-1) + linked(-2, numbers[k], numbers[k + 1]), start + 0.01 * k) for k in range(count))

    first = section("", linked(-1, after=-2)) + slivers(100.0 - 0.01 * count, -1, -2)
    second = slivers(0.0, -2, -1) + section("", linked(-1, before=-2, more='<speed sOffset="0" max="10"/>'), 0.01 * count)
    onto = '<link><successor elementType="road" elementId="2" contactPoint="start"/></link>'
    back = '<link><predecessor elementType="road" elementId="1" contactPoint="end"/></link>'
    network = roads.read_network(write(tmp_path, road(lanes=first, link=onto), road(line(100.0), lanes=second, identity="2", link=back)))
    assert network.links["1/0/-1"].successors == [f"2/{count}/-1"]
    made = network.route("1", "2")
    assert made.length == pytest.approx(200.0, abs=1e-6)
    assert np.allclose([made.driving_lane().right, made.driving_lane().left], [[-1.75], [1.75]], atol=1e-6)
    # what holds where the section begins holds where the road begins
    assert np.array_equal(made.speed_limit_at([99.0, 101.0]), [np.inf, 10.0])
    assert np.allclose(network.road("2").lanes[0].right, -3.5)


def test_connections_name_lanes_of_the_sliver_at_the_end_of_a_road(tmp_path: Path):
    first = section("", linked(-1, after=-2)) + section("", linked(-1) + linked(-2, before=-1), 99.97)
    onto = '<link><successor elementType="junction" elementId="9"/></link>'
    way = road(line(100.0, 20.0), lanes=section("", linked(-1, before=-2)), identity="2", length=20.0).replace('junction="-1"', 'junction="9"')
    junction = '<junction id="9"><connection id="0" incomingRoad="1" connectingRoad="2" contactPoint="start"><laneLink from="-2" to="-1"/>'
    network = roads.read_network(write(tmp_path, road(lanes=first, link=onto), way, junction + "</connection></junction>"))
    assert network.links["1/0/-1"].successors == ["2/0/-1"]


def test_any_sections_give_a_road_or_one_error(tmp_path: Path):
    rng = random.Random(4)
    for _ in range(60):
        starts = [0.0]
        for _ in range(rng.randint(0, 6)):
            starts.append(min(starts[-1] + rng.choice([0.0, 1e-7, 1e-6, 1e-5, 1e-3, 0.01, 0.03, 0.049, 0.06, 0.3, 40.0]), 100.0))
        if rng.random() < 0.3:
            starts[-1] = max(starts[-1], 100.0 - rng.choice([0.0, 1e-6, 1e-4, 0.02]))
        lanes = ""
        for start in starts:
            width = f'<width sOffset="{rng.choice([0, 0.01])}" a="{rng.choice([0, 3.5])}" b="{rng.choice([0, 0.05])}" c="0" d="0"/>'
            numbers = [-rng.randint(1, 3) for _ in range(2)]
            lanes += section("", "".join(linked(-k, *numbers, width=width) for k in range(1, rng.randint(2, 4))), start)
        network = roads.read_network(write(tmp_path, road(lanes=lanes)))
        # what cannot be made is an error with its place, nothing else is raised
        network.check()
        with suppress(RoadError):
            network.road("1")


def test_a_road_of_millimetres_is_crossed(tmp_path: Path):
    def onto(other: int) -> str:
        return f'<link><successor elementType="road" elementId="{other}" contactPoint="start"/></link>'

    parts = [road(lanes=section("", linked(-1, after=-1)), link=onto(2))]
    parts.append(road(line(100.0, 0.004), lanes=section("", linked(-1, after=-1)), identity="2", length=0.004, link=onto(3)))
    parts.append(road(line(100.004), lanes=section("", linked(-1)), identity="3"))
    assert roads.read_network(write(tmp_path, *parts)).route("1", "3").length == pytest.approx(200.004, abs=1e-6)


WRONG = {
    "friction": ('<material sOffset="0" friction="0"/>', "friction is 0, expected more than 0"),
    "no friction": ('<material sOffset="0" friction="wet"/>', "friction is 'wet', expected a finite number"),
    "unit": ('<speed sOffset="0" max="3" unit="knots"/>', "unit 'knots' and is taken as unknown, expected m/s, km/h or mph"),
    "speed": ('<speed sOffset="0" max="fast"/>', "max is 'fast', expected a finite number"),
    "link": ('<link><successor id="x"/></link>', "id is 'x', expected a finite number"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_value_that_no_lane_has_is_a_finding(tmp_path: Path, name: str):
    more, words = WRONG[name]
    network = roads.read_network(write(tmp_path, road(lanes=section("", lane(-1, more=more)))))
    (finding,) = [item for item in network.check() if item.severity == "warning"]
    assert words in finding.message
    made = network.road("1")
    assert np.all(made.friction == 1.0)
    assert np.all(np.isinf(made.speed_limit))


def test_wrong_values_of_other_formats_spare_the_rest(tmp_path: Path):
    text = samples.commonroad(tmp_path).read_text()
    (tmp_path / "a.xml").write_text(text.replace("<additionalValue>13.5<", "<additionalValue>-3<"))
    network = roads.read_network(tmp_path / "a.xml")
    assert np.isinf(network.links["1"].limits[0][1])
    assert any("speed limit is -3 m/s" in finding.message for finding in network.findings)
    text = samples.sumo(tmp_path).read_text()
    (tmp_path / "a.net.xml").write_text(text.replace('id="a_1" index="1" speed="13.89"', 'id="a_1" index="1" width="0" speed="0"'))
    network = roads.read_network(tmp_path / "a.net.xml")
    assert network.links["a_1"].end_widths == pytest.approx((3.2, 3.2))
    assert np.isinf(network.links["a_1"].limits[0][1])
    text = samples.lanelet2(tmp_path).read_text()
    (tmp_path / "a.osm").write_text(text.replace('<tag k="local_x" v="', '<tag k="local_x" v="x', 1))
    network = roads.read_network(tmp_path / "a.osm")
    # the lanelet of that node is lost, not the file
    assert {"2001", "2002"} <= set(network.links)
    assert "2003" not in network.links


def test_lanes_lead_on_across_a_lanelet_without_length(tmp_path: Path):
    def bound(side: str, x: tuple[float, float], y: float) -> str:
        return f"<{side}>" + "".join(f"<point><x>{place}</x><y>{y}</y></point>" for place in x) + f"</{side}>"

    ends = {1: (0.0, 50.0), 2: (50.0, 50.0), 3: (50.0, 90.0)}
    body = "".join(
        f'<lanelet id="{k}">{bound("leftBound", x, 3.5)}{bound("rightBound", x, 0.0)}<successor ref="{k + 1}"/></lanelet>' for k, x in ends.items()
    )
    path = tmp_path / "a.xml"
    path.write_text(f'<?xml version="1.0"?>\n<commonRoad commonRoadVersion="2020a">{body}</commonRoad>\n')
    network = roads.read_network(path)
    assert network.links["1"].successors == ["3"]
    assert network.route("1", "3").length == pytest.approx(90.0)


@pytest.mark.parametrize(("term", "known"), [("+x_0=0", True), ("+x_0=5", False), ("+x_0=abc", False)])
def test_only_a_plain_projection_tells_where_the_origin_is(tmp_path: Path, term: str, known: bool):
    path = write(tmp_path, road())
    reference = f"<geoReference>+proj=tmerc +lat_0=49 +lon_0=8 {term}</geoReference></header>"
    path.write_text(path.read_text().replace('<header revMajor="1" revMinor="7"/>', '<header revMajor="1" revMinor="7">' + reference))
    assert read_network(path).road("1").origin == ((49.0, 8.0) if known else None)


def test_widths_of_a_skipped_first_section_do_not_matter(tmp_path: Path):
    nothing = '<width sOffset="0" a="0" b="0" c="0" d="0"/>'
    steep = '<width sOffset="0" a="3.5" b="0" c="-2" d="0"/><width sOffset="0.1" a="3.48" b="0" c="0" d="0"/>'
    made = read(tmp_path, road(lanes=section("", linked(-1, after=-1, width=nothing)) + section("", linked(-1, width=steep), 0.02)))
    # the value where the section begins, not its cubic led back
    assert made.lanes[0].right[0] == pytest.approx(-3.5)
