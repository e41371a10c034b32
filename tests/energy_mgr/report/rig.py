"""Short drives to report on."""

import numpy as np

from energy_mgr import Trajectory
from energy_mgr.simulation import Drive, Event, simulate
from powertrain import Vehicle


def there_and_stop(length=60.0, acceleration=2.0, top=8.0) -> Trajectory:
    """Straight, from rest to rest."""
    s = np.linspace(0.0, length, 31)
    v = np.minimum(np.sqrt(2 * acceleration * np.minimum(s, length - s)), top)
    return Trajectory.along(s, s, 0 * s, 0 * s, 0 * s, v, name="there and stop")


def arc(radius=40.0, length=50.0, v=9.0) -> Trajectory:
    """To the left, at constant speed from beginning to end."""
    s = np.linspace(0.0, length, 26)
    angle = s / radius
    x, y = radius * np.sin(angle), radius * (1 - np.cos(angle))
    return Trajectory.along(s, x, y, angle, np.full(len(s), 1 / radius), np.full(len(s), v), name="arc")


def stopping_drive(vehicle: Vehicle) -> Drive:
    events = [Event(part="measurement", kind="nan", time_s=3.0, duration_s=0.1), Event(part="friction", kind="value", share=0.6, station_m=40.0)]
    return simulate(there_and_stop(), vehicle, events=events, compiled=False)


def bending_drive(vehicle: Vehicle) -> Drive:
    """Late on purpose: five seconds of a bend."""
    return simulate(arc(), vehicle, longest=5.0, compiled=False)
