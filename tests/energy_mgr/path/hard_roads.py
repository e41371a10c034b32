"""Random roads that are hard on a path planner, and an oracle for what it returns.

`hard_road(seed)` draws a road; `worst_border_gap` and `curvature_extreme`, from `border_oracle`, judge a curve without the package's own checks.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roads import PlanarCurve, Road, RoadBuilder, RoadError
from roads.road import Extent

from .border_oracle import curvature_extreme, worst_border_gap

__all__ = ["CAR", "FAMILIES", "curvature_extreme", "hard_road", "passage", "worst_border_gap"]

Floats = NDArray[np.float64]

#: Twice half a car's width and what its driver keeps, m; a pinched road has a narrower place, all others are a decimetre wider everywhere.
CAR = 1.9
NARROWEST, WIDEST, TIGHTEST, LONGEST = 2.2, 12.0, 6.0, 1500.0
#: The spline overshoots where curvature jumps, and noise bends it further.
OVERSHOOT = 0.9


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _turn(rng: np.random.Generator, low: float, high: float) -> float:
    """An angle between `low` and `high` degrees to either side, rad."""
    return float(np.radians(rng.uniform(low, high)) * rng.choice([-1.0, 1.0]))


def _blended(rng: np.random.Generator, builder: RoadBuilder, radius: float, angle: float, longest: float = np.inf) -> None:
    way = radius * abs(angle)
    builder.bend(radius, angle, min(max(0.5, rng.uniform(0.05, 0.95) * way), 0.95 * way, longest))


def _straight(rng: np.random.Generator, builder: RoadBuilder) -> None:
    builder.straight(_log(rng, 5.0, 300.0))


def _bend(rng: np.random.Generator, builder: RoadBuilder) -> None:
    builder.straight(_log(rng, 1.0, 80.0))
    _blended(rng, builder, _log(rng, TIGHTEST, 120.0), _turn(rng, 15.0, 120.0))


def _hairpin(rng: np.random.Generator, builder: RoadBuilder) -> None:
    builder.straight(_log(rng, 5.0, 80.0))
    _blended(rng, builder, _log(rng, TIGHTEST, 20.0), _turn(rng, 150.0, 200.0))


def _roundabout(rng: np.random.Generator, builder: RoadBuilder) -> None:
    entry, ring, angle = _log(rng, TIGHTEST, 20.0), _log(rng, 8.0, 25.0), np.radians(rng.uniform(60.0, 280.0))
    builder.straight(_log(rng, 10.0, 80.0)).roundabout(entry, ring, angle, rng.uniform(0.5, 4.5)).straight(rng.uniform(5.0, 40.0))


def _s_turn(rng: np.random.Generator, builder: RoadBuilder) -> None:
    angle = _turn(rng, 20.0, 90.0)
    for _ in range(2 * int(rng.integers(1, 3))):
        _blended(rng, builder, _log(rng, TIGHTEST, 30.0), angle, rng.uniform(0.5, 4.0))
        angle *= -rng.uniform(0.8, 1.2)
        if rng.random() < 0.7:
            builder.straight(rng.uniform(0.1, 4.0))


def _arc(rng: np.random.Generator, builder: RoadBuilder) -> None:
    builder.arc(_log(rng, TIGHTEST, 150.0), _turn(rng, 10.0, 150.0))
    if rng.random() < 0.6:
        builder.straight(_log(rng, 1.0, 50.0))


def _circuit(rng: np.random.Generator) -> PlanarCurve:
    """Star-shaped about its middle, with up to 20 waves, as wild as a drawn least radius allows."""
    middle, size = _log(rng, 12.0, 180.0), rng.uniform(0.2, 0.7)
    least = _log(rng, TIGHTEST, min(25.0, 0.8 * middle))
    phi = np.linspace(0.0, 2.0 * np.pi, int(2.0 * np.pi * middle / 0.8), endpoint=False)[:: int(rng.choice([-1, 1]))]
    waves = np.arange(2, rng.integers(4, 21))
    wave = (rng.normal(size=len(waves)) / waves) @ np.cos(np.outer(waves, phi) + rng.uniform(0.0, 2.0 * np.pi, (len(waves), 1)))
    wave /= np.max(np.abs(wave))
    while True:
        radius = middle * (1.0 + size * wave)
        curve = PlanarCurve.through(radius[:, None] * np.column_stack([np.cos(phi), np.sin(phi)]), closed=True)
        if np.max(np.abs(curve.curvature(np.arange(0.0, curve.length, 0.2)))) <= 1.0 / least:
            return curve
        size *= 0.85


def _oval(rng: np.random.Generator) -> PlanarCurve:
    """Two equal straights and two equal half turns; that the second half is the first one turned round closes it."""
    straight, radius, side = _log(rng, 1.0, 300.0), _log(rng, TIGHTEST, 60.0), rng.choice([-1.0, 1.0])
    blend = rng.uniform(0.1, 0.9) * radius * np.pi
    builder = RoadBuilder("oval")
    for _ in range(2):
        builder.straight(straight).bend(radius, side * np.pi, blend)
    return builder.build(spacing=0.5, closed=True).reference


UNITS = {"bends": _bend, "hairpins": _hairpin, "roundabouts": _roundabout, "s-turns": _s_turn, "arcs": _arc, "straights": _straight}
CLOSED = {"circuit": _circuit, "oval": _oval}
FAMILIES = (*UNITS, *CLOSED, "widths", "short", "noisy", "mixed")


def hard_road(seed: int) -> Road:
    """A road drawn from `seed`; its name tells the seed, the family, and whether it is `pinched`: narrower somewhere than a car needs."""
    rng = np.random.default_rng(seed)
    family = str(rng.choice(FAMILIES))
    pinched = rng.random() < 0.1
    while True:
        try:
            road = _drawn(rng, f"{seed} {family}{' pinched' * pinched}", family, pinched)
        except RoadError:
            continue  # a road that the package refuses is no road: draw another one
        bent = float(np.max(np.abs(road.reference.curvature(np.arange(0.0, road.length, 0.2)))))
        fits = np.min(road.left - road.right) < CAR if pinched else min(passage(road, "road"), passage(road, "own")) >= CAR + 0.1
        if fits and bent * TIGHTEST * OVERSHOOT <= 1.0 and road.length <= LONGEST:
            return road


def _drawn(rng: np.random.Generator, name: str, family: str, pinched: bool) -> Road:
    if family in CLOSED:
        curve = CLOSED[family](rng)
        length = curve.length
    else:
        # cut where the length is reached, so that roads also begin and end within bends
        length = rng.uniform(10.0, 30.0) if family == "short" else _log(rng, 40.0, 0.99 * LONGEST)
        builder = RoadBuilder(name, heading=rng.uniform(-np.pi, np.pi))
        units = [UNITS[family]] if family in UNITS else [_bend, _straight] if family in ("widths", "noisy") else list(UNITS.values())
        while builder.length < length:
            units[int(rng.integers(len(units)))](rng, builder)
        curve = builder.build(spacing=0.5).reference
    often = family in ("widths", "mixed")
    bumps = [_Bump.drawn(rng, length) for _ in range(rng.integers(1, 3 + int(length / 60.0)) if often or rng.random() < 0.3 else 0)]
    pinch = [
        _Bump(rng.uniform(0.0, 0.5) * length, rng.uniform(0.3, min(5.0, 0.1 * length)), min(8.0, 0.3 * length), 0.0, int(rng.integers(2)))
    ] * pinched
    if family == "noisy" or (family == "mixed" and rng.random() < 0.3):
        steps = np.cumsum(rng.uniform(2.0, 5.0, int(length / 2.0)))
        s = np.append(0.0, steps[steps < length])
        points = curve.position(s) + rng.normal(0.0, rng.uniform(0.01, 0.05), (len(s), 2))
    else:
        corners = np.concatenate([[0.0], *(bump.corners(length) for bump in (*bumps, *pinch))])
        s = _with_corners(np.linspace(0.0, length, int(length / rng.choice([0.5, 1.0, 2.0])) + 2), corners)
        s = s[: len(s) - curve.closed]
        points = curve.position(s)
    right, left, lanes = _section(rng, s, length, curve.closed, bumps, pinch)
    return Road.from_points(name, points, right, left, closed=curve.closed, lane_edges=lanes)


def _with_corners(s: Floats, corners: Floats) -> Floats:
    """Stations `s` with `corners`, where those of `s` give way and none but the ends are closer than 5 cm."""
    corners = np.unique(corners)
    corners = corners[np.append(True, np.diff(corners) > 0.05) & (corners < s[-1] - 0.1)]
    away = np.min(np.abs(s[:, None] - corners), axis=1) > 0.1
    return np.sort(np.concatenate([s[away], corners]))


@dataclass(frozen=True)
class _Bump:
    """A trapezoid that one edge comes in by (goes out where negative): from `at` over a `rise`, on for `hold`, back over a `rise`, m."""

    at: float
    rise: float
    hold: float
    depth: float
    edge: int

    @classmethod
    def drawn(cls, rng: np.random.Generator, length: float) -> _Bump:
        """A ramp, a step or a parked car, shortened to fit the road."""
        rise, hold, depth = (
            (rng.uniform(5.0, 40.0), rng.uniform(0.0, 50.0), rng.uniform(-4.0, 3.0)),
            (rng.uniform(1.0, 2.0), rng.uniform(3.0, 40.0), rng.uniform(-3.0, 2.5)),
            (rng.uniform(0.3, 1.0), rng.uniform(4.0, 6.0), rng.uniform(1.6, 2.2)),
        )[int(rng.integers(3))]
        fit = min(1.0, 0.9 * length / (2.0 * rise + hold))
        return cls(rng.uniform(-0.1, 0.9) * length, fit * rise, fit * hold, depth, int(rng.integers(2)))

    def corners(self, length: float) -> Floats:
        """Its stations on a road of `length`; those beyond the ends come out somewhere on it, which does no harm."""
        return np.mod(self.at + np.cumsum([0.0, self.rise, self.hold, self.rise]), length)

    def share(self, s: Floats, length: float, closed: bool) -> Floats:
        """How much of its depth there is at stations `s`, 0 to 1."""
        way = np.mod(s - self.at, length) if closed else s - self.at
        return np.interp(way, np.cumsum([0.0, self.rise, self.hold, self.rise]), [0.0, 1.0, 1.0, 0.0])


def _section(
    rng: np.random.Generator, s: Floats, length: float, closed: bool, bumps: list[_Bump], pinch: list[_Bump]
) -> tuple[Floats, Floats, list[tuple[int, Floats, Floats]]]:
    """Right and left edge at stations `s`, and one or two lanes: right-hand traffic, so that the right one (-1 in OpenDRIVE) leads this way."""
    width = _log(rng, NARROWEST, WIDEST)
    share = (1.0, 0.0, 0.5, rng.uniform())[rng.choice(4, p=[0.25, 0.25, 0.35, 0.15])]
    edges = [np.full(len(s), -share * width), np.full(len(s), (1.0 - share) * width)]
    two, divider = rng.random() < 0.6, float(np.mean([edge[0] for edge in edges]))
    for bump in bumps:
        part, here = bump.share(s, length, closed), edges[1] - edges[0]
        under = here[part > 0.0] if np.any(part > 0.0) else here
        depth = np.clip(bump.depth, np.max(under) - WIDEST, np.min(under) - NARROWEST)
        edges[bump.edge] += (1.0, -1.0)[bump.edge] * depth * part
    two &= bool(np.min(edges[1] - edges[0]) >= 2.0 * NARROWEST)
    for bump in pinch:
        part, here = bump.share(s, length, closed), edges[1] - edges[0]
        edges[bump.edge] += (1.0, -1.0)[bump.edge] * part * (np.min(here[part == np.max(part)]) - rng.uniform(1.2, 1.85))
    right, left = edges
    least = np.minimum(NARROWEST, 0.5 * (left - right))
    middle = np.clip(divider, right + least, left - least)
    return right, left, [(1, right, middle), (-1, middle, left)] if two else [(1, right, left)]


def passage(road: Road, extent: Extent, reach: float = 5.0) -> float:
    """The least distance in m from border to border, up to about `reach` m of way apart; no wider disc passes, also not in a chicane of steps."""
    s = np.union1d(road.s, np.arange(0.0, road.length, 0.2))
    place, d1, d2 = road.reference.pieces(road.reference.parameter(s), 2)  # asked for once: stations take the time
    speed = np.hypot(*d1.T)
    kappa = (d1[:, 0] * d2[:, 1] - d1[:, 1] * d2[:, 0]) / speed**3
    normal, fold = np.column_stack([-d1[:, 1], d1[:, 0]]) / speed[:, None], 0.9 / np.maximum(np.abs(kappa), 1e-9)
    right, left = road.corridor(extent).borders(s)
    # what lies beyond a centre of curvature is folded back and no border
    right, left = np.where(kappa < 0.0, np.maximum(right, -fold), right), np.where(kappa > 0.0, np.minimum(left, fold), left)
    one, other = place + right[:, None] * normal, place + left[:, None] * normal
    least = float(np.min(left - right))
    for shift in range(1, min(int(reach / 0.2), len(s) // 2)):
        ends = len(s) if road.closed else len(s) - shift
        for a, b in ((one, other), (other, one)):
            least = min(least, float(np.min(np.hypot(*(a[:ends] - np.roll(b, -shift, axis=0)[:ends]).T))))
    return least
