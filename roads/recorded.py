"""When a recorded drive was where on a road."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .errors import RoadError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Recorded:
    """A drive as it was recorded; the speed changes evenly from one time to the next.

    Attributes:
        t: (k,) times from its start, s, increasing.
        s: (k,) stations on the road, m, never decreasing.
        v: (k,) speeds, m/s; 0 at both ends of a stretch of time is a stop.

    Raises:
        RoadError: arrays of different lengths, times that do not increase, speeds or stations that go back.
    """

    t: Floats
    s: Floats
    v: Floats

    def __post_init__(self) -> None:
        good = self.t.ndim == 1 and self.t.shape == self.s.shape == self.v.shape and len(self.t) > 1
        if not good or not np.all(np.isfinite([self.t, self.s, self.v])):
            raise RoadError(f"a recorded drive of shapes {self.t.shape}, {self.s.shape}, {self.v.shape}, expected finite numbers, as many in each")
        if np.any(np.diff(self.t) <= 0.0) or np.any(np.diff(self.s) < -1e-9) or np.any(self.v < 0.0):
            raise RoadError("a recorded drive with times, stations or speeds that go back, expected a car that drives on")

    @property
    def duration(self) -> float:
        """From the start to the end, stops included, s."""
        return float(self.t[-1] - self.t[0])

    @property
    def stops(self) -> list[tuple[float, float]]:
        """Station in m and duration in s of every stop."""
        still = (self.v[1:] == 0.0) & (self.v[:-1] == 0.0)
        edges = np.flatnonzero(np.diff(np.concatenate([[False], still, [False]]).astype(int)))
        return [(float(self.s[a]), float(self.t[b] - self.t[a])) for a, b in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)]

    @property
    def moving_time(self) -> float:
        """Time without the stops, s."""
        return self.duration - sum(duration for _, duration in self.stops)

    def between(self, start: float, end: float) -> Recorded | None:
        """The part from station `start` to `end` (m), counted from the start; None where too little of it lies there."""
        start, end = max(start, float(self.s[0])), min(end, float(self.s[-1]))
        inner = np.flatnonzero((self.s > start) & (self.s < end))
        if len(inner) < 1 or end <= start:
            return None
        t = np.interp([start, end], self.s, self.t)
        v = np.interp(t, self.t, self.v)
        rows = np.array([[t[0], start, v[0]], *np.column_stack([self.t, self.s, self.v])[inner], [t[1], end, v[1]]])
        rows = rows[np.append(True, np.diff(rows[:, 0]) > 1e-9)]
        return None if len(rows) < 2 else Recorded(rows[:, 0] - rows[0, 0], rows[:, 1] - start, rows[:, 2])

    def laid(self, at: Floats, s: Floats) -> Recorded:
        """The same drive where the stations `at` (n,) have become `s` (n,), m; its speeds stay, its stations move."""
        beyond = np.maximum(self.s - at[-1], 0.0)
        return Recorded(self.t, np.interp(self.s, at, s) + beyond, self.v)
