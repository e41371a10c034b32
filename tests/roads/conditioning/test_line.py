"""The line out of scattered places: close to the road that was driven, bends kept, stops drawn together."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from roads import Road, RoadBuilder, RoadError, open_road
from roads.conditioning.chords import beside
from roads.conditioning.conditioned import Conditioned, conditioned
from roads.conditioning.recording import Recording
from roads.conditioning.wish import Wish

from .drives import Receiver, recorded


def made(recording: Recording, wish: Wish | None = None, closed: bool | None = False) -> Conditioned:
    return conditioned(recording, wish or Wish(), closed)


def off(points: np.ndarray, road: Road) -> np.ndarray:
    """Distances (n,) of points from the road's reference."""
    return cKDTree(road.reference.position(np.arange(0.0, road.length, 0.1))).query(points)[0]


def words(found: Conditioned) -> str:
    return "\n".join(str(finding) for finding in found.findings)


def test_exact_places_stay_as_they_are():
    recording = recorded(open_road("rural"), Receiver(), 0)
    found = made(recording)
    assert np.array_equal(found.points, recording.points)
    assert not found.findings


@pytest.mark.parametrize(("name", "noise"), [("rural", 1.0), ("rural", 2.5), ("descent", 2.5), ("commute", 2.5), ("rural", 5.0)])
def test_noise_of_a_receiver_is_smoothed_within_its_accuracy(name: str, noise: float):
    road = open_road(name)
    rms, length = [], []
    for seed in range(5):
        found = made(recorded(road, Receiver(plane=noise), seed))
        rms.append(np.sqrt(np.mean(off(found.points, road) ** 2)))
        length.append(float(np.sum(np.hypot(*np.diff(found.points, axis=0).T))) / road.length)
    # places one second apart say less about a bend than about a straight; raw places lie `noise` off
    assert np.median(rms) < 0.75 * noise
    assert abs(np.median(length) - 1.0) < 0.02


def test_a_bend_in_a_long_straight_is_kept():
    road = RoadBuilder("one bend").straight(800.0).bend(25.0, np.radians(90.0), 10.0).straight(800.0).build()
    for seed in range(3):
        found = made(recorded(road, Receiver(plane=1.0), seed))
        # places 9 m apart about the bend, each 1 m off
        assert off(found.points, road).max() < 3.5
        curve = Road.from_points("made", found.points, -1.0, 1.0).reference
        sharpest = np.abs(curve.curvature(np.linspace(0.0, curve.length, 3000))).max()
        assert 0.5 / 25.0 < sharpest < 1.6 / 25.0
        straight = np.abs(curve.curvature(np.linspace(100.0, 700.0, 600)))
        assert np.median(straight) < 1.0 / 1000.0


def test_the_stated_accuracy_is_what_the_places_are_off():
    recording = recorded(open_road("rural"), Receiver(plane=1.5), 3)
    found = made(recording, Wish(plane=2.0))
    line = found.points
    distance = cKDTree(np.column_stack([np.interp(np.linspace(0, len(line) - 1, 40000), np.arange(len(line)), c) for c in line.T])).query(
        recording.points
    )[0]
    # the smoothest line within it: on the ladder of smoothness the next step would be beyond
    assert 0.6 * 2.0 < np.sqrt(np.mean(distance**2)) <= 2.0 * 1.05


def test_a_cloud_at_a_stop_is_one_place():
    rng = np.random.default_rng(5)
    x = np.arange(0.0, 800.0, 10.0)
    way = np.column_stack([x, 20.0 * np.sin(x / 150.0)])
    places = np.vstack([way[:30], way[30] + rng.normal(0.0, 2.0, (25, 2)), way[31:]])
    found = made(Recording("drive", places, None, None, None, tuple(map(str, range(len(places))))))
    truth = cKDTree(np.column_stack([np.arange(0.0, 790.0, 0.1), 20.0 * np.sin(np.arange(0.0, 790.0, 0.1) / 150.0)]))
    assert truth.query(found.points)[0].max() < 2.0
    length = float(np.sum(np.hypot(*np.diff(found.points, axis=0).T)))
    assert length == pytest.approx(float(np.sum(np.hypot(*np.diff(way, axis=0).T))), rel=0.01)
    assert "1 stop drawn together" in words(found)


def test_a_stop_counts_no_more_than_other_places():
    rng = np.random.default_rng(3)
    x = np.arange(0.0, 800.0, 10.0)
    way = np.column_stack([x, np.zeros(80)]) + rng.normal(0.0, 1.0, (80, 2))
    # while it stands the receiver drifts to the side
    stood = np.array([400.0, 5.0]) + rng.normal(0.0, 1.0, (120, 2))
    places = np.vstack([way[:40], stood, way[40:]])
    found = made(Recording("drive", places, None, None, None, tuple(map(str, range(200)))))
    assert np.abs(found.points[:, 1]).max() < 3.0


def test_a_noisy_circuit_closes_smoothly():
    angle = np.linspace(0.0, 2.0 * np.pi, 150, endpoint=False)
    rng = np.random.default_rng(2)
    ring = 150.0 * np.column_stack([np.cos(angle), np.sin(angle)]) + rng.normal(0.0, 1.0, (150, 2))
    found = made(Recording("ring", ring, None, np.arange(150.0), None, tuple(map(str, range(150)))), closed=True)
    assert found.closed
    assert np.abs(np.hypot(*found.points.T) - 150.0).max() < 1.5
    curve = Road.from_points("ring", found.points, -1.0, 1.0, closed=True).reference
    seam = np.abs(curve.curvature(np.linspace(-15.0, 15.0, 200) % curve.length))
    assert seam.max() < 1.0 / 50.0
    assert found.recorded is not None
    middle = np.interp(75.0, found.recorded.t, found.recorded.s)
    assert middle == pytest.approx(150.0 * np.pi, rel=0.03)


def test_raw_takes_the_places_as_they_are():
    recording = recorded(open_road("rural"), Receiver(plane=2.5, height=1.0), 1)
    found = made(recording, Wish(raw=True))
    assert recording.height is not None
    told = {(*place, z) for *place, z in np.column_stack([recording.points, recording.height]).tolist()}
    made_of = {(*place, z) for *place, z in np.column_stack([found.points, found.height]).tolist()}
    # and some places on pieces three times as long as their neighbours, on the straight between
    assert told <= made_of
    assert len(made_of) < 1.2 * len(told)


def test_a_drawn_line_is_not_left_between_its_points():
    # straights of 300 m between arcs drawn by points 2 m apart, as programs thin a line
    line, heading = [np.zeros(2)], 0.0
    for turn in (0.8, -1.2, 0.5, 0.9, -0.6):
        line.append(line[-1] + 300.0 * np.array([np.cos(heading), np.sin(heading)]))
        for _ in range(10):
            heading += turn / 10.0
            line.append(line[-1] + 2.0 * np.array([np.cos(heading), np.sin(heading)]))
    points = np.array(line)
    for wish in (Wish(), Wish(raw=True)):
        found = made(Recording("drawn", points, None, None, None, tuple(map(str, range(len(points))))), wish)
        curve = Road.from_points("made", found.points, -1.0, 1.0).reference
        # without places on the straights the spline is up to 60 m beside them
        assert beside(curve.position(np.arange(0.0, curve.length, 1.0)), points) < 1.0


def test_an_accuracy_that_no_smooth_line_has_is_refused():
    rng = np.random.default_rng(0)
    x = np.arange(0.0, 3000.0, 10.0)
    drive = np.column_stack([x, 40.0 * np.sin(x / 150.0)]) + rng.normal(0.0, 3.0, (300, 2))
    with pytest.raises(RoadError, match=r"no smooth line leads along the places within 0\.05 m"):
        made(Recording("drive", drive, None, None, None, tuple(map(str, range(300)))), Wish(plane=0.05))
