"""Measured loss maps of a drive: read from CSV, kept raw for reports, fitted by polynomials for optimisation.

A map file has a header and the columns `torque_nm`, `speed_radps` (or `speed_rpm`) and `loss_w` (or `efficiency`), one operating point a line, in any
order; generating points have negative torque. The fit is, with t = |torque| and w = |speed|,

    P = c0 + c1 w + c2 w^2 + (a1 t + a2 t^2 + a3 t w + a4 t^2 w)        a apart for motoring and generating

with all coefficients at least zero, hence never negative, convex in torque on either side and continuous at zero torque.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import msgspec
import numpy as np

from ..errors import VehicleError

if TYPE_CHECKING:
    from os import PathLike

    from numpy.typing import NDArray

    from ..description.sections import Drive

    Floats = NDArray[np.float64]

#: No drive has torques (Nm), speeds (rad/s, rpm) or losses (W) beyond this.
_LARGEST = 1e7
_COLUMNS = "torque_nm, speed_radps or speed_rpm, loss_w or efficiency"


class MapFit(NamedTuple):
    """Polynomial losses of a drive.

    Attributes:
        common: (3,) coefficients of 1, |speed|, speed^2: W, Nm, Nms.
        motoring: (4,) coefficients of |torque|, torque^2, |torque speed|, torque^2 |speed|.
        generating: (4,) the same for torque against the speed.
        rmse: root mean square error over the map's points, W.
        worst: largest error, W.
    """

    common: Floats
    motoring: Floats
    generating: Floats
    rmse: float
    worst: float

    def losses(self, torque: Any, speed: Any) -> Any:
        """Loss in W at `torque` (Nm) and `speed` (rad/s); numbers, arrays and CasADi symbols pass."""
        t, w = np.fabs(torque), np.fabs(speed)
        # one where torque and speed have the same sign; at rest motoring counts, where both agree
        drives = 0.5 + 0.5 * np.sign(np.sign(torque * speed) + 0.5)
        total = float(self.common[0]) + float(self.common[1]) * w + float(self.common[2]) * w**2
        for side, share in ((self.motoring, drives), (self.generating, 1.0 - drives)):
            a = [float(value) for value in side]
            total = total + share * (a[0] * t + a[1] * t**2 + a[2] * t * w + a[3] * t**2 * w)
        return total


@dataclass(frozen=True, eq=False)
class MotorMap:
    """Measured operating points of a drive.

    Attributes:
        source: where they come from, for messages.
        torque: (n,) Nm, negative when generating.
        speed: (n,) rad/s.
        loss: (n,) W.
    """

    source: str
    torque: Floats
    speed: Floats
    loss: Floats

    def at(self, torque: Any, speed: Any) -> Floats:
        """Loss in W between the measured points, linear on their triangulation; NaN outside of what was measured."""
        from scipy.interpolate import LinearNDInterpolator

        scale = np.array([np.ptp(self.torque), np.ptp(self.speed)])
        table = LinearNDInterpolator(np.column_stack([self.torque, self.speed]) / scale, self.loss)
        return np.asarray(table(np.asarray(torque) / scale[0], np.asarray(speed) / scale[1]), dtype=np.float64)

    def fit(self) -> MapFit:
        """The polynomial losses nearest to the map in the least-squares sense, all coefficients at least zero."""
        t, w = np.abs(self.torque), np.abs(self.speed)
        torques = np.column_stack([t, t**2, t * w, t**2 * w])
        drives = (self.torque * self.speed >= 0.0)[:, None]
        rows = np.column_stack([np.ones_like(t), w, w**2, torques * drives, torques * ~drives])
        found = _nearest(rows, self.loss)
        error = rows @ found - self.loss
        return MapFit(found[:3], found[3:7], found[7:], float(np.sqrt(np.mean(error**2))), float(np.max(np.abs(error))))

    def drive(self, drive: Drive) -> Drive:
        """`drive` with the constants of (3.39) that come nearest to this map, so that planners see its losses.

        (3.39) has the same losses for driving and recuperating; `fit` keeps them apart. The resistance, per-current and speed-dependent terms
        change; what the map loses in proportion to power beyond them joins the gear's efficiency. The map is of motor and inverter: the gear's
        own efficiency stays as it was declared.
        """
        t, w = np.abs(self.torque), np.abs(self.speed)
        rows = np.column_stack([np.ones_like(t), w, w**2, t, t**2, t * w])
        constant, drag, eddy, a, b, share = _nearest(rows, self.loss)
        flux = drive.pole_pairs * drive.magnet_flux_wb
        return msgspec.structs.replace(
            drive,
            inverter_constant_w=float(constant),
            friction_nm=float(drag),
            hysteresis_nm=0.0,
            eddy_nms=float(eddy),
            inverter_per_current_wpa=float(1.5 * flux * a),
            phase_resistance_ohm=float(max(1.5 * flux**2 * b, 1e-4)),
            gear_efficiency=float((1.0 - min(share, 0.99)) * drive.gear_efficiency),
            weakening=None,
        )


def _nearest(rows: Floats, loss: Floats) -> Floats:
    """Coefficients, none below zero, of the columns of `rows` that come nearest to `loss`."""
    from scipy.optimize import nnls

    size = np.maximum(np.abs(rows).max(axis=0), 1e-300)
    return nnls(rows / size, loss)[0] / size


def read_map(path: str | PathLike[str]) -> MotorMap:
    """The loss map of a CSV file.

    Raises:
        VehicleError: with file, line, what was found and what was expected.
    """
    path = Path(path)
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            lines = [(number, row) for number, row in enumerate(csv.reader(file), start=1) if row and not row[0].lstrip().startswith("#")]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise VehicleError(f"{path}: cannot be read as a loss map: {getattr(error, 'strerror', None) or error}") from None
    if not lines:
        raise VehicleError(f"{path}: empty, expected a header with {_COLUMNS}")
    header = [name.strip() for name in lines[0][1]]
    if "torque_nm" not in header or not {"speed_radps", "speed_rpm"} & set(header) or not {"loss_w", "efficiency"} & set(header):
        raise VehicleError(f"{path}, line {lines[0][0]}: columns {', '.join(header)}, expected {_COLUMNS}")
    rows = np.array([_numbers(path, number, row, len(header)) for number, row in lines[1:]])
    if len(rows) < 12:
        raise VehicleError(f"{path}: {len(rows)} operating points, expected at least 12")
    column = {name: rows[:, k] for k, name in enumerate(header)}
    speed = column["speed_radps"] if "speed_radps" in column else column["speed_rpm"] * (np.pi / 30.0)
    return _checked(path, [number for number, _ in lines[1:]], column["torque_nm"], speed, column)


def _numbers(path: Path, number: int, row: list[str], count: int) -> list[float]:
    if len(row) != count:
        raise VehicleError(f"{path}, line {number}: {len(row)} values, expected {count}")
    try:
        values = [float(word) for word in row]
    except ValueError:
        raise VehicleError(f"{path}, line {number}: found {', '.join(row)!r}, expected numbers") from None
    if not np.all(np.isfinite(values)) or np.max(np.abs(values)) > _LARGEST:
        raise VehicleError(f"{path}, line {number}: found {', '.join(row)!r}, expected finite numbers up to {_LARGEST:g}")
    return values


def _checked(path: Path, numbers: list[int], torque: Floats, speed: Floats, column: dict[str, Floats]) -> MotorMap:
    if "loss_w" in column:
        loss = column["loss_w"]
    else:
        efficiency, power = column["efficiency"], torque * speed
        if np.any(bad := (efficiency <= 0.0) | (efficiency > 1.0)):
            at = int(np.argmax(bad))
            raise VehicleError(f"{path}, line {numbers[at]}: efficiency {efficiency[at]:g}, expected above 0 and at most 1")
        # an efficiency says nothing where no power passes
        useful = power != 0.0
        torque, speed, efficiency, power = torque[useful], speed[useful], efficiency[useful], power[useful]
        if len(power) < 12:
            raise VehicleError(f"{path}: {len(power)} operating points with power, expected at least 12 where efficiency is given")
        loss = np.where(power >= 0.0, power / efficiency - power, -power * (1.0 - efficiency))
    if np.any(loss < 0.0):
        at = int(np.argmax(loss < 0.0))
        raise VehicleError(f"{path}, line {numbers[at]}: loss {loss[at]:g} W, expected none below zero")
    spread = np.column_stack([torque, speed]) - [np.mean(torque), np.mean(speed)]
    if np.linalg.matrix_rank(spread / np.maximum(np.abs(spread).max(axis=0), 1e-300), tol=1e-6) < 2:
        raise VehicleError(f"{path}: all points have the same torque or speed, or lie on a line, expected a map over both")
    return MotorMap(str(path), torque, speed, loss)
