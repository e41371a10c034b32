from pathlib import Path

import numpy as np
import pytest

import roads
from roads import NetworkBuilder, RoadBuilder, RoadError
from roads.gallery.shelf import find


@pytest.fixture(scope="module")
def town() -> roads.Network:
    return roads.read_network(find("roundabout"))


def test_route_leads_round_the_roundabout(town: roads.Network):
    lanes = [step.link.id for group in town.steps("west/0/1", "east") for step in group]
    assert lanes[0] == "west/0/1"
    assert lanes[1:3] == ["west in/0/-1", "ring after west/0/-1"]
    assert lanes[-2:] == ["east out/0/-1", "east/0/-1"]
    # counter-clockwise: past the south, not the north
    assert "ring past south/0/-1" in lanes
    assert "ring past north/0/-1" not in lanes


def test_route_is_smooth_across_its_links(town: roads.Network):
    road = town.route("west/0/1", "north")
    # where the way in meets the ring and leaves it the curvature changes at once by 0.2 1/m; a curve with continuous curvature rounds that off
    # over 0.1 m, which turns its heading there by 2 mrad and moves it by less than 0.1 mm
    for angle in (np.pi + np.radians(25.0), 2.5 * np.pi - np.radians(25.0)):
        s, off = road.reference.locate([[16.25 * np.cos(angle), 16.25 * np.sin(angle)]])
        assert abs(off[0]) < 1e-4
        turn = float(road.reference.heading(s[0])) - (angle + 0.5 * np.pi)
        assert abs((turn + np.pi) % (2 * np.pi) - np.pi) < 3e-3
    # and the reference is the middle of the lanes driven, within 1 mm
    for group in town.steps("west/0/1", "north"):
        for step in group:
            _, off = road.reference.locate(step.link.centre[:, :2])
            assert np.max(np.abs(off)) < 1e-3


def test_borders_of_a_route_are_those_of_its_lanes(town: roads.Network):
    road = town.route("west/0/1", "north")
    edge = road.reference.position(road.s) + road.right[:, None] * road.reference.normal(road.s)
    lines = [step.link.borders[1][:, :2] for group in town.steps("west/0/1", "north") for step in group]
    dense = np.concatenate(
        [np.column_stack([np.interp(np.linspace(0, 1, 3000), np.linspace(0, 1, len(line)), line[:, k]) for k in (0, 1)]) for line in lines]
    )
    from scipy.spatial import cKDTree

    distance, _ = cKDTree(dense).query(edge)
    # points of the borders are 0.1 m apart; steps of the edge where links meet lie between two borders
    assert np.quantile(distance, 0.97) < 0.06


def test_all_ways_from_every_arm(town: roads.Network):
    for begin in ("north", "south", "east", "west"):
        for end in ("north", "south", "east", "west"):
            road = town.route(f"{begin}/0/1", f"{end}/0/-1")
            assert np.max(np.abs(road.reference.curvature(np.linspace(0, road.length, 2000)))) < 0.2
            assert np.min(road.left - road.right) > 3.4


def test_positions_mean_the_lane_they_lie_in(town: roads.Network):
    link, s, distance = town.nearest(100.0, -1.75)
    # east of the ring the lane on the south side leads outwards
    assert (link, distance) == ("east/0/-1", pytest.approx(0.0, abs=1e-6))
    assert s == pytest.approx(60.0, abs=1e-6)
    road = town.route((100.0, 1.75), (-100.0, 1.75))
    assert np.allclose(road.reference.position(0.0), [100.0, 1.75], atol=1e-6)
    assert np.allclose(road.reference.position(road.length), [-100.0, 1.75], atol=1e-6)


def test_a_goal_behind_the_start_needs_a_way_round(town: roads.Network):
    # along the ring it exists, on an arm it does not
    road = town.route("ring after north/0/-1", "ring past north/0/-1")
    assert road.length > 2 * np.pi * 16 * 0.8
    with pytest.raises(RoadError, match="no way from"):
        town.route("east/0/-1", "east/0/1")


def test_unknown_places_are_named(town: roads.Network):
    for start, words in (("nowhere", "no road or lane 'nowhere', expected an id such as"), ((1e6, 0.0), r"is \d+ m from the nearest lane")):
        with pytest.raises(RoadError, match=words):
            town.route(start, "east")
    with pytest.raises(RoadError, match="expected finite numbers"):
        town.route((np.nan, 0.0), "east")
    with pytest.raises(RoadError, match="no road 'x', expected one of"):
        town.road("x")
    with pytest.raises(RoadError, match="expected length, time or a function"):
        town.route("west/0/1", "east", cost="beauty")  # type: ignore[arg-type]


def grid() -> NetworkBuilder:
    """From a to d: along b, 200 m on a motorway, or along c, 120 m up a hill on a track."""
    net = NetworkBuilder("choice")

    def straight(x: float, y: float, heading: float, length: float):
        return RoadBuilder("x", (x, y), heading).straight(length).elements()

    net.road("a", straight(0, 0, 0, 50), left=[], limit=20)
    bow = RoadBuilder("b", (50.0, 0.0), 0.0).bend(40, np.radians(60), 10).bend(40, np.radians(-120), 10).bend(40, np.radians(60), 10)
    (x, _), _ = bow.end()
    net.road("b", bow.elements(), left=[], limit=30, junction="1")
    net.road("c", straight(50, 0, 0, x - 50), left=[], limit=3, junction="1")
    net.road("d", straight(x, 0, 0, 50), left=[], limit=20)
    net.enters("1", ("a", "end"))
    for way in "bc":
        net.connect("1", ("a", "end"), way, ("d", "start"), (-1, -1, -1))
    return net


def test_cost_decides_the_way(tmp_path):
    grid().write(tmp_path / "choice.xodr")
    network = roads.read_network(tmp_path / "choice.xodr")

    def way(cost) -> list[str]:
        return [step.link.road for group in network.steps("a", "d", cost=cost) for step in group]

    assert way("length") == ["a", "c", "d"]
    assert way("time") == ["a", "b", "d"]
    assert way(lambda s, height, limit: float(np.sum(np.diff(s) / limit[:-1]))) == ["a", "b", "d"]
    # a cost may be negative, as downhill
    assert way(lambda s, height, limit: -float(s[-1])) == ["a", "b", "d"]
    with pytest.raises(RoadError, match="is not a number"):
        way(lambda s, height, limit: float("nan"))


def around(radius: float) -> np.ndarray:
    """From the end of 200 m on the x axis back to their beginning, by half circles to the left (positive radius) or right: points (n, 2)."""
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 40)
    bow = np.column_stack([np.abs(radius) * np.cos(angle), radius * (1.0 + np.sin(angle))])
    return np.vstack([bow + np.array([200.0, 0.0]), [[x, 2.0 * radius] for x in range(190, 0, -10)], [[0.0, 2.0 * radius]] - (bow - bow[0])])


@pytest.mark.parametrize("first", [10.0, 290.0])
def test_the_way_round_is_the_shorter_one_wherever_its_long_lane_lies(first: float):
    # from the end of `home` back to its beginning: by `one` and `two`, 300 m, or by `other` and `way`, 340 m
    after = {"home": ["one", "other"], "one": ["two"], "two": ["home"], "other": ["way"], "way": ["home"]}
    lines = {"home": np.column_stack([np.linspace(0.0, 200.0, 41), np.zeros(41)])}
    for names, radius, cut in ((("one", "two"), 50.0 / np.pi, first), (("other", "way"), -70.0 / np.pi, 170.0)):
        line = around(radius)
        s = np.append(0.0, np.cumsum(np.hypot(*np.diff(line, axis=0).T)))
        for name, ends in zip(names, ((0.0, cut), (cut, s[-1])), strict=True):
            at = np.linspace(*ends, int(ends[1] - ends[0]) + 2)
            lines[name] = np.column_stack([np.interp(at, s, line[:, axis]) for axis in (0, 1)])

    def link(name: str) -> roads.Link:
        way = np.gradient(lines[name], axis=0)
        normal = np.column_stack([-way[:, 1], way[:, 0], np.zeros(len(way))]) / np.hypot(*way.T)[:, None]
        line = np.column_stack([lines[name], np.zeros(len(way))])
        return roads.Link(name, name, "driving", lambda: (line + 1.75 * normal, line - 1.75 * normal), after[name], beside=(name,), against=(False,))

    network = roads.Network("ring", "ring", "made here", {name: link(name) for name in lines}, dict.fromkeys(lines, 1.0))
    steps = [step for group in network.steps((150.0, 0.0), (50.0, 0.0)) for step in group]
    assert [step.link.id for step in steps] == ["home", "one", "two", "home"]
    assert [(steps[k].start, steps[k].end) for k in (0, -1)] == [pytest.approx((150.0, 200.0)), pytest.approx((0.0, 50.0))]


def test_a_cost_that_falls_on_a_ring_is_refused(town: roads.Network):
    with pytest.raises(RoadError, match="falls without end"):
        town.route("west/0/1", "east", cost=lambda s, height, limit: -1.0)


def test_joints_of_a_network_are_checked(tmp_path):
    net = grid()
    net.write(tmp_path / "a.xodr")
    text = (tmp_path / "a.xodr").read_text()
    # move d away by 10 m
    (tmp_path / "b.xodr").write_text(text.replace('y="0" hdg="0" length="50"', 'y="10" hdg="0" length="50"').replace('x="0" y="10"', 'x="0" y="0"'))
    with pytest.raises(RoadError, match=r"lane d/0/-1 begins 10.00 m"):
        roads.read_network(tmp_path / "b.xodr").route("a", "d")
    with pytest.raises(RoadError, match="is there already"):
        net.road("a", [])
    with pytest.raises(RoadError, match="no start of road 'q'"):
        net.enters("1", ("q", "start"))


def test_a_banked_lane_is_as_wide_as_its_surface(tmp_path: Path):
    lane = '<lane id="{0}" type="driving"><width sOffset="0" a="3" b="0" c="0" d="0"/></lane>'
    path = tmp_path / "bank.xodr"
    path.write_text(
        '<OpenDRIVE><header revMajor="1" revMinor="6"/><road name="" length="200" id="1" junction="-1"><planView>'
        '<geometry s="0" x="0" y="0" hdg="0" length="200"><line/></geometry></planView>'
        '<lateralProfile><superelevation s="0" a="0.9" b="0" c="0" d="0"/></lateralProfile>'
        '<lanes><laneSection s="0"><center><lane id="0" type="none"/></center>'
        f"<right>{lane.format(-1)}{lane.format(-2)}</right></laneSection></lanes>"
        "</road></OpenDRIVE>"
    )
    network = roads.read_network(path)
    # seen from above it is 3 cos 0.9 = 1.86 m wide, which would be too narrow
    assert network.links["1/0/-1"].end_widths == pytest.approx((3.0, 3.0))
    assert network.route("1/0/-1", "1/0/-2").length == pytest.approx(200.0, abs=0.1)
