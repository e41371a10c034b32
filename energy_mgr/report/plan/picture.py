"""What the figure of a plan shows, as plain arrays: the process that draws it needs nothing else of this package."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np

from ..style import KMH

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ...planning import Plan, Run

    Floats = NDArray[np.float64]

#: Half the length of road that the sharpest bend is shown with, m.
REACH = 60.0


@dataclass(frozen=True, eq=False, slots=True)
class Lines:
    """A stretch of road from above, points (n, 2) in m: both borders, the baseline's path and the plan's."""

    right: Floats
    left: Floats
    baseline: Floats
    plan: Floats


@dataclass(frozen=True, eq=False, slots=True)
class Series:
    """One drive over its stations (n,): km/h, m/s^2, 1/m, kW. Acceleration and power hold until the next station."""

    s: Floats
    speed: Floats
    acceleration: Floats
    curvature: Floats
    power: Floats

    @classmethod
    def of(cls, run: Run) -> Self:
        """The series of a run."""
        profile, power = run.profile, run.ledger.power / 1000.0
        held = np.append(profile.acceleration, profile.acceleration[-1]), np.append(power, power[-1])
        return cls(profile.s, KMH * profile.v, held[0], run.path.curve.curvature(profile.s), held[1])


@dataclass(frozen=True, eq=False, slots=True)
class PlanPicture:
    """All that is drawn of a plan.

    Attributes:
        map_title, bend_title, title: what stands above map, bend and speed.
        road: the whole road.
        bend: the pieces of road about the sharpest bend; more than one where it lies across a circuit's seam.
        start, square: points (2,) in m, of the start and the sharpest bend on the plan's path.
        baseline, plan: the two drives.
        limit_s, limit: what the speed is bounded by on the plan's path, (n,), m and km/h.
    """

    map_title: str
    bend_title: str
    title: str
    road: Lines
    bend: tuple[Lines, ...]
    start: Floats
    square: Floats
    baseline: Series
    plan: Series
    limit_s: Floats
    limit: Floats

    @classmethod
    def of(cls, plan: Plan) -> Self:
        """The picture of `plan`."""
        at, on_path = _sharpest(plan)
        saved = plan.saving_percent
        change = f"{saved:z.1f} % less energy" if saved is not None else f"{plan.baseline.energy_kwh - plan.energy_kwh:z.4f} kWh less"
        return cls(
            map_title=f"{plan.road.name}, {plan.road.length / 1000.0:z.2f} km",
            bend_title=f"sharpest bend (square in the map), at {at:z.0f} m",
            title=f"{plan.journey_time:z.1f} s, {plan.energy_kwh:z.4f} kWh: {change} than the baseline ({plan.baseline.journey_time:z.1f} s)",
            road=_lines(plan, _stations(plan.road.length, plan.road.length / 4000.0)),
            bend=tuple(_lines(plan, piece) for piece in _around(plan, at)),
            start=plan.chosen.path.curve.position(0.0),
            square=plan.chosen.path.curve.position(on_path),
            baseline=Series.of(plan.baseline),
            plan=Series.of(plan.chosen),
            limit_s=plan.chosen.limits.s,
            limit=KMH * plan.chosen.limits.v_max,
        )


def _stations(length: float, step: float) -> Floats:
    return np.linspace(0.0, length, max(int(length / step), 20) + 1)


def _lines(plan: Plan, road_s: Floats) -> Lines:
    reference = plan.road.reference
    right, left = plan.road.corridor("road").borders(road_s)
    points, normal = reference.position(road_s), reference.normal(road_s)
    paths = [run.path.curve.position(np.interp(road_s, run.path.knot_road_s, run.path.knot_s)) for run in (plan.baseline, plan.chosen)]
    return Lines(points + right[:, None] * normal, points + left[:, None] * normal, paths[0], paths[1])


def _sharpest(plan: Plan) -> tuple[float, float]:
    """Station on the road and on the plan's path where the baseline bends most."""
    s = _stations(plan.road.length, 1.0)
    baseline, chosen = plan.baseline.path, plan.chosen.path
    kappa = baseline.curve.curvature(np.interp(s, baseline.knot_road_s, baseline.knot_s))
    at = float(s[np.argmax(np.abs(kappa))])
    return at, float(np.interp(at, chosen.knot_road_s, chosen.knot_s))


def _around(plan: Plan, at: float) -> list[Floats]:
    """Stations of the road about `at`, in pieces without a gap."""
    reach = min(REACH, 0.5 * plan.road.length)
    around = np.linspace(at - reach, at + reach, 400)
    around = np.unique(np.mod(around, plan.road.length)) if plan.road.closed else np.unique(np.clip(around, 0.0, plan.road.length))
    return np.split(around, np.flatnonzero(np.diff(around) > 5.0) + 1)
