"""Corridors of a road in generic position against distances that are measured in the plane."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from roads import Narrowing, Road

from .generic import generic, line, plain


def distance(road: Road, offset: np.ndarray, points: np.ndarray) -> np.ndarray:
    """From `points` to the border at `offset` (n,), looked at every 5 mm: off by 3 um at a distance of 1 m."""
    s = np.linspace(0.0, road.length, 80_000)
    border = road.reference.position(s) + np.interp(s, road.s, offset, period=road.length if road.closed else None)[:, None] * road.reference.normal(
        s
    )
    return cKDTree(border).query(points)[0]


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("margin", [0.4, 1.3])
def test_places_at_the_ends_of_the_usable_width_are_the_margin_away_from_their_border(closed: bool, margin: float):
    road = generic(closed=closed)
    corridor = road.corridor("road", margin)
    # at the ends of an open road the disc reaches beyond the border's end
    s = np.concatenate([[0.0, 0.4, road.length - 0.9], np.linspace(3.0, road.length - 3.0, 80)])[0 if closed else 3 :]
    for offset, border in zip(corridor.offsets(s), (corridor.right, corridor.left), strict=True):
        points = road.reference.position(s) + offset[:, None] * road.reference.normal(s)
        # the border is taken as straight between thirteen looks under the disc: up to 4 mm are missing where it has a corner
        found = distance(road, border, points)
        assert found == pytest.approx(margin, abs=5e-3)
        assert np.quantile(np.abs(found - margin), 0.8) < 3e-4


@pytest.mark.parametrize("closed", [False, True])
def test_own_lanes_reach_from_the_outermost_border_to_that_of_the_oncoming_one(closed: bool):
    road = generic(closed=closed, pieces=True)
    s = np.linspace(1.0, road.length - 1.0, 300)
    right, left = road.corridor("own").borders(s)
    first, second, oncoming = road.lanes
    assert left == pytest.approx(plain(road, second.left, s), abs=1e-9)
    outer = plain(road, first.right, s)
    # beside the end of a lane the strip narrows before it, never beyond it
    assert np.all(right >= np.where(np.isnan(outer), plain(road, second.right, s), outer) - 1e-9)
    near = road.s[np.flatnonzero(np.isnan(first.right))[[0, -1]]]
    far = np.min(np.abs(s[:, None] - np.append(near, [0.0, road.length])), axis=1) > 45.0
    assert right[far] == pytest.approx(np.where(np.isnan(outer), plain(road, second.right, s), outer)[far], abs=1e-9)
    assert oncoming.direction == -1


def test_narrowings_over_the_seam_and_in_the_middle_are_narrow_all_along_and_nowhere_else():
    road = generic(closed=True)
    plain_one = road.corridor("road", 0.9)
    length = road.length
    narrow = plain_one.narrowed(Narrowing(length - 17.2, 9.1, right=-3.7), Narrowing(140.3, 151.9, left=2.3), Narrowing(146.0, 171.0, right=-4.1))
    s = np.linspace(0.0, length, 4001)[:-1]
    right, left = plain_one.borders(s)
    over, middle, last = (s > length - 17.2) | (s < 9.1), (s > 140.3) & (s < 151.9), (s > 146.0) & (s < 171.0)
    # the step across takes a millimetre of the road beside
    clear = np.min(np.abs(s[:, None] - [length - 17.2, 9.1, 140.3, 151.9, 146.0, 171.0]), axis=1) > 2e-3
    found = narrow.borders(s)
    expected = np.where(over, np.maximum(right, -3.7), np.where(last, np.maximum(right, -4.1), right)), np.where(middle, np.minimum(left, 2.3), left)
    for one, other in zip(found, expected, strict=True):
        assert one[clear] == pytest.approx(other[clear], abs=1e-9)


@pytest.mark.parametrize("closed", [False, True])
def test_centre_of_the_driving_lane_lies_as_far_from_both_its_borders(closed: bool):
    road = generic(closed=closed)
    lane = road.driving_lane()
    centre = road.lane_centre()
    middle = 0.5 * (lane.right + lane.left)
    places = line(road, middle, road.s)
    s, offset = centre.locate(places)
    # the curve is drawn through these places
    assert offset == pytest.approx(0.0, abs=1e-6)
    assert np.all(np.diff(s[:-1]) > 0.0)
    assert centre.closed == closed
