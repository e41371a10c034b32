"""From the plant's state to measurements: perfect ones, or those of the published sensors with noise, bias, delay and a slow satellite receiver."""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING, Protocol

import numpy as np

from powertrain.battery import published_power
from powertrain.chassis.double_track import WHEELS
from powertrain.sensors import TABLE_C2, Gnss, GnssDescription, Sensor, SensorBank

from ..manager import Measurements

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from powertrain import Plant

    from .events import Event

    Floats = NDArray[np.float64]

SENSORS = ("ideal", "real")
#: Yaw rate gyroscope (not in Table C.2; a MEMS unit of good quality), and heading of a receiver with two antennas, rad.
_GYRO, _COMPASS = Sensor(0.0, 0.004, 0.016), 0.003
#: The battery's power (5.7) is looked up so often, over so long, s: the closed form, since `available_power`, which is sharper, takes a second.
_BATTERY_EVERY, _BATTERY_HORIZON = 1.0, 10.0


class Sensing(Protocol):
    """Makes measurements out of the plant."""

    def measure(self, t: float, plant: Plant, a_x: float, a_y: float, friction: float) -> Measurements:
        """What is measured at time `t` (s), given the true accelerations (m/s^2) and friction."""
        ...


class _Reader:
    """Where the numbers are in the plant's state, and the battery's power once in a while."""

    def __init__(self, plant: Plant) -> None:
        states = plant.body.states
        self.plane = [states.index(name) for name in ("x", "y", "psi", "v_x", "v_y", "yaw_rate")]
        first = states.index("omega_fl")
        self.spins = slice(first, first + 4)
        first = states.index("torque_1")
        self.torques = slice(first, first + len(plant.body.motors))
        self.angles = [states.index(f"delta_{wheel}") for wheel in plant.body.steered]
        self._next, self._window = -math.inf, (-math.inf, math.inf)

    def window(self, t: float, plant: Plant) -> tuple[float, float]:
        """What the battery can take (negative) and give over the next seconds, W."""
        if t >= self._next:
            pack, state = plant.pack, plant.battery_state.tolist()
            most, least = published_power(pack.cell, state[:-1], state[-1], _BATTERY_HORIZON)
            count = pack.series * pack.parallel
            self._window = (float(least) * count, float(most) * count)
            self._next = t + _BATTERY_EVERY
        return self._window


class IdealSensing:
    """Measurements are the truth."""

    def __init__(self, plant: Plant) -> None:
        """For one plant."""
        self._reader = _Reader(plant)

    def measure(self, t: float, plant: Plant, a_x: float, a_y: float, friction: float) -> Measurements:
        """As `Sensing.measure`."""
        r, state = self._reader, plant.state.tolist()
        low, high = r.window(t, plant)
        x, y, psi, v_x, v_y, yaw_rate = (state[k] for k in r.plane)
        spins, torques, angles = tuple(state[r.spins]), tuple(state[r.torques]), tuple(state[k] for k in r.angles)
        return Measurements(t, x, y, psi, v_x, v_y, yaw_rate, a_x, a_y, spins, torques, angles, plant.soc, low, high, (), friction)


class RealSensing:
    """The published sensors: Table C.2 for velocities, accelerations and wheels, a receiver that is 5 Hz and 0.2 s late for place and heading."""

    def __init__(self, plant: Plant, rng: np.random.Generator, gnss: GnssDescription | None = None) -> None:
        """For one plant as it stands now; noise from `rng`."""
        self._reader, self._rng = _Reader(plant), rng
        names = {"v_x": "oxts_v_x", "v_y": "oxts_v_y", "a_x": "oxts_a_x", "a_y": "oxts_a_y"}
        sensors = {name: TABLE_C2[source] for name, source in names.items()} | {"yaw_rate": _GYRO}
        sensors |= {f"spin_{wheel}": TABLE_C2["wheel_speed"] for wheel in WHEELS}
        self._bank, self._gnss = SensorBank(sensors, rng), Gnss(gnss or GnssDescription(), rng)
        self._headings: deque[tuple[float, float]] = deque(maxlen=1000)
        start = plant.state.tolist()
        x, y, psi = (start[k] for k in self._reader.plane[:3])
        self._pose = (0.0, x, y, psi)
        for _ in range(8):  # the delays fill before the drive begins
            self._bank.sample(self._truth(start, 0.0, 0.0))

    def _truth(self, state: Sequence[float], a_x: float, a_y: float) -> dict[str, float]:
        v_x, v_y, yaw_rate = (state[k] for k in self._reader.plane[3:])
        spins = {f"spin_{wheel}": spin for wheel, spin in zip(WHEELS, state[self._reader.spins], strict=True)}
        return {"v_x": v_x, "v_y": v_y, "a_x": a_x, "a_y": a_y, "yaw_rate": yaw_rate} | spins

    def measure(self, t: float, plant: Plant, a_x: float, a_y: float, friction: float) -> Measurements:
        """As `Sensing.measure`; nobody measures friction."""
        r, state = self._reader, plant.state.tolist()
        seen, (low, high) = self._bank.sample(self._truth(state, a_x, a_y)), r.window(t, plant)
        x, y, psi = (state[k] for k in r.plane[:3])
        self._headings.append((t, psi))
        for fix in self._gnss.step(t, x, y):
            if fix.time >= self._pose[0]:
                heading = min(self._headings, key=lambda row: abs(row[0] - fix.time))[1]
                self._pose = (fix.time, fix.x, fix.y, heading + _COMPASS * float(self._rng.standard_normal()))
        stamp, x, y, psi = self._pose
        v_x, v_y, yaw_rate, a_x, a_y = (seen[name] for name in ("v_x", "v_y", "yaw_rate", "a_x", "a_y"))
        spins = tuple(seen[f"spin_{wheel}"] for wheel in WHEELS)
        torques, angles = tuple(state[r.torques]), tuple(state[k] for k in r.angles)
        return Measurements(t, x, y, psi, v_x, v_y, yaw_rate, a_x, a_y, spins, torques, angles, plant.soc, low, high, (), 1.0, stamp)


class Spoiled:
    """Measurements under the events of a drive."""

    def __init__(self) -> None:
        """Nothing has happened yet."""
        self._held: Measurements | None = None

    def spoil(self, m: Measurements, active: Sequence[Event]) -> Measurements:
        """`m` as it arrives."""
        events = [event for event in active if event.part == "measurement"]
        brakes = [event for event in active if event.part.startswith("brake_")]
        if brakes:
            shares = {event.part[6:]: event.share if event.kind == "weak" else 0.0 for event in brakes}
            m = m._replace(brakes=tuple(shares.get(wheel, 1.0) for wheel in WHEELS))
        if not any(event.kind == "frozen" for event in events):
            self._held = None
        for event in events:
            if event.kind == "nan":
                m = m._replace(x=math.nan, v_x=math.nan)
            elif event.kind == "jump":
                m = m._replace(x=m.x - event.size * math.sin(m.psi), y=m.y + event.size * math.cos(m.psi))
            elif event.kind == "late":
                m = m._replace(t=m.t - event.size)
            else:
                self._held = self._held or m
                m = self._held._replace(t=m.t)
        return m
