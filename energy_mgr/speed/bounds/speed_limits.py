"""The limits of a car on a path along a road, put together from parts."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from .limits import UNLIMITED, Limits
from .parts import standard_parts
from .stations import ground_along

if TYPE_CHECKING:
    from collections.abc import Sequence

    from powertrain import Vehicle
    from roads import Road

    from ...path import Path
    from .parts import Part


@dataclass(frozen=True, eq=False)
class SpeedLimits(Limits):
    """Bounds on speed, acceleration, force and time along a path; see `Limits` for what they hold."""

    @classmethod
    def along(
        cls,
        road: Road,
        path: Path,
        vehicle: Vehicle,
        *,
        parts: Sequence[Part] | None = None,
        extra: Sequence[Part] = (),
        step: float = 2.0,
        start_speed: float = 0.0,
        end_speed: float = 0.0,
    ) -> SpeedLimits:
        """The limits of `vehicle` on `path` along `road` at stations at most `step` (m) apart.

        Args:
            road: with posted limits, heights, bank and friction.
            path: to be driven.
            vehicle: the car.
            parts: what bounds the drive; by default road, car, lateral acceleration, comfort and motors (V1).
            extra: parts beside these.
            step: m.
            start_speed: m/s, on open roads.
            end_speed: m/s, on open roads.

        Raises:
            PlanningError: a step, speed or part out of range; the limit, the station and by how much.
        """
        used = [*(standard_parts() if parts is None else parts), *extra]
        ground = ground_along(road, path, step, [s for part in used for s in part.stations])
        count = len(ground.s)
        free = np.full(count - 1, UNLIMITED)
        limits = cls(vehicle, road.name, ground, {"car": np.full(count, vehicle.limits.speed_max_mps)}, free, free)
        for part in used:
            limits = part.added(limits)
        return replace(limits, start_speed=start_speed, end_speed=end_speed).checked()
