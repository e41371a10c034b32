"""A speed profile and how it was found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from powertrain import Ledger, drive_energy

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from .bounds.speed_limits import SpeedLimits

    Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SpeedProfile:
    """Speed over stations; between two stations the acceleration is constant.

    Attributes:
        s: (n,) stations on the path, m.
        v: (n,) speeds, m/s.
        status: `solved`; `solved early`, where the least energy is reached by arriving before the time allowed; `reduced accuracy`, where the
            cone solver met only its reduced tolerances (the limits are kept all the same, the energy is not certain to be the least).
        iterations: cone programmes (eco) or profiles (scaled) computed.
        solve_ms: wall time, ms.
        scale: common factor on speed and acceleration limits (V2); 1 where none was applied.
        brake: (n-1,) force of the friction brakes between the stations, N; None where they are not used.
        method: what made it.
        lower_bound: proven bound, J: no profile on these stations within the limits that arrives as early takes less energy; -inf where none was
            proven. Finer stations leave a little more room (0.2 % at 2 m on the shipped roads).
        gap: how far the profile's energy may be above the least, as a fraction of the energy that moves (sum of all components' magnitudes);
            nan where nothing is proven.
        price: what a second less would cost, W.
    """

    s: Floats
    v: Floats
    status: str
    iterations: int
    solve_ms: float
    scale: float = 1.0
    brake: Floats | None = None
    method: str = ""
    lower_bound: float = -np.inf
    gap: float = np.nan
    price: float = np.nan

    @property
    def acceleration(self) -> Floats:
        """(n-1,) acceleration between the stations, m/s^2."""
        return np.diff(self.v**2) / (2.0 * np.diff(self.s))

    @property
    def interval_time(self) -> Floats:
        """(n-1,) time between the stations, s."""
        return 2.0 * np.diff(self.s) / (self.v[1:] + self.v[:-1])

    @property
    def journey_time(self) -> float:
        """Duration, s."""
        return float(np.sum(self.interval_time))

    def speed_at(self, s: ArrayLike) -> Floats:
        """Speed at stations `s`, m/s: speed squared is linear between the profile's stations."""
        return np.sqrt(np.interp(np.asarray(s, dtype=np.float64), self.s, self.v**2))


@dataclass(frozen=True, eq=False)
class Front:
    """Time against energy: profiles of which none is both earlier and thriftier than another.

    Attributes:
        profiles: from the fastest to the slowest.
        journey_time: (k,) s.
        energy: (k,) drawn from the battery, J.
        price: (k,) what a second less costs there, W.
        gap: (k,) proven gaps of the energies, as `SpeedProfile.gap`.
    """

    profiles: tuple[SpeedProfile, ...]
    journey_time: Floats
    energy: Floats
    price: Floats
    gap: Floats

    @classmethod
    def of(cls, limits: SpeedLimits, profiles: Sequence[SpeedProfile]) -> Front:
        """The front of some profiles within the same limits."""
        energy = [energy_of(limits, p).total for p in profiles]
        columns = [[p.journey_time for p in profiles], energy, [p.price for p in profiles], [p.gap for p in profiles]]
        return cls(tuple(profiles), *(np.array(column, dtype=np.float64) for column in columns))


def energy_of(limits: SpeedLimits, profile: SpeedProfile) -> Ledger:
    """The account of driving `profile` with the car and over the heights of `limits`."""
    return drive_energy(limits.vehicle, profile.s, profile.v, limits.z, 0.0 if profile.brake is None else profile.brake)
