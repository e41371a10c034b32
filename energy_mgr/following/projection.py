"""Projection of the car on its path without looking at the clock (F1).

`tipi` is the published iteration-free law (3.20)-(3.22): one explicit step a period, errors decay with K_Ps (1 - kappa e_y). `safe` takes
one or two Newton steps on e_x = 0 from the point before, checks the answer, and searches again where the law would lose the path: after
jumps of the measured place, at the centre of curvature. It stays on its branch where a path crosses itself. A normal step takes one or two
evaluations of the trajectory, about 10 us; searches, which are rare, some 0.1 ms.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal

from ..errors import PlanningError
from ..motion import VehicleState
from .projected import DOMAIN_MIN, How, Line, Projected, offsets_from
from .search import TIE, Found, around, nearest

if TYPE_CHECKING:
    from ..trajectory.pieces import TrajectoryPoint
    from ..trajectory.trajectory import Trajectory

#: m; Newton steps below this are not worth another evaluation
_CLOSE = 1e-5
#: m; what may be left after the last step
_RESIDUAL = 0.01


class PathProjection:
    """Keeps the station of the car on `trajectory`.

    Args:
        trajectory: what to be projected on.
        method: "safe" or "tipi".
        gain: K_Ps of (3.21), 1/s; "tipi" only.
        window: how far around the last station is searched after a jump, m.
        jump: what a measured place may deviate from twice the driven way within a period, m.
        dt: period, s, if known: the gain is then checked at once.

    Raises:
        PlanningError: an unknown method, a gain, window or jump that is not positive, gain times dt of 1 or more (the explicit step would overshoot).
    """

    def __init__(
        self,
        trajectory: Trajectory,
        *,
        method: Literal["safe", "tipi"] = "safe",
        gain: float = 10.0,
        window: float = 10.0,
        jump: float = 0.5,
        dt: float | None = None,
    ) -> None:
        if method not in ("safe", "tipi"):
            raise PlanningError(f"projection method {method!r}, expected safe or tipi")
        for name, value in (("gain", gain), ("window", window), ("jump", jump)):
            if not 0.0 < value < math.inf:
                raise PlanningError(f"projection {name} {value}, expected more than 0")
        self.method, self.gain, self.window, self.jump = method, gain, window, jump
        if dt is not None:
            self._check(dt)
        self._line = Line(trajectory)
        self.reset()

    def _check(self, dt: float) -> None:
        if self.method == "tipi" and not self.gain * dt < 1.0:
            raise PlanningError(f"projection gain {self.gain:g} 1/s with a period of {dt:g} s, expected a product below 1")

    @property
    def trajectory(self) -> Trajectory:
        """What is projected on."""
        return self._line.trajectory

    @property
    def s(self) -> float:
        """Station of the last update, m; that of the start before the first."""
        return self._line.first if self._point is None else self._point.s

    def kappa_rate(self, s: float) -> float:
        """Change of curvature along the path at station `s`, 1/m^2."""
        return self._line.kappa_rate(s)

    def reset(self) -> None:
        """Forget the station: the next update searches the whole trajectory."""
        self._point: TrajectoryPoint[float] | None = None
        self._sdot, self._x, self._y, self._psi = 0.0, 0.0, 0.0, 0.0

    def snapshot(self) -> tuple[Any, ...]:
        """Everything that the next update depends on but the trajectory."""
        return None if self._point is None else self._point.s, self._sdot, self._x, self._y, self._psi

    def restore(self, snapshot: tuple[Any, ...]) -> None:
        """Go back to a `snapshot`."""
        s, self._sdot, self._x, self._y, self._psi = snapshot
        self._point = None if s is None else self._line.point(s)

    def replace(self, trajectory: Trajectory) -> None:
        """Go over to another trajectory, at the place of the last update; stations may count from elsewhere on it."""
        self._line = Line(trajectory)
        if self._point is not None:
            self._point = self._line.point(nearest(self._line, VehicleState(self._x, self._y, self._psi, 0.0, 0.0, 0.0)).s)

    def update(self, state: VehicleState, dt: float) -> Projected:
        """The projection of `state` (finite), `dt` seconds after the one before.

        Raises:
            PlanningError: with `tipi`, a period too long for the gain.
        """
        last = self._point
        if last is None:
            at = self._seen(state, nearest(self._line, state).s, "global")
            at = self._with_gain(at) if self.method == "tipi" else at
        elif self.method == "tipi":
            self._check(dt)
            at = self._tipi(state, dt, last.s)
        else:
            at = self._safe(state, dt, last)
        self._point, self._sdot, self._x, self._y, self._psi = at.point, at.sdot, state.x, state.y, state.psi
        return at

    def _seen(self, state: VehicleState, s: float, how: How) -> Projected:
        point = self._line.point(s)
        return self._line.projected(state, point, offsets_from(point, state), how)

    def _tipi(self, state: VehicleState, dt: float, s: float) -> Projected:
        """An Euler step from pose and station of the period before to the present time: with pose k and station k - 1 in (3.20) it would lead."""
        return self._with_gain(self._seen(state, self._line.inside(s + self._sdot * dt), "tipi"))

    def _with_gain(self, at: Projected) -> Projected:
        return at._replace(sdot=self.gain * at.e_x + at.sdot)

    def _safe(self, state: VehicleState, dt: float, last: TrajectoryPoint[float]) -> Projected:
        line, driven, guess = self._line, math.hypot(state.v_x, state.v_y) * dt, last.s + self._sdot * dt
        if math.hypot(state.x - self._x, state.y - self._y) > 2.0 * driven + self.jump:
            return self._searched(state, guess)
        # the first step, from the last point, predicts: mostly so well that one evaluation confirms it
        point = last
        for more in (True, True, True, False):
            offsets = offsets_from(point, state)
            # d e_x/ds = -(1 - kappa e_y)
            slope = 1.0 - point.kappa * offsets[1]
            if slope < DOMAIN_MIN:
                return self._outside(state, last.s, driven)
            target = line.inside(point.s + offsets[0] / slope)
            if abs(target - point.s) <= (_CLOSE if more else _RESIDUAL):
                return line.projected(state, point, offsets, "newton")
            if not more or abs(target - guess) > 0.5 * self.window:
                break
            point = line.point(target)
        return self._searched(state, guess)

    def _searched(self, state: VehicleState, guess: float) -> Projected:
        """Around `guess`, and all over if nothing near is found there; a branch elsewhere has to be clearly nearer."""
        here = around(self._line, state, guess, self.window)
        if here.interior and here.distance <= self.jump and here.fit > 0.0:
            return self._seen(state, here.s, "window")
        there = nearest(self._line, state)
        if self._keeps(here, there):
            return self._seen(state, here.s, "window")
        return self._seen(state, self._lap_near(there.s, guess), "global")

    @staticmethod
    def _keeps(here: Found, there: Found) -> bool:
        return here.interior and here.distance <= there.distance + TIE and here.fit > min(0.0, there.fit)

    def _outside(self, state: VehicleState, last: float, driven: float) -> Projected:
        """Near the centre of curvature all stations are about as near: go on, not back and not faster than the car, until one is clearly nearer."""
        found = around(self._line, state, last, self.window)
        at = self._seen(state, self._line.inside(min(max(found.s, last), last + driven)), "outside")
        if math.hypot(at.e_x, at.e_y) > self._line.distance(state) + 2.0 * TIE:
            return self._seen(state, self._lap_near(nearest(self._line, state).s, last), "global")
        return at

    def _lap_near(self, s: float, guess: float) -> float:
        """Station `s` on the lap of `guess`."""
        line = self._line
        return s + round((guess - s) / line.length) * line.length if line.closed else s
