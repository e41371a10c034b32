"""Slow tests: coulombic efficiency, capacity, and the open-circuit voltage of charge and discharge.

The method is that of G. L. Plett, Battery Management Systems vol. 1, chapter 2: charge that went in and came out of a closed cycle gives the
efficiency; what a full discharge took out gives the capacity; the mean of the two slow branches gives U_OCV, half their distance M.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...errors import VehicleError
from .readers import REFERENCE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .records import DynamicTest, OcvTest, Script

    Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Charge:
    """Charge balance of a test: efficiency at its temperature and at the reference temperature, capacity in A s."""

    temperature: float
    efficiency: float
    reference_efficiency: float
    capacity: float


def _sums(scripts: Sequence[Script | None]) -> tuple[float, float]:
    moved = [script.moved for script in scripts if script is not None]
    return sum(m[0] for m in moved), sum(m[1] for m in moved)


def charge_balances(tests: Sequence[OcvTest] | Sequence[DynamicTest]) -> list[Charge]:
    """Efficiency and capacity per test.

    Scripts at the reference temperature (25 degC) have its efficiency: that of a test at this temperature or, without one, the efficiency
    interpolated over the temperatures there are.

    Raises:
        VehicleError: naming every script of the test: an efficiency that is not between 0.9 and 1.01, or a capacity that is not positive.
    """
    warm = [(test, *_scripts(test)) for test in tests]
    warm.sort(key=lambda entry: entry[0].temperature)
    temperatures = np.array([test.temperature for test, _, _ in warm])
    found = np.ones(len(warm))
    for _ in range(400):  # a contraction by the share of charge that the reference scripts carry
        reference = float(np.interp(REFERENCE, temperatures, found))
        found = np.array([_efficiency(here, there, reference, abs(test.temperature - REFERENCE) < 0.5) for test, here, there in warm])
    reference = float(np.interp(REFERENCE, temperatures, found))
    balances = []
    for (test, here, there), eta in zip(warm, found.tolist(), strict=True):
        into, out = _sums(here[:1])
        into_there, out_there = _sums(there[:1])
        balance = Charge(test.temperature, eta, reference, out + out_there - eta * into - reference * into_there)
        if not 0.9 < eta < 1.01 or not balance.capacity > 0.0:
            source = ", ".join(script.source for script in (*here, *there) if script is not None)
            hours = balance.capacity / 3600.0
            raise VehicleError(f"{source}: coulombic efficiency {eta:.4f} and capacity {hours:.4g} Ah, expected 0.9 to 1.01 and above 0")
        balances.append(balance)
    return balances


def _scripts(test: OcvTest | DynamicTest) -> tuple[list[Script | None], list[Script | None]]:
    """Scripts at the test's temperature and at the reference temperature, those up to the empty cell first."""
    from .records import OcvTest

    if isinstance(test, OcvTest):
        return [test.discharge, test.charge], [test.empty, test.full]
    return [test.drive], [test.empty, test.full]


def _efficiency(here: list[Script | None], there: list[Script | None], reference: float, same: bool) -> float:
    into, out = _sums(here)
    into_there, out_there = _sums(there)
    if there == [None, None]:
        return 1.0  # the cycle is not closed: nothing can be said
    if same:
        return (out + out_there) / (into + into_there)
    return (out + out_there - reference * into_there) / into


@dataclass(frozen=True, eq=False)
class Branches:
    """Slow discharge and charge at one temperature, over rising charge, less the ohmic drop.

    Attributes:
        temperature: K.
        soc_discharge: (n,) increasing, with `discharge` (n,) in V.
        soc_charge: (m,) increasing, with `charge` (m,) in V.
    """

    temperature: float
    soc_discharge: Floats
    discharge: Floats
    soc_charge: Floats
    charge: Floats

    def mean(self, soc: Floats) -> tuple[Floats, Floats]:
        """U_OCV and M in V at `soc`; beyond the end of a branch the other one, less half the distance at that end."""
        low, high = max(self.soc_discharge[0], self.soc_charge[0]), min(self.soc_discharge[-1], self.soc_charge[-1])
        inner = np.clip(soc, low + 0.005, high - 0.02)
        half = 0.5 * (np.interp(inner, self.soc_charge, self.charge) - np.interp(inner, self.soc_discharge, self.discharge))
        half = np.maximum(half, 0.0)
        discharge, charge = np.interp(soc, self.soc_discharge, self.discharge), np.interp(soc, self.soc_charge, self.charge)
        fade = np.clip((1.0 - soc) / 0.03, 0.0, 1.0)  # a full cell has come to rest after charging
        ocv = np.where(soc > high - 0.02, discharge + half * fade, np.where(soc < low + 0.005, charge - half, 0.5 * (discharge + charge)))
        return ocv, half


def branches(test: OcvTest, balance: Charge) -> Branches:
    """The two branches of a slow test.

    Raises:
        VehicleError: a script in which no steady current flows.
    """
    down, up = test.discharge, test.charge
    into, out = _sums([test.discharge])
    into_there, out_there = _sums([test.empty])
    bottom = 1.0 - (out + out_there - balance.efficiency * into - balance.reference_efficiency * into_there) / balance.capacity
    soc_down, v_down = _branch(down, 1.0, balance, sign=1.0)
    soc_up, v_up = _branch(up, bottom, balance, sign=-1.0)
    return Branches(test.temperature, soc_down[::-1], v_down[::-1], soc_up, v_up)


def _branch(script: Script, soc0: float, balance: Charge, sign: float) -> tuple[Floats, Floats]:
    flow = sign * script.current
    active = flow > 0.5 * np.max(flow)
    if np.max(flow) <= 0.0 or np.count_nonzero(active) < 10:
        kind = "discharge" if sign > 0.0 else "charge"
        raise VehicleError(f"{script.source}: no steady {kind} current, expected a slow full {kind}")
    charged, discharged = script.charged - script.charged[0], script.discharged - script.discharged[0]
    soc = soc0 - (discharged - balance.efficiency * charged) / balance.capacity
    first, last = (int(k) for k in np.flatnonzero(active)[[0, -1]])
    jumps = []
    if first > 0:
        jumps.append(sign * (script.voltage[first - 1] - script.voltage[first]))
    if last + 1 < len(flow):
        jumps.append(sign * (script.voltage[last + 1] - script.voltage[last]))
    drop = max(min(jumps, default=0.0), 0.0)  # the smaller: at the ends a part of the jump is charge that was moved
    keep = np.flatnonzero(active)
    keep = keep[np.concatenate([[True], np.diff(-sign * soc[keep]) > 0.0])]
    return soc[keep], script.voltage[keep] + sign * drop
