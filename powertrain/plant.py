"""The whole car as a plant: double track, drives, steering, auxiliaries and battery, with an account of every joule.

Mechanics advance in fixed steps; the battery follows every few of them with the mean power that was drawn. Each flow is integrated with the weights
of the step itself, so what a component takes is what it gives, loses and keeps, to rounding; what is left over in `PlantLedger.imbalance` of the
body is the integrator's error.

    plant = Plant(load_vehicle("romo"), speed=10.0)
    for _ in range(5000):
        plant.step(plant.body.command(torque_cmd=40.0))
    print(plant.ledger())
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .battery import PackModel, load_cell
from .chassis.double_track import DoubleTrack
from .chassis.flows import ELECTRIC, FLOWS, KEPT, SINKS, SOURCES, flows, kept
from .chassis.machine import Machine
from .description.sections import Battery, Electrics
from .drive.supply import converter_input, converter_loss
from .errors import VehicleError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from .battery import PowerCurrent
    from .vehicle import Vehicle

    Floats = NDArray[np.float64]

_BATTERY = ("chemical", "terminal", "heat", "polarisation")
#: Limits of the cell that a drive may pass.
LIMITS: tuple[str, ...] = ("voltage", "current", "soc", "temperature")


class _PackOnPower:
    """The pack as a model that is asked for power."""

    inputs: tuple[str, ...] = ("power", "ambient")

    def __init__(self, pack: PackModel) -> None:
        self.pack, self.states = pack, pack.states
        self._solved: tuple[Any, Any, PowerCurrent] | None = None

    def derivative(self, x: Sequence[Any], u: Sequence[Any]) -> list[Any]:
        return self.pack.derivative(x, self._current(x, u).current, u[1])

    def flows(self, x: Sequence[Any], u: Sequence[Any]) -> list[Any]:
        """Powers in the order of `_BATTERY`, then the current and whether it gives the power."""
        found = self._current(x, u)
        return [*self.pack.powers(x, found.current), found.current, found.feasible]

    def _current(self, x: Sequence[Any], u: Sequence[Any]) -> PowerCurrent:
        # both methods are asked for the same symbols, and the expression is large
        if self._solved is None or self._solved[0] is not x or self._solved[1] is not u:
            self._solved = (x, u, self.pack.current_from_power(u[0], x))
        return self._solved[2]


@dataclass(frozen=True)
class PlantLedger:
    """The account of a drive, J.

    Attributes:
        duration: s.
        energy: by flow: those of `powertrain.chassis.flows.FLOWS`, then `auxiliary`, `converter`, and the battery's `chemical`, `terminal`, `heat`,
            `polarisation`.
        kept: change of the energy of motion, springs and pads.
        imbalance: by part (`battery`, `bus`, `body`, `whole`), what does not add up, over the energy that passed through it.
        unserved: energy that was drawn although no current of the battery gives that power.
        outside: seconds beyond each of the cell's `LIMITS`. The plant does not cut the power there: whoever drives it has to.
    """

    duration: float
    energy: dict[str, float]
    kept: float
    imbalance: dict[str, float]
    unserved: float
    outside: dict[str, float]

    def __str__(self) -> str:
        rows = [
            ("from the battery's charge", [("chemical", -1.0), ("heat", 1.0), ("polarisation", 1.0)]),
            ("supply", [("auxiliary", 1.0), ("converter", 1.0)]),
            ("drives and steering", [(name, 1.0) for name in (*ELECTRIC, "steering_work")]),
            ("resistances and tyres", [(name, 1.0) for name in SINKS]),
            ("kept", [(name, 1.0) for name in KEPT]),
        ]
        lines = [f"energy in kJ over {self.duration:.2f} s (positive: spent or kept)"]
        for title, items in rows:
            lines.append(title)
            lines += [f"  {name:16s}{sign * self.energy[name] / 1e3:12.4f}" for name, sign in items if self.energy[name] != 0.0]
        lines.append(f"  {'motion':16s}{self.kept / 1e3:12.4f}")
        lines.append("does not add up: " + ", ".join(f"{part} {share:.1e}" for part, share in self.imbalance.items()))
        if self.unserved:
            lines.append(f"beyond what the battery gives: {self.unserved / 1e3:.3f} kJ")
        if passed := {name: seconds for name, seconds in self.outside.items() if seconds > 0.0}:
            lines.append("beyond the cell's limits: " + ", ".join(f"{name} for {seconds:.2f} s" for name, seconds in passed.items()))
        return "\n".join(lines)


class Plant:
    """A car on its wheels with a charged battery."""

    def __init__(
        self,
        vehicle: Vehicle,
        *,
        speed: float = 0.0,
        soc: float = 0.9,
        temperature: float = 298.15,
        dt: float = 1e-3,
        battery_every: int = 4,
    ) -> None:
        """`vehicle` rolling straight at `speed` (m/s), charged to `soc`, all at `temperature` (K).

        Args:
            vehicle: the car.
            speed: m/s.
            soc: state of charge, 0 to 1.
            temperature: of battery and surroundings, K.
            dt: step of the mechanics, s.
            battery_every: steps of the mechanics in a step of the battery.

        Raises:
            VehicleError: the description lacks a section, or a number that makes no state.
        """
        if not (np.isfinite(speed) and 0.0 <= soc <= 1.0 and 150.0 < temperature < 500.0 and battery_every >= 1):
            found = f"speed {speed} m/s, soc {soc}, temperature {temperature} K, battery every {battery_every} steps"
            raise VehicleError(f"{vehicle.name}: {found}, expected a finite speed, soc in 0 to 1, 150 to 500 K and at least every step")
        self.body = DoubleTrack(vehicle)
        self.electrics = vehicle.need("electrics", Electrics)
        battery = vehicle.need("battery", Battery)
        self.pack = PackModel(load_cell(battery.cell), battery.series, battery.parallel, battery.thermal_resistance_kpw)
        self._machine = Machine(self.body, dt, integrands=lambda x, u: list(flows(self.body, x, u).values()))
        on_power = _PackOnPower(self.pack)
        self._battery = Machine(on_power, dt * battery_every, integrands=on_power.flows)
        self.state: Floats = np.array(self.body.initial(speed))
        self.battery_state: Floats = np.array(self.pack.rest(soc, temperature), dtype=np.float64)
        self._every, self._ambient = battery_every, temperature
        self._steps, self._unserved, self._owed = 0, 0.0, 0.0
        self._spent = np.zeros(len(FLOWS))
        self._turned = np.zeros(len(FLOWS))
        self._cell = np.zeros(len(_BATTERY))
        self._outside = dict.fromkeys(LIMITS, 0.0)
        self._before = kept(self.body, list(self.state))
        self._electric = np.array([float(name in (*ELECTRIC, "motor", "steering_work")) for name in FLOWS])
        self._auxiliary = float(converter_input(self.electrics, self.electrics.auxiliary_w))
        #: mean power at the battery's terminals in its last step, W
        self.power = 0.0

    @property
    def time(self) -> float:
        """Time since the start, s."""
        return self._steps * self._machine.dt

    @property
    def soc(self) -> float:
        """State of charge."""
        return float(self.battery_state[0])

    @property
    def dt(self) -> float:
        """Step of the mechanics, s."""
        return self._machine.dt

    def compile_c(self) -> None:
        """Turn the mechanics into machine code: about a second once, then a third of the time.

        Raises:
            VehicleError: there is no C compiler, or it refused.
        """
        self._machine.compile_scalar()

    def begin(self, **values: float) -> None:
        """Put states of the body in place, by name, before the first step: the account counts from there.

        Raises:
            ValueError: a name that is no state.
        """
        for name, value in values.items():
            self.state[self.body.states.index(name)] = value
        self._before = kept(self.body, list(self.state))

    def named(self) -> dict[str, float]:
        """The states of the body by name."""
        return {name: float(value) for name, value in zip(self.body.states, self.state, strict=True)}

    def step(self, command: ArrayLike) -> None:
        """Advance by one step under `command`, inputs in the order of `self.body.inputs`."""
        self.state = self._machine.step(self.state, command)
        drawn = self._machine.integrals
        self._spent += drawn
        self._turned += np.abs(drawn)
        self._steps += 1
        self._owed += float(drawn @ self._electric)
        if self._steps % self._every == 0:
            self._draw()

    def advance(self, command: ArrayLike, steps: int) -> None:
        """Advance by `steps` under `command`: as `step` so many times, in half the time.

        Raises:
            VehicleError: more steps than are left until the battery's own next step.
        """
        left = self._every - self._steps % self._every
        if not 1 <= steps <= left:
            raise VehicleError(f"advance by {steps} steps, expected 1 to {left}: then the battery's step is due")
        self.state = self._machine.advance(self.state, command, steps)
        self._spent += self._machine.integrals
        self._turned += self._machine.turned
        self._owed += float(self._machine.integrals @ self._electric)
        self._steps += steps
        if steps == left:
            self._draw()

    def _draw(self) -> None:
        """Let the battery give what the last steps took."""
        power = self._owed / self._battery.dt + self._auxiliary
        self.battery_state = self._battery.step(self.battery_state, [power, self._ambient])
        drawn = self._battery.integrals
        self._cell += drawn[: len(_BATTERY)]
        self.power = float(drawn[1]) / self._battery.dt
        self._watch(float(drawn[1]), float(drawn[4]))
        self._unserved += max(power * self._battery.dt - float(drawn[1]), 0.0) if drawn[5] < self._battery.dt * (1.0 - 1e-9) else 0.0
        self._owed = 0.0

    def _watch(self, energy: float, charge: float) -> None:
        """Count the time outside of the cell's limits, from the last step's energy (J) and charge (As) at the terminals."""
        limits, dt = self.pack.cell.limits, self._battery.dt
        current = charge / dt / self.pack.parallel
        voltage = energy / charge / self.pack.series if charge != 0.0 else limits.voltage_min_v
        soc, temperature = float(self.battery_state[0]), float(self.battery_state[-1])
        beyond = (
            not limits.voltage_min_v <= voltage <= limits.voltage_max_v,
            not -limits.charge_peak_a <= current <= limits.discharge_peak_a,
            not limits.soc_min <= soc <= limits.soc_max,
            not limits.temperature_min_degc <= temperature - 273.15 <= limits.temperature_max_degc,
        )
        for name, outside in zip(LIMITS, beyond, strict=True):
            self._outside[name] += dt * outside

    def ledger(self) -> PlantLedger:
        """The account up to the last step of the battery."""
        energy: dict[str, float] = dict(zip(FLOWS, (float(value) for value in self._spent), strict=True))
        energy |= dict(zip(_BATTERY, (float(value) for value in self._cell), strict=True))
        whole = (self._steps // self._every) * self._battery.dt
        energy["auxiliary"] = self.electrics.auxiliary_w * whole
        energy["converter"] = float(converter_loss(self.electrics, self.electrics.auxiliary_w)) * whole
        change = float(kept(self.body, list(self.state))) - float(self._before)
        drives = float(self._spent @ self._electric)
        gaps = {
            "battery": energy["chemical"] - energy["terminal"] - energy["heat"] - energy["polarisation"],
            "bus": energy["terminal"] + self._unserved - energy["auxiliary"] - energy["converter"] - (drives - self._owed),
            "body": sum(energy[name] for name in SOURCES) - sum(energy[name] for name in (*SINKS, *KEPT)) - change,
        }
        passed = {"battery": sum(abs(energy[name]) for name in _BATTERY), "bus": 2.0 * abs(energy["terminal"]), "body": float(np.sum(self._turned))}
        imbalance = {name: abs(gap) / max(passed[name], 1e-9) for name, gap in gaps.items()}
        imbalance["whole"] = abs(sum(gaps.values())) / max(passed["battery"] + passed["body"], 1e-9)
        return PlantLedger(self.time, energy, change, imbalance, self._unserved, dict(self._outside))
