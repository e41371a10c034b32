"""What a stretch of road costs a car, before anything is planned: the weight of an edge when a route is sought."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from powertrain import Vehicle, drive_energy

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

#: Speed where no limit is posted, m/s.
UNPOSTED = 50.0 / 3.6


def route_energy(vehicle: Vehicle) -> Callable[[Floats, Floats, Floats], float]:
    """A cost for `Network.route`: the energy in J that `vehicle` draws from its battery when it drives a stretch at the limits.

    Quasi-static: losses and slope at constant speed between limits, no braking for bends; the change of kinetic energy is left out since what
    one stretch puts in, the next one takes out. Downhill it may be negative.
    """
    fastest = vehicle.limits.speed_max_mps

    def cost(s: Floats, height: Floats, limit: Floats) -> float:
        keep = np.append(True, np.diff(s) > 1e-6)
        v = np.minimum(np.where(np.isfinite(limit), limit, UNPOSTED), fastest)
        total = 0.0
        s, height, v = s[keep], height[keep], v[keep]
        for part in np.split(np.arange(len(s)), np.flatnonzero(np.diff(v)) + 1):
            # a limit holds up to the station where the next one begins
            part = np.append(part, part[-1] + 1) if part[-1] + 1 < len(s) else part
            if len(part) > 1:
                total += drive_energy(vehicle, s[part], np.full(len(part), v[part[0]]), height[part]).total
        return float(total)

    return cost
