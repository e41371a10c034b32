"""What stands in columns along stations, checked, and read at other stations: what `roads.Road` needs to be reversed, cut and resampled.

These are functions of arrays: a road uses them, they need no road.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .errors import RoadError
from .geometry.curve import read_only

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from scipy.interpolate import PchipInterpolator

    Floats = NDArray[np.float64]

#: No road is resampled to more points.
MOST_POINTS = 5_000_000


def must_be_numbers(values: Floats, s: Floats, what: str) -> None:
    """Refuse `values` unless they are a finite number at each of the stations `s` (n,), m.

    Raises:
        RoadError: it begins with `what` they are.
    """
    if values.shape != s.shape:
        raise RoadError(f"{what} has shape {values.shape}, expected {s.shape}")
    if not np.all(np.isfinite(values)):
        at = int(np.argmin(np.isfinite(values)))
        raise RoadError(f"{what} at s = {s[at]:.1f} m is {values[at]}, expected a finite number")


def read_at(values: Floats, s: Floats, at: Floats, period: float | None) -> Floats:
    """`values` (n,) that stand at the stations `s` (n,), linear between them, at the stations `at` (k,), all in m.

    Args:
        values: NaN where there is nothing: what ends ends at its last station, not half way to the next.
        s: increasing.
        at: wanted stations.
        period: length of a closed road, m; None for an open one.
    """
    at = at if period is None else np.mod(at, period)
    gone = np.isnan(values)
    if not gone.any():
        return read_only(np.interp(at, s, values, period=period))
    near = np.interp(at, s, np.where(gone, 0.0, values), period=period)
    return read_only(np.where(np.interp(at, s, gone.astype(float), period=period) > 1e-9, np.nan, near))


def monotone(values: Floats, s: Floats, period: float | None) -> PchipInterpolator:
    """The monotone cubic through `values` (n,) at the stations `s` (n,), m; `period` (m) is the length of a closed road, None for an open one."""
    from scipy.interpolate import PchipInterpolator  # slow to import, and flat roads never need it

    if period is None:
        return PchipInterpolator(s, values)
    # three data beyond the seam on either side make the derivative there the same from both ends
    around = np.concatenate([s[-3:] - period, s, s[:3] + period])
    return PchipInterpolator(around, np.concatenate([values[-3:], values, values[:3]]))


def turned(values: Floats, *, closed: bool) -> Floats:
    """`values` (n,) in the order of the other direction; on a closed road the first one stays the first."""
    return read_only(np.roll(values[::-1], 1) if closed else values[::-1])


def turned_stations(s: Floats, length: float, *, closed: bool) -> Floats:
    """The stations `s` (n,), m, counted from the other end of a road of `length` (m)."""
    return read_only(np.concatenate([[0.0], turned(length - s, closed=closed)[1:]]))


def turned_limits(limit: Floats, *, closed: bool) -> Floats:
    """Limits (n,), m/s, that count from each station on, so that in the other direction each covers the same ground."""
    return read_only(limit[::-1] if closed else np.append(limit[-2::-1], limit[0]))


def from_the_other_end(name: str, values: Floats) -> Floats:
    """What a column says when the road is driven the other way: distances and times count from the end, curvature changes sign."""
    if name in ("s", "t"):
        return values[-1] - values
    return {"psi": values + np.pi, "kappa": -values, "a": -values}.get(name, values)


def stations_of(stretch: slice, s: Floats, length: float, *, closed: bool, name: str) -> Floats:
    """Both ends of `stretch` (stations in m) and what lies between them of the stations `s` of a road; on a closed one counted on over its start.

    Raises:
        RoadError: a step, or stations that are not on the road or in the wrong order; it begins with the road's `name`.
    """
    start = 0.0 if stretch.start is None else float(stretch.start)
    end = length if stretch.stop is None else float(stretch.stop)
    if stretch.step is not None:
        raise RoadError(f"{name}: a stretch has no step, found {stretch.step}; `resampled` changes the spacing")
    if closed and end <= start:
        end += length
    if not (0.0 <= start < end and end - start <= length + 1e-9 and start < length and (closed or end <= length + 1e-6)):
        raise RoadError(f"{name}: stretch {stretch.start}:{stretch.stop} m, expected increasing stations between 0 and {length:.3f} m")
    end = end if closed else min(end, length)
    inner = np.concatenate([s, s + length]) if closed else s
    return np.concatenate([[start], inner[(inner > start + 1e-6) & (inner < end - 1e-6)], [end]])


def even_stations(spacing: float, length: float, *, closed: bool, name: str) -> Floats:
    """Stations at most `spacing` apart, evenly over a road of `length`, all in m; a closed one does not repeat its start.

    Raises:
        RoadError: a spacing that is not positive, or so small that the points are too many; it begins with the road's `name`.
    """
    if not 0.0 < spacing < np.inf:
        raise RoadError(f"{name}: spacing {spacing} m, expected more than 0")
    count = max(int(np.ceil(min(length / spacing, 1e12) - 1e-9)), 3 if closed else 1)
    if count > MOST_POINTS:
        raise RoadError(f"{name}: spacing {spacing:g} m makes {count:.3g} points, expected at most {MOST_POINTS}")
    s = np.linspace(0.0, length, count + 1)
    return s[:-1] if closed else s


def lowest_between(limit: Floats, s: Floats, at: Floats, length: float) -> Floats:
    """The lowest of the limits (n,), m/s, that begin at stations `s` (n,) within each of the stretches from one station of `at` (k,) to the next.

    inf where none begins; the last stretch ends at `length`; all stations in m.
    """
    first = np.clip(np.searchsorted(s, at), 0, len(s) - 1)
    inside = (s[first] >= at) & (s[first] < np.append(at[1:], length))
    return np.where(inside, np.minimum.reduceat(limit, first), np.inf)
