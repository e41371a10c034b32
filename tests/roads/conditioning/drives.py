"""Drives as a receiver records them, made from roads that are known: places every second with noise, heights with noise or in steps, a stop."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roads import Road
from roads.conditioning.recording import Recording
from roads.formats.geodesy import to_degrees

Floats = NDArray[np.float64]
#: Where (0, 0) of the roads lies: latitude and longitude, degrees.
ORIGIN = (48.1, 11.3)


@dataclass(frozen=True)
class Receiver:
    """What a receiver does to the truth.

    Attributes:
        plane: standard deviation of the places, m.
        height: of the heights, m.
        step: in which heights are told, m; 0 for none.
        period: from place to place, s.
    """

    plane: float = 0.0
    height: float = 0.0
    step: float = 0.0
    period: float = 1.0


def driven(road: Road, period: float, stop: tuple[float, float] | None = None, fastest: float = 22.0) -> tuple[Floats, Floats]:
    """Times and stations of a drive that slows down for bends (2 m/s^2 across, 1.5 along) and stands at `stop` (station, duration)."""
    s = np.arange(0.0, road.length, 0.5)
    v = np.minimum(np.sqrt(2.0 / np.maximum(np.abs(road.reference.curvature(s)), 1e-6)), fastest)
    v[0] = v[-1] = 0.3
    if stop is not None:
        v[np.argmin(np.abs(s - stop[0]))] = 0.1
    for k in range(1, len(s)):
        v[k] = min(v[k], np.sqrt(v[k - 1] ** 2 + 1.5))
    for k in range(len(s) - 2, -1, -1):
        v[k] = min(v[k], np.sqrt(v[k + 1] ** 2 + 1.5))
    t = np.concatenate([[0.0], np.cumsum(np.diff(s) * 2.0 / (v[1:] + v[:-1]))])
    if stop is not None:
        t[s > s[np.argmin(np.abs(s - stop[0]))]] += stop[1]
    at = np.arange(0.0, t[-1], period)
    return at, np.interp(at, t, s)


def recorded(road: Road, receiver: Receiver, seed: int, stop: tuple[float, float] | None = None) -> Recording:
    """A drive along `road` as `receiver` records it."""
    rng = np.random.default_rng(seed)
    t, s = driven(road, receiver.period, stop)
    points = road.reference.position(s) + rng.normal(0.0, receiver.plane, (len(s), 2))
    z = road.height_at(s) + rng.normal(0.0, receiver.height, len(s))
    z = np.round(z / receiver.step) * receiver.step if receiver.step else z
    return Recording("drive", points, z, t, None, tuple(f"point {k}" for k in range(len(s))))


def gpx(recording: Recording, path: Path, *, timed: bool = True) -> Path:
    """`recording` as a GPX file about `ORIGIN`."""
    rows = []
    for k, (lon, lat) in enumerate(to_degrees(recording.points, ORIGIN).tolist()):
        z = "" if recording.height is None else f"<ele>{recording.height[k]:.2f}</ele>"
        t = 0.0 if recording.time is None else float(recording.time[k])
        when = f"<time>2026-05-04T{int(t // 3600):02d}:{int(t % 3600 // 60):02d}:{t % 60:06.3f}Z</time>" if timed else ""
        rows.append(f'<trkpt lat="{lat:.8f}" lon="{lon:.8f}">{z}{when}</trkpt>')
    head = '<?xml version="1.0"?>\n<gpx version="1.1" creator="test" xmlns="http://www.topografix.com/GPX/1/1"><trk><name>drive</name><trkseg>\n'
    path.write_text(head + "\n".join(rows) + "\n</trkseg></trk></gpx>\n", encoding="utf-8")
    return path


def gain(z: Floats) -> float:
    """Sum of all rises, m."""
    return float(np.sum(np.maximum(np.diff(z), 0.0)))
