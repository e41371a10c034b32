"""Driving resistances M6: air drag, rolling resistance, slope.

Plain functions of NumPy operations, so that arrays and CasADi symbols both pass. Forces in N per metre of horizontal way: with stations and
speeds counted along the map, rolling resistance is `m g f_R` and slope `m g dz/ds` exactly, for any grade.
"""

from __future__ import annotations

from typing import Any

from ..vehicle import GRAVITY, Vehicle

#: The speed that the rolling resistance polynomial is scaled with, m/s (100 km/h).
ROLLING_SPEED = 100.0 / 3.6


def rolling_coefficient(vehicle: Vehicle, v: Any) -> Any:
    """Rolling resistance coefficient f_R at speed `v` (m/s, not negative), without unit."""
    p, x = vehicle.resistance, v / ROLLING_SPEED
    return p.rolling_0 + p.rolling_1 * x + p.rolling_4 * x**4


def rolling_force(vehicle: Vehicle, v: Any) -> Any:
    """Rolling resistance in N at speed `v` (m/s)."""
    return vehicle.chassis.mass_kg * GRAVITY * rolling_coefficient(vehicle, v)


def drag_force(vehicle: Vehicle, v_squared: Any) -> Any:
    """Air drag in N at squared speed `v_squared` (m^2/s^2), in still air."""
    p = vehicle.resistance
    return 0.5 * p.air_density_kgpm3 * p.drag_coefficient * p.frontal_area_m2 * v_squared


def slope_force(vehicle: Vehicle, slope: Any) -> Any:
    """Downhill force in N for a slope dz/ds, positive uphill."""
    return vehicle.chassis.mass_kg * GRAVITY * slope


def driving_resistance(vehicle: Vehicle, v: Any, slope: Any) -> Any:
    """Sum of drag, rolling resistance and slope force in N at speed `v` (m/s) on slope dz/ds."""
    return drag_force(vehicle, v**2) + rolling_force(vehicle, v) + slope_force(vehicle, slope)
