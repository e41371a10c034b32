"""From latitude and longitude to metres on a plane, and back: a transverse Mercator projection of its own for every file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import RoadError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

#: Farther from its origin a plane map is more than 0.1 % out of scale, m.
FARTHEST = 250e3


def _projection(latitude: float, longitude: float) -> Any:
    from pyproj import Proj

    return Proj(proj="tmerc", lat_0=latitude, lon_0=longitude, k=1.0, ellps="WGS84")


def to_plane(latitude: ArrayLike, longitude: ArrayLike, origin: tuple[float, float] | None = None) -> tuple[Floats, tuple[float, float]]:
    """Points (n, 2) in m, east and north of `origin` (latitude, longitude in degrees; default: the first point), and the origin.

    Raises:
        RoadError: coordinates that are not on Earth or farther than 250 km from the origin.
    """
    latitude, longitude = np.asarray(latitude, dtype=np.float64), np.asarray(longitude, dtype=np.float64)
    bad = ~((np.abs(latitude) <= 89.0) & (np.abs(longitude) <= 360.0))
    if bad.any():
        at = int(np.argmax(bad))
        raise RoadError(f"point {at} is at latitude {latitude[at]}, longitude {longitude[at]}, expected degrees on Earth, not at a pole")
    origin = origin or (float(latitude[0]), float(longitude[0]))
    x, y = _projection(*origin)(longitude, latitude)
    points = np.column_stack([x, y])
    far = ~(np.hypot(*points.T) < FARTHEST)
    if far.any():
        raise RoadError(f"point {int(np.argmax(far))} is more than {FARTHEST / 1000:.0f} km from the first one, expected a road on one map")
    return points, origin


def to_degrees(points: Floats, origin: tuple[float, float]) -> Floats:
    """(n, 2) longitude and latitude in degrees of points (n, 2) in m about `origin` (latitude, longitude)."""
    longitude, latitude = _projection(*origin)(points[:, 0], points[:, 1], inverse=True)
    return np.column_stack([longitude, latitude])
