"""What a drive leaves behind: columns over time, the account of its energy, and what is read off them."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from powertrain import KWH

from ..errors import PlanningError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from os import PathLike
    from pathlib import Path

    from numpy.typing import NDArray

    from powertrain import PlantLedger, Vehicle

    from ..trajectory.trajectory import Trajectory
    from .events import Event

    Floats = NDArray[np.float64]

#: Units of the plant's states by the beginning of their names; the last that fits counts.
_UNITS = {
    **{"x": "m", "y": "m", "psi": "rad", "v_": "mps", "yaw_rate": "radps", "roll": "rad", "pitch": "rad", "roll_rate": "radps"},
    **{
        "pitch_rate": "radps",
        "omega": "radps",
        "u_": "m",
        "w_": "m",
        "clamp": "nm",
        "hold": "1",
        "torque": "nm",
        "delta": "rad",
        "delta_rate": "radps",
    },
}
#: Accelerations of the trajectory below which driving counts as constant, m/s^2 ahead and aside.
CONSTANT = (0.05, 0.5)
#: So far from a change driving is settled, s.
SETTLED = 1.0


def labelled(name: str, unit: str | None = None) -> str:
    """A column's name with its unit."""
    found = unit or [u for start, u in _UNITS.items() if name == start or name.startswith(start)][-1]
    return name if found == "1" else f"{name}_{found}"


class Recorder:
    """Rows of one drive, in blocks."""

    def __init__(self, names: Sequence[str], block: int = 5000) -> None:
        """Columns of these names."""
        self.names, self._block = tuple(names), block
        self._full: list[Floats] = []
        self._rows, self._at = np.empty((block, len(names))), 0

    def next(self) -> Floats:
        """The next row, to be written into."""
        if self._at == self._block:
            self._full.append(self._rows)
            self._rows, self._at = np.empty_like(self._rows), 0
        self._at += 1
        return self._rows[self._at - 1]

    def columns(self) -> dict[str, Floats]:
        """All columns, read-only."""
        whole = np.concatenate([*self._full, self._rows[: self._at]])
        columns = {}
        for k, name in enumerate(self.names):
            column = np.ascontiguousarray(whole[:, k])
            column.setflags(write=False)
            columns[name] = column
        return columns


@dataclass(frozen=True, eq=False)
class Drive:
    """A drive that was simulated.

    Attributes:
        vehicle, trajectory: what drove, and what it was to follow.
        columns: (n,) arrays by name with units, one row per control period: time, the plant's states, the true station and offsets, the demand, what
            the allocator expected to give, commands, battery.
        ledger: every joule.
        outcome: `arrived` (standing at the end of an open road, or a lap of a closed one done), `stopped` (standing before it), `lost` (farther off
        than     10 m), `late` (not there in the time allowed).
        statuses: how many control periods had which status.
        refused: measurements refused, by reason.
        errors: steps of the manager that failed on a believed measurement.
        happened: events with the time at which they began.
        noticed: what the manager said (actuators at fault, measurements refused), with the time at which it began to.
        step_time: (n,) CPU time of the manager's steps, s.
        wall: wall time of the simulation, s.
        options: how it was made.
    """

    vehicle: Vehicle
    trajectory: Trajectory
    columns: dict[str, Floats]
    ledger: PlantLedger
    outcome: str
    statuses: dict[str, int]
    refused: dict[str, int]
    errors: int
    happened: list[tuple[float, Event]]
    noticed: list[tuple[float, str]]
    step_time: Floats
    wall: float
    options: dict[str, Any] = field(default_factory=dict)

    @property
    def duration(self) -> float:
        """s"""
        return self.ledger.duration

    @cached_property
    def journey_time(self) -> float:
        """From the start until the end of the trajectory is reached but for 0.2 m, s; the duration where it is not reached."""
        s, t = self.columns["s_m"], self.columns["t_s"]
        there = s >= self.trajectory.s[-1] - 0.2
        return float(t[np.argmax(there)] - t[0]) if np.any(there) else self.duration

    @property
    def battery_energy(self) -> float:
        """Drawn at the battery's terminals, auxiliaries included, J."""
        return self.ledger.energy["terminal"]

    @property
    def drive_energy(self) -> float:
        """Drawn by traction and steering drives alone, J: what a quasi-static plan counts."""
        energy = self.ledger.energy
        return self.ledger.energy["terminal"] + self.ledger.unserved - energy["auxiliary"] - energy["converter"]

    @property
    def energy_kwh(self) -> float:
        """`drive_energy` in kWh."""
        return self.drive_energy / KWH

    @cached_property
    def offset_rms(self) -> float:
        """Root mean square of the lateral offset, m."""
        return float(np.sqrt(np.mean(self.columns["e_y_m"] ** 2)))

    @property
    def offset_max(self) -> float:
        """Largest lateral offset, m."""
        return float(np.max(np.abs(self.columns["e_y_m"])))

    @cached_property
    def constant(self) -> NDArray[np.bool_]:
        """(n,) where the trajectory asks for constant driving, and has done and will do so for `SETTLED`."""
        c = self.columns
        changing = (np.abs(c["a_ref_mps2"]) >= CONSTANT[0]) | (np.abs(c["kappa_ref_1pm"]) * c["v_ref_mps"] ** 2 >= CONSTANT[1]) | (c["v_x_mps"] < 1.0)
        t = c["t_s"]
        if not np.any(changing):
            return np.ones(len(t), dtype=np.bool_)
        at = t[changing]
        after = np.searchsorted(at, t, side="right")
        before, behind = at[np.maximum(after - 1, 0)], at[np.minimum(after, len(at) - 1)]
        return ~changing & ((after == 0) | (t - before > SETTLED)) & ((after == len(at)) | (behind - t > SETTLED))

    @property
    def torque_jitter(self) -> float:
        """Root mean square of the rate of torque commands while driving is constant, Nm/s, over all motors."""
        return self._jitter("torque_cmd_")

    @property
    def steering_jitter(self) -> float:
        """The same for steering commands, rad/s."""
        return self._jitter("steer_cmd_")

    def _jitter(self, prefix: str) -> float:
        t, still = self.columns["t_s"], self.constant[1:] & self.constant[:-1]
        if not np.any(still):
            return float("nan")
        rates = [np.diff(column)[still] / np.diff(t)[still] for name, column in self.columns.items() if name.startswith(prefix)]
        return float(np.sqrt(np.mean(np.square(rates))))

    def save(self, path: str | PathLike[str]) -> Path:
        """Write the columns as Parquet, whole or not at all.

        Raises:
            PlanningError: the place cannot be written to.
        """
        from .log_file import write

        about = {"vehicle": self.vehicle.name, "trajectory": self.trajectory.name, "outcome": self.outcome, **self.options}
        return write(self.columns, about, path)

    def __getitem__(self, name: str) -> Floats:
        """A column.

        Raises:
            PlanningError: there is none of that name.
        """
        if name not in self.columns:
            raise PlanningError(f"log of {self.trajectory.name}: no column {name!r}, expected one of {', '.join(self.columns)}")
        return self.columns[name]
