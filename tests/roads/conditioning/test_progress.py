"""Times at scattered places made one drive: how fast, where it stood."""

import numpy as np
import pytest

from roads import Recorded, RoadError, open_road
from roads.conditioning.conditioned import conditioned
from roads.conditioning.progress import from_columns, recorded_drive
from roads.conditioning.recording import spread
from roads.conditioning.wish import Wish

from .drives import Receiver, driven, recorded


@pytest.mark.parametrize(("noise", "off"), [(0.0, 0.25), (1.0, 0.6), (2.5, 1.0)])
def test_speeds_are_those_that_were_driven(noise: float, off: float):
    road = open_road("rural")
    stop = (0.4 * road.length, 25.0)
    t, s = driven(road, 1.0, stop)
    v = np.gradient(s, t)
    missed, stood = [], []
    for seed in range(5):
        drive = conditioned(recorded(road, Receiver(plane=noise), seed, stop), Wish(), False).recorded
        assert drive is not None
        assert drive.duration == pytest.approx(t[-1])
        missed.append(np.sqrt(np.mean((np.interp(t, drive.t, drive.v) - v) ** 2)))
        where = [(place, duration) for place, duration in drive.stops if duration > 10.0]
        assert len(where) == 1
        assert where[0][0] == pytest.approx(stop[0], abs=3.0 + 3.0 * noise)
        stood.append(where[0][1])
    # a difference of raw places one second apart would be off by the noise times the root of 2
    assert np.median(missed) < off
    assert np.median(stood) == pytest.approx(25.0, abs=2.0 + 2.0 * noise)


def test_exact_speeds_are_taken_as_recorded():
    t = np.arange(0.0, 60.0)
    v = 10.0 + 3.0 * np.sin(t / 10.0)
    s = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]))])
    drive = recorded_drive(t, s, v, float(s[-1]))
    assert drive is not None
    assert np.interp(t, drive.t, drive.v) == pytest.approx(v, rel=1e-9)
    assert np.interp(t, drive.t, drive.s) == pytest.approx(s, abs=0.2)


def test_tables_tell_times_or_speeds():
    s = np.array([0.0, 10.0, 30.0, 40.0])
    of_speeds = from_columns(s, None, np.array([0.0, 10.0, 10.0, 5.0]))
    assert of_speeds is not None
    assert of_speeds.t == pytest.approx([0.0, 2.0, 4.0, 4.0 + 10.0 / 7.5])
    of_times = from_columns(s, np.array([5.0, 6.0, 8.0, 9.0]), None)
    assert of_times is not None
    assert of_times.t == pytest.approx([0.0, 1.0, 3.0, 4.0])
    assert of_times.v == pytest.approx(10.0)
    assert from_columns(s, np.array([0.0, 1.0, 1.0, 2.0]), None) is None
    assert from_columns(s, None, np.zeros(4)) is None


def test_a_part_of_a_drive_counts_from_its_start():
    drive = Recorded(np.arange(11.0), np.arange(0.0, 101.0, 10.0), np.full(11, 10.0))
    part = drive.between(20.0, 70.0)
    assert part is not None
    assert part.t == pytest.approx(np.arange(6.0))
    assert part.s == pytest.approx(np.arange(0.0, 51.0, 10.0))
    assert drive.between(21.0, 29.0) is None


def test_a_drive_that_goes_back_is_refused():
    ones = np.ones(3)
    with pytest.raises(RoadError, match="go back"):
        Recorded(np.array([0.0, 1.0, 1.0]), np.arange(3.0), ones)
    with pytest.raises(RoadError, match="go back"):
        Recorded(np.arange(3.0), np.array([0.0, 2.0, 1.0]), ones)
    with pytest.raises(RoadError, match="shapes"):
        Recorded(np.arange(3.0), np.arange(2.0), ones)


def test_a_road_that_is_cut_keeps_its_part_of_the_drive():
    from dataclasses import replace

    road = open_road("rural")
    t, s = driven(road, 1.0)
    road = replace(road, recorded=Recorded(t, s, np.gradient(s, t)))
    part = road[500.0:1500.0]
    assert part.recorded is not None
    assert part.recorded.s[0] < 25.0
    assert part.recorded.s[-1] > 975.0
    assert road.reversed().recorded is None
    anew = road.resampled(3.0)
    assert anew.recorded is not None
    assert anew.recorded.s[-1] == pytest.approx(s[-1], abs=0.5)


@pytest.mark.parametrize("pause", [30.0, 600.0, 1e5])
@pytest.mark.parametrize("told", [False, True])
def test_a_receiver_that_pauses_while_standing_leaves_a_stop(pause: float, told: bool):
    t = np.arange(200.0)
    t[100:] += pause
    u = 10.0 * np.arange(200.0)
    drive = recorded_drive(t, u, np.full(200, 10.0) if told else None, 1990.0)
    assert drive is not None
    ((place, stood),) = drive.stops
    assert place == pytest.approx(1000.0, abs=12.0)
    assert stood == pytest.approx(pause, abs=2.5)
    assert drive.moving_time == pytest.approx(199.0, abs=3.0)
    assert np.median(drive.v[drive.v > 0.0]) == pytest.approx(10.0, rel=0.02)


def test_times_in_whole_seconds_are_spread():
    assert spread(np.array([0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0])) == pytest.approx(np.arange(8) / 4.0)
    assert spread(np.array([0.0, 1.0, 2.0])) == pytest.approx([0.0, 1.0, 2.0])


def test_rows_that_repeat_a_place_are_a_stop_and_speeds_of_another_drive_are_none():
    t = np.arange(30.0)
    s = np.concatenate([np.arange(10.0) * 10.0, np.full(10, 90.0), 90.0 + np.arange(1.0, 11.0) * 10.0])
    drive = from_columns(s, t, None)
    assert drive is not None
    ((place, stood),) = drive.stops
    assert place == 90.0
    assert stood == pytest.approx(10.0)
    even = from_columns(10.0 * t, t, np.full(30, 36.0))
    assert even is not None
    assert even.v == pytest.approx(10.0)


def test_a_part_ends_where_it_is_cut_and_not_at_a_sample():
    drive = Recorded(np.array([0.0, 50.0, 100.0]), np.array([0.0, 500.0, 1000.0]), np.full(3, 10.0))
    part = drive.between(200.0, 800.0)
    assert part is not None
    assert part.duration == pytest.approx(60.0)
    assert part.s[[0, -1]] == pytest.approx([0.0, 600.0])
