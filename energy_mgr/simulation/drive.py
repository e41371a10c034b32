"""The closed loop: plant, sensors, manager, at their own rates."""

from __future__ import annotations

import math
import time
from collections import Counter
from operator import itemgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from powertrain import Plant, VehicleError
from powertrain.chassis.compiled import compiler

from ..errors import PlanningError
from ..following import PathProjection
from ..manager import DeadReckoning, EnergyManager, WheelCommands
from ..motion import VehicleState
from .events import Event, Happening
from .log import Drive, Recorder, labelled
from .sensing import SENSORS, IdealSensing, RealSensing, Sensing, Spoiled

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from powertrain import Vehicle

    from ..following import Projected
    from ..trajectory.trajectory import Trajectory

    Floats = NDArray[np.float64]

#: Farther off the trajectory than this a drive is lost, m.
LOST = 10.0
#: A car that stands for so long before its end has stopped, s.
_STOPPED = 5.0
#: From this many seconds of drive on, a step in machine code pays for its compilation.
_COMPILED = 20.0
#: The battery's own step, s.
_BATTERY = 0.02
_TRUTH = ("s_m", "e_y_m", "e_psi_rad", "v_ref_mps", "a_ref_mps2", "kappa_ref_1pm", "slope", "bank_rad", "friction")
_ASKED = ("a_x_demand_mps2", "a_y_demand_mps2", "yaw_demand_radps2", "a_x_given_mps2", "a_y_given_mps2", "yaw_given_radps2")
_REST = ("soc", "battery_power_w", "a_x_mps2", "a_y_mps2", "residual", "iterations", "step_time_s")


def simulate(
    trajectory: Trajectory,
    vehicle: Vehicle,
    *,
    manager: EnergyManager | None = None,
    follower: str = "linearising",
    allocator: str = "efficient",
    cost: str = "physical",
    sensors: str = "ideal",
    events: Sequence[Event] = (),
    offset: float = 0.0,
    soc: float = 0.7,
    seed: int = 0,
    dt: float = 1e-3,
    longest: float | None = None,
    compiled: bool | None = None,
    knows_friction: bool = False,
    report: Callable[[str], None] | None = None,
) -> Drive:
    """Drive `trajectory` with `vehicle` from its start to its end (a closed one for a lap).

    Args:
        trajectory: what to follow.
        vehicle: the car, as plant and as what the manager believes it to be.
        manager: an energy manager of your own, new or restored; by default one of the three options below.
        follower: tracking law: `linearising`, `geometric`, `pd`.
        allocator: see `energy_mgr.allocation.ALLOCATORS`.
        cost: `physical`, `heuristic`, `blended`.
        sensors: `ideal`, or `real`: the published sensors, with a dead-reckoning observer.
        events: what goes wrong.
        offset: how far to the left of the trajectory the car starts, m.
        soc: state of charge at the start.
        seed: of the sensors' noise.
        dt: step of the plant, s; the manager's period must be a multiple of it.
        longest: time allowed, s; by default twice the planned one and 30 s more.
        compiled: plant in machine code (a second once); by default for longer drives where there is a C compiler.
        knows_friction: whether ideal sensors tell the road's friction.
        report: told about progress.

    Raises:
        PlanningError: an option that does not exist, an event or a period that does not fit.
        VehicleError: the description lacks a section that the plant needs.
    """
    allowed = 2.0 * trajectory.journey_time + 30.0 if longest is None else longest
    if sensors not in SENSORS:
        raise PlanningError(f"sensors {sensors!r}, expected one of {', '.join(SENSORS)}")
    if not (math.isfinite(offset) and math.isfinite(dt) and dt > 0.0 and math.isfinite(allowed) and allowed >= dt and seed >= 0):
        found = f"offset {offset} m, dt {dt} s, longest {longest} s, seed {seed}"
        raise PlanningError(f"{found}: expected finite numbers, steps and durations above zero, and a seed of 0 or more")
    if manager is None:
        observer = DeadReckoning() if sensors == "real" else None
        manager = EnergyManager(vehicle, trajectory, follower=follower, allocator=allocator, cost=cost, observer=observer)
    elif manager.follower.trajectory is not trajectory:
        raise PlanningError(f"{trajectory.name}: the manager follows another trajectory, {manager.follower.trajectory.name}")
    options = {"follower": follower, "allocator": allocator, "cost": cost, "sensors": sensors, "seed": seed, "dt": dt}
    start = trajectory.point(float(trajectory.s[0]))
    substeps = max(round(manager.period / dt), 1)
    plant = Plant(vehicle, speed=start.v, soc=soc, dt=dt, battery_every=substeps * max(round(_BATTERY / manager.period), 1))
    loop = _Loop(trajectory, plant, manager, events, knows_friction)
    loop.place(start, offset)
    sensing: Sensing = IdealSensing(plant) if sensors == "ideal" else RealSensing(plant, np.random.default_rng(seed))
    if compiled or (compiled is None and min(trajectory.journey_time, allowed) > _COMPILED and _has_compiler()):
        plant.compile_c()
        manager.compile_c()
    began = time.perf_counter()
    outcome = loop.run(sensing, allowed, report)
    return Drive(
        vehicle, trajectory, loop.recorder.columns(), plant.ledger(), outcome, dict(loop.statuses), dict(manager.refused), manager.errors,
        loop.happening.begun, loop.noticed, np.array(loop.step_times), time.perf_counter() - began, options,
    )  # fmt: skip


def _has_compiler() -> bool:
    try:
        compiler()
    except VehicleError:
        return False
    return True


class _Loop:
    """One drive in progress."""

    def __init__(self, trajectory: Trajectory, plant: Plant, manager: EnergyManager, events: Sequence[Event], knows_friction: bool) -> None:
        self.trajectory, self.plant, self.manager = trajectory, plant, manager
        self.layout = manager.allocator.layout
        self.happening, self._spoiled, self._knows = Happening(events, self.layout), Spoiled(), knows_friction
        self._substeps = round(manager.period / plant.dt)
        if self._substeps < 1 or abs(self._substeps * plant.dt - manager.period) > 1e-9:
            raise PlanningError(f"control period {manager.period} s, expected a multiple of the plant's step of {plant.dt} s")
        self._truth = PathProjection(trajectory)
        body = plant.body
        inputs = [labelled(name, "rad" if name.startswith("steer") else "nm") for name in self.layout.names]
        states = [labelled(name) for name in body.states]
        self.recorder = Recorder(["t_s", *states, *inputs, *_TRUTH, *_ASKED, *_REST])
        self.statuses: Counter[str] = Counter()
        self.noticed: list[tuple[float, str]] = []
        self.step_times: list[float] = []
        self._friction = 1.0
        self._limits: list[tuple[int, float]] = []
        self._stuck: dict[int, float] = {}
        # a lap, or the end of a road that is not to be stopped at
        self._way = trajectory.length if trajectory.closed or trajectory.v[-1] > 0.1 else math.inf
        self._at = {name: body.states.index(name) for name in ("x", "y", "psi", "v_x", "v_y", "yaw_rate")}
        self._plane = itemgetter(*self._at.values())
        self._memory: tuple[Any, ...] | None = None

    def place(self, start: Any, offset: float) -> None:
        """Put the car beside the start."""
        x, y = start.x - offset * math.sin(start.psi), start.y + offset * math.cos(start.psi)
        self.plant.begin(x=x, y=y, psi=start.psi, yaw_rate=start.kappa * start.v)

    def run(self, sensing: Sensing, allowed: float, report: Callable[[str], None] | None) -> str:
        """Drive until something ends it."""
        plant, manager, spoiled = self.plant, self.manager, self._spoiled
        period, standing, said, begin, t = manager.period, 0.0, -10.0, float(self.trajectory.s[0]), 0.0
        before, s = self._plane(plant.state.tolist())[3:5], begin
        a_x = a_y = 0.0
        perfect = isinstance(sensing, IdealSensing)
        while t < allowed:
            if self.happening.update(t, s):
                self._apply()
            measured = spoiled.spoil(sensing.measure(t, plant, a_x, a_y, self._friction if self._knows else 1.0), self.happening.active)
            clock = time.process_time_ns()
            commands = manager.step(measured, t)
            spent = 1e-9 * (time.process_time_ns() - clock)
            self._note(t, commands)
            truth = self._located(perfect, commands)
            s = truth.s + truth.sdot * period
            self._record(t, truth, commands, (a_x, a_y), spent)
            plant.advance(self._inputs(commands, truth.point), self._substeps)
            v_x, v_y, yaw_rate = self._plane(plant.state.tolist())[3:]
            a_x, a_y = (v_x - before[0]) / period - yaw_rate * v_y, (v_y - before[1]) / period + yaw_rate * v_x
            before, t = (v_x, v_y), plant.time
            standing = standing + period if math.hypot(v_x, v_y) < 0.02 else 0.0
            if report and t - said >= 10.0:
                said = t
                report(f"driving: {truth.s - begin:.0f} of {self.trajectory.length:.0f} m")
            if ended := self._ended(truth, commands, standing):
                return ended
        return "late"

    def _ended(self, truth: Any, commands: WheelCommands, standing: float) -> str:
        if max(abs(truth.e_y), abs(truth.e_x)) > LOST:
            return "lost"
        if truth.s - self.trajectory.s[0] >= self._way or (commands.status == "arrived" and standing > 0.2):
            return "arrived"
        return "stopped" if standing > _STOPPED else ""

    def _located(self, perfect: bool, commands: WheelCommands) -> Projected:
        """The car on the trajectory in truth: what the manager has found, where that cannot be anything else."""
        following = self.manager.following
        sure = perfect and not self.happening.active and commands.status not in ("rejected", "stopping")
        projection = self.manager.follower.projection
        if sure and following is not None and projection.method == "safe":
            self._memory = projection.snapshot()
            return following.at
        if self._memory is not None:
            self._truth.restore(self._memory)
            self._memory = None
        return self._truth.update(VehicleState(*self._plane(self.plant.state.tolist())), self.manager.period)

    def _apply(self) -> None:
        """What the active events do to commands and road."""
        active, names = self.happening.active, self.layout.names
        frictions = [event.share for event in active if event.part == "friction"]
        self._friction = frictions[-1] if frictions else 1.0
        self._limits = []
        stuck: dict[int, float] = {}
        for event in active:
            if event.part.startswith(("motor_", "brake_")):
                name = event.part.replace("motor_", "torque_cmd_").replace("brake_", "brake_cmd_")
                place = names.index(name)
                self._limits.append((place, float(self.layout.upper[place]) * (event.share if event.kind == "weak" else 0.0)))
            elif event.part.startswith("steer_"):
                wheel = event.part[6:]
                place = names.index(f"steer_cmd_{wheel}")
                stuck[place] = self._stuck.get(place, float(self.plant.state[self.plant.body.states.index(f"delta_{wheel}")]))
        self._stuck = stuck

    def _inputs(self, commands: WheelCommands, point: Any) -> list[float]:
        inputs = [*commands.inputs, point.slope, math.tan(point.bank), self._friction]
        for place, most in self._limits:
            inputs[place] = min(max(inputs[place], -most), most)
        for place, angle in self._stuck.items():
            inputs[place] = angle
        return inputs

    def _note(self, t: float, commands: WheelCommands) -> None:
        self.statuses[commands.status] += 1
        if commands.reason and (not self.noticed or self.noticed[-1][1] != commands.reason):
            self.noticed.append((t, commands.reason))

    def _record(self, t: float, truth: Any, commands: WheelCommands, accelerations: tuple[float, float], spent: float) -> None:
        row, plant, point = self.recorder.next(), self.plant, truth.point
        n = 1 + len(plant.state)
        row[0], row[1:n] = t, plant.state
        following, found = self.manager.following, self.manager.allocation
        demand = (math.nan,) * 3 if following is None else following.demand
        given, residual, iterations = ((math.nan,) * 3, 0.0, 0) if found is None else (found.given, found.residual, found.iterations)
        row[n:] = (
            *commands.inputs,
            *(truth.s, truth.e_y, truth.e_psi, point.v, point.a, point.kappa, point.slope, point.bank, self._friction),
            *demand,
            *given,
            *(plant.soc, plant.power, *accelerations, residual, iterations, spent),
        )
        self.step_times.append(spent)
