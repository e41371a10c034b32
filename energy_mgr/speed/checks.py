"""Every profile that leaves this package has been looked at: limits re-evaluated, arrival compared."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..errors import SolverError
from .bounds.jerk import jerk_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .bounds.speed_limits import SpeedLimits

    Floats = NDArray[np.float64]

#: Limits may be passed by this fraction, the arrival time missed by this much (s).
LIMIT_TOLERANCE = 1e-3
TIME_TOLERANCE = 0.1


class _Row(NamedTuple):
    what: str
    unit: str
    value: Floats
    bound: Floats
    scale: float


def check_profile(limits: SpeedLimits, v: Floats, brake: Floats | None = None) -> None:
    """Re-evaluate every limit at the stations and, for forces, at both ends of every interval; see `SpeedLimits` for why that covers the way between.

    Args:
        limits: what must hold.
        v: (n,) speeds, m/s.
        brake: (n-1,) force of the friction brakes, N.

    Raises:
        SolverError: a limit is passed by more than 0.1 %; station, limit and value are named.
    """
    if not np.all(np.isfinite(v)) or np.any(v < 0.0):
        at = int(np.argmin(np.isfinite(v) & (v >= 0.0)))
        raise SolverError(f"{limits.name}: speed {v[at]:g} m/s at s = {limits.s[at]:.1f} m, expected a number that is not negative")
    for row in _rows(limits, v, np.zeros_like(limits.ds) if brake is None else brake):
        beyond = row.value - row.bound - LIMIT_TOLERANCE * np.maximum(row.bound, row.scale) - 1e-6
        if np.max(beyond) > 0.0:
            at = int(np.argmax(beyond))
            s = limits.s[at + 1 if row.what == "jerk" else at]
            raise SolverError(f"{limits.name}: {row.what} {row.value[at]:.4f} {row.unit} at s = {s:.1f} m, limit {row.bound[at]:.4f} {row.unit}")


def _rows(limits: SpeedLimits, v: Floats, brake: Floats) -> list[_Row]:
    vehicle, bound = limits.vehicle, np.sqrt(2.0 * limits.energy_max)
    gain = np.diff(v**2) / (2.0 * limits.ds)
    rows = [
        _Row("speed", "m/s", v, bound, 0.0),
        _Row("acceleration", "m/s^2", gain, limits.acceleration, 0.0),
        _Row("deceleration", "m/s^2", -gain, limits.deceleration, 0.0),
    ]
    # a motor that cannot recuperate has a limit of zero: there 0.1 % is of the force of an ordinary braking
    scale = vehicle.effective_mass * vehicle.limits.deceleration_max_mps2
    for end in (v[:-1], v[1:]):
        for limit in limits.forces:
            wheels = vehicle.effective_mass * gain + limits.resistance(end, limit.sign)
            force = wheels + brake if limit.of == "motors" else wheels
            rows.append(_Row(f"{limit.name} (force)", "N", limit.sign * force, np.asarray(limit.ceiling(vehicle, end, limit.data)), scale))
    if np.isfinite(limits.jerk) and len(v) > 2:
        rows.append(_Row("jerk", "m/s^3", np.abs(jerk_of(limits.ds, v)), np.full(len(v) - 2, limits.jerk), 0.0))
    return rows


def check_times(limits: SpeedLimits, v: Floats, journey_time: float) -> None:
    """Arrival and windows.

    Raises:
        SolverError: the arrival is late, or a window is missed.
    """
    arrival = arrival_times(limits, v)
    if arrival[-1] > journey_time + TIME_TOLERANCE:
        raise SolverError(f"{limits.name}: the profile found takes {arrival[-1]:.3f} s, expected at most {journey_time:.3f} s")
    for window in limits.windows:
        t = float(arrival[station_number(limits, window.s)])
        if not window.earliest - TIME_TOLERANCE <= t <= window.latest + TIME_TOLERANCE:
            raise SolverError(
                f"{limits.name}: the profile found passes s = {window.s:g} m at {t:.3f} s, expected {window.earliest:g} to {window.latest:g} s"
            )


def arrival_times(limits: SpeedLimits, v: Floats) -> Floats:
    """(n,) time at every station, s."""
    return np.concatenate([[0.0], np.cumsum(2.0 * limits.ds / (v[1:] + v[:-1]))])


def station_number(limits: SpeedLimits, s: float) -> int:
    """Number of the station at `s` m."""
    return int(np.argmin(np.abs(limits.s - s)))
