"""What goes wrong on a drive: actuators that fail, measurements that lie, ice on the road; from a TOML file or by hand.

[[event]]                  # a wheel that stays as it is turned
station_m = 850.0          # or time_s
part = "steer_fl"          # motor_<k>, brake_<wheel>, steer_<wheel>, measurement, friction
kind = "stuck"             # dead, weak (with share), stuck; frozen, jump (with size), late, nan; value
duration_s = 2.0           # for ever if left out
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import msgspec

from powertrain.description.toml_file import read_toml

from ..errors import PlanningError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from os import PathLike

    from ..allocation import Layout

Kind = Literal["dead", "weak", "stuck", "frozen", "jump", "late", "nan", "value"]
_MEASURED = ("frozen", "jump", "late", "nan")
Time = Annotated[float, msgspec.Meta(ge=0.0, lt=1e9)]


class Event(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One thing that goes wrong.

    Attributes:
        part: `motor_<k>` (from 1), `brake_<wheel>`, `steer_<wheel>` with wheels fl, fr, rl, rr, `measurement`, or `friction`.
        kind: `dead` or `weak` (`share` is left) for motors and brakes, `stuck` for steering; `nan`, `frozen`, `jump` (by `size` m to the left),
        `late`     (by `size` s) for measurements; `value` (`share` of the friction that tyres were described for) for friction.
        time_s: when it begins, s.
        station_m: where it begins, m along the trajectory; the earlier of the two where both are given.
        duration_s: how long it lasts; for ever if left out.
        share: what is left.
        size: of a jump in m, of a delay in s.
    """

    part: str
    kind: Kind
    time_s: Time | None = None
    station_m: float | None = None
    duration_s: Time | None = None
    share: Annotated[float, msgspec.Meta(ge=0.0, le=1.5)] = 0.0
    size: Annotated[float, msgspec.Meta(gt=-1e6, lt=1e6)] = 5.0


class _Events(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    event: list[Event]


def read_events(path: str | PathLike[str]) -> tuple[Event, ...]:
    """The events of a TOML file.

    Raises:
        VehicleError: a file that cannot be read, or an entry that is no event.
    """
    return tuple(read_toml(Path(path), _Events).event)


def checked(events: Sequence[Event], layout: Layout) -> tuple[Event, ...]:
    """`events` if this car has their parts.

    Raises:
        PlanningError: the first that does not fit, by its number.
    """
    parts = {
        **{f"motor_{k + 1}": ("dead", "weak") for k in range(layout.motors)},
        **{f"brake_{wheel}": ("dead", "weak") for wheel in ("fl", "fr", "rl", "rr")},
        **{f"steer_{wheel}": ("stuck",) for wheel in layout.track.steered},
        "measurement": _MEASURED,
        "friction": ("value",),
    }
    for number, event in enumerate(events, start=1):
        if event.part not in parts:
            raise PlanningError(f"event {number}: part {event.part!r}, expected one of {', '.join(parts)}")
        if event.kind not in parts[event.part]:
            raise PlanningError(f"event {number}: {event.part} is {event.kind!r}, expected {' or '.join(parts[event.part])}")
        times = [value for value in (event.time_s, event.station_m, event.duration_s) if value is not None]
        if (event.time_s is None and event.station_m is None) or not all(map(math.isfinite, times)):
            raise PlanningError(f"event {number}: begins at time_s {event.time_s}, station_m {event.station_m}, expected at least one of them")
        if event.part != "friction" and event.share > 1.0:
            raise PlanningError(f"event {number}: {event.part} keeps a share of {event.share}, expected at most 1")
        if event.part == "friction" and event.share <= 0.0:
            raise PlanningError(f"event {number}: friction {event.share}, expected more than 0")
    return tuple(events)


class Happening:
    """The events of one drive, as time goes on."""

    def __init__(self, events: Sequence[Event], layout: Layout) -> None:
        """None of `events` has begun.

        Raises:
            PlanningError: an event that does not fit the car.
        """
        self._waiting, self._since, self.active = list(checked(events, layout)), {}, []
        #: events that have begun, with the time
        self.begun: list[tuple[float, Event]] = []

    def update(self, t: float, s: float) -> bool:
        """Begin and end what is due at time `t` (s) and station `s` (m); whether anything changed."""
        if not self._waiting and not self._since:
            return False
        due = [e for e in self._waiting if (e.time_s is not None and t >= e.time_s - 1e-9) or (e.station_m is not None and s >= e.station_m)]
        for event in due:
            self._waiting.remove(event)
            self.active.append(event)
            self.begun.append((t, event))
            if event.duration_s is not None:
                self._since[len(self.begun)] = (t + event.duration_s, event)
        over = [key for key, (end, _) in self._since.items() if t >= end - 1e-9]
        for key in over:
            self.active.remove(self._since.pop(key)[1])
        return bool(due or over)

    _waiting: list[Event]
    _since: dict[int, tuple[float, Event]]
    active: list[Event]
