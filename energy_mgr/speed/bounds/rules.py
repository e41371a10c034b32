"""What a user asks of a drive beyond the car's own limits, in stations of the road; every path along it gets them in its own."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ...errors import PlanningError
from .grip import Grip
from .limits import Window
from .parts import Arrival, FrictionBrakes, Jerk, Part, Stop
from .speed_limits import SpeedLimits

if TYPE_CHECKING:
    from collections.abc import Sequence

    from powertrain import Vehicle
    from roads import Road

    from ...path import Path


@dataclass(frozen=True)
class DriveRules:
    """What bounds a drive beside road, car and comfort.

    Attributes:
        start_speed: m/s, on open roads.
        end_speed: m/s, on open roads.
        stops: stations of stop lines on the road, m.
        windows: stations on the road with the times (s) between which they may be passed.
        jerk: largest magnitude, m/s^3.
        grip: friction coefficient of dry asphalt for the friction ellipse; None leaves it out, as published.
        friction_brakes: whether the friction brakes may be used beside recuperation.
        parts: further parts, with stations on the path.
        step: distance of the stations, m.
    """

    start_speed: float = 0.0
    end_speed: float = 0.0
    stops: Sequence[float] = ()
    windows: Sequence[Window] = ()
    jerk: float | None = None
    grip: float | None = None
    friction_brakes: bool = False
    parts: Sequence[Part] = field(default=())
    step: float = 2.0

    def __post_init__(self) -> None:
        # as tuples, so that two requests for the same are equal and can be looked up
        for name, value in (("stops", self.stops), ("windows", [Window(*window) for window in self.windows]), ("parts", self.parts)):
            object.__setattr__(self, name, tuple(value))

    def limits(self, road: Road, path: Path, vehicle: Vehicle) -> SpeedLimits:
        """The limits of `vehicle` on `path` along `road` under these rules.

        Raises:
            PlanningError: a rule out of range, with its station.
        """
        extra: list[Part] = [FrictionBrakes()] if self.friction_brakes else []
        extra += [] if self.grip is None else [Grip(self.grip)]
        extra += [] if self.jerk is None else [Jerk(self.jerk)]
        extra += [Stop(_on_path(road, path, s)) for s in self.stops]
        extra += [Arrival(_on_path(road, path, s), earliest, latest) for s, earliest, latest in self.windows]
        return SpeedLimits.along(
            road, path, vehicle, extra=[*extra, *self.parts], step=self.step, start_speed=self.start_speed, end_speed=self.end_speed
        )


def _on_path(road: Road, path: Path, s: float) -> float:
    """Station on the path abreast of the road's station `s`."""
    if not 0.0 <= s <= road.length:
        raise PlanningError(f"{road.name}: station {s:g} m, expected 0 to {road.length:.1f} m")
    return float(np.clip(np.interp(s, path.knot_road_s, path.knot_s), 0.0, path.curve.length))
