"""A road in generic position written and read again, and routes along parts of its lanes."""

from pathlib import Path

import numpy as np
import pytest

import roads
from roads import Road

from ..generic import from_the_other_side, generic, limits, line, scene

Floats = np.ndarray


def places(road: Road) -> Floats:
    s = np.random.default_rng(3).uniform(0.5, road.length - 0.5, 120)
    return s[np.min(np.abs(s[:, None] - road.s), axis=1) > 0.05]


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("suffix", [".geojson", ".csv", ".xodr"])
@pytest.mark.parametrize("turned", [False, True])
def test_every_column_comes_back_where_it_was(tmp_path: Path, suffix: str, closed: bool, turned: bool):
    # a track CSV holds lanes of constant width, OpenDRIVE lanes up to the edges
    road = generic(closed=closed, even=suffix == ".csv", snug=suffix == ".xodr")
    road = road.reversed() if turned else road
    roads.write(road, tmp_path / f"a{suffix}")
    copy = roads.read(tmp_path / f"a{suffix}")
    s = places(road)
    found, expected = scene(copy, s * (copy.length / road.length)), scene(road, s)
    exact = suffix != ".xodr"
    for name, values in expected.items():
        if name == "wear" or (name == "friction" and not exact):
            # no format has columns of one's own, OpenDRIVE's friction is constant from place to place
            continue
        # decimals of the file; OpenDRIVE's lanes are cubics over the station, read by lines 1 cm off at most in the middle of 19 m
        assert found[name] == pytest.approx(values, abs=1e-6 if exact else 2e-2 if name[-4:] in ("ight", "left") else 1e-3), name


@pytest.mark.parametrize("closed", [False, True])
def test_lanes_that_end_and_begin_come_back_in_geojson(tmp_path: Path, closed: bool):
    road = generic(closed=closed, pieces=True)
    roads.write(road, tmp_path / "a.geojson")
    copy = roads.read(tmp_path / "a.geojson")
    s = places(road)
    found, expected = scene(copy, s), scene(road, s)
    for name in expected.keys() - {"wear"}:
        assert found[name] == pytest.approx(expected[name], abs=1e-6, nan_ok=True), name


@pytest.mark.parametrize("number", [0, 1, 2])
@pytest.mark.parametrize("ends", [(0.0, 1.0), (0.14, 0.83), (0.41, 0.57)])
def test_a_route_along_part_of_a_lane_is_that_part_of_the_road(tmp_path: Path, number: int, ends: tuple[float, float]):
    road = generic(snug=True)
    roads.write(road, tmp_path / "a.xodr")
    lane = road.lanes[number]
    middle = 0.5 * (lane.left + lane.right)
    start, goal = line(road, middle, np.array(ends) * road.length)[:: lane.direction]
    route = roads.read_network(tmp_path / "a.xodr").route((float(start[0]), float(start[1])), (float(goal[0]), float(goal[1])))
    # positions mean the foot on a line through points that are some metres apart
    assert route.reference.position(np.array([0.0, route.length])) == pytest.approx(np.array([start, goal]), abs=1e-2)
    other = road if lane.direction > 0 else road.reversed()
    middle = middle if lane.direction > 0 else -middle[::-1]
    s = np.linspace(1.0, route.length - 1.0, 150)
    abreast, offset = other.reference.locate(route.reference.position(s))
    assert offset == pytest.approx(np.interp(abreast, other.s, middle), abs=1e-2)
    # signs stand at the reference's stations, and limits begin at the borders' points there
    clear = np.min(np.abs(abreast[:, None] - other.s), axis=1) > 0.2
    assert np.array_equal(limits(route, s[clear]), limits(other, abreast[clear]))
    # the lane's middle is higher or lower than the reference by the bank
    raised = other.height_at(abreast) + offset * np.tan(other.bank_at(abreast))
    assert route.height_at(s) == pytest.approx(raised, abs=2e-2)
    assert route.bank_at(s) == pytest.approx(other.bank_at(abreast), abs=2e-2)
    assert [one.direction for one in route.lanes] == [one.direction for one in other.lanes]
    found, expected = scene(route, s), scene(other, abreast)
    names = {"right": "right", "left": "left"} | {f"{k} {side}": f"{k} {side}" for k in range(3) for side in ("right", "left")}
    for mine, its in names.items():
        # abreast of the route is not abreast of the road: places on the same border, a little further or back
        at, beside = other.reference.locate(found[mine])
        _, true = other.reference.locate(expected[its])
        assert beside == pytest.approx(np.interp(at, abreast, true), abs=8e-2), mine


def test_telling_a_scene_from_the_other_side_twice_changes_nothing():
    road = generic()
    found = scene(road, places(road))
    again = from_the_other_side(from_the_other_side(found))
    assert all(np.array_equal(again[name], values) for name, values in found.items())
