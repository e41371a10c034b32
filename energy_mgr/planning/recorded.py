"""A recorded drive as one more way to drive the road: its own speeds, in its own time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from powertrain import drive_energy, force_limits

from ..speed import SpeedProfile
from .comparison import Run

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from roads import Recorded, Road

    from ..path import Path
    from ..speed import SpeedLimits

    Floats = NDArray[np.float64]

#: Stations of a profile are at least this far apart, m.
_APART = 1e-3


def recorded_run(road: Road, path: Path, limits: SpeedLimits) -> Run | None:
    """The drive recorded along `road`, on `path` (the lane's centre); its stops take no time here. None where none was recorded.

    What recuperation cannot take the friction brakes do, as in every car that drives on a road.
    """
    if road.recorded is None:
        return None
    s, v = _profile(road.recorded, road, path)
    if len(s) < 2:
        return None
    z = np.interp(s, limits.s, limits.z)
    free = drive_energy(limits.vehicle, s, v, z)
    _, regen = force_limits(limits.vehicle, 0.5 * (v[1:] + v[:-1]))
    brake = np.maximum(-free.force - regen, 0.0)
    profile = SpeedProfile(s, v, "recorded", 0, 0.0, brake=brake if brake.any() else None, method="as recorded")
    return Run(path, limits, profile, drive_energy(limits.vehicle, s, v, z, brake))


def _profile(recorded: Recorded, road: Road, path: Path) -> tuple[Floats, Floats]:
    """Stations (n,) on the path and speeds there: what is driven at even acceleration in time is so over these stations."""
    s = np.interp(recorded.s, path.knot_road_s, path.knot_s) if not road.closed else recorded.s * (path.curve.length / road.length)
    kept = [0]
    for k in range(1, len(s)):
        if s[k] - s[kept[-1]] > _APART and s[k] <= path.curve.length and recorded.v[k] + recorded.v[kept[-1]] > 1e-3:
            kept.append(k)
    return s[kept], recorded.v[kept]
