import numpy as np
import pytest
from scipy.special import fresnel

from roads import RoadBuilder, RoadError


def test_clothoid_ends_where_the_fresnel_integrals_say():
    length, kappa = 60.0, 1.0 / 25.0
    road = RoadBuilder("c").clothoid(length, 0.0, kappa).build()
    scale = np.sqrt(np.pi * length / kappa)
    sine, cosine = fresnel(length / scale)
    assert np.allclose(road.reference.position(road.length), scale * np.array([cosine, sine]), atol=1e-9)
    assert road.reference.heading(road.length) == pytest.approx(0.5 * kappa * length, abs=1e-4)


@pytest.mark.parametrize("angle", [-1.5, 0.7, 2.6])
def test_bend_turns_by_its_angle_and_is_as_tight_as_its_radius(angle: float):
    road = RoadBuilder("b").straight(50).bend(20, angle, 10).straight(50).build()
    assert road.reference.heading(road.length) == pytest.approx(angle, abs=1e-6)
    kappa = road.reference.curvature(np.arange(0, road.length, 0.1))
    # the spline rounds off the corners of the curvature by a few parts in a thousand
    assert np.max(np.abs(kappa)) == pytest.approx(1 / 20, rel=0.01)
    assert np.sign(kappa[np.argmax(np.abs(kappa))]) == np.sign(angle)


def test_roundabout_goes_on_straight_for_a_right_angle_along_the_ring():
    road = RoadBuilder("r").straight(30).roundabout(18, 16, np.pi / 2, 10).straight(30).build()
    assert road.reference.heading(road.length) == pytest.approx(0.0, abs=1e-6)


def test_closed_road_closes_or_says_by_how_much_it_does_not():
    oval = RoadBuilder("oval")
    for _ in range(2):
        oval.straight(100).bend(30, np.pi, 20)
    assert oval.build(closed=True).length == pytest.approx(oval.length, abs=1e-6)
    with pytest.raises(RoadError, match=r"the end misses the start by 100\.0"):
        RoadBuilder("open").straight(100).build(closed=True)


def test_impossible_elements_are_refused():
    with pytest.raises(RoadError, match="more than 0.100 rad"):
        RoadBuilder("x").bend(20, 0.1, 10)
    with pytest.raises(RoadError, match="expected a positive length"):
        RoadBuilder("x").straight(-1)
    with pytest.raises(RoadError, match="no elements"):
        RoadBuilder("x").build()


def test_limits_hold_from_where_they_are_posted():
    road = RoadBuilder("l").straight(50).limit(10).straight(50).limit(20).straight(50).build()
    assert road.speed_limit_at([0.0, 49.5]).tolist() == [np.inf, np.inf]
    assert road.speed_limit_at([50.0, 99.9, 100.0, 150.0]).tolist() == [10, 10, 20, 20]
