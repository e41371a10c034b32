"""Drives that turn back, break off, go astray or back in time."""

import numpy as np
import pytest

from roads import RoadError
from roads.conditioning.conditioned import Conditioned, conditioned
from roads.conditioning.legs import legs_of, turning_points
from roads.conditioning.recording import Recording, astray, in_time
from roads.conditioning.wish import Wish


def recording(points: np.ndarray, time: np.ndarray | None = None) -> Recording:
    return Recording("drive", points, None, time, None, tuple(f"point {k}" for k in range(len(points))))


def made(points: np.ndarray, wish: Wish | None = None) -> Conditioned:
    return conditioned(recording(points), wish or Wish(), None)


def wavy(count: int = 81, step: float = 10.0, noise: float = 0.0, seed: int = 0) -> np.ndarray:
    x = np.arange(count) * step
    return np.column_stack([x, 30.0 * np.sin(x / 120.0)]) + np.random.default_rng(seed).normal(0.0, noise, (count, 2))


@pytest.mark.parametrize("noise", [0.0, 1.0, 2.5])
@pytest.mark.parametrize("beside", [0.0, 1.5])
def test_out_and_back_are_two_ways(noise: float, beside: float):
    out, back = wavy(noise=noise), wavy(noise=noise, seed=1)[-2::-1] + np.array([0.0, beside])
    drive = np.vstack([out, back])
    (tip,) = turning_points(recording(drive))
    assert abs(tip - 80) <= 1
    found = made(drive)
    length = float(np.sum(np.hypot(*np.diff(found.points, axis=0).T)))
    assert length == pytest.approx(float(np.sum(np.hypot(*np.diff(wavy(), axis=0).T))), rel=0.03)
    (warning,) = [str(finding) for finding in found.findings if finding.severity == "warning"]
    assert "turns back on its own line" in warning
    assert "2 ways along roads" in warning
    second = made(drive, Wish(leg=2))
    # the way back begins where the way out ended
    assert np.hypot(*(second.points[0] - wavy()[-1])) < 2.0 + 3.0 * noise + beside
    assert np.hypot(*(second.points[-1] - wavy()[0])) < 2.0 + 3.0 * noise + beside


@pytest.mark.parametrize("radius", [5.0, 9.0, 15.0])
def test_a_hairpin_is_a_bend_and_no_way_back(radius: float):
    turn = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 9)
    up = np.column_stack([np.arange(0.0, 200.0, 5.0), np.zeros(40)])
    pin = np.column_stack([200.0 + radius * np.cos(turn), radius + radius * np.sin(turn)])
    back = up[::-1] + np.array([0.0, 2.0 * radius])
    drive = np.vstack([up, pin, back])
    assert turning_points(recording(drive)) == []
    found = made(drive)
    assert len(found.points) == len(drive)


def test_a_short_gap_is_bridged_and_a_long_one_parts():
    way = wavy(200)
    short = np.vstack([way[:80], way[88:]])
    found = made(short)
    assert found.points[-1] == pytest.approx(way[-1])
    (warning,) = [str(finding) for finding in found.findings]
    assert "point 79" in warning
    assert "is bridged" in warning
    far = np.vstack([way[:150], way[150:] + np.array([30_000.0, 0.0])])
    assert [(leg.first, leg.last, leg.ended) for leg in legs_of(recording(far))] == [(0, 149, "gap"), (150, 199, "end")]
    assert len(made(far).points) == 150
    with pytest.raises(RoadError, match="leg 3 of a drive that has 2"):
        made(far, Wish(leg=3))


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("noise", [0.0, 2.0])
def test_points_astray_are_left_out(count: int, noise: float):
    drive = wavy(noise=noise)
    drive[40 : 40 + count] += [0.0, 200.0]
    assert np.flatnonzero(astray(recording(drive))).tolist() == list(range(40, 40 + count))
    found = made(drive)
    assert np.abs(found.points[:, 1]).max() < 45.0
    assert "astray" in str(found.findings)


def test_a_dead_end_is_not_astray():
    out = np.column_stack([np.arange(0.0, 300.0, 15.0), np.zeros(20)])
    assert not astray(recording(np.vstack([out, out[-2::-1]]))).any()
    corner = np.vstack([out, np.column_stack([np.full(20, 285.0), np.arange(30.0, 330.0, 15.0)])])
    assert not astray(recording(corner)).any()


def test_points_out_of_order_in_time_are_left_out():
    time = np.arange(81.0)
    time[[20, 21]] = [5.0, 6.0]
    assert np.flatnonzero(~in_time(recording(wavy(), time))).tolist() == [20, 21]
    found = conditioned(recording(wavy(), time), Wish(), None)
    # where two are missing a place between holds the curve
    assert len(found.points) == 80
    assert "point 20" in str(found.findings[0])


@pytest.mark.parametrize(
    ("wish", "message"),
    [
        ({"plane": 0.0}, "accuracy in the plane"),
        ({"height": 1e3}, "accuracy in the height"),
        ({"leg": 0}, "leg 0"),
        ({"raw": True, "plane": 1.0}, "raw with"),
    ],
)
def test_wishes_out_of_range_are_refused(wish: dict[str, float], message: str):
    with pytest.raises(RoadError, match=message):
        Wish(**wish)  # pyright: ignore[reportArgumentType]


def test_what_stands_still_is_no_drive():
    with pytest.raises(RoadError, match="stands at one place"):
        made(np.zeros((50, 2)))


@pytest.mark.parametrize("stood", [120, 600])
def test_a_receiver_that_drifts_while_the_car_stands_turns_nothing_round(stood: int):
    for seed in range(5):
        rng = np.random.default_rng(seed)
        drift = np.zeros((stood, 2))
        for k in range(1, stood):
            drift[k] = 0.983 * drift[k - 1] + 0.18 * rng.normal(0.0, 2.5, 2)
        way = wavy()
        drive = np.vstack([way[:40], way[40] + drift, way[40:]]) + rng.normal(0.0, 0.3, (81 + stood, 2))
        assert len(legs_of(recording(drive))) == 1


def test_crawling_is_no_turning_back():
    for seed in range(5):
        x = np.arange(0.0, 400.0, 0.05)
        drive = np.column_stack([x, 10.0 * np.sin(x / 80.0)]) + np.random.default_rng(seed).normal(0.0, 0.5, (len(x), 2))
        (leg,) = legs_of(recording(drive))
        # along the points it would be six kilometres; along anchors four noises apart it is a third too much
        assert leg.length < 600.0
