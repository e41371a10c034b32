import numpy as np
import pytest

import roads
from roads import RoadError, join, open_road

from ..samples import bend


@pytest.fixture(scope="module")
def rural():
    return open_road("rural")


def test_reversed_road_covers_the_same_ground(rural: roads.Road):
    back = rural.reversed()
    s = np.linspace(0.0, rural.length, 1001)
    t = back.length - s
    assert np.max(np.hypot(*(back.reference.position(t) - rural.reference.position(s)).T)) < 1e-6
    assert np.allclose(back.height_at(t), rural.height_at(s), atol=1e-6)
    assert np.allclose(back.slope_at(t), -rural.slope_at(s), atol=1e-6)
    inner = np.linspace(1.0, rural.length - 1.0, 1777)
    assert np.mean(back.speed_limit_at(back.length - inner) != rural.speed_limit_at(inner)) < 0.002
    # what was the lane for the other direction is now the lane to drive, on the right
    lane = back.driving_lane()
    assert lane.direction == 1
    assert lane.left[0] == pytest.approx(0.0)
    assert np.allclose(back.reversed().right, rural.right)


def test_reversed_circuit_keeps_its_start():
    road = open_road("handling")
    back = road.reversed()
    assert back.closed
    assert np.allclose(back.reference.position(0.0), road.reference.position(0.0), atol=1e-9)
    s = np.linspace(0.0, road.length, 500)
    assert np.max(np.hypot(*(back.reference.position(-s) - road.reference.position(s)).T)) < 1e-6


def test_limits_of_a_reversed_circuit_cover_the_same_ground():
    turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    posted = 5.0 + np.arange(24.0)  # all of them different, that of the last stretch leads up to the seam
    road = roads.Road.from_points("ring", 50.0 * np.column_stack([np.cos(turn), np.sin(turn)]), -3.0, 3.0, closed=True, speed_limit=posted)
    middles = 0.5 * (road.s + np.append(road.s[1:], road.length))
    assert np.array_equal(road.speed_limit_at(middles), posted)
    assert np.array_equal(road.reversed().speed_limit_at(road.length - middles), posted)


def test_stretch_is_the_same_road(rural: roads.Road):
    part = rural[500:1700]
    s = np.linspace(0.0, 1200.0, 901)
    assert part.length == pytest.approx(1200.0, abs=1e-6)
    assert np.max(np.hypot(*(part.reference.position(s) - rural.reference.position(s + 500.0)).T)) < 1e-6
    assert np.max(np.abs(part.height_at(s) - rural.height_at(s + 500.0))) < 1e-4
    assert len(part.lanes) == 2


def test_stretch_of_a_circuit_may_lead_over_its_start():
    road = open_road("handling")
    part = road[900:100]
    assert not part.closed
    assert part.length == pytest.approx(road.length - 800.0, abs=1e-6)
    s = np.linspace(0.0, part.length, 300)
    assert np.max(np.hypot(*(part.reference.position(s) - road.reference.position(900.0 + s)).T)) < 1e-6


@pytest.mark.parametrize("stretch", [slice(10, 5), slice(-1, 5), slice(0, 1e9), slice(0, 100, 2), slice(np.nan, 5)])
def test_bad_stretches_are_refused(rural: roads.Road, stretch: slice):
    with pytest.raises(RoadError, match="stretch"):
        rural[stretch]


def test_cut_and_joined_is_the_same(rural: roads.Road):
    whole = join([rural[:700], rural[700:1900], rural[1900:]], "rural")
    s = np.linspace(0.0, rural.length, 2001)
    assert whole.length == pytest.approx(rural.length, abs=1e-5)
    assert np.max(np.hypot(*(whole.reference.position(s) - rural.reference.position(s)).T)) < 1e-4
    assert np.max(np.abs(whole.height_at(s) - rural.height_at(s))) < 1e-3
    assert len(whole.lanes) == 2


def test_roads_that_do_not_meet_are_not_joined(rural: roads.Road):
    with pytest.raises(RoadError, match=r"begins .* m, .* rad and .* m of height away"):
        join([rural[:700], rural[720:]])
    with pytest.raises(RoadError, match="is closed"):
        join([open_road("handling"), rural])
    with pytest.raises(RoadError, match="at least one"):
        join([])


def test_joining_roads_of_different_lanes_keeps_each_where_it_is():
    one = bend()
    (x, y), heading = one.reference.position(one.length), float(one.reference.heading(one.length))
    single = (
        roads.RoadBuilder("single", (float(x), float(y)), heading)
        .straight(50)
        .build(lanes=((1, -3.5, 0.0),), height=lambda s: np.full(len(s), one.height[-1]))
    )
    whole = join([one, single])
    assert [lane.direction for lane in whole.lanes] == [1, -1, 1]
    assert np.isnan(whole.lanes[1].right[-1])
    assert not np.isnan(whole.lanes[1].right[0])
    # the edge beside the second road is the second road's
    assert np.interp(one.length + 1.0, whole.s, whole.left) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("widths", [(3.5, 5.0), (5.0, 3.5)])
def test_at_a_joint_the_road_is_nowhere_wider_than_the_one_that_is_there(widths: tuple[float, float]):
    lanes = [((1, -width, 0.0), (-1, 0.0, width)) for width in widths]
    parts = [roads.RoadBuilder("straight", (60.0 * k, 0.0), 0.0).straight(60).build(lanes=own) for k, own in enumerate(lanes)]
    whole = join(parts)
    # an edge may change at once only on the wider side of the joint, within a centimetre
    s = 60.0 + np.linspace(-0.03, 0.03, 121)
    own = np.where(s < 60.0, *widths)
    assert np.all(np.interp(s, whole.s, whole.left) <= own + 1e-9)
    assert np.all(np.interp(s, whole.s, whole.right) >= -own - 1e-9)


def test_resampling_keeps_the_line_and_never_raises_a_limit(rural: roads.Road):
    made = rural.resampled(0.7)
    s = np.linspace(0.0, rural.length, 3001)
    assert np.max(np.diff(made.s)) <= 0.7 + 1e-6
    assert np.max(np.hypot(*(made.reference.position(s) - rural.reference.position(s)).T)) < 1e-3
    assert np.all(made.speed_limit_at(s) <= rural.speed_limit_at(s) + 1e-9)
    with pytest.raises(RoadError, match="spacing"):
        rural.resampled(0.0)
