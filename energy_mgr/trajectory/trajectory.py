"""The trajectory lambda(s): path and speed in one table over stations (L1), and what lies between them.

The planner writes it, controllers, observers, simulation and reports read it. It knows no clock: time is one more column over stations.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from ..errors import PlanningError
from .check import LABELS, LARGEST, discord, first_fault
from .derived import derived
from .pieces import Pieces, TrajectoryPoint, place, point_between, points_between

if TYPE_CHECKING:
    from collections.abc import Sequence
    from os import PathLike

    from numpy.typing import ArrayLike, NDArray

    from powertrain import Ledger

    from ..path import Path
    from ..speed import SpeedLimits, SpeedProfile

    Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Where to be, how fast, and what it draws, at stations on the path. All arrays (n,), read-only.

    Between stations `at` and `point` interpolate so that the columns stay consistent: v dv/ds = a and dt/ds = 1/v hold exactly, dz/ds = slope
    too; x, y are quintic Hermite polynomials whose heading and curvature are psi and kappa, continuous and exact at the stations. Where curvature
    is smooth, x and y are good to the sixth power of the step, psi to the fifth, kappa to the fourth, dx/ds = cos(psi), dy/ds = sin(psi) and
    dpsi/ds = kappa to the fifth; where it has a kink within the step (a knot of the planned spline, the end of a clothoid) to the third, second and
    first power. An arc of 100 m radius in steps of 2 m is right to 2e-13 m.

    A closed track has its first row once more as its last, one lap later. Stations beyond its ends wrap; x, y, v repeat, while t and psi go on
    counting: one journey time and the turns of one lap more per lap. Other tracks refuse stations beyond their ends.

    Attributes:
        s: stations along the path, m.
        x: position, m.
        y: position, m.
        z: height, m.
        psi: heading, continuous, rad.
        kappa: curvature, 1/m.
        v: speed, m/s.
        a: acceleration from here to the next station, m/s^2; the last row takes that of the first on closed tracks, else of the row before.
        t: time of arrival, s.
        power: mean power drawn from the battery from here to the next station, W; last row as `a`.
        jerk: change of `a` at the station over the time between the middles (in time) of the intervals beside it, m/s^3: acceleration is constant
            between stations, so this is a difference, good to the first power of the step. Wraps on closed tracks; elsewhere the end rows, which
            have one interval, repeat their neighbours (0 if there are only two rows). Linear between stations.
        slope: dz/ds.
        bank: superelevation, rad, positive where the left side is higher.
        closed: the end joins the start.
        name: of the road, for messages and files; characters that cannot be printed are escaped.

    Raises:
        PlanningError: arrays of other shapes, values that are not finite or above 1e9, stations that do not grow by 1e-6 m, times that do not grow,
            negative speeds, standstill at two stations in a row, headings that jump by half a turn, a closed track whose ends do not meet.
    """

    s: Floats
    x: Floats
    y: Floats
    z: Floats
    psi: Floats
    kappa: Floats
    v: Floats
    a: Floats
    t: Floats
    power: Floats
    jerk: Floats
    slope: Floats
    bank: Floats
    closed: bool = False
    name: str = "trajectory"

    #: Names of the columns in files, with units, in the order of the attributes.
    COLUMNS = tuple(LABELS.values())

    def __post_init__(self) -> None:
        name = self.name if self.name.isprintable() else self.name.encode("unicode_escape").decode("ascii")
        object.__setattr__(self, "name", name.strip() or "trajectory")
        for label, values in self.columns.items():
            object.__setattr__(self, label, _column(values, self.name, LABELS[label]))
            if self.s.ndim != 1 or len(self.s) < 2:
                raise PlanningError(f"{self.name}: s_m has shape {self.s.shape}, expected (n,) with n of 2 or more")
            if self.columns[label].shape != self.s.shape:
                raise PlanningError(f"{self.name}: {LABELS[label]} has shape {self.columns[label].shape}, expected {self.s.shape} as s_m")
        if fault := first_fault(self.columns, closed=self.closed):
            raise PlanningError(f"{self.name}: row {fault.row}: {fault.text}")

    @classmethod
    def of(cls, path: Path, limits: SpeedLimits, profile: SpeedProfile, ledger: Ledger) -> Trajectory:
        """The trajectory of driving `path` with `profile`, at the profile's stations."""
        s = profile.s
        # at the end of a circuit the curve is back at its start, but its heading has gone on
        xy, psi = path.curve.position(s), path.curve.heading(s)
        bank = getattr(limits, "bank", 0.0)
        line = {"s": s, "x": xy[:, 0], "y": xy[:, 1], "z": limits.z, "psi": psi, "kappa": path.curve.curvature(s), "v": profile.v, "bank": bank}
        return cls._made(line, ledger.power, limits.closed, limits.name)

    @classmethod
    def along(
        cls,
        s: ArrayLike,
        x: ArrayLike,
        y: ArrayLike,
        psi: ArrayLike,
        kappa: ArrayLike,
        v: ArrayLike,
        *,
        z: ArrayLike = 0.0,
        bank: ArrayLike = 0.0,
        power: ArrayLike = 0.0,
        closed: bool = False,
        name: str = "trajectory",
    ) -> Trajectory:
        """A trajectory from a line that was planned elsewhere; a, t, jerk and slope follow from it.

        Args:
            s, x, y, psi, kappa, v: (n,) each, as in the class; a closed track has its first row once more as its last.
            z, bank: (n,) or one value.
            power: (n - 1,) mean power of each interval or one value, W.
            closed: the end joins the start.
            name: of the road.

        Raises:
            PlanningError: as the class, and where heading does not follow the points, or curvature the heading.
        """
        given = {"s": s, "x": x, "y": y, "z": z, "psi": psi, "kappa": kappa, "v": v, "bank": bank}
        made = cls._made({key: _column(values, name, LABELS[key]) for key, values in given.items()}, _column(power, name, "power_w"), closed, name)
        if fault := discord(made.columns):
            raise PlanningError(f"{made.name}: row {fault.row}: {fault.text}")
        return made

    @classmethod
    def _made(cls, line: dict[str, Any], power: ArrayLike, closed: bool, name: str) -> Trajectory:
        """With what follows from the line worked out; `power` (n - 1,) or one."""
        s, v, power = np.asarray(line["s"]), np.asarray(line["v"]), np.asarray(power)
        if s.ndim != 1 or len(s) < 2 or v.shape != s.shape:
            raise PlanningError(f"{name}: s_m and v_mps have shapes {s.shape} and {v.shape}, expected one (n,) with n of 2 or more")
        for label, values, shape in (*((key, np.asarray(line[key]), s.shape) for key in line), ("power", power, (len(s) - 1,))):
            if values.shape not in ((), shape):
                raise PlanningError(f"{name}: {LABELS[label]} has shape {values.shape}, expected {shape} or one value")
        whole = derived({key: np.broadcast_to(values, s.shape) for key, values in line.items()}, power, closed=closed)
        return cls(**{key: whole[key] for key in LABELS}, closed=closed, name=name)

    @property
    def columns(self) -> dict[str, Floats]:
        """The arrays by name, in the order of `COLUMNS`."""
        return {name: getattr(self, name) for name in LABELS}

    @property
    def length(self) -> float:
        """From the first station to the last, m."""
        return float(self.s[-1] - self.s[0])

    @property
    def journey_time(self) -> float:
        """From the first station to the last, s."""
        return float(self.t[-1] - self.t[0])

    def table(self) -> Floats:
        """(n, 13) array with the columns of `COLUMNS`."""
        return np.column_stack(list(self.columns.values()))

    @overload
    def at(self, s: float) -> TrajectoryPoint[float]: ...
    @overload
    def at(self, s: Sequence[float] | NDArray[Any]) -> TrajectoryPoint[Floats]: ...
    def at(self, s: Any) -> TrajectoryPoint[Any]:
        """All columns at stations `s` (m), one or an array of any shape; see the class for what is exact between stations.

        Raises:
            PlanningError: NaN, or a station beyond the ends of an open track.
        """
        if np.ndim(s) == 0:
            return self.point(s)
        s = _column(s, self.name, "s_m")
        inside, laps = self._wrapped(s, "station", "m", self._pieces.s)
        row = np.searchsorted(self.s, inside, side="right") - 1
        found = points_between(self._pieces.rows[row], inside)
        return found._replace(s=s, psi=found.psi + laps * float(self.psi[-1] - self.psi[0]), t=found.t + laps * self.journey_time)

    def point(self, s: float) -> TrajectoryPoint[float]:
        """As `at`, for one station and in plain floats: about 3 us, for controllers. The first call prepares the intervals.

        Raises:
            PlanningError: as `at`.
        """
        pieces, s = self._pieces, float(s)
        inside, laps = s, 0
        if not pieces.s[0] <= s <= pieces.s[-1]:
            inside, laps = self._lap(s, "station", "m", pieces.s)
        found = point_between(pieces.lists[bisect_right(pieces.s, inside) - 1], inside)
        if laps:
            return found._replace(s=s, psi=found.psi + laps * float(self.psi[-1] - self.psi[0]), t=found.t + laps * self.journey_time)
        return found

    @overload
    def at_time(self, t: float) -> float: ...
    @overload
    def at_time(self, t: Sequence[float] | NDArray[Any]) -> Floats: ...
    def at_time(self, t: Any) -> Any:
        """Stations (m) at times `t` (s), one or an array of any shape: the inverse of t(s). On closed tracks it goes on over the laps.

        Raises:
            PlanningError: NaN, or a time before the start or, on open tracks, after the end.
        """
        times = self._pieces.t
        if np.ndim(t) == 0:
            t = float(t)
            inside, laps = (t, 0) if times[0] <= t <= times[-1] else self._lap(t, "time", "s", times)
            return place(self._pieces.lists[bisect_right(times, inside) - 1], inside, min) + laps * self.length
        inside, laps = self._wrapped(_column(t, self.name, "t_s"), "time", "s", times)
        rows = self._pieces.rows[np.searchsorted(self.t, inside, side="right") - 1]
        return place(np.moveaxis(rows, -1, 0), inside, np.minimum) + laps * self.length

    @cached_property
    def _pieces(self) -> Pieces:
        return Pieces.of(self.columns)

    def _lap(self, value: float, what: str, unit: str, ends: list[float]) -> tuple[float, int]:
        """A value beyond the ends, wrapped, and the laps that makes."""
        first, last = ends[0], ends[-1]
        if not self.closed or not abs(value) < LARGEST:
            more = f", or wrapped below {LARGEST:g}" if self.closed else ""
            raise PlanningError(f"{self.name}: {what} {value:.9g} {unit} is not on the trajectory, expected {first:.9g} to {last:.9g} {unit}{more}")
        laps = math.floor((value - first) / (last - first))
        return min(max(value - laps * (last - first), first), last), laps

    def _wrapped(self, values: Floats, what: str, unit: str, ends: list[float]) -> tuple[Floats, Floats]:
        first, last = ends[0], ends[-1]
        outside = ~((values >= first) & (values <= last))
        if not np.any(outside):
            return values, np.zeros(())
        for value in values[outside if not self.closed else ~(np.abs(values) < LARGEST)][:1]:
            self._lap(float(value), what, unit, ends)
        laps = np.where(outside, np.floor((values - first) / (last - first)), 0.0)
        return np.clip(values - laps * (last - first), first, last), laps

    def save(self, path: str | PathLike[str]) -> None:
        """Write a file of the kind of its suffix, .csv or .parquet, whole or not at all.

        Raises:
            PlanningError: another suffix, a place that cannot be written to.
        """
        from .files import save

        save(self, path)

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Trajectory:
        """Read a file that `save` wrote, or one like it; see `energy_mgr.trajectory.files`.

        Raises:
            PlanningError: in one line what is wrong where: file, line, column, found, expected.
        """
        from .files import read

        columns, closed, name = read(path)
        return cls(**columns, closed=closed, name=name)


def _column(values: ArrayLike, name: str, label: str) -> Floats:
    """A read-only copy."""
    try:
        column = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise PlanningError(f"{name}: {label} is {str(values)[:40]!r}, expected numbers") from None
    column.setflags(write=False)
    return column
