"""A speed profile and how it was found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

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
    """

    s: Floats
    v: Floats
    status: str
    iterations: int
    solve_ms: float
    scale: float = 1.0

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
