"""A road in generic position: it winds, climbs and leans, and its stations are unequal."""

import numpy as np

from energy_mgr import Trajectory


def winding(length: float = 120.0, v: float = 11.0, *, mirror: bool = False) -> Trajectory:
    """Bends to both sides of up to 1/40 m, slopes of up to 8 %, banks of up to 0.1 rad, speeds around `v`; `mirror` swaps left and right."""
    fine = np.linspace(0.0, length, 24_001)
    side = -1.0 if mirror else 1.0
    kappa = side * (0.004 + 0.02 * np.sin(fine / 13.0))
    psi = side * 0.4 + side * (0.004 * fine + 0.26 * (1.0 - np.cos(fine / 13.0)))
    step = fine[1]
    x, y = (np.concatenate([[0.0], np.cumsum(0.5 * step * (part[1:] + part[:-1]))]) for part in (np.cos(psi), np.sin(psi)))
    rng = np.random.default_rng(71)
    rows = np.unique(np.concatenate([[0], np.cumsum(rng.integers(120, 320, 400)), [24_000]]))
    rows = np.append(rows[rows < 23_900], 24_000)
    s = fine[rows]
    speed, z, bank = v + 1.5 * np.sin(s / 17.0 + 0.5), 1.1 * np.sin(s / 19.0) + 0.02 * s, side * (0.02 + 0.08 * np.cos(s / 11.0))
    return Trajectory.along(s, x[rows], y[rows], psi[rows], kappa[rows], speed, z=z, bank=bank, name="winding")
