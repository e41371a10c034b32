"""Where the manager's state comes from: an interface for observers, and the two that need no model.

An observer takes each believed measurement and gives the state now. `PerfectState` passes on what is measured. `DeadReckoning` serves sensors as they
are: place and heading come seldom and late, velocities often and at once.
"""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING, Any, Protocol

from ..motion import VehicleState

if TYPE_CHECKING:
    from .measurements import Measurements


class Observer(Protocol):
    """Gives the state of the car now."""

    def update(self, m: Measurements, t: float) -> VehicleState:
        """The state at time `t` (s), given the measurement that has just been believed."""
        ...

    def snapshot(self) -> Any:
        """The memory, as plain data."""
        ...

    def restore(self, memory: Any) -> None:
        """Take up what `snapshot` gave."""
        ...


class PerfectState:
    """The state is what is measured."""

    def update(self, m: Measurements, t: float) -> VehicleState:
        """As `Observer.update`."""
        return m.motion

    def snapshot(self) -> Any:
        """As `Observer.snapshot`: there is no memory."""
        return ()

    def restore(self, memory: Any) -> None:
        """As `Observer.restore`."""


class DeadReckoning:
    """Place and heading integrated from velocities, and pulled towards each late fix by what was wrong when that fix was true.

    Velocities are integrated from accelerations, which are quiet, and pulled towards those measured; the yaw rate is smoothed. A bias of an
    acceleration stays as an error of the velocity, `blend` times as long.
    """

    def __init__(self, gain: float = 0.3, memory: int = 200, blend: float = 0.08, smooth: float = 0.02) -> None:
        """For a car whose place is known at the start.

        Args:
            gain: share of a fix's difference that is taken over.
            memory: past places that are kept, in control periods; a fix from before them is passed over.
            blend: time constant of the velocities, s.
            smooth: time constant of the yaw rate, s.
        """
        self._gain, self._blend, self._smooth = gain, blend, smooth
        self._speeds: tuple[float, float, float] | None = None
        self._past: deque[tuple[float, float, float, float]] = deque(maxlen=memory)
        self._fix = -math.inf

    def update(self, m: Measurements, t: float) -> VehicleState:
        """As `Observer.update`."""
        stamp = m.t if m.pose_time is None else m.pose_time
        if not self._past or t < self._past[-1][0]:
            # the first place was true when it was measured; and after a clock was set back, all begins anew
            self._past.clear()
            psi, way = m.psi + m.yaw_rate * (t - stamp), t - stamp
            x, y = m.x + way * (math.cos(psi) * m.v_x - math.sin(psi) * m.v_y), m.y + way * (math.sin(psi) * m.v_x + math.cos(psi) * m.v_y)
            self._past.append((t, x, y, psi))
            self._fix = stamp
        before, x, y, psi = self._past[-1]
        dt = t - before
        v_x, v_y, yaw_rate = self._velocities(m, dt)
        middle = psi + 0.5 * dt * yaw_rate
        cos, sin = math.cos(middle), math.sin(middle)
        x, y, psi = x + dt * (cos * v_x - sin * v_y), y + dt * (sin * v_x + cos * v_y), psi + dt * yaw_rate
        if stamp > self._fix and (stamp >= self._past[0][0] or len(self._past) < (self._past.maxlen or 0)):
            self._fix = stamp
            then = min(self._past, key=lambda row: abs(row[0] - stamp))
            shift = [self._gain * e for e in (m.x - then[1], m.y - then[2], math.remainder(m.psi - then[3], math.tau))]
            x, y, psi = x + shift[0], y + shift[1], psi + shift[2]
            # what was wrong then has been wrong since
            for _ in range(len(self._past)):
                row = self._past.popleft()
                self._past.append((row[0], row[1] + shift[0], row[2] + shift[1], row[3] + shift[2]))
        self._past.append((t, x, y, psi))
        return m.motion._replace(x=x, y=y, psi=psi, v_x=v_x, v_y=v_y, yaw_rate=yaw_rate)

    def _velocities(self, m: Measurements, dt: float) -> tuple[float, float, float]:
        """Smoothed velocities after `dt` seconds."""
        if self._speeds is None:
            self._speeds = (m.v_x, m.v_y, m.yaw_rate)
        v_x, v_y, yaw_rate = self._speeds
        share, turn = dt / (self._blend + dt), dt / (self._smooth + dt)
        yaw_rate += turn * (m.yaw_rate - yaw_rate)
        a_x, a_y = m.a_x + yaw_rate * v_y, m.a_y - yaw_rate * v_x
        v_x, v_y = v_x + dt * a_x, v_y + dt * a_y
        self._speeds = (v_x + share * (m.v_x - v_x), v_y + share * (m.v_y - v_y), yaw_rate)
        return self._speeds

    def snapshot(self) -> Any:
        """As `Observer.snapshot`."""
        return {"past": list(self._past), "fix": self._fix, "speeds": self._speeds}

    def restore(self, memory: Any) -> None:
        """As `Observer.restore`."""
        self._past.clear()
        self._past.extend(tuple(row) for row in memory["past"])
        self._fix = memory["fix"]
        self._speeds = None if memory["speeds"] is None else tuple(memory["speeds"])
