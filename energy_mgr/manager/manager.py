"""The energy manager: the closed loop of observing, following and allocating, one `step` per control period (G1).

    manager = EnergyManager(load_vehicle("romo"), plan.trajectory)
    commands = manager.step(measurements, t)

A step does a fixed amount of work, keeps nothing that grows, and does not raise: a measurement that cannot be believed is counted and answered with
the last safe command, as far as the actuators' limits allow it now; after some time without a good one the car is braked to a stop.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from powertrain.description.sections import Electrics
from powertrain.drive.supply import converter_input
from powertrain.vehicle import GRAVITY

from ..allocation import ALLOCATORS, NO_FAULTS, Ahead, Allocation, Faults, Situation
from ..errors import PlanningError
from ..following import Follower
from .guard import Guard, Trust
from .measurements import Measurements, WheelCommands
from .monitor import Monitor
from .observers import Observer, PerfectState

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from powertrain import Vehicle

    from ..allocation import Allocator
    from ..trajectory.trajectory import Trajectory

    Floats = NDArray[np.float64]

#: Deceleration of a blind stop, and the one that holds a car that has arrived, m/s^2.
_STOP, _HOLD = 3.0, 1.5
#: Share of the planned speed with stuck steering.
_LIMP = 0.6


class EnergyManager:
    """Follows a trajectory with a car, with the least losses.

    Attributes:
        follower: where the car is on the trajectory and what it shall do.
        allocator: how the actuators share it.
        faults: actuators that were found not to obey.
        refused: how often measurements were refused, by reason.
        errors: how often a step failed on a measurement that had been believed, which should be never.
        last_error: what the last of these was.
        following: the answer of the follower in the last good step, None before.
        allocation: the answer of the allocator in the last good step, None before.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        trajectory: Trajectory,
        *,
        follower: str | Follower = "linearising",
        allocator: str | Allocator = "efficient",
        cost: str = "physical",
        observer: Observer | None = None,
        trust: Trust | None = None,
        period: float = 0.004,
        horizon: tuple[float, ...] = (),
    ) -> None:
        """The manager of one car on one trajectory.

        Args:
            vehicle: the car.
            trajectory: what to follow.
            follower: a tracking law by name (`linearising`, `geometric`, `pd`), or a follower of your own.
            allocator: by name (see `energy_mgr.allocation.ALLOCATORS`), or one of your own.
            cost: what the allocator saves: `physical`, `heuristic` or `blended`.
            observer: makes the state out of measurements; by default they are the state.
            trust: which measurements are believed.
            period: of control, s.
            horizon: times (s) at which an allocator that looks ahead is told the demands to come; by default those that it asks for.

        Raises:
            VehicleError: the description lacks a section that this needs.
            PlanningError: no law or allocator of that name, or a period that is not positive.
        """
        if not (math.isfinite(period) and period > 0.0):
            raise PlanningError(f"control period of {period} s, expected a positive one")
        if isinstance(allocator, str) and allocator not in ALLOCATORS:
            raise PlanningError(f"allocator {allocator!r}, expected one of {', '.join(ALLOCATORS)}")
        self.vehicle, self.period = vehicle, period
        self.follower = Follower(trajectory, vehicle, law=follower) if isinstance(follower, str) else follower
        self.allocator: Allocator = ALLOCATORS[allocator](vehicle, cost=cost, dt=period) if isinstance(allocator, str) else allocator
        self._horizon = horizon or tuple(getattr(self.allocator, "horizon", ()))
        self._observer: Observer = observer or PerfectState()
        layout = self.allocator.layout
        self._guard, self._monitor = Guard(trust or Trust(), 4, layout.motors, len(layout.steered)), Monitor(layout, period)
        self._patience = (trust or Trust()).patience
        electrics = vehicle.electrics
        self._auxiliary = float(converter_input(electrics, electrics.auxiliary_w)) if isinstance(electrics, Electrics) else 0.0
        self.errors, self.last_error = 0, ""
        self.following: Any = None
        self.allocation: Allocation | None = None
        self._before: Floats = np.zeros(layout.size)
        self._known = NO_FAULTS
        self._trust = trust or Trust()
        self._missed = 0
        self._clock, self._lost, self._s, self._arrived, self._speed = -math.inf, 0, 0.0, False, 0.0

    @property
    def faults(self) -> Faults:
        """Actuators that were found not to obey."""
        return self._monitor.faults

    @property
    def refused(self) -> dict[str, int]:
        """How often measurements were refused, by reason."""
        return self._guard.refused

    def replace(self, trajectory: Trajectory) -> None:
        """Go over to a new plan where the car is; a car that had arrived drives on."""
        self.follower.replace(trajectory)
        self._arrived = False

    def clear_faults(self) -> None:
        """Believe all actuators again, as after a repair."""
        self._monitor.clear()

    def step(self, measurements: Measurements, t: float) -> WheelCommands:
        """The commands for the period that begins at `t` (s)."""
        try:
            if t < self._clock - self._trust.age:
                self._guard.forget()  # the clock was set back: what is remembered has times that will not come again
            self._clock = float(t) if math.isfinite(t) else self._clock
            reason = self._guard.reason(measurements, t)
            if reason:
                self._missed += 1
                return self._without(reason)
            return self._with(measurements, t)
        except Exception as error:  # a car in motion cannot be left without commands, whatever this is
            self.errors += 1
            self.last_error = f"{type(error).__name__}: {error}"
            return self._without(self.last_error)

    def _with(self, m: Measurements, t: float) -> WheelCommands:
        """Commands from a measurement that is believed."""
        state = self._observer.update(m, t)
        faults = self._monitor.update(self._before.tolist(), m.torques, m.angles, m.brakes)
        if faults is not self._known:
            self._adapt(faults)
        if self._lost * self.period > self._patience:
            self.follower.law.reset()  # what was braked blindly is no disturbance
        following = self.follower.step(state, self.period * (1 + self._missed))
        self._missed = 0
        self.following, self._s, self._speed = following, following.at.s, m.v_x
        if following.done or self._arrived:
            self._arrived, self._lost = True, 0
            return self._halted("arrived", _HOLD, self._named(faults))
        spins = m.wheel_speeds if len(m.wheel_speeds) else (m.v_x / self.vehicle.chassis.wheel_radius_m,) * 4
        now = Situation(
            state,
            following.demand,
            self._before,
            spins,
            faults,
            m.power_min - self._auxiliary,
            m.power_max - self._auxiliary,
            self.period,
            self._ahead(),
        )
        found = self.allocation = self.allocator.allocate(now)
        self.follower.achieved(found.given)
        if found.status == "held":
            return self._without("no allocation passed its check")
        self._lost = 0
        self._before = found.command
        return self._commands(found.status, self._named(faults))

    def _adapt(self, faults: Faults) -> None:
        """Let the tracking law know: a wheel that is stuck rolls along if the car is turned by its angle, and is easier to hold when slower."""
        self._known = faults
        stuck = [angle for angle in faults.stuck if angle is not None]
        self.follower.law.adapt(sum(stuck) / len(stuck) if stuck else 0.0, _LIMP if stuck else 1.0)

    def _ahead(self) -> tuple[Ahead, ...]:
        if not self._horizon:
            return ()
        seen = self.follower.preview(self._horizon)
        return tuple(Ahead(*row) for row in zip(self._horizon, seen.demands, seen.speeds, seen.yaw_rates, strict=True))

    def _without(self, reason: str) -> WheelCommands:
        """The last safe command, or the blind stop. Periods are counted, since clocks may lie."""
        self._lost += 1
        if self._lost * self.period > self._patience:
            return self._halted("stopping", _STOP, reason)
        return self._commands("rejected", reason)

    def _halted(self, status: str, deceleration: float, reason: str) -> WheelCommands:
        """Motors let go and brakes closed as fast as they can, wheels kept where they point."""
        layout, before = self.allocator.layout, self._before
        speed = self._speed / self.vehicle.chassis.wheel_radius_m
        shares = layout.packed(self.faults).tolist()
        low, high = layout.box(before.tolist(), (speed,) * 4, self.period, shares)
        wanted = np.zeros(layout.size)
        wanted[layout.steers] = before[layout.steers]
        # what brakes are left share the work, and the slope is held as well
        brakes = layout.upper[layout.brakes] * shares[layout.motors : layout.motors + 4]
        slope = 0.0 if self.following is None else abs(self.following.at.point.slope)
        most = self.vehicle.chassis.mass_kg * self.vehicle.chassis.wheel_radius_m * (deceleration + GRAVITY * slope)
        wanted[layout.brakes] = most * brakes / max(float(np.sum(brakes)), 1e-9)
        self._before = np.clip(wanted, low, high)
        return self._commands(status, reason)

    def _commands(self, status: str, reason: str) -> WheelCommands:
        layout, values = self.allocator.layout, self._before.tolist()
        brakes = layout.brakes
        return WheelCommands(tuple(values[layout.torques]), tuple(values[brakes]), tuple(values[layout.steers]), status, reason, self._s)

    def _named(self, faults: Faults) -> str:
        """The actuators at fault, for people."""
        if faults is NO_FAULTS:
            return ""
        layout, names = self.allocator.layout, self.allocator.layout.names
        parts = [f"motor {k + 1} gives {share:.0%}" for k, share in enumerate(faults.motors) if share != 1.0]
        parts += [f"brake {names[layout.brakes.start + k][10:]} gives {share:.0%}" for k, share in enumerate(faults.brakes) if share != 1.0]
        parts += [f"steering {names[layout.steers.start + k][10:]} stuck" for k, angle in enumerate(faults.stuck) if angle is not None]
        return ", ".join(parts)

    def compile_c(self) -> None:
        """Let the allocator run as machine code, if it can: a second or two once; answers then differ in their last digits.

        Raises:
            VehicleError: there is no C compiler, or it refused.
        """
        compile_c = getattr(self.allocator, "compile_c", None)
        if compile_c is not None:
            compile_c()

    def snapshot(self) -> dict[str, Any]:
        """Everything that the next steps depend on, as plain data. This and a restored manager go on alike, to the last digit."""
        return {
            "before": self._before.tolist(),
            "clock": self._clock,
            "lost": self._lost,
            "missed": self._missed,
            "s": self._s,
            "speed": self._speed,
            "arrived": self._arrived,
            "errors": self.errors,
            "guard": self._guard.snapshot(),
            "monitor": self._monitor.snapshot(),
            "observer": self._observer.snapshot(),
            "follower": self.follower.snapshot(),
            "allocator": self.allocator.snapshot(),
        }

    def restore(self, memory: dict[str, Any]) -> None:
        """Take up what `snapshot` gave; vehicle, trajectory and options must be the same."""
        self._before = np.array(memory["before"], dtype=np.float64)
        self._known = NO_FAULTS
        self._clock, self._lost, self._missed, self._s = memory["clock"], memory["lost"], memory["missed"], memory["s"]
        self._speed, self._arrived = memory["speed"], memory["arrived"]
        self.errors = memory["errors"]
        for part, name in ((self._guard, "guard"), (self._monitor, "monitor"), (self._observer, "observer"), (self.follower, "follower")):
            part.restore(memory[name])
        self._known = self._monitor.faults
        self.allocator.restore(memory["allocator"])
