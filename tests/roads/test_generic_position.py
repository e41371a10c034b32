"""Reversing, cutting, joining and resampling a road on which nothing is symmetric, even, level or constant leaves everything where it stands."""

from itertools import pairwise

import numpy as np
import pytest

from roads import Road, join

from .generic import from_the_other_side, generic, limits, plain, scene

KINDS = {"open": {}, "circuit": {"closed": True}, "lanes that end": {"pieces": True}, "circuit with lanes that end": {"closed": True, "pieces": True}}
kinds = pytest.mark.parametrize("kind", KINDS)


def places(road: Road, start: float = 0.0, end: float | None = None) -> np.ndarray:
    """Stations off the road's own ones, where limits and lanes change, and a few on both sides of the seam of a circuit."""
    length = road.length
    rng = np.random.default_rng(5)
    s = rng.uniform(start, length if end is None else end, 60)
    seam = np.array([0.3, 1.1, length - 0.2, length - 2.3]) if road.closed and end is None else s[:0]
    s = np.sort(np.concatenate([s, seam]))
    near = np.min(np.abs(np.mod(s, length)[:, None] - np.append(road.s, length)), axis=1)
    return s[near > 0.05]


def assert_same(found: dict[str, np.ndarray], expected: dict[str, np.ndarray], within: float) -> None:
    assert found.keys() == expected.keys()
    for name, values in expected.items():
        assert np.array_equal(np.isnan(found[name]), np.isnan(values)), name
        assert found[name] == pytest.approx(values, abs=within, nan_ok=True), name


@kinds
def test_who_comes_the_other_way_meets_the_same_things_on_the_other_side(kind: str):
    road = generic(**KINDS[kind])
    s = places(road)
    # backwards the parameter of the spline counts anew: Newton's method finds stations to 1e-8 m
    assert_same(from_the_other_side(scene(road.reversed(), road.length - s)), scene(road, s), 1e-6)
    # where the road ends there is the limit of what was driven last
    assert road.closed or limits(road.reversed(), np.array([road.length]))[0] == road.speed_limit[0]
    again = road.reversed().reversed()
    assert_same(scene(again, s), scene(road, s), 1e-6)
    assert again.s == pytest.approx(road.s, abs=1e-9)


@kinds
@pytest.mark.parametrize("ends", [(21.3, 188.8), (70.4, 240.9)])
def test_a_stretch_holds_what_the_road_holds_there(kind: str, ends: tuple[float, float]):
    road = generic(**KINDS[kind])
    if road.closed:
        # over the seam, which lies in a bend
        ends = ends[1], ends[0] + road.length
    stretch = road[ends[0] : ends[1] - (road.length if road.closed else 0.0)]
    assert stretch.length == pytest.approx(ends[1] - ends[0], abs=1e-6)
    assert not stretch.closed
    s = places(road, *ends)
    found, expected = scene(stretch, s - ends[0]), scene(road, s)
    # a lane of which the stretch has nothing is left out
    kept = sum(not np.isnan(plain(road, lane.right, np.arange(ends[0], ends[1], 0.1))).all() for lane in road.lanes)
    assert len(stretch.lanes) == kept
    assert found.keys() <= expected.keys()
    # heights are monotone cubics, which notice a cut up to two stations away
    inner = (s > ends[0] + 35.0) & (s < ends[1] - 35.0)
    for one in (found, expected):
        one["height"], one["slope"] = one["height"][inner], one["slope"][inner]
    assert_same(found, {name: expected[name] for name in found}, 1e-6)


@pytest.mark.parametrize("pieces", [False, True])
def test_parts_joined_again_are_the_road(pieces: bool):
    road = generic(pieces=pieces)
    cuts = [0.0, 61.7, 163.1, 245.6, road.length]
    joined = join([road[a:b] for a, b in pairwise(cuts)])
    assert joined.length == pytest.approx(road.length, abs=1e-2)
    s = places(road)
    # the curve is drawn anew through the old points and those of the cuts, columns lie a centimetre beside the joints
    inner = s[np.min(np.abs(s[:, None] - cuts), axis=1) > 0.2]
    found, expected = scene(joined, inner * (joined.length / road.length)), scene(road, inner)
    # each part keeps its own lanes where their number differs, and further columns are not joined
    names = [name for name in expected if name != "wear" and not (pieces and name[0].isdigit())]
    assert_same({name: found[name] for name in names}, {name: expected[name] for name in names}, 2e-2)


@kinds
@pytest.mark.parametrize("spacing", [3.7, 21.0])
def test_resampled_columns_are_the_roads_at_the_new_stations_and_limits_are_never_raised(kind: str, spacing: float):
    road = generic(**KINDS[kind])
    made = road.resampled(spacing)
    count = int(np.ceil(road.length / spacing))
    at = np.linspace(0.0, road.length, count + 1)[: count if road.closed else None]
    assert made.reference.position(made.s) == pytest.approx(road.reference.position(at), abs=1e-6)
    for name in ("right", "left", "bank", "friction"):
        assert getattr(made, name) == pytest.approx(plain(road, getattr(road, name), at), abs=1e-9), name
    assert made.columns["wear"] == pytest.approx(plain(road, road.columns["wear"], at), abs=1e-9)
    assert made.height == pytest.approx(road.height_at(at), abs=1e-9)
    for lane, own in zip(made.lanes, road.lanes, strict=True):
        assert lane.direction == own.direction
        for side in ("right", "left"):
            assert getattr(lane, side) == pytest.approx(plain(road, getattr(own, side), at), abs=1e-9, nan_ok=True)
    ends = np.append(at, road.length)[1 : len(at) + 1] if road.closed else np.append(at[1:], road.length)
    least = [np.min(limits(road, np.linspace(a, b - 1e-9, 400))) if b > a else limits(road, np.array([a]))[0] for a, b in zip(at, ends, strict=True)]
    assert made.speed_limit.tolist() == pytest.approx(least)
