"""One driving cycle."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import RoadError
from ..formats.tables.table import read_table

if TYPE_CHECKING:
    from os import PathLike

    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

SHELF = Path(__file__).parent
KMH = 1.0 / 3.6


@dataclass(frozen=True, eq=False)
class Cycle:
    """A driving cycle.

    Attributes:
        name: short name.
        title: name and remarks.
        source: regulation.
        t: (n,) times, s, from 0.
        v: (n,) speeds, m/s, linear between the times.
    """

    name: str
    title: str
    source: str
    t: Floats
    v: Floats

    @property
    def duration(self) -> float:
        """s"""
        return float(self.t[-1] - self.t[0])

    @property
    def distance(self) -> float:
        """m"""
        return float(self.distances[-1])

    @property
    def distances(self) -> Floats:
        """(n,) distance covered at each time, m."""
        return np.concatenate([[0.0], np.cumsum(0.5 * (self.v[1:] + self.v[:-1]) * np.diff(self.t))])

    @property
    def acceleration(self) -> Floats:
        """(n - 1,) acceleration between the times, m/s^2."""
        return np.diff(self.v) / np.diff(self.t)

    def speed_at(self, t: ArrayLike) -> Floats:
        """Speed in m/s at times `t`; zero before and after the cycle."""
        return np.interp(np.asarray(t, dtype=np.float64), self.t, self.v, left=0.0, right=0.0)


def names() -> list[str]:
    """Names of the cycles that ship with the package."""
    return sorted(path.stem for path in SHELF.glob("*.csv"))


def load(name_or_path: str | PathLike[str]) -> Cycle:
    """A shipped cycle by name, or one from a CSV with columns `t_s` and `v_kmh` or `v_mps`.

    Raises:
        RoadError: no such cycle, or a file without those columns, with times that do not increase or speeds below zero.
    """
    path = Path(name_or_path)
    if path.suffix == "" and not path.is_file():
        if str(name_or_path) not in names():
            raise RoadError(f"{name_or_path}: no such file and no shipped cycle, expected one of {', '.join(names())}")
        path = SHELF / f"{name_or_path}.csv"
    table = read_table(path)
    columns = dict(zip(table.names, table.rows.T, strict=True))
    speed = columns.get("v_mps", columns.get("v_kmh", np.zeros(0)) * KMH)
    if "t_s" not in columns or not len(speed):
        raise RoadError(f"{path}:{table.header}: columns {', '.join(table.names) or 'without names'}, expected t_s and v_kmh or v_mps")
    steps = np.diff(columns["t_s"])
    if np.any(steps <= 0.0):
        raise RoadError(f"{table.at(int(np.argmax(steps <= 0.0)) + 1)}: t_s does not increase, expected increasing times")
    if np.any(speed < 0.0):
        raise RoadError(f"{table.at(int(np.argmax(speed < 0.0)))}: speed is {float(np.min(speed)):g} m/s, expected 0 or more")
    for array in (columns["t_s"], speed):
        array.setflags(write=False)
    return Cycle(path.stem, table.keys.get("name", path.stem), table.keys.get("source", ""), columns["t_s"], speed)
