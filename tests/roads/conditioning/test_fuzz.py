"""Recordings that went wrong in every way at once: a road, or one error, in bounded time; and the road can be planned.

A few in every run of the tests; `python -m tests.roads.conditioning.test_fuzz 2000` for as many as you like.
"""

import sys
import time
import warnings

import numpy as np
import pytest

from roads import RoadError, open_road
from roads.conditioning.conditioned import conditioned
from roads.conditioning.recording import Recording
from roads.conditioning.wish import Wish
from roads.formats.recorded_line import road_about

from ...timing import slowness
from .drives import Receiver, recorded

#: No recording of some hundred points may take longer, s of processor time on a machine as fast as the one that this was chosen on.
LONGEST = 5.0


def spoiled(rng: np.random.Generator) -> Recording:
    """A drive with one to five things wrong."""
    road = open_road(str(rng.choice(["rural", "commute", "descent"])))
    receiver = Receiver(
        float(rng.choice([0.0, 0.5, 3.0, 10.0])), float(rng.choice([0.0, 1.0, 10.0])), float(rng.choice([0.0, 1.0])), float(rng.choice([1.0, 5.0]))
    )
    base = recorded(road, receiver, int(rng.integers(1_000_000)), (float(rng.uniform(100.0, road.length - 100.0)), 30.0))
    points, height, t = base.points, base.height, base.time
    assert height is not None
    assert t is not None
    for _ in range(int(rng.integers(1, 6))):
        count = len(points)
        at = int(rng.integers(1, count - 1))
        some = slice(at, at + int(rng.integers(1, 30)))
        match int(rng.integers(12)):
            case 0:
                points = points.copy()
                points[some] += rng.normal(0.0, 300.0, 2)
            case 1:
                points, height, t = (np.concatenate([values[:at], values[some], values[at:]]) for values in (points, height, t))
            case 2:
                points, height, t = (np.delete(values, np.arange(count)[some], axis=0) for values in (points, height, t))
            case 3:
                points = np.concatenate([points, points[-2::-1]])
                height = np.concatenate([height, height[-2::-1]])
                t = np.concatenate([t, 2.0 * t[-1] - t[-2::-1] + 1.0])
            case 4:
                points = points.copy()
                points[some] = points[at]
            case 5:
                height = height.copy()
                height[some] += rng.normal(0.0, 60.0)
            case 6:
                t = t.copy()
                t[some] = t[some][::-1]
            case 7:
                points = points.copy()
                points[some] = points[some][::-1]
            case 8:
                points, height, t = points[: at + 1], height[: at + 1], t[: at + 1]
            case 9:
                points = points + rng.normal(0.0, 3.0, points.shape)
            case 10:
                points = points.copy()
                points[at:] += [float(rng.choice([200.0, 5e3, 5e4])), 0.0]
            case _:
                points, height, t = (np.repeat(values, 3, axis=0) for values in (points, height, t))
        if len(points) < 3:
            break
    return Recording("spoiled", points, height, t, None, tuple(f"point {k}" for k in range(len(points))))


def attack(seed: int) -> str:
    """What became of one recording: `road` or `error`."""
    rng = np.random.default_rng([20261128, seed])
    recording = spoiled(rng)
    start = time.process_time()
    outcome, said = "error", ""
    try:
        made = conditioned(recording, Wish(raw=bool(rng.random() < 0.1)), None)
        road = road_about(recording, "spoiled", closed=None, width=None, origin=None, wish=Wish())
        outcome = "road"
        assert np.isfinite(made.points).all()
        assert np.isfinite(made.height).all()
        # what no road does is either gone or told
        steep = np.abs(road.slope_at(np.linspace(0.0, road.length, 500))).max() > 1.0
        assert not steep or any("no road does" in str(finding) for finding in road.findings)
        if made.recorded is not None:
            assert made.recorded.duration > 0.0
    except RoadError as error:
        said = str(error)
    assert said.isprintable()
    assert time.process_time() - start < LONGEST * slowness(), seed
    return outcome


@pytest.mark.parametrize(("first", "count"), [(0, 12), pytest.param(12, 120, marks=pytest.mark.slow)])
def test_spoiled_recordings_give_a_road_or_one_error(first: int, count: int):
    outcomes = [attack(seed) for seed in range(first, first + count)]
    # what is wrong is left out: few are beyond that
    assert outcomes.count("road") >= 0.8 * count


if __name__ == "__main__":
    warnings.simplefilter("error")
    total = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    found = [attack(seed) for seed in range(total)]
    print(f"{total} recordings: {found.count('road')} roads, {found.count('error')} errors")
