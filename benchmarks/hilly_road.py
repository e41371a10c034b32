"""A synthetic road for benchmarks that grow: straights and bends, posted limits, hills; the first part of a longer one is the shorter one."""

from __future__ import annotations

from functools import cache

import numpy as np

import roads
from energy_mgr import SpeedLimits, plan_path
from energy_mgr.speed.bounds.parts import Part
from powertrain import load_vehicle
from roads import Road

SEED = 6
STEEPEST = 0.05
KMH = 1.0 / 3.6
_WAVES, _LONGEST_M, _SHORTEST_M, _LOOKED_AT_M = 40, 4000.0, 250.0, 120e3


def hilly_road(kilometres: float) -> Road:
    """Bends of 40 to 400 m radius by turns left and right, straights of 50 to 500 m, limits of 50 to 100 km/h, slopes up to 5 % either way."""
    rng, turned = np.random.default_rng(SEED), 0.0
    builder = roads.RoadBuilder(f"hilly, {kilometres:g} km")
    while builder.length < 1000.0 * kilometres:
        if rng.random() < 0.3 or not builder.length:
            builder.limit(float(rng.choice([50, 60, 70, 80, 90, 100])) * KMH)
        radius = float(np.exp(rng.uniform(np.log(40.0), np.log(400.0))))
        # back towards where the road leads, so that it gets somewhere
        sign = -np.sign(turned) if abs(turned) > 1.0 else rng.choice([-1.0, 1.0])
        angle = sign * rng.uniform(0.2, 1.4)
        builder.straight(rng.uniform(50.0, 500.0)).bend(radius, angle, min(30.0, 0.8 * radius * abs(angle)))
        turned += angle
    return builder.straight(50.0).build(height=_height())[0.0 : 1000.0 * kilometres]


def _height():
    """Heights over stations: cosines of random phase, whose steepest slope on the longest road is 5 %."""
    rng = np.random.default_rng(SEED + 1)
    number = 2.0 * np.pi / np.exp(rng.uniform(np.log(_SHORTEST_M), np.log(_LONGEST_M), _WAVES))
    phase = rng.uniform(0.0, 2.0 * np.pi, _WAVES)

    def sloping(s):
        return sum(np.cos(n * s + p) for n, p in zip(number, phase, strict=True))

    scale = STEEPEST / float(np.max(np.abs(sloping(np.arange(0.0, _LOOKED_AT_M, 2.0)))))
    return lambda s: scale * sum((np.sin(n * s + p) - np.sin(p)) / n for n, p in zip(number, phase, strict=True))


@cache
def limits_on_hills(kilometres: float, count: int, *, parts: tuple[Part, ...] | None = None) -> SpeedLimits:
    """The limits of the ROMO on the lane's centre at `count` stations, evenly spaced."""
    road, path = _centre(kilometres)
    step = path.curve.length / (count - 1) * (1.0 + 1e-9)
    return SpeedLimits.along(road, path, load_vehicle("romo"), parts=None if parts is None else list(parts), step=step)


@cache
def _centre(kilometres: float):
    road = hilly_road(kilometres)
    return road, plan_path(road, 1.05, kind="lane")
