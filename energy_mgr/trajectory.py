"""The trajectory lambda(s): path and speed in one table over stations (L1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from powertrain import Ledger

    from .path import Path
    from .speed import SpeedLimits, SpeedProfile

    Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Where to be, how fast, and what it draws, at stations on the path. All arrays (n,), read-only.

    Attributes:
        s: stations along the path, m.
        x: position, m.
        y: position, m.
        z: height, m.
        psi: heading, continuous, rad.
        kappa: curvature, 1/m.
        v: speed, m/s.
        a: acceleration from here to the next station (the last repeats the one before), m/s^2.
        t: time of arrival, s.
        power: mean power drawn from the battery from here to the next station (the last repeats the one before), W.
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

    #: Names of the columns in files, with units, in the order of the attributes.
    COLUMNS = ("s_m", "x_m", "y_m", "z_m", "psi_rad", "kappa_1pm", "v_mps", "a_mps2", "t_s", "power_w")

    @classmethod
    def of(cls, path: Path, limits: SpeedLimits, profile: SpeedProfile, ledger: Ledger) -> Trajectory:
        """The trajectory of driving `path` with `profile`, at the profile's stations."""
        s = profile.s
        # the end of a circuit is not wrapped to its start, so that heading goes on
        xy = path.curve.position(s)
        columns = (
            s,
            xy[:, 0],
            xy[:, 1],
            limits.z,
            _heading(path, s),
            path.curve.curvature(s),
            profile.v,
            np.append(profile.acceleration, profile.acceleration[-1]),
            np.concatenate([[0.0], np.cumsum(profile.interval_time)]),
            np.append(ledger.power, ledger.power[-1]),
        )
        made = [np.array(column, dtype=np.float64) for column in columns]
        for column in made:
            column.setflags(write=False)
        return cls(*made)

    def table(self) -> Floats:
        """(n, 10) array with the columns of `COLUMNS`."""
        return np.column_stack([self.s, self.x, self.y, self.z, self.psi, self.kappa, self.v, self.a, self.t, self.power])


def _heading(path: Path, s: Floats) -> Floats:
    psi = path.curve.heading(s)
    if path.curve.closed:
        psi = np.unwrap(psi)
    return psi
