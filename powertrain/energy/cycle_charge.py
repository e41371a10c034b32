"""Drive cycles out of a battery: charge, voltage and current under a cycle's power, and how far a charge goes.

The pack is a lumped one at one temperature, which is held: warming is not followed. What the battery does not take, the friction brakes do; what
it does not give is missing, and named.

    cycle = roads.cycles.load("wltc_3b")
    ledger = charge_over_cycle(vehicle, cycle.t, cycle.v, soc=0.9, until="empty")
    ledger.range, ledger.cycles, ledger.end
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from ..battery.tables import smallest
from ..description.sections import Battery
from ..errors import VehicleError
from .cycle import CycleLedger, Demand, cycle_demand

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ..vehicle import Vehicle
    from .cycle_step import PowerStep, Served

    Floats = NDArray[np.float64]

#: Longer intervals are driven in equal parts of at most this many seconds.
LONGEST = 10.0
#: Intervals that one call drives at most: some ten seconds of work.
MOST = 500_000
#: A cycle that is repeated has to end as fast as it began, to this share of its energy.
_JUMP = 1e-3


class Shortfall(NamedTuple):
    """Where the battery first could not do what the cycle asked for.

    Attributes:
        time: s since the start, beginning of that interval.
        distance: m since the start.
        reason: the limit of the cell that was in the way: "soc", "voltage", "current", or "power" (more than the resistance lets through).
    """

    time: float
    distance: float
    reason: str


@dataclass(frozen=True, eq=False)
class ChargeLedger:
    """The account of a battery over a cycle, or over as many as it lasts for. Arrays are read-only.

    n is the number of the cycle's times (more if intervals are longer than `LONGEST`, as many times more as cycles are driven).

    Attributes:
        cycle: the account of the cycle once, at the terminals, as if the battery gave and took everything.
        time: (n,) s since the start.
        distance: (n,) m since the start.
        speed: (n,) m/s.
        soc: (n,) state of charge.
        voltage: (n,) at the terminals under the current that begins, V; the last one under the current before.
        current: (n-1,) of the pack, A, positive on discharge.
        power: (n-1,) that the battery gave, W, negative where it was charged.
        components: energy in J by where it went; they add up to `energy + unserved`. `brake` holds what the battery refused, too.
        energy: given at the terminals, J, recuperation deducted.
        loss: heat and polarisation inside of the pack, J; `energy + loss` is what the charge held (charge that a coulombic efficiency below 1 does
            not let in is in neither).
        heat: of it the heat of the resistances, J.
        charge_ah: charge drawn from the pack, Ah.
        unserved: driving energy that the battery did not give, J. The cycle goes on as if it had.
        refused: recuperated energy that the battery did not take and the friction brakes did, J, at the terminals: the motors' losses count as
            if it had been taken.
        shortage: where power for driving was first not met, or None.
        refusal: where recuperation was first not taken, or None.
        end: "cycle done", or the reason for which it ended before: that of `shortage`; "soc" is an empty battery.
        range: with `until="empty"` the way driven, m; else the way to the cell's least charge if all goes on like this cycle, None where its charge
            does not fall or its power was not met.
    """

    cycle: CycleLedger
    time: Floats
    distance: Floats
    speed: Floats
    soc: Floats
    voltage: Floats
    current: Floats
    power: Floats
    components: dict[str, float]
    energy: float
    loss: float
    heat: float
    charge_ah: float
    unserved: float
    refused: float
    shortage: Shortfall | None
    refusal: Shortfall | None
    end: str
    range: float | None

    @property
    def cycles(self) -> float:
        """Cycles driven, the last one by its way."""
        return float(self.distance[-1]) / self.cycle.distance


def charge_over_cycle(
    vehicle: Vehicle, t: ArrayLike, v: ArrayLike, slope: ArrayLike = 0.0, *, soc: float, temperature: float = 298.15,
    until: Literal["once", "empty"] = "once",
) -> ChargeLedger:  # fmt: skip
    """The battery of `vehicle`, at rest at first, under the power of a cycle (`drive_cycle`): once, or until it is empty.

    Power holds over each interval. The limits are those of the cell: charge, voltage, current (peak and steady).

    Args:
        vehicle: the car, with a battery.
        t: (n,) times, s.
        v: (n,) speeds, m/s.
        slope: dz/ds, one or one per interval.
        soc: charge at the start, 0 to 1.
        temperature: of the cells, K, within the range in which they were identified.
        until: "once", or "empty": repeat the cycle until a power for driving is not met, be it for the least charge or another limit.

    Raises:
        VehicleError: what `drive_cycle` refuses, no battery, a charge or temperature that makes no state, more than `MOST` intervals; with
            "empty" a cycle that draws no energy or ends at another speed than it begins.
    """
    if until not in ("once", "empty"):
        raise VehicleError(f"charge over a cycle until {until!r}, expected 'once' or 'empty'")
    demand = cycle_demand(vehicle, t, v, slope)
    parts = _Parts.of(np.asarray(t, dtype=np.float64), np.asarray(v, dtype=np.float64))
    cycle = demand.ledger()
    step = _step(vehicle, soc, temperature)
    most = 1 if until == "once" else _most_cycles(vehicle, cycle, parts.speed, step, soc, len(parts.dt))
    inputs = step.inputs(cycle.power[parts.of_interval], parts.dt)
    state, held, runs = np.array(step.pack.rest(soc, temperature)[:-1], dtype=np.float64), 0.0, []
    for _ in range(most):
        served, held = step.drive(state, inputs, held, stop=until == "empty")
        runs.append(served)
        state = served.states[-1]
        if len(served.seen) < len(inputs):
            break
    else:
        if until == "empty":
            raise VehicleError(f"{vehicle.name}: the battery is not empty after {most} cycles, expected a cycle that draws charge")
    return _ledger(step, demand, cycle, parts, runs, until)


@dataclass(frozen=True, eq=False)
class _Parts:
    """A cycle in parts that are short enough: durations (m,), the interval each belongs to, times, ways and speeds (m+1,) from the start."""

    dt: Floats
    of_interval: NDArray[np.int64]
    time: Floats
    distance: Floats
    speed: Floats

    @classmethod
    def of(cls, t: Floats, v: Floats) -> _Parts:
        t = t - t[0]
        whole = np.diff(t)
        many = np.maximum(np.ceil(whole / LONGEST - 1e-9), 1.0)
        if np.sum(many) > MOST:
            raise VehicleError(
                f"a cycle of {t[-1]:g} s in {len(whole)} intervals has {np.sum(many):.0f} parts of {LONGEST:g} s, expected at most {MOST}"
            )
        count = many.astype(np.int64)
        which = np.repeat(np.arange(len(whole)), count)
        place = (np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)) / many[which]
        time, speed = np.append(t[which] + place * whole[which], t[-1]), np.append(v[which] + place * np.diff(v)[which], v[-1])
        way = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))])
        return cls(np.diff(time), which, time, way, speed)


def _step(vehicle: Vehicle, soc: float, temperature: float) -> PowerStep:
    from ..battery import PackModel, load_cell
    from ..battery.availability import unknown_temperature
    from ..battery.cell import frozen_at
    from .cycle_step import PowerStep

    battery = vehicle.need("battery", Battery)
    cell = load_cell(battery.cell)
    if not 0.0 <= soc <= 1.0:
        raise VehicleError(f"{vehicle.name}: soc is {soc}, expected 0 to 1")
    low, high = (degc + 273.15 for degc in cell.validity.temperature_degc)
    if not np.isfinite(temperature) or unknown_temperature(cell, temperature):
        raise VehicleError(f"{vehicle.name}: battery at {temperature} K, expected {low:g} to {high:g}, where cell {cell.name} was identified")
    pack = PackModel(frozen_at(cell, float(temperature)), battery.series, battery.parallel)
    return PowerStep(pack, float(temperature))


def _most_cycles(vehicle: Vehicle, cycle: CycleLedger, v: Floats, step: PowerStep, soc: float, parts: int) -> int:
    """How many cycles the battery lasts for at most.

    Raises:
        VehicleError: a cycle that cannot be repeated, or would be too often.
    """
    if not cycle.energy > 0.0:
        raise VehicleError(f"{vehicle.name}: the cycle draws {cycle.energy / 1e3:.4g} kJ from the battery, which never empties it; expected above 0")
    jump = 0.5 * vehicle.effective_mass * float(v[-1] ** 2 - v[0] ** 2)
    if abs(jump) > _JUMP * cycle.energy:
        raise VehicleError(f"{vehicle.name}: the cycle begins at {v[0]:g} m/s and ends at {v[-1]:g} m/s, expected equal speeds for repeating it")
    cell, count = step.pack.cell, step.pack.count
    charge = max(soc - cell.limits.soc_min, 0.0) * cell.capacity / smallest(cell.capacity_correction)
    # a tenth to spare for cells whose voltage passes the limit at rest
    most = 1.1 * charge * cell.limits.voltage_max_v * count / cycle.energy + 2.0
    if most * parts > MOST:
        raise VehicleError(f"{vehicle.name}: until empty up to {most:.3g} cycles of {parts} intervals, expected at most {MOST} intervals in all")
    return int(most)


def _ledger(step: PowerStep, demand: Demand, cycle: CycleLedger, parts: _Parts, runs: list[Served], until: str) -> ChargeLedger:
    from .cycle_step import CURRENT, HEAT, POLARISATION, TERMINAL, VOLTAGE, VOLTAGE_AFTER

    seen, share = np.concatenate([run.seen for run in runs]), np.concatenate([run.share for run in runs])
    states = np.concatenate([runs[0].states[:1], *(run.states[1:] for run in runs)])
    done, size = len(seen), len(parts.dt)
    place = np.arange(done) % size
    dt, lap = parts.dt[place], np.arange(done + 1) // size
    wrapped = np.append(place, done % size)
    if done and done % size == 0:  # the end of a cycle, not the beginning of the next
        lap[-1], wrapped[-1] = lap[-1] - 1, size
    asked = cycle.power[parts.of_interval[place]]
    missing = (1.0 - share) * asked * dt
    unserved, refused = float(np.sum(np.maximum(missing, 0.0))), float(np.sum(np.fmax(-missing, 0.0)))
    components = {name: float(np.sum(row[parts.of_interval[place]] * dt)) for name, row in demand.components.items()}
    components["brake"] += refused
    final = seen[-1, VOLTAGE_AFTER] if done else float(step.pack.voltage([*states[0], step.temperature], 0.0))
    time, distance = (row[wrapped] + lap * row[-1] for row in (parts.time, parts.distance))
    shortage, refusal = _first(runs, parts, cycle.power, time, distance)
    soc, current, power = states[:, 0], seen[:, CURRENT], seen[:, TERMINAL]
    heat, polarisation = (float(np.sum(seen[:, column] * dt)) for column in (HEAT, POLARISATION))
    return ChargeLedger(
        cycle=cycle, time=_read_only(time), distance=_read_only(distance), speed=_read_only(parts.speed[wrapped]), soc=_read_only(soc),
        voltage=_read_only(np.append(seen[:, VOLTAGE], final)), current=_read_only(current), power=_read_only(power), components=components,
        energy=float(np.sum(power * dt)), loss=heat + polarisation, heat=heat, charge_ah=float(np.sum(current * dt)) / 3600.0,
        unserved=unserved, refused=refused, shortage=shortage, refusal=refusal,
        end=shortage.reason if until == "empty" and shortage else "cycle done",
        range=float(distance[-1]) if until == "empty" else _expected(step, soc, cycle.distance, shortage),
    )  # fmt: skip


def _read_only(array: Floats) -> Floats:
    own = np.array(array)
    own.setflags(write=False)
    return own


def _first(runs: list[Served], parts: _Parts, power: Floats, time: Floats, distance: Floats) -> tuple[Shortfall | None, Shortfall | None]:
    """The first interval in which driving, and in which recuperation was not met in full."""
    size, shortage, refusal = len(parts.dt), None, None
    for lap, run in enumerate(runs):
        for k, reason in run.events:
            event = Shortfall(float(time[lap * size + k]), float(distance[lap * size + k]), reason)
            if power[parts.of_interval[k]] > 0.0:
                shortage = shortage or event
            else:
                refusal = refusal or event
    return shortage, refusal


def _expected(step: PowerStep, soc: Floats, way: float, shortage: Shortfall | None) -> float | None:
    """How far the charge above the least goes at the charge per way of this cycle."""
    least, before, after = step.pack.cell.limits.soc_min, float(soc[0]), float(soc[-1])
    if before <= least:
        return 0.0
    return (before - least) * way / (before - after) if before > after and shortage is None else None
