import numpy as np
import pytest

from roads import PlanarCurve, Road, RoadBuilder

from .hard_roads import CAR, FAMILIES, curvature_extreme, hard_road, passage, worst_border_gap

ONE_LANE = ((1, -3.0, 3.0),)


@pytest.fixture(scope="module")
def hard() -> list[Road]:
    return [hard_road(seed) for seed in range(200)]


def circle(radius: float, sign: int = 1) -> np.ndarray:
    angle = sign * np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def test_same_seed_gives_the_same_road(hard: list[Road]):
    for seed in (3, 77, 150):
        again = hard_road(seed)
        assert np.array_equal(again.reference.breaks_s, hard[seed].reference.breaks_s)
        assert np.array_equal(again.left, hard[seed].left)


def test_roads_cover_families_and_sizes(hard: list[Road]):
    count = {family: sum(family in road.name.split() for road in hard) for family in FAMILIES}
    assert min(count.values()) >= 5, count
    length = np.array([road.length for road in hard])
    narrow, wide = (np.array([pick(road.left - road.right) for road in hard]) for pick in (np.min, np.max))
    assert 9.9 < length.min() < 20.0
    assert 1000.0 < length.max() <= 1500.0
    assert np.sort(narrow)[len(hard) // 5] < 2.6
    assert 10.0 < wide.max() <= 12.0 + 1e-9
    assert 0.08 < np.mean([road.closed for road in hard]) < 0.3
    assert 0.2 < np.mean([len(road.lanes) == 2 for road in hard]) < 0.7
    assert 0.2 < np.mean(wide - narrow > 0.1) < 0.7
    for at in ("right", "left"):
        assert 0.1 < np.mean([abs(np.median(getattr(road, at))) < 1e-9 for road in hard]) < 0.5


def test_roads_reach_the_tightest_bends_and_fold_inside_them(hard: list[Road]):
    tightest, folds = [], 0
    for road in hard:
        s = np.arange(0.0, road.length, 0.5)
        kappa = road.reference.curvature(s)
        right, left = road.corridor("road").borders(s)
        tightest.append(1.0 / max(np.max(np.abs(kappa)), 1e-9))
        folds += bool(np.max(np.maximum(kappa * left, kappa * right)) > 1.0)
    assert 5.3 < min(tightest) < 6.3
    assert np.mean(np.array(tightest) < 8.0) > 0.25
    assert folds >= 5


def test_a_tenth_of_the_roads_is_too_narrow_and_no_other(hard: list[Road]):
    pinched = np.array(["pinched" in road.name for road in hard])
    narrow = np.array([np.min(road.left - road.right) < CAR for road in hard])
    assert np.array_equal(pinched, narrow)
    assert 0.05 < np.mean(pinched) < 0.16
    # cross-sections are 3 m wide, but where the straight steps aside by 2 m within 1 m its corners (10, 0) and (11, -1) come closer
    gate = Road.from_points("gate", [(0, 0), (10, 0), (11, 0), (20, 0)], [-3.0, -3.0, -1.0, -1.0], [0.0, 0.0, 2.0, 2.0])
    assert passage(gate, "road") == pytest.approx(np.sqrt(2.0), abs=1e-9)


def test_gap_on_a_straight_is_half_the_width_less_the_offset():
    road = RoadBuilder("straight").straight(100).build(lanes=ONE_LANE)
    gap, _ = worst_border_gap(road, "road", PlanarCurve.through([(0.0, 1.3), (100.0, 1.3)]))
    assert gap == pytest.approx(1.7, abs=1e-9)
    # from 2.5 m left to 3.5 m left: past the border by half a metre at the end, 1 m of shift in 100 m of way
    gap, at = worst_border_gap(road, "road", PlanarCurve.through([(0.0, 2.5), (100.0, 3.5)]))
    assert gap == pytest.approx(-0.5, abs=1e-9)
    assert at == pytest.approx(np.hypot(100.0, 1.0), abs=1e-6)


def test_gap_is_that_of_the_lane_asked_for():
    road = RoadBuilder("straight").straight(100).build()
    centre = road.lane_centre()
    assert worst_border_gap(road, "lane", centre)[0] == pytest.approx(1.75, abs=1e-9)
    assert worst_border_gap(road, "road", PlanarCurve.through([(0.0, 0.0), (100.0, 0.0)]))[0] == pytest.approx(3.5, abs=1e-9)
    assert worst_border_gap(road, "own", PlanarCurve.through([(0.0, 0.5), (100.0, 0.5)]))[0] == pytest.approx(-0.5, abs=1e-9)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("radius", "expected"), [(19.0, 2.0), (21.5, 1.5), (16.0, -1.0), (23.25, -0.25)])
def test_gap_on_a_ring_is_the_difference_of_the_radii(sign: int, radius: float, expected: float):
    road = Road.from_points("ring", circle(20.0, sign), -3.0, 3.0, closed=True)
    # the spline through 400 points misses the circle by less than a micrometre, chords of the border by 0.01^2 / 8 / 17 m
    assert worst_border_gap(road, "road", PlanarCurve.through(circle(radius, sign), closed=True))[0] == pytest.approx(expected, abs=5e-6)


def test_gap_to_a_step_is_measured_across_it():
    # the left edge comes in from 3 m to 1 m between 50 m and 51 m: the line 2 x + y = 103
    road = Road.from_points("step", [(0, 0), (50, 0), (51, 0), (100, 0)], -3.0, [3.0, 3.0, 1.0, 1.0])
    gap, at = worst_border_gap(road, "road", PlanarCurve.through([(0.0, 0.5), (49.5, 0.5)]))
    assert gap == pytest.approx(abs(2 * 49.5 + 0.5 - 103.0) / np.sqrt(5.0), abs=1e-9)
    assert at == pytest.approx(49.5)


@pytest.mark.parametrize("side", [1, -1])
def test_inside_of_a_bend_tighter_than_its_edge_is_the_corner_of_its_envelope(side: int):
    # a quarter of radius 6 about (0, 6), inner edge 9 off: the lines y = 9 and x = -3 meet at (-3, 9), what is folded lies on the road
    edges = (-1.0, 9.0) if side > 0 else (-9.0, 1.0)
    builder = RoadBuilder("fold", start=(-40.0, 0.0)).straight(40).arc(6.0, side * np.pi / 2).straight(40)
    road = builder.build(spacing=0.25, lanes=((1, *edges),))
    # 3 m off both lines; that cuts the folded arc, which has a radius of 3 m about the same middle
    angle = np.linspace(-np.pi / 2, 0.0, 40)
    way_in = np.column_stack([np.linspace(-36.0, -2.5, 68), np.full(68, 6.0)])
    way_out = way_in[::-1, ::-1] * [1.0, -1.0] + np.array([-6.0, 6.0])
    way = np.vstack([way_in, np.column_stack([-2 + 2 * np.cos(angle), 8 + 2 * np.sin(angle)]), way_out])
    # moved out by 3 m it is nearest to the outer edge, 7 m about (0, 6), in the middle of its arc about (1, 5); moved in by 2 m to the corner,
    # from the middle of its arc about (-4, 10); by 2.5 m that is off the road, beyond both lines
    # the spline overshoots by a millimetre where arc and straight meet
    for shift, expected in ((0.0, 3.0), (-3.0, 7.0 - np.sqrt(2.0) - 2.0), (2.0, 2.0 - np.sqrt(2.0)), (2.5, np.sqrt(2.0) - 1.5)):
        curve = PlanarCurve.through((way + shift * np.array([-1.0, 1.0])) * [1.0, side])
        assert worst_border_gap(road, "road", curve)[0] == pytest.approx(expected, abs=3e-3)


def test_borders_of_another_stretch_do_not_count():
    # three quarters of a turn and across itself, bridge over road
    bridge = RoadBuilder("bridge").straight(60).bend(20.0, 1.5 * np.pi, 5.0).straight(70).build(lanes=ONE_LANE)
    assert worst_border_gap(bridge, "road", bridge.reference)[0] == pytest.approx(3.0, abs=1e-4)
    hairpin = RoadBuilder("hairpin").straight(60).arc(6.0, np.pi).straight(60).build(spacing=0.25, lanes=((1, -7.0, 4.0),))
    assert worst_border_gap(hairpin, "road", hairpin.reference)[0] == pytest.approx(4.0, abs=1e-3)


def test_curvature_of_a_circle_and_of_an_ellipse():
    # a spline through 400 points bends a share of (2 pi / 400)^2 / 12 more than the circle at its points
    assert curvature_extreme(PlanarCurve.through(circle(40.0), closed=True)) == pytest.approx(1 / 40, rel=3e-5)
    angle = np.linspace(0.0, 2.0 * np.pi, 2000, endpoint=False)
    ellipse = np.column_stack([30.0 * np.cos(angle), 12.0 * np.sin(angle)])
    assert curvature_extreme(PlanarCurve.through(ellipse, closed=True)) == pytest.approx(30.0 / 12.0**2, rel=1e-4)


def test_gap_of_the_reference_is_at_most_its_least_offset(hard: list[Road]):
    # less where a border comes closer askew; negative where the reference runs beside the road
    for road in [road for road in hard if road.length < 150.0][:12]:
        right, left = road.corridor("road").borders(np.linspace(0.0, road.length, 2000))
        least = min(np.min(left), np.min(-right))
        gap, _ = worst_border_gap(road, "road", road.reference, spacing=0.1)
        assert gap <= max(least, 0.0) + 1e-3, road.name
        assert (gap < 0.0) == (least < 0.0) or abs(least) < 0.01, road.name
