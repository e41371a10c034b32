"""Following a trajectory: projection and tracking law, one `step` per control period."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from ..motion import MotionDemand, VehicleState
from .law import Resistances, limited
from .laws import make_law
from .projected import Projected
from .projection import PathProjection

if TYPE_CHECKING:
    from collections.abc import Sequence

    from powertrain import Vehicle

    from ..trajectory.trajectory import Trajectory

#: m and m/s: an open path's end is reached, the car stands
_REACHED, _STANDS = 0.2, 0.03
#: what no car does, m, m/s and rad/s: states are cut to it, so that squares stay finite
_FAR, _FAST, _SPIN = 1e7, 200.0, 50.0


class Following(NamedTuple):
    """One control period.

    Attributes:
        demand: for the allocator.
        at: the car on its path; of the last good state if this one was refused.
        e_v: speed along the path minus that of the trajectory, m/s.
        done: the end of an open path is reached and the car stands.
        supervised: the demand was held back by a limit, or the state was refused.
    """

    demand: MotionDemand
    at: Projected
    e_v: float
    done: bool
    supervised: bool


class Preview(NamedTuple):
    """What the trajectory will ask for: one entry per time asked; speeds m/s, yaw rates rad/s."""

    demands: list[MotionDemand]
    speeds: list[float]
    yaw_rates: list[float]


class Follower:
    """Follows `trajectory` with `vehicle`, independently of time.

    Args:
        law: a name of `LAWS`.
        projection: "safe" or "tipi".
        gains: of the law; None for its defaults.

    Attributes:
        refused: states with numbers that are not finite so far; each repeats the demand before.

    Raises:
        PlanningError: no such law or projection.
    """

    def __init__(
        self,
        trajectory: Trajectory,
        vehicle: Vehicle,
        *,
        law: str = "linearising",
        projection: Literal["safe", "tipi"] = "safe",
        gains: Any = None,
    ) -> None:
        self.law = make_law(law, vehicle, gains)
        self.projection = PathProjection(trajectory, method=projection)
        self._resistances = Resistances(vehicle)
        self.reset()

    @property
    def trajectory(self) -> Trajectory:
        """What is followed."""
        return self.projection.trajectory

    def reset(self) -> None:
        """As new."""
        self.refused = 0
        self._last: Following | None = None
        self.law.reset()
        self.projection.reset()

    def step(self, state: VehicleState, dt: float) -> Following:
        """The demand for the coming `dt` seconds. A state that is not finite is refused and counted: the demand before is repeated.

        Raises:
            PlanningError: with projection "tipi", a period too long for its gain.
        """
        if not _usual(state):
            if not all(map(math.isfinite, state)):
                return self._refuse(dt)
            state = _plausible(state)
        at = self.projection.update(state, dt)
        demand = self.law.demand(state, at, dt)
        done = at.to_go <= _REACHED and math.hypot(state.v_x, state.v_y) <= _STANDS
        self._last = Following(demand, at, at.ahead - at.point.v, done, self.law.supervised)
        return self._last

    def _refuse(self, dt: float) -> Following:
        self.refused += 1
        if self._last is not None:
            return self._last._replace(supervised=True)
        start = self.trajectory.point(float(self.trajectory.s[0]))
        at = Projected(start.s, 0.0, 0.0, 0.0, 0.0, 0.0, "global", start)
        return Following(MotionDemand(0.0, 0.0, 0.0), at, 0.0, False, True)

    def achieved(self, given: MotionDemand) -> None:
        """What the allocator reached of the last demand."""
        if self._last is not None:
            self.law.achieved(self._last.demand, given)

    def preview(self, times: Sequence[float]) -> Preview:
        """Feed-forward demands, speeds and yaw rates at `times` (s, not negative) from now, as if the car were on its trajectory.

        Before the first step that is at the start. Beyond the end of an open path the car stands.
        """
        trajectory = self.trajectory
        now = trajectory.point(self.projection.s)
        demands, speeds, yaw_rates = [], [], []
        for time in times:
            t = now.t + max(float(time), 0.0)
            over = not trajectory.closed and t >= float(trajectory.t[-1])
            point = trajectory.point(float(trajectory.s[-1]) if over else trajectory.at_time(t))
            v, a = (0.0, 0.0) if over else (point.v, point.a)
            turn = 0.0 if over else self.projection.kappa_rate(point.s) * v * v + point.kappa * a
            state = VehicleState(point.x, point.y, point.psi, v, 0.0, point.kappa * v)
            at = Projected(point.s, 0.0, 0.0, 0.0, v, v, "newton", point)
            demands.append(self._resistances.demand(a, point.kappa * v * v, turn, state, at))
            speeds.append(v)
            yaw_rates.append(point.kappa * v)
        return Preview(demands, speeds, yaw_rates)

    def replace(self, trajectory: Trajectory) -> None:
        """Go over to a new plan where the car is; what the law has learnt of the car stays."""
        self.projection.replace(trajectory)
        self._last = None

    def snapshot(self) -> tuple[Any, ...]:
        """Everything but trajectory, vehicle and gains."""
        return self.projection.snapshot(), self.law.snapshot(), self._last, self.refused

    def restore(self, snapshot: tuple[Any, ...]) -> None:
        """Go back to a `snapshot` that was taken on the same trajectory."""
        projection, law, self._last, self.refused = snapshot
        self.projection.restore(projection)
        self.law.restore(law)


def _usual(state: VehicleState) -> bool:
    """Whether `_plausible` would leave the state as it is; what is not finite never passes."""
    x, y, psi, v_x, v_y, yaw_rate, a_x, a_y, friction = state
    return (
        -_FAR < x < _FAR
        and -_FAR < y < _FAR
        and -_FAR < psi < _FAR
        and -_FAST < v_x < _FAST
        and -_FAST < v_y < _FAST
        and -_SPIN < yaw_rate < _SPIN
        and -_FAST < a_x < _FAST
        and -_FAST < a_y < _FAST
        and 0.0 <= friction <= 2.0
    )


def _plausible(state: VehicleState) -> VehicleState:
    """The state cut to what a car can do."""
    return VehicleState(
        limited(state.x, _FAR),
        limited(state.y, _FAR),
        state.psi if abs(state.psi) < _FAR else math.remainder(state.psi, math.tau),
        limited(state.v_x, _FAST),
        limited(state.v_y, _FAST),
        limited(state.yaw_rate, _SPIN),
        limited(state.a_x, _FAST),
        limited(state.a_y, _FAST),
        min(max(state.friction, 0.0), 2.0),
    )
