"""Hard cases that were met once: each of these gave a wrong road, or a wrong error, before."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import roads
from roads import Road, RoadError
from roads.editing.smooth import smoothed
from roads.gallery.shelf import find

from . import samples
from .formats.test_opendrive import lane, road, section, write


@pytest.mark.parametrize("name", ["descent", "rural"])
def test_a_bend_on_a_grade_has_no_bank(name: str):
    made = roads.read_network(find(name)).route("1", "1")
    assert np.max(np.abs(made.bank)) < 1e-5


@pytest.mark.parametrize("radius", [500.0, 100.0, 30.0])
def test_a_change_of_lane_adds_no_noise_to_the_curvature(tmp_path: Path, radius: float):
    arc = f'<geometry s="0" x="0" y="0" hdg="0" length="180"><arc curvature="{1 / radius}"/></geometry>'
    path = write(tmp_path, road(arc, length=180.0, lanes=section("", lane(-1) + lane(-2))))
    made = roads.read_network(path).route("1/0/-1", "1/0/-2")
    before = made.reference.curvature(np.linspace(3.0, 90.0, 800))
    assert np.max(np.abs(before - 1.0 / (radius + 1.75))) < 2e-3 / radius**0.5
    # the change itself: 3.5 m aside in 80 m bends by 5.8 * 3.5 / 80^2 1/m at most
    assert np.max(np.abs(made.reference.curvature(np.linspace(0.0, made.length, 3000)))) < 1.0 / (radius + 5.3) + 0.006


def test_a_route_that_begins_in_the_middle_of_a_bend_begins_on_it(tmp_path: Path):
    arc = '<geometry s="0" x="0" y="0" hdg="0" length="90"><arc curvature="0.03333333333333333"/></geometry>'
    network = roads.read_network(write(tmp_path, road(arc, length=90.0)))
    begin, end = ((np.array([31.75 * np.sin(a), 30.0 - 31.75 * np.cos(a)])) for a in (0.71, 2.3))
    made = network.route(tuple(begin), tuple(end))
    away = np.hypot(*(made.reference.position(np.linspace(0.0, made.length, 400)) - [0.0, 30.0]).T)
    assert np.max(np.abs(away - 31.75)) < 1e-3
    assert np.max(np.abs(made.reference.curvature(np.linspace(0.0, made.length, 400)) - 1.0 / 31.75)) < 2e-4


def test_a_change_of_lane_needs_its_way(tmp_path: Path):
    network = roads.read_network(write(tmp_path, road(lanes=section("", lane(-1) + lane(-2)))))
    with pytest.raises(RoadError, match=r"changing from lane 1/0/-1 to 1/0/-2 takes at least 12 m, 5.0 m are left"):
        network.route((95.0, -1.75), "1/0/-2")


def test_a_road_as_place_means_from_its_beginning_to_its_end(tmp_path: Path):
    link = '<link><successor id="-1"/></link>'
    back = '<link><predecessor id="-1"/></link>'
    taper = '<width sOffset="0" a="0" b="0.14" c="0" d="0"/>'
    lanes = section(lane(1), lane(-1, more=link)) + section(lane(1), lane(-1, more=back + link) + lane(-2, taper), 25.0)
    lanes += section(lane(1), lane(-1, more=back), 50.0)
    network = roads.read_network(write(tmp_path, road(lanes=lanes.replace(back + link, back[:-7] + link[6:]))))
    made = network.route("1", "1")
    assert made.length == pytest.approx(100.0, abs=0.01)
    assert made.reference.position(0.0)[0] == pytest.approx(0.0, abs=1e-6)


def test_roads_that_nobody_can_drive_along_are_not_written(tmp_path: Path):
    one_way = roads.read(write(tmp_path, road(lanes=section("", lane(-1)))))
    for suffix in (".xodr", ".csv", ".geojson"):
        with pytest.raises(RoadError, match="no lane of .* leads in the direction of its stations"):
            roads.write(one_way.reversed(), tmp_path / f"a{suffix}")
        assert not (tmp_path / f"a{suffix}").exists()


def test_limits_are_those_of_the_lane_driven(tmp_path: Path):
    kinds = '<type s="0" type="town"><speed max="50" unit="km/h"/></type>'
    late = lane(-1, more='<speed sOffset="60" max="80" unit="km/h"/>')
    path = write(tmp_path, road(more=kinds, lanes=section(lane(1), late)))
    for made in (roads.read(path), roads.read_network(path).route("1/0/-1", "1/0/-1")):
        # before its own limit begins the lane has its road's
        assert np.allclose(made.speed_limit_at([10.0, 90.0]) * 3.6, [50.0, 80.0])
    unknown = lane(-1, more='<speed sOffset="0" max="0" unit="km/h"/>')
    assert roads.read(write(tmp_path, road(more=kinds, lanes=section("", unknown)))).speed_limit_at(10.0) == pytest.approx(50 / 3.6)
    fast, slow = (lane(number, more=f'<speed sOffset="0" max="{speed}" unit="km/h"/>') for number, speed in ((-1, 120), (-2, 80)))
    made = roads.read(write(tmp_path, road(lanes=section("", fast + slow))))
    assert made.driving_lane().name == "-2"
    assert np.allclose(made.speed_limit * 3.6, 80.0)


def test_a_route_from_the_middle_of_a_lane_meets_limits_where_they_stand(tmp_path: Path):
    kinds = '<type s="0" type="town"><speed max="50" unit="km/h"/></type>'
    late = lane(-1, more='<speed sOffset="60" max="80" unit="km/h"/>')
    made = roads.read_network(write(tmp_path, road(more=kinds, lanes=section(lane(1), late)))).route((40.0, -1.75), "1/0/-1")
    # the sign stands at 60 m, 20 m after the start
    assert np.allclose(3.6 * made.speed_limit_at([2.0, 18.0, 22.0, 58.0]), [50.0, 50.0, 80.0, 80.0])


def test_only_speed_limits_of_lanelet2_limit_the_speed(tmp_path: Path):
    text = samples.lanelet2(tmp_path).read_text()
    for old, new, limit in (
        ("de274-50", "de274-30", 30 / 3.6),
        ("de274-50", "usR2-1", np.inf),
        ("de274-50", "50 KM/H", 50 / 3.6),
        ('v="speed_limit"', 'v="right_of_way"', np.inf),
    ):
        (tmp_path / "b.osm").write_text(text.replace(old, new))
        assert roads.read_network(tmp_path / "b.osm").links["2001"].limits == ((0.0, pytest.approx(limit)),)


def test_geojson_keeps_what_the_road_has(tmp_path: Path):
    route = roads.read_network(find("roundabout")).route("west/0/1", "north")
    roads.write(route, tmp_path / "a.geojson")
    copy = roads.read(tmp_path / "a.geojson")
    assert np.allclose(copy.driving_lane().left, route.driving_lane().left, atol=1e-6)
    s = np.arange(0.0, 100.0, 5.0)
    points = np.column_stack([s, 0.0 * s])
    made = Road.from_points("x", points, -3.0, 3.0, bank=0.1, friction=0.3, lane_edges=[(0, -3.0, 3.0)], left_hand=True)
    for suffix in (".geojson", ".csv", ".xodr"):
        roads.write(made, tmp_path / f"b{suffix}")
        copy = roads.read(tmp_path / f"b{suffix}")
        assert (copy.left_hand, copy.lanes[0].direction) == (True, 0)
        assert np.allclose(copy.bank, 0.1)
        assert np.allclose(copy.friction, 0.3)


def test_edges_of_joined_roads_are_nowhere_wider_than_the_roads():
    narrow = Road.from_points("narrow", [[10.0 * k, 0.0] for k in range(11)], -1.75, 1.75)
    wide = Road.from_points("wide", [[100.0 + 10.0 * k, 0.0] for k in range(11)], -7.0, 7.0)
    made = roads.join([narrow, wide])
    assert np.allclose(np.interp([50.0, 95.0, 99.9, 100.1, 105.0], made.s, made.left), [1.75, 1.75, 1.75, 7.0, 7.0])
    route = roads.read_network(find("roundabout")).route("west/0/1", "north")
    again = roads.join([route[:200], route[200:]])
    assert np.allclose(np.interp(route.s, again.s, again.driving_lane().left), route.driving_lane().left, atol=0.02) or again.drive is not None


def test_heights_are_given_at_all_points_or_at_none(tmp_path: Path):
    path = samples.geojson(tmp_path)
    text = path.read_text()
    assert ", 500.0], [" in text
    path.write_text(text.replace(", 500.0], [", "], [", 1))
    with pytest.raises(RoadError, match="expected a height at all or none"):
        roads.read(path, width=7.0)


def test_a_lanelet_with_heights_at_some_points_takes_the_missing_ones_from_those(tmp_path: Path):
    path = samples.lanelet2(tmp_path)
    path.write_text(path.read_text().replace('<tag k="ele" v="500"/>', "", 1))
    network = roads.read_network(path)
    assert any("heights are led over" in finding.message for finding in network.findings)
    assert all(np.allclose(border[:, 2], 500.0) for link in network.links.values() for border in link.borders)


def test_left_hand_traffic_and_bus_lanes_of_sumo(tmp_path: Path):
    text = samples.sumo(tmp_path).read_text()
    left = tmp_path / "left.net.xml"
    left.write_text(text.replace('version="1.16"', 'version="1.16" lefthand="true"').replace("-1.60", "-8.00"))
    network = roads.read_network(left)
    # lane 0 is the outer one, now on the left
    assert (network.links["a_0"].right, network.links["a_1"].left) == ("a_1", "a_0")
    three = '<lane id="a_1" index="1" disallow="passenger" speed="13.89" length="100.00" shape="0.00,-1.60 100.00,-1.60"/>\n'
    three += '<lane id="a_2" index="2" speed="13.89" length="100.00" shape="0.00,1.60 100.00,1.60"/>'
    bus = tmp_path / "bus.net.xml"
    start = text.index('<lane id="a_1"')
    bus.write_text(text[:start] + three + text[text.index("\n", start) :])
    assert roads.read_network(bus).links["a_0"].left is None


HEADERS = {
    "remark after the header": "# x_m,y_m,w_tr_left_m,w_tr_right_m\n# lengths in metres\n",
    "header as a key": "# columns: x_m,y_m,w_tr_left_m,w_tr_right_m\n",
}


@pytest.mark.parametrize("name", HEADERS)
def test_headers_are_found_among_remarks(tmp_path: Path, name: str):
    (tmp_path / "a.csv").write_text(HEADERS[name] + "\n".join(f"{5 * k},0,1,5" for k in range(9)))
    made = roads.read(tmp_path / "a.csv")
    assert (made.right[0], made.left[0]) == (-5.0, 1.0)


def test_headers_that_do_not_fit_are_refused(tmp_path: Path):
    (tmp_path / "a.csv").write_text("# x_m,y_m,w_tr_left_m,w_tr_right_m,more\n" + "\n".join(f"{5 * k},0,1,5" for k in range(9)))
    with pytest.raises(RoadError, match="4 columns, expected 5 as in line 1"):
        roads.read(tmp_path / "a.csv")
    (tmp_path / "b.csv").write_text("x_km,y_km,psi_deg,v_kmh\n0,0,0,50\n0.1,0,0,50\n0.2,0,0,50\n")
    with pytest.raises(RoadError, match=r"b\.csv:1: column x_km is in km, expected m"):
        roads.read(tmp_path / "b.csv", lane=3.5, width=7.0)


def test_closed_means_the_same_in_all_tables(tmp_path: Path):
    path = samples.edges(tmp_path)
    path.write_text("# closed: yes\n" + path.read_text())
    with pytest.raises(RoadError, match="closed is 'yes', expected true or false"):
        roads.read(path)


def test_own_lanes_reach_no_further_than_they_are():
    s = np.arange(0.0, 101.0, 10.0)
    right = np.where(s >= 50.0, 3.5, np.nan)
    made = Road.from_points("x", np.column_stack([s, 0.0 * s]), -3.5, 7.0, lane_edges=[(1, -3.5, 3.5), (1, right, right + 3.5)])
    _, left = made.corridor("own").borders([45.0, 50.0, 60.0, 100.0])
    assert np.allclose(left, [3.5, 3.5, 7.0, 7.0])


def test_an_open_arc_is_not_closed(tmp_path: Path):
    angle = np.linspace(0.0, 0.8 * 2 * np.pi, 9)
    (tmp_path / "a.csv").write_text("\n".join(f"{50 * np.cos(a)},{50 * np.sin(a)},2,2" for a in angle))
    assert not roads.read(tmp_path / "a.csv").closed


def test_columns_turn_with_the_road(tmp_path: Path):
    made = roads.read(samples.path_csv(tmp_path), lane=3.5, width=7.0)
    back = made.reversed()
    turn = back.columns["psi"] - back.reference.heading(back.s)
    assert np.max(np.abs((turn + np.pi) % (2 * np.pi) - np.pi)) < 5e-3
    assert np.allclose(back.columns["kappa"], -made.columns["kappa"][::-1])
    assert np.allclose(back.columns["s"], back.s, atol=0.01)


def test_smoothing_keeps_the_ends_of_an_open_road():
    s = np.append(np.arange(0.0, 300.0, 3.0), 297.03)
    noise = np.random.default_rng(1).normal(0.0, 0.1, len(s))
    made, _ = smoothed(Road.from_points("x", np.column_stack([s, noise]), -3.0, 3.0), 0.3)
    assert np.allclose(made.reference.position(0.0), [0.0, noise[0]], atol=1e-6)
    assert np.allclose(made.reference.position(made.length), [297.03, noise[-1]], atol=1e-6)
    assert np.min(np.diff(made.s)) > 0.0


def test_names_stay_on_one_line(tmp_path: Path):
    made = Road.from_points("a\nclosed: true\x00\ud800", [[0.0, 0.0], [5.0, 0.0], [10.0, 0.0]], -2.0, 2.0)
    assert made.name.isprintable()
    for suffix in (".csv", ".xodr", ".geojson"):
        roads.write(made, tmp_path / f"a{suffix}")
        assert roads.read(tmp_path / f"a{suffix}").name == made.name


def test_links_without_contact_point_are_taken_by_position(tmp_path: Path):
    import re

    text = find("roundabout").read_text()
    (tmp_path / "a.xodr").write_text(re.sub(r'(<(?:predecessor|successor) [^>]*) contactPoint="\w+"', r"\1", text))
    lost, kept = roads.read_network(tmp_path / "a.xodr"), roads.read_network(find("roundabout"))
    assert {name: link.successors for name, link in lost.links.items()} == {name: link.successors for name, link in kept.links.items()}


@pytest.mark.parametrize("bad", [[[np.nan, 0.0]], [[np.inf, 0.0]]])
def test_places_that_are_no_numbers_are_refused(bad: list[list[float]]):
    with pytest.raises(RoadError, match="point 0 is not finite"):
        samples.bend().reference.locate(bad)
