"""What lies between the stations of a trajectory.

Every interval is one row of numbers; `between` reads all quantities off it. The same lines serve floats, for a controller that asks for one place
250 times a second, and arrays, for everybody else.

    x, y         quintic Hermite polynomials in s with the position, the unit tangent and the curvature vector of both stations: the line is C2
    psi, kappa   heading and curvature of that line
    z            cubic Hermite polynomial with the slope of both stations; slope is its derivative
    v            v^2 linear in s, hence v dv/ds = a
    t            closed form for constant acceleration, also from and to standstill: dt/ds = 1/v
    a, power     constant from a station up to the next
    jerk, bank   linear
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

T = TypeVar("T")

#: Keeps 0/0 out of the time at standstill; far below any speed.
_TINY = 1e-300


class TrajectoryPoint(NamedTuple, Generic[T]):
    """One place of a trajectory, or many: floats or arrays of one shape. Units as in `Trajectory`."""

    s: T
    x: T
    y: T
    z: T
    psi: T
    kappa: T
    v: T
    a: T
    t: T
    power: T
    jerk: T
    slope: T
    bank: T


@dataclass(frozen=True, eq=False)
class Pieces:
    """The intervals of a trajectory as rows; the last row is the last station itself, so that a question there is answered from the table.

    Attributes:
        rows: (n, 33) numbers of every interval, as `between` takes them.
        s: stations, as a list, which `bisect` likes best.
        t: times, likewise.
    """

    rows: Floats
    s: list[float]
    t: list[float]

    @classmethod
    def of(cls, columns: Mapping[str, Floats]) -> Pieces:
        """The intervals between the rows of a table with the names of `TrajectoryPoint`."""
        rows = np.column_stack(
            [*_ends(columns), *_motion(columns), *_line(columns), *_height(columns), *(columns[name] for name in ("a", "power")), *_linear(columns)]
        )
        return cls(rows, columns["s"].tolist(), columns["t"].tolist())

    @cached_property
    def lists(self) -> list[list[float]]:
        """The rows once more, as Python's floats for one place at a time: 1 kB each, made at the first question."""
        return self.rows.tolist()


def between(row: Iterable[Any], s: Any, sqrt: Callable[[Any], Any], atan2: Callable[[Any, Any], Any]) -> TrajectoryPoint[Any]:
    """The trajectory at station `s` (m) of the interval `row`: floats with the functions of `math`, arrays with those of NumPy."""
    s0, _, h, v0, _, e0, e1, t0, _, w, x0, x1, x2, x3, x4, x5, y0, y1, y2, y3, y4, y5, psi0, z0, z1, z2, z3, a, power, j0, dj, b0, db = row
    d = s - s0
    u = d / h
    xs = x1 + d * (2.0 * x2 + d * (3.0 * x3 + d * (4.0 * x4 + d * 5.0 * x5)))
    ys = y1 + d * (2.0 * y2 + d * (3.0 * y3 + d * (4.0 * y4 + d * 5.0 * y5)))
    xss = 2.0 * x2 + d * (6.0 * x3 + d * (12.0 * x4 + d * 20.0 * x5))
    yss = 2.0 * y2 + d * (6.0 * y3 + d * (12.0 * y4 + d * 20.0 * y5))
    square = xs * xs + ys * ys
    # weighted like this, rounding makes no square of a speed negative
    v = sqrt((1.0 - u) * e0 + u * e1)
    return TrajectoryPoint(
        s,
        x0 + d * (x1 + d * (x2 + d * (x3 + d * (x4 + d * x5)))),
        y0 + d * (y1 + d * (y2 + d * (y3 + d * (y4 + d * y5)))),
        z0 + d * (z1 + d * (z2 + d * z3)),
        # x1, y1 is the tangent at the station before: heading is counted on from there
        psi0 + atan2(x1 * ys - y1 * xs, x1 * xs + y1 * ys),
        (xs * yss - ys * xss) / (square * sqrt(square)),
        v,
        a,
        t0 + w * u / (v0 + v + _TINY),
        power,
        j0 + u * dj,
        z1 + d * (2.0 * z2 + d * 3.0 * z3),
        b0 + u * db,
    )


def place(row: Iterable[Any], t: Any, least: Callable[[Any, Any], Any]) -> Any:
    """The station (m) at time `t` (s) of the interval `row`, the inverse of `between`; with constant acceleration v is linear in t."""
    s0, s1, h, v0, v1, _, _, t0, dt, *_ = row
    share = (t - t0) / dt
    return least(s0 + h * (share * (2.0 * v0 + share * (v1 - v0)) / (v0 + v1 + _TINY)), s1)


def _next(values: Floats) -> Floats:
    """(n,) values one station on; the last is its own next."""
    return np.append(values[1:], values[-1])


def _step(values: Floats) -> Floats:
    """(n,) lengths of the intervals; one for that of the last station, which is only asked at its start."""
    return np.append(np.diff(values), 1.0)


def _still(values: Floats) -> Floats:
    """Coefficients with zeros for the last station, from which nothing goes on."""
    return np.append(values[:-1], 0.0)


def _ends(columns: Mapping[str, Floats]) -> tuple[Floats, ...]:
    s = columns["s"]
    return s, _next(s), _step(s)


def _line(columns: Mapping[str, Floats]) -> list[Floats]:
    h, psi, kappa = _step(columns["s"]), columns["psi"], columns["kappa"]
    cos, sin = np.cos(psi), np.sin(psi)
    made: list[Floats] = []
    for p, first, second in ((columns["x"], cos, -kappa * sin), (columns["y"], sin, kappa * cos)):
        rise = _next(p) - p
        d0, d1, a0, a1 = h * first, h * _next(first), h**2 * second, h**2 * _next(second)
        third = (10.0 * rise - 6.0 * d0 - 4.0 * d1 - 1.5 * a0 + 0.5 * a1) / h**3
        fourth = (-15.0 * rise + 8.0 * d0 + 7.0 * d1 + 1.5 * a0 - a1) / h**4
        fifth = (6.0 * rise - 3.0 * d0 - 3.0 * d1 - 0.5 * a0 + 0.5 * a1) / h**5
        made += [p, first, 0.5 * second, _still(third), _still(fourth), _still(fifth)]
    return [*made, psi]


def _height(columns: Mapping[str, Floats]) -> tuple[Floats, ...]:
    h, z, slope = _step(columns["s"]), columns["z"], columns["slope"]
    mean = (_next(z) - z) / h
    second = (3.0 * mean - 2.0 * slope - _next(slope)) / h
    third = (slope + _next(slope) - 2.0 * mean) / h**2
    return z, slope, _still(second), _still(third)


def _motion(columns: Mapping[str, Floats]) -> tuple[Floats, ...]:
    v, t = columns["v"], columns["t"]
    after = _next(v)
    duration = _step(t)
    return v, after, v**2, after**2, t, duration, duration * (v + after)


def _linear(columns: Mapping[str, Floats]) -> tuple[Floats, ...]:
    jerk, bank = columns["jerk"], columns["bank"]
    return jerk, _next(jerk) - jerk, bank, _next(bank) - bank


def point_between(row: list[float], s: float) -> TrajectoryPoint[float]:
    """`between` for one station."""
    return between(row, s, math.sqrt, math.atan2)


def points_between(rows: Floats, s: Floats) -> TrajectoryPoint[Floats]:
    """`between` for stations (...,) with their rows (..., 33)."""
    return between(np.moveaxis(rows, -1, 0), s, np.sqrt, np.arctan2)
