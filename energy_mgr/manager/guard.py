"""The door of the energy manager: which measurements are believed.

A measurement is refused if a number of it is none, if it is old or not newer than the last one, if nothing in it has moved although the car does, or
if the car cannot have got there. A place that is refused as a jump again and again, and whose steps fit together, is the new truth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ..errors import PlanningError
from .measurements import Measurements

#: Why a measurement is refused.
REASONS = ("not a number", "late", "frozen", "jump")


@dataclass(frozen=True)
class Trust:
    """How much is believed.

    Attributes:
        age: of a measurement, at most, s.
        moving: from this speed on (m/s) a car that does not move in its measurements has frozen ones.
        place: jump that noise may make, m.
        heading: the same, rad.
        speed: the same, m/s.
        yaw_rate: the same, rad/s.
        acceleration: largest rate at which velocities change, m/s^2 (and rad/s^2).
        again: so many refused places in a row that fit together are believed; of a receiver that is slower than control, a tenth of it.
        pose_age: of place and heading, at most, s.
        drift: share of the way driven, by which places may differ from what speeds and headings say, over `window`.
        window: s.
        patience: s without a good measurement, after which the car is stopped blindly.
    """

    age: float = 0.1
    moving: float = 0.5
    place: float = 1.0
    heading: float = 0.3
    speed: float = 1.0
    yaw_rate: float = 0.5
    acceleration: float = 20.0
    again: int = 25
    pose_age: float = 3.0
    drift: float = 0.2
    window: float = 0.5
    patience: float = 0.3

    def __post_init__(self) -> None:
        """Refuse what is no limit.

        Raises:
            PlanningError: a limit that is not positive.
        """
        for name, value in vars(self).items():
            if not value > 0:
                raise PlanningError(f"trust in measurements: {name} = {value}, expected a positive number")


class Guard:
    """The last believed measurement, the last refused one, and how often which reason was met."""

    def __init__(self, trust: Trust, wheels: int, motors: int, steered: int) -> None:
        """For a car with so many wheels, motors and steered wheels."""
        self._trust, self._counts = trust, (wheels, motors, steered)
        self.refused: dict[str, int] = dict.fromkeys(REASONS, 0)
        self.forget()

    def forget(self) -> None:
        """Believe the next measurement that is one: nothing is known of where the car was."""
        self._last: Measurements | None = None
        self._jumped: Measurements | None = None
        self._again = 0
        #: a place believed not long ago with its time, how far speeds and headings say the car has gone since, and the length of that way
        self._anchor = (0.0, 0.0, 0.0)
        self._gone = (0.0, 0.0, 0.0)

    def reason(self, m: Measurements, t: float) -> str:
        """Why `m` is not believed at time `t`; empty if it is."""
        found = self._fault(m, t)
        if found:
            self.refused[found] += 1
        else:
            self._move(m)
            self._last, self._jumped, self._again = m, None, 0
        return found

    def _fault(self, m: Measurements, t: float) -> str:
        trust, last = self._trust, self._last
        if not self._numbers(m):
            return "not a number"
        stamp = m.t if m.pose_time is None else m.pose_time
        if not -1e-6 <= t - m.t <= trust.age or not -1e-6 <= t - stamp <= trust.pose_age:
            return "late"
        if last is None:
            return ""
        if m.t <= last.t or (m.pose_time is not None and last.pose_time is not None and m.pose_time < last.pose_time):
            return "late"
        if m.v_x > trust.moving and m[1:9] == last[1:9]:
            return "frozen"
        return self._jump(m, last)

    def _move(self, m: Measurements) -> None:
        """Reckon on from the last believed measurement to `m`, and set a new anchor once in a while or where there is none."""
        last = self._last
        if last is None or self._again or m.t - self._anchor[0] > self._trust.window:
            self._anchor, self._gone = (m.t, m.x, m.y), (0.0, 0.0, 0.0)
            return
        dx, dy, way = self._reckoned(m, last)
        self._gone = (self._gone[0] + dx, self._gone[1] + dy, self._gone[2] + way)

    @staticmethod
    def _reckoned(m: Measurements, last: Measurements) -> tuple[float, float, float]:
        """From one measurement to the next by speed and heading: x, y and length of the way, m."""
        dt, psi = m.t - last.t, m.psi
        dx, dy = dt * (math.cos(psi) * m.v_x - math.sin(psi) * m.v_y), dt * (math.sin(psi) * m.v_x + math.cos(psi) * m.v_y)
        return dx, dy, math.hypot(dx, dy)

    def _astray(self, m: Measurements, last: Measurements) -> bool:
        """Whether places have gone elsewhere than speeds and headings since the anchor: pieces that fit one by one may not fit together."""
        if m.pose_time is not None:
            return False
        dx, dy, way = self._reckoned(m, last)
        _, x, y = self._anchor
        off = math.hypot(m.x - x - self._gone[0] - dx, m.y - y - self._gone[1] - dy)
        return off > self._trust.place + self._trust.drift * (self._gone[2] + way)

    def _numbers(self, m: Measurements) -> bool:
        try:
            stamp = 0.0 if m.pose_time is None else m.pose_time
            total = sum(m[:9]) + sum(m.wheel_speeds) + sum(m.torques) + sum(m.angles) + sum(m.brakes) + m.soc + m.friction + stamp
            wheels, motors, steered = self._counts
            whole = len(m.wheel_speeds) in (0, wheels) and len(m.torques) in (0, motors) and len(m.angles) in (0, steered)
            return (
                math.isfinite(total)
                and whole
                and len(m.brakes) in (0, wheels)
                and all(0.0 <= share <= 1.0 for share in m.brakes)
                and m.power_min - m.power_max <= 0.0
                and m.friction > 0.0
            )
        except (TypeError, AttributeError, ValueError, ArithmeticError):
            return False

    def _jump(self, m: Measurements, last: Measurements) -> str:
        if self._fits(m, last) and not self._astray(m, last):
            return ""
        before, self._jumped = self._jumped, m
        slow = m.pose_time is not None
        still = before is not None and (m.x, m.y) == (before.x, before.y) and m.v_x > self._trust.moving
        if before is not None and (m.pose_time == before.pose_time if slow else still):
            return "jump"  # the same once more says nothing new
        # a strange place that goes on as the car does, sample after sample, is where the car is
        self._again = self._again + 1 if before is not None and self._fits(m, before) else 1
        return "" if self._again >= (max(self._trust.again // 10, 2) if slow else self._trust.again) else "jump"

    def _fits(self, m: Measurements, earlier: Measurements) -> bool:
        trust, dt = self._trust, m.t - earlier.t
        # place and heading belong to their own time
        pose_dt = (m.t if m.pose_time is None else m.pose_time) - (earlier.t if earlier.pose_time is None else earlier.pose_time)
        reach = trust.place + 0.5 * trust.acceleration * pose_dt * max(pose_dt, 0.0)
        cos, sin = math.cos(earlier.psi), math.sin(earlier.psi)
        x = earlier.x + (cos * earlier.v_x - sin * earlier.v_y) * pose_dt
        y = earlier.y + (sin * earlier.v_x + cos * earlier.v_y) * pose_dt
        gain = trust.acceleration * dt
        return (
            abs(m.x - x) <= reach
            and abs(m.y - y) <= reach
            and abs(math.remainder(m.psi - earlier.psi - earlier.yaw_rate * pose_dt, math.tau)) <= trust.heading + 0.5 * gain * abs(pose_dt)
            and abs(m.v_x - earlier.v_x) <= trust.speed + gain
            and abs(m.v_y - earlier.v_y) <= trust.speed + gain
            and abs(m.yaw_rate - earlier.yaw_rate) <= trust.yaw_rate + gain
        )

    def snapshot(self) -> dict[str, Any]:
        """The memory, as plain data."""
        return {
            "refused": dict(self.refused),
            "last": None if self._last is None else tuple(self._last),
            "jumped": None if self._jumped is None else tuple(self._jumped),
            "again": self._again,
            "anchor": self._anchor,
            "gone": self._gone,
        }

    def restore(self, memory: dict[str, Any]) -> None:
        """Take up what `snapshot` gave."""
        self.refused = dict(memory["refused"])
        self._last, self._jumped = (None if memory[key] is None else Measurements(*memory[key]) for key in ("last", "jumped"))
        self._again = memory["again"]
        self._anchor, self._gone = tuple(memory["anchor"]), tuple(memory["gone"])
