import numpy as np
import pytest

from roads import Road, RoadBuilder, RoadError


@pytest.fixture
def bend() -> Road:
    return RoadBuilder("bend").straight(40).bend(20, 1.5, 10).straight(40).build()


def test_corridors_nest(bend: Road):
    s = np.linspace(0, bend.length, 200)
    lane, own, road = (bend.corridor(extent, 0.9).offsets(s) for extent in ("lane", "own", "road"))
    assert np.all(lane[0] == own[0])
    assert np.all(lane[1] == own[1])
    assert np.all(road[0] <= own[0])
    assert np.all(own[1] <= road[1])
    assert np.allclose(road[1] - road[0], 7.0 - 1.8)


def test_corridor_ends_before_the_centre_of_curvature():
    angle = np.linspace(0, np.pi, 40)
    tight = Road.from_points("tight", 6.0 * np.column_stack([np.cos(angle), np.sin(angle)]), -4.0, 8.0)
    s = np.linspace(1.0, tight.length - 1.0, 50)
    assert np.max(tight.corridor("road").offsets(s)[1] * tight.reference.curvature(s)) <= 0.9 + 1e-9


def test_margin_is_kept_at_right_angles_to_a_widening_border():
    s = np.arange(0.0, 101.0, 5.0)
    road = Road.from_points("funnel", np.column_stack([s, 0 * s]), -2.0 - 0.1 * s, 4.0)
    right, _ = road.corridor("road", 1.0).offsets(np.array([50.0]))
    distance_to_border_line = (right[0] - (-2.0 - 0.1 * 50.0)) / np.hypot(1.0, 0.1)
    assert distance_to_border_line == pytest.approx(1.0, abs=1e-9)


def test_a_narrow_place_that_the_car_fits_through_is_not_closed_by_its_steps():
    s = np.arange(0.0, 101.0, 1.0)
    half = np.where((s > 48) & (s < 53), 1.1, 5.0)
    corridor = Road.from_points("pinch", np.column_stack([s, 0 * s]), -half, half).corridor("road", 1.05)
    at, width = corridor.narrowest()
    assert 48 <= at <= 53
    assert width == pytest.approx(0.1, abs=1e-3)


def test_usable_offsets_keep_the_margin_from_a_crooked_border(rng: np.random.Generator):
    s = np.arange(0.0, 101.0, 5.0)
    left = rng.uniform(2.5, 5.0, len(s))
    corridor = Road.from_points("crooked", np.column_stack([s, 0 * s]), -5.0, left).corridor("road", 1.0)
    at = np.arange(10.0, 90.0, 0.37)
    fine = np.arange(0.0, 100.0, 0.001)
    edge = np.column_stack([fine, np.interp(fine, s, left)])
    usable = corridor.offsets(at)[1]
    inside = np.array([np.min(np.hypot(*(edge - place).T)) for place in np.column_stack([at, usable])])
    # corners of the border that fall between two looks under the disc are cut by less than this
    assert np.max(np.abs(inside - 1.0)) < 0.03


def test_lane_centre_runs_in_the_middle_of_the_right_lane(bend: Road):
    lane = bend.lane_centre()
    _, offset = bend.reference.project(lane.position(lane.breaks_s), bend.s)
    assert np.allclose(offset, -1.75, atol=1e-6)
    assert lane.length > bend.length  # the right lane is the outer one of a left bend


def test_height_does_not_overshoot_and_wraps_on_circuits():
    angle = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    height = np.where(angle < np.pi, 0.0, 5.0)
    road = Road.from_points("step", 50 * np.column_stack([np.cos(angle), np.sin(angle)]), -3.0, 3.0, closed=True, height=height)
    s = np.linspace(0, road.length, 1000)
    z = road.height_at(s)
    assert z.min() >= 0.0
    assert z.max() <= 5.0
    assert road.height_at(road.length + 10.0) == pytest.approx(float(road.height_at(10.0)))
    assert road.slope_at(1e-6) == pytest.approx(float(road.slope_at(road.length - 1e-6)), abs=1e-3)


def test_bank_and_friction_of_a_circuit_are_linear_over_its_seam_too():
    angle = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    bank, friction = 0.1 * np.cos(angle + 1.0), 0.8 + 0.1 * np.sin(angle)
    ring = Road.from_points("ring", 50.0 * np.column_stack([np.cos(angle), np.sin(angle)]), -4.0, 4.0, closed=True, bank=bank, friction=friction)
    for share in (0.25, 0.5, 0.75):
        at = ring.s[-1] + share * (ring.length - ring.s[-1])
        for laps in (-1.0, 0.0, 1.0):
            assert ring.bank_at(at + laps * ring.length) == pytest.approx((1.0 - share) * bank[-1] + share * bank[0], abs=1e-12)
            assert ring.friction_at(at + laps * ring.length) == pytest.approx((1.0 - share) * friction[-1] + share * friction[0], abs=1e-12)


def test_values_that_make_no_road_are_refused():
    line = np.column_stack([np.arange(5.0), np.zeros(5)])
    with pytest.raises(RoadError, match=r"borders cross at s = 0\.0 m"):
        Road.from_points("x", line, 1.0, -1.0)
    with pytest.raises(RoadError, match=r"height at s = 2\.0 m is nan"):
        Road.from_points("x", line, -1.0, 1.0, height=[0, 0, np.nan, 0, 0])
    with pytest.raises(RoadError, match="speed limit"):
        Road.from_points("x", line, -1.0, 1.0, speed_limit=0.0)
    with pytest.raises(RoadError, match="corridor 'half' is unknown"):
        Road.from_points("x", line, -1.0, 1.0).corridor("half")  # pyright: ignore[reportArgumentType]


def test_arrays_of_a_road_cannot_be_written_to(bend: Road):
    with pytest.raises(ValueError, match="read-only"):
        bend.left[0] = 1.0
