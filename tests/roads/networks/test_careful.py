"""What a careful driver can and cannot drive, and that a route is a road along which the car can be driven."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest

import roads
from roads import RoadError
from roads.gallery.shelf import find
from roads.networks.shortest import shortest

from ..formats.test_opendrive import lane, road, section, write
from ..formats.test_short_sections import line, linked
from .dirty import cut_up


def onto(other: int, contact: str = "start") -> str:
    return f'<link><successor elementType="road" elementId="{other}" contactPoint="{contact}"/></link>'


def sharpest(made: roads.Road) -> float:
    return float(np.max(np.abs(made.reference.curvature(np.linspace(0.0, made.length, int(20 * made.length) + 2)))))


@pytest.mark.parametrize("seed", [1, 2])
def test_sections_cut_up_with_slivers_change_no_route(tmp_path: Path, seed: int):
    clean = roads.read_network(find("roundabout"))
    dirty = roads.read_network(cut_up(Path(find("roundabout")), tmp_path / "dirty.xodr", seed))
    assert len(dirty.links) > 1.5 * len(clean.links)
    for begin, end in product(("north", "south"), ("east", "west")):
        one, other = clean.route(begin, end), dirty.route(begin, end)
        assert other.length == pytest.approx(one.length, abs=1e-3)
        s = np.linspace(0.0, min(one.length, other.length), 300)
        assert np.allclose(other.reference.position(s), one.reference.position(s), atol=2e-3)
        assert np.min(other.driving_lane().left - other.driving_lane().right) > 3.4


def turn_lane(folder: Path, opens: float, stays: float) -> Path:
    """A lane that opens from no width beside the one that leads on, over `opens` m, stays for `stays` m and leads to road 2; -1 ends there."""
    taper = f'<width sOffset="0" a="0" b="{3.5 / opens}" c="0" d="0"/>'
    lanes = section("", linked(-1, after=-1)) + section("", linked(-1, before=-1, after=-1) + linked(-2, after=-2, width=taper), 30.0)
    lanes += section("", linked(-1, before=-1) + linked(-2, before=-2, after=-1), 30.0 + opens)
    length = 30.0 + opens + stays
    after = road(line(length), section("", linked(-1)), identity="2").replace('y="0"', 'y="-3.5"')
    return write(folder, road(line(0.0, length), lanes, length, link=onto(2)), after)


def test_a_lane_that_opens_from_no_width_is_changed_to_once_it_is_wide_enough(tmp_path: Path):
    network = roads.read_network(turn_lane(tmp_path, 30.0, 40.0))
    made = network.route("1", "2")
    assert sharpest(made) < 0.03
    y = made.reference.position(np.linspace(0.0, made.length, 400))[:, 1]
    assert np.all(np.diff(y) < 1e-5)
    assert (y[0], y[-1]) == (pytest.approx(-1.75, abs=1e-6), pytest.approx(-5.25, abs=1e-6))
    # the lane is 2 m wide 17.1 m after it begins to open: nobody leaves the other one before that
    before = made.reference.position(np.linspace(0.0, 47.0, 50))[:, 1]
    assert np.allclose(before, -1.75, atol=1e-4)
    lane = made.driving_lane()
    assert np.min(lane.left - lane.right) > 1.99
    # the change leads over two sections, and both list it
    assert [[step.link.id for step in group] for group in network.steps("1", "2")] == [
        ["1/0/-1"],
        ["1/1/-1", "1/1/-2"],
        ["1/2/-1", "1/2/-2"],
        ["2/0/-1"],
    ]


@pytest.mark.parametrize(("stays", "room"), [(8.0, True), (6.0, False)])
def test_room_for_a_change_counts_over_several_sections(tmp_path: Path, stays: float, room: bool):
    # of the 10 m on which the lane opens, the last 4.29 m are wide enough
    network = roads.read_network(turn_lane(tmp_path, 10.0, stays))
    if room:
        assert network.route("1", "2").length > 140.0
    else:
        with pytest.raises(RoadError, match=r"changing from lane 1/2/-1 to 1/2/-2 takes at least 12 m, 10.3 m are left"):
            network.route("1", "2")


@pytest.mark.parametrize(("length", "room"), [(24.5, True), (23.5, False)])
def test_two_changes_take_twice_the_way(tmp_path: Path, length: float, room: bool):
    lanes = section("", linked(-1) + linked(-2) + linked(-3, after=-1))
    after = road(line(length), section("", linked(-1)), identity="2").replace('y="0"', 'y="-7"')
    network = roads.read_network(write(tmp_path, road(line(0.0, length), lanes, length, link=onto(2)), after))
    if not room:
        with pytest.raises(RoadError, match=r"changing from lane 1/0/-1 to 1/0/-3 takes at least 24 m, 23.5 m are left"):
            network.route("1/0/-1", "2")
        return
    made = network.route("1/0/-1", "2")
    # each takes half of the room
    x, y = made.reference.position(np.linspace(0.0, made.length, 2000)).T
    assert np.interp([0.5 * length, length], x, y) == pytest.approx([-5.25, -8.75], abs=0.02)


def test_a_link_that_contradicts_the_geometry_is_no_way(tmp_path: Path):
    """From 1 to 4 by 2, whose lane begins 5 m aside, or by 3, which is longer."""
    start = road(lanes=section("", linked(-1, after=-1)), link='<link><successor elementType="junction" elementId="9"/></link>')

    def way(number: int, plan: str, length: float) -> str:
        made = road(plan, section("", linked(-1, before=-1, after=-1)), length, identity=str(number), link=onto(4))
        return made.replace('junction="-1"', 'junction="9"')

    aside = line(100.0, 20.0).replace('y="0"', 'y="5"')
    angle = 0.6
    bow = "".join(
        f'<geometry s="{k * 10 * angle}" x="{x}" y="{y}" hdg="{h}" length="{10 * angle * (1 + (k == 1))}"><arc curvature="{c}"/></geometry>'
        for k, (x, y, h, c) in enumerate(
            (
                (100.0, 0.0, 0.0, 0.1),
                (100.0 + 10 * np.sin(angle), 10 * (1 - np.cos(angle)), angle, -0.1),
                (100.0 + 30 * np.sin(angle), 10 * (1 - np.cos(angle)), -angle, 0.1),
            )
        )
    ).replace(f's="{20 * angle}"', f's="{30 * angle}"')
    end = 100.0 + 40 * np.sin(angle)
    connections = "".join(
        f'<connection id="{k}" incomingRoad="1" connectingRoad="{k}" contactPoint="start"><laneLink from="-1" to="-1"/></connection>' for k in (2, 3)
    )
    parts = [start, way(2, aside, 20.0), way(3, bow, 40.0 * angle), road(line(end), section("", linked(-1)), identity="4")]
    network = roads.read_network(write(tmp_path, *parts, f'<junction id="9">{connections}</junction>'))
    assert [step.link.road for group in network.steps("1", "4") for step in group] == ["1", "3", "4"]
    (warning,) = [finding for finding in network.check() if "nobody is led there" in finding.message and "1/0/-1" in finding.message]
    assert "lane 2/0/-1 begins 5.00 m and 0.00 rad away from the end of 1/0/-1" in warning.message


@pytest.mark.parametrize("gap", [0.5, 2.0])
def test_what_lanes_miss_each_other_by_is_led_over_inside_the_strip(tmp_path: Path, gap: float):
    after = road(line(100.0), section("", linked(-1)), identity="2").replace('y="0"', f'y="{gap}"')
    made = roads.read_network(write(tmp_path, road(lanes=section("", linked(-1, after=-1)), link=onto(2)), after)).route("1", "2")
    strip = made.driving_lane()
    assert np.allclose([strip.right, strip.left], [[-1.75], [1.75]], atol=0.04)
    assert np.all(made.right <= strip.right)
    assert np.all(made.left >= strip.left)
    assert sharpest(made) < 0.02


def lanelets(folder: Path, **ways: tuple[np.ndarray, str]) -> Path:
    """A scenario of lanes 3.5 m wide about lines (n, 2), each with the ids that follow it."""
    body = ""
    for name, (points, after) in ways.items():
        way = np.gradient(points, axis=0)
        normal = np.column_stack([-way[:, 1], way[:, 0]]) / np.hypot(*way.T)[:, None]
        body += f'<lanelet id="{name[1:]}">'
        for side, offset in (("leftBound", 1.75), ("rightBound", -1.75)):
            body += f"<{side}>" + "".join(f"<point><x>{x:.4f}</x><y>{y:.4f}</y></point>" for x, y in points + offset * normal) + f"</{side}>"
        body += "".join(f'<successor ref="{other}"/>' for other in after.split()) + "</lanelet>"
    path = folder / "made.xml"
    path.write_text(f'<?xml version="1.0"?>\n<commonRoad commonRoadVersion="2020a">{body}</commonRoad>\n')
    return path


def straight(begin: tuple[float, float], end: tuple[float, float], count: int = 9) -> np.ndarray:
    return np.linspace(begin, end, count)


@pytest.mark.parametrize("angle", [0.8, 1.57, 1.9])
def test_corners_of_polylines_are_rounded(tmp_path: Path, angle: float):
    turned = (40.0 + 40.0 * np.cos(angle), 40.0 * np.sin(angle))
    network = roads.read_network(lanelets(tmp_path, w1=(straight((0, 0), (40, 0)), "2"), w2=(straight((40, 0), turned), "")))
    made = network.route("1", "2")
    # at 1.9 rad an arc that leaves the corner by 2.4 m, the most that is cut off, has a radius of 3.3 m; a cubic with its ends and directions is
    # sharper in the middle, and a spline where it leaves the straight
    assert sharpest(made) < 1.0 / 2.3
    lane = made.driving_lane()
    assert np.min(lane.left - lane.right) > 3.0
    # the reference stays in the strip, and away from the corner in its middle
    assert np.all(lane.right < 0.0)
    assert np.all(lane.left > 0.0)
    assert np.allclose(made.reference.position(30.0), [30.0, 0.0], atol=0.01)


def test_a_turn_on_the_spot_is_no_way(tmp_path: Path):
    network = roads.read_network(lanelets(tmp_path, w1=(straight((0, 0), (40, 0)), "2"), w2=(straight((40, 0), (1, 3)), "")))
    with pytest.raises(RoadError, match=r"no way from 1 to 2 .* lane 2 begins 0.00 m and 3.06 rad away from the end of 1, .* and 2.0 rad"):
        network.route("1", "2")
    half = 1.2 * np.column_stack([np.sin(angle := np.linspace(0.0, np.pi, 9)), 1.0 - np.cos(angle)]) + [40.0, 0.0]
    ways = {"w1": (straight((0, 0), (40, 0)), "2"), "w2": (half, "3"), "w3": (straight((40, 2.4), (0, 2.4)), "")}
    with pytest.raises(RoadError, match=r"lane 2 turns by 3.1\d rad within 3.7 m, expected a radius of at least 2 m"):
        roads.read_network(lanelets(tmp_path, **ways)).route("1", "3")


def test_a_last_segment_that_turns_is_not_the_direction_of_a_lane(tmp_path: Path):
    # by 2.4 rad, more than any corner may
    hooked = np.vstack([straight((0, 0), (40, 0)), [[39.9, 0.1]]])
    network = roads.read_network(lanelets(tmp_path, w1=(hooked, "2"), w2=(straight((39.9, 0.1), (80, 0.1)), "")))
    made = network.route("1", "2")
    assert sharpest(made) < 1.0 / 2.5
    assert made.length == pytest.approx(80.0, abs=0.1)


def test_a_lane_narrower_than_a_car_is_left_and_a_lone_one_driven(tmp_path: Path):
    waist = (
        '<width sOffset="0" a="3.5" b="0" c="0" d="0"/><width sOffset="40" a="1.5" b="0" c="0" d="0"/><width sOffset="50" a="3.5" b="0" c="0" d="0"/>'
    )
    beside = roads.read_network(write(tmp_path, road(lanes=section("", lane(-1) + lane(-2, waist)))))
    assert [step.link.id for group in beside.steps("1/0/-2", "1/0/-2") for step in group] == ["1/0/-2", "1/0/-1", "1/0/-2"]
    alone = roads.read_network(write(tmp_path, road(lanes=section("", lane(-1, waist)))))
    assert [step.link.id for group in alone.steps("1", "1") for step in group] == ["1/0/-1"]


def test_ways_with_costs_of_either_sign_are_the_cheapest():
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import bellman_ford

    rng = np.random.default_rng(3)
    count = 40
    pairs = np.unique(rng.integers(0, count, (160, 2)), axis=0)
    # costs that no ring lowers: a height for each place, and something positive for each edge
    height = rng.uniform(-5.0, 5.0, count)
    weights = rng.uniform(0.1, 3.0, len(pairs)) + height[pairs[:, 1]] - height[pairs[:, 0]]
    assert np.any(weights < 0.0)
    found, before = shortest(count, pairs[:, 0], pairs[:, 1], weights, 0, "here")
    expected = bellman_ford(csr_array((weights, tuple(pairs.T)), shape=(count, count)), indices=[0])[0]
    assert found == pytest.approx(expected)
    reached = np.flatnonzero(np.isfinite(found))[1:]
    cost = {tuple(pair): weight for pair, weight in zip(pairs.tolist(), weights.tolist(), strict=True)}
    assert all(found[k] == pytest.approx(found[before[k]] + cost[before[k], k]) for k in reached.tolist())
    with pytest.raises(RoadError, match="here: the cost falls without end"):
        shortest(3, np.array([0, 1, 2]), np.array([1, 2, 0]), np.array([1.0, -3.0, 1.0]), 0, "here")


def test_a_network_without_lanes_for_cars_has_no_ways_and_a_narrow_lane_is_no_place(tmp_path: Path):
    network = roads.read_network(write(tmp_path, road(lanes=section("", lane(-1, kind="sidewalk")))))
    assert [finding.severity for finding in network.check()] == ["note"]
    narrow = lane(-2, '<width sOffset="0" a="1.5" b="0" c="0" d="0"/>')
    network = roads.read_network(write(tmp_path, road(lanes=section("", lane(-1) + narrow))))
    # the narrow lane leads nowhere: the position stands for the one beside it
    made = network.route((20.0, -4.25), "1")
    assert made.reference.position(0.0) == pytest.approx([20.0, -1.75], abs=1e-6)


def test_a_road_that_begins_with_a_ramp_goes_on_in_the_lane_after_it(tmp_path: Path):
    lanes = section("", lane(-1, kind="entry")) + section("", lane(-1), 50.0)
    made = roads.read_network(write(tmp_path, road(lanes=lanes))).road("1")
    assert np.allclose([made.driving_lane().right, made.driving_lane().left], [[-3.5], [0.0]], atol=1e-6)
