"""Records of cell tests: what a cycler or a virtual lab wrote, in SI units, battery current positive on discharge."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...errors import VehicleError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

#: Larger samples than these are no battery's: A or V, and s or A s.
_HUGE = {"time": 1e9, "current": 1e6, "voltage": 1e6, "charged": 1e9, "discharged": 1e9}
#: Mean distance of the points over which sampled current and charge counter are brought together, s.
_ALIGN_EVERY = 300.0


@dataclass(frozen=True, eq=False)
class Script:
    """One script of a test: columns of n samples, finite, none above 1e6 A or V.

    Attributes:
        source: where it comes from, for messages.
        time: s, not decreasing.
        current: A, positive on discharge, sampled.
        voltage: V.
        charged: A s that went in since the script began, by the tester's counter.
        discharged: A s that came out.
    """

    source: str
    time: Floats
    current: Floats
    voltage: Floats
    charged: Floats
    discharged: Floats

    def __post_init__(self) -> None:
        for name, bound in _HUGE.items():
            column = getattr(self, name)
            if column.ndim != 1 or column.shape != self.time.shape or len(column) < 2:
                raise VehicleError(f"{self.source}: column {name} has shape {column.shape}, expected {self.time.shape} with at least two samples")
            if not np.all(np.isfinite(column)):
                raise VehicleError(f"{self.source}: {name} at sample {int(np.argmin(np.isfinite(column)))} is not finite")
            if np.max(np.abs(column)) > bound:
                at = int(np.argmax(np.abs(column)))
                raise VehicleError(f"{self.source}: {name} at sample {at} is {column[at]:g}, expected at most {bound:g}")
        if not np.all(np.diff(self.time) >= 0.0):
            raise VehicleError(f"{self.source}: time goes back at sample {int(np.argmin(np.diff(self.time) >= 0.0)) + 1}")
        for name in ("charged", "discharged"):
            if not np.all(np.diff(getattr(self, name)) >= -1e-6):
                at = int(np.argmin(np.diff(getattr(self, name)) >= -1e-6)) + 1
                raise VehicleError(f"{self.source}: {name} charge falls at sample {at}, expected a counter that never falls")

    @property
    def moved(self) -> tuple[float, float]:
        """Charge that went in and charge that came out, A s."""
        return float(self.charged[-1] - self.charged[0]), float(self.discharged[-1] - self.discharged[0])

    def aligned(self) -> Script:
        """The same script with a current whose integral keeps to the charge counter.

        A cycler samples current once a second but counts charge all the time; the difference (some mA) is spread over stretches of five minutes.
        """
        counted = (self.discharged - self.discharged[0]) - (self.charged - self.charged[0])
        dt = np.diff(self.time)
        missing = counted - np.concatenate([[0.0], np.cumsum(self.current[:-1] * dt)])
        edges = np.linspace(self.time[0], self.time[-1], max(int((self.time[-1] - self.time[0]) / _ALIGN_EVERY), 1) + 1)
        place = np.searchsorted(edges[1:-1], self.time, side="right")
        count = np.bincount(place, minlength=len(edges) - 1)
        mean = np.bincount(place, missing, minlength=len(edges) - 1) / np.maximum(count, 1)
        middle = 0.5 * (edges[1:] + edges[:-1])
        smooth = np.interp(self.time, np.concatenate([[edges[0]], middle, [edges[-1]]]), np.concatenate([[0.0], mean, [missing[-1]]]))
        return replace(self, current=self.current + np.append(np.diff(smooth) / np.maximum(dt, 1e-9), 0.0))


@dataclass(frozen=True, eq=False)
class OcvTest:
    """Slow full discharge and charge at one temperature.

    Attributes:
        temperature: of scripts 1 and 3, K; scripts 2 and 4 run at the reference temperature.
        discharge: script 1, from full.
        empty: script 2, what was left and is taken out at the reference temperature; None if script 1 emptied the cell.
        charge: script 3, from empty.
        full: script 4, what was missing and is put in at the reference temperature; None if script 3 filled the cell.
    """

    temperature: float
    discharge: Script
    charge: Script
    empty: Script | None = None
    full: Script | None = None


@dataclass(frozen=True, eq=False)
class DynamicTest:
    """A dynamic profile at one temperature, from full to empty.

    Attributes:
        temperature: of script 1, K; scripts 2 and 3 run at the reference temperature.
        drive: script 1, the dynamic profile, from a full cell at rest.
        empty: script 2, or None.
        full: script 3, or None.
    """

    temperature: float
    drive: Script
    empty: Script | None = None
    full: Script | None = None
