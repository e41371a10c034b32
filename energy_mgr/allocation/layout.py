"""Which actuators a car has, in the order in which they are commanded, and what they can do in one control period."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from powertrain.chassis.double_track import WHEELS, DoubleTrack

from ..errors import PlanningError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from powertrain import Vehicle

    Floats = NDArray[np.float64]

#: A steering angle of this size counts as one in the scaled programme, rad.
_ANGLE = 0.1


@dataclass(frozen=True)
class Faults:
    """What the actuators cannot do (any more).

    Attributes:
        motors: share of its torque that each motor still gives, 0 (dead) to 1; empty: all sound.
        brakes: the same per wheel.
        stuck: per steered wheel the angle (rad) at which it is stuck, None where it turns; empty: all turn.
    """

    motors: tuple[float, ...] = ()
    brakes: tuple[float, ...] = ()
    stuck: tuple[float | None, ...] = ()

    @property
    def any(self) -> bool:
        """Whether anything is wrong at all."""
        return any(share != 1.0 for share in (*self.motors, *self.brakes)) or any(angle is not None for angle in self.stuck)


NO_FAULTS = Faults()


class Layout:
    """The actuators of one car: motor torques, friction brakes and steering angles, in the order of the plant's inputs.

    Attributes:
        vehicle: the car.
        track: its double-track model, whose equations allocation shares.
        names: of the commands: `torque_cmd_<motor>`, `brake_cmd_<wheel>`, `steer_cmd_<wheel>`.
        scale: (n,) what counts as one in the scaled programme: the largest torques, 0.1 rad.
        lower, upper: (n,) what the actuators can do at all: Nm, Nm, rad.
        rate: (n,) how fast commands may change, 1/s; a brake's full torque takes its lag.
    """

    def __init__(self, vehicle: Vehicle) -> None:
        """The layout of `vehicle`.

        Raises:
            VehicleError: the description lacks a section that the double-track model needs.
        """
        self.vehicle = vehicle
        self.track = track = DoubleTrack(vehicle)
        self.motors, self.steered = len(track.motors), tuple(WHEELS.index(name) for name in track.steered)
        self.names: tuple[str, ...] = track.inputs[:-3]
        #: places of the commands to the left and the right wheel of each axle with a rack
        self.racks = self._joined()
        #: whether lateral force and yaw moment can be chosen independently of each other
        self.both_axles = len(self.steered) == 4
        self.torques = slice(0, self.motors)
        self.brakes = slice(self.motors, self.motors + 4)
        self.steers = slice(self.motors + 4, len(self.names))
        drive, brakes, steering = vehicle.drive, track.brakes, track.steering
        brake = [brakes.front_torque_max_nm] * 2 + [brakes.rear_torque_max_nm] * 2
        angles = len(self.steered)
        self.upper = np.array([drive.torque_max_nm] * self.motors + brake + [steering.angle_max_rad] * angles)
        self.lower = np.array([-drive.regen_torque_max_nm] * self.motors + [0.0] * 4 + [-steering.angle_max_rad] * angles)
        strongest = max(drive.torque_max_nm, drive.regen_torque_max_nm)
        self.scale = np.array([strongest] * self.motors + [max(most, 1.0) for most in brake] + [_ANGLE] * angles)
        self.rate = np.array([drive.torque_rate_nmps] * self.motors + [most / brakes.lag_s for most in brake] + [steering.rate_max_radps] * angles)
        # the share of each wheel's speed in each motor's, from the model itself
        units = np.eye(4)
        speeds = [track.motor_speeds({f"omega_{name}": units[k][w] for w, name in enumerate(WHEELS)}) for k in range(4)]
        self._speed_of_wheel = [[(w, float(speeds[w][m])) for w in range(4) if speeds[w][m] != 0.0] for m in range(self.motors)]

    def _joined(self) -> tuple[tuple[int, int], ...]:
        if self.track.steering.individual:
            return ()
        first = self.motors + 4
        return tuple((first + k, first + k + 1) for k in range(0, len(self.steered), 2))

    @cached_property
    def alike(self) -> Floats:
        """(n, m): commands of m actuators of which a rack is one, to all n commands."""
        columns = np.eye(self.size)
        for left, right in self.racks:
            columns[right, left] = 1.0
        return np.delete(columns, [right for _, right in self.racks], axis=1)

    @property
    def wheel_torque_per_motor(self) -> list[float]:
        """Sum of the torques at the wheels over that of each motor."""
        one = [{f"torque_{j + 1}": float(j == k) for j in range(self.motors)} for k in range(self.motors)]
        return [float(sum(self.track.drive_torques(torques))) for torques in one]

    @property
    def size(self) -> int:
        """How many commands there are."""
        return len(self.names)

    def motor_speeds(self, wheel_speeds: Sequence[Any]) -> list[Any]:
        """Speed of each motor in rad/s for those of the four wheels."""
        return [sum(gain * wheel_speeds[wheel] for wheel, gain in parts) for parts in self._speed_of_wheel]

    def packed(self, faults: Faults) -> Floats:
        """`faults` as numbers: shares of motors, shares of brakes, then per steered wheel 1 where it turns or 0, then the angles where not."""
        stuck = faults.stuck or (None,) * len(self.steered)
        angles = [0.0 if angle is None else angle for angle in stuck]
        return np.array([*(faults.motors or (1.0,) * self.motors), *(faults.brakes or (1.0,) * 4), *(float(a is None) for a in stuck), *angles])

    def box(self, before: Sequence[Any], wheel_speeds: Sequence[Any], dt: Any, faults: Sequence[Any]) -> tuple[list[Any], list[Any]]:
        """Smallest and largest commands that may follow `before` after `dt` seconds: envelopes, rates and `faults` as `packed` gives them.

        Where two limits contradict each other (a motor that has become too fast for its torque), what the actuator can do at all counts more than
        its rate. NumPy operations only: numbers and symbols pass.
        """
        m, count = self.motors, len(self.steered)
        shares, free, angles = faults[: m + 4], faults[m + 4 : m + 4 + count], faults[m + 4 + count :]
        low: list[Any] = []
        high: list[Any] = []
        for k, speed in enumerate(self.motor_speeds(wheel_speeds)):
            forward, backward = self.track.torque_range(speed)
            _append(low, high, -backward * shares[k], forward * shares[k], before[k], float(self.rate[k]) * dt)
        for k in range(m, m + 4):
            _append(low, high, 0.0, float(self.upper[k]) * shares[k], before[k], float(self.rate[k]) * dt)
        for k in range(count):
            at = m + 4 + k
            _append(low, high, float(self.lower[at]), float(self.upper[at]), before[at], float(self.rate[at]) * dt)
            low[at], high[at] = (free[k] * bound + (1.0 - free[k]) * angles[k] for bound in (low[at], high[at]))
        return low, high

    def checked(self, faults: Faults) -> Faults:
        """`faults` if they fit this car.

        Raises:
            PlanningError: another number of motors, brakes or steered wheels, or shares outside 0 to 1.
        """
        for what, values, count in (("motors", faults.motors, self.motors), ("brakes", faults.brakes, 4), ("stuck", faults.stuck, len(self.steered))):
            if values and len(values) != count:
                raise PlanningError(f"{self.vehicle.name}: faults name {len(values)} {what}, expected none or {count}")
        if not all(0.0 <= share <= 1.0 for share in (*faults.motors, *faults.brakes)):
            raise PlanningError(f"{self.vehicle.name}: faults leave {(*faults.motors, *faults.brakes)} of motors and brakes, expected 0 to 1 each")
        most = 2.0 * self.track.steering.angle_max_rad
        if not all(angle is None or abs(angle) <= most for angle in faults.stuck):
            raise PlanningError(f"{self.vehicle.name}: steering stuck at {faults.stuck} rad, expected {-most:.3g} to {most:.3g} rad each, or None")
        return faults


def _append(low: list[Any], high: list[Any], least: Any, most: Any, before: Any, step: Any) -> None:
    """The part of `least` to `most` within `step` of `before`; the end next to it where there is none."""
    low.append(np.fmin(np.fmax(least, before - step), most))
    high.append(np.fmax(np.fmin(most, before + step), least))
