"""A manager on a road, measurements of a car that does what the road asks, and a plant to drive."""

import math

import numpy as np

from energy_mgr import Trajectory
from energy_mgr.allocation import Layout
from energy_mgr.manager import EnergyManager, Measurements
from powertrain import Plant
from tests.energy_mgr.following.rig import straight

DT = 0.004


def rolling(k: int, v=10.0, radius=0.27365, layout: Layout | None = None, **more) -> Measurements:
    """After k periods of rolling along +x; drives and steering report zero where there is a layout."""
    motors, steered = ((0.0,) * layout.motors, (0.0,) * len(layout.steered)) if layout else ((), ())
    return Measurements(DT * k, v * DT * k, 0.0, 0.0, v, 0.0, 0.0, wheel_speeds=(v / radius,) * 4, torques=motors, angles=steered)._replace(**more)


def rolled(vehicle, steps=10, **options) -> EnergyManager:
    """A manager that has seen `steps` good measurements."""
    manager = EnergyManager(vehicle, straight(), **options)
    for k in range(steps):
        assert manager.step(rolling(k), DT * k).status in ("solved", "limited")
    return manager


def assert_allowed(manager, commands, before, speed=10.0):
    """Finite, and reached from the last commands within rates and envelopes."""
    vehicle, layout = manager.vehicle, manager.allocator.layout
    values = np.array(commands.inputs)
    assert np.all(np.isfinite(values)), commands
    spin = speed / vehicle.chassis.wheel_radius_m
    low, high = layout.box(list(before.inputs), (spin,) * 4, DT, layout.packed(manager.faults).tolist())
    assert np.all(values >= np.array(low) - 1e-9)
    assert np.all(values <= np.array(high) + 1e-9)


class Loop:
    """Plant, manager and perfect measurements, period by period."""

    def __init__(self, manager: EnergyManager, road: Trajectory, *, soc=0.7, window=(-60e3, 60e3), report=True) -> None:
        start = road.point(float(road.s[0]))
        self.manager, self.road, self.window, self.report = manager, road, window, report
        self.plant = Plant(manager.vehicle, speed=start.v, soc=soc, battery_every=20)
        states = self.plant.body.states
        self.at = {name: states.index(name) for name in ("x", "y", "psi", "v_x", "v_y", "yaw_rate")}
        state = self.plant.state
        state[self.at["x"]], state[self.at["y"]], state[self.at["psi"]] = start.x, start.y, start.psi
        state[self.at["yaw_rate"]] = start.kappa * start.v
        self.spins = [states.index(f"omega_{wheel}") for wheel in ("fl", "fr", "rl", "rr")]
        self.torques = [states.index(f"torque_{motor}") for motor in self.plant.body.motors]
        self.angles = [states.index(f"delta_{wheel}") for wheel in self.plant.body.steered]
        self.before, self.a = (start.v, 0.0), (0.0, 0.0)
        self.s = float(road.s[0])
        self.periods = 0

    def measured(self) -> Measurements:
        q = self.plant.state.tolist()
        pick = [tuple(q[k] for k in places) if self.report or places is self.spins else () for places in (self.spins, self.torques, self.angles)]
        return Measurements(self.periods * DT, *(q[k] for k in self.at.values()), *self.a, *pick, self.plant.soc, *self.window)

    def period(self, change=lambda inputs, t: inputs, spoil=lambda m: m):
        """One control period; `change` is what actuators make of their commands."""
        t = self.periods * DT
        commands = self.manager.step(spoil(self.measured()), t)
        point = self.road.point(min(max(commands.s, float(self.road.s[0])), float(self.road.s[-1])))
        self.plant.advance(change([*commands.inputs, point.slope, math.tan(point.bank), 1.0], t), 4)
        v_x, v_y, yaw = (self.plant.state[self.at[name]] for name in ("v_x", "v_y", "yaw_rate"))
        self.a = (float((v_x - self.before[0]) / DT - yaw * v_y), float((v_y - self.before[1]) / DT + yaw * v_x))
        self.before = (float(v_x), float(v_y))
        self.periods += 1
        return commands

    @property
    def speed(self) -> float:
        return math.hypot(*self.before)
