"""A journey that the battery can make: power limits follow the charge along the way (B3), and the drive slows down until the charge lasts.

The source proposes to reduce speed and acceleration step by step until the journey is feasible. Here the arrival is put off just so far that the
charge lasts; where not even the thriftiest drive arrives, the error says how far it gets.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from powertrain import KWH, Vehicle
from powertrain.battery import load_cell, states
from powertrain.battery.availability import available_power, published_power
from powertrain.description.sections import Battery
from powertrain.energy.cycle_charge import ChargeLedger, charge_over_cycle

from ..errors import InfeasibleError, PlanningError, SolverError
from .bounds.forces import ElectricPower
from .bounds.parts import BatteryPower
from .checks import arrival_times
from .fastest.forward_backward import refuse_too_early
from .result import SpeedProfile
from .thriftiest.eco import EcoSolver

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .bounds.speed_limits import SpeedLimits

    Floats = NDArray[np.float64]

#: Charges at which powers are looked up, as distances from the cell's least and largest charge, and between; linear in between.
_NEAR_ENDS, _SPACING = (0.0, 0.005, 0.01, 0.02, 0.05), 0.1
#: For how long the powers must hold, s.
_HORIZON = 10.0
#: Rounds of limits and charge; they end when the charge changes by less than the second figure anywhere.
_ROUNDS, _SETTLED = 12, 5e-4
#: The arrival is put off to within this fraction of itself.
_TIME_ACCURACY = 2e-3


@dataclass(frozen=True, eq=False)
class BatteryDrive:
    """A drive with its battery.

    Attributes:
        profile: the speed.
        limits: with the power that the battery gives and takes along this drive.
        soc: (n,) charge at the stations.
        charge: the battery's account.
        asked_time: arrival time asked for, s; the profile's is later where the charge would not have lasted.
        rounds: of power limits and charge.
    """

    profile: SpeedProfile
    limits: SpeedLimits
    soc: Floats
    charge: ChargeLedger
    asked_time: float
    rounds: int

    @property
    def put_off(self) -> float:
        """By how much the arrival was put off for the charge to last, s."""
        return max(self.profile.journey_time - self.asked_time, 0.0)


def battery_powers(vehicle: Vehicle, soc: Floats, temperature: float = 298.15) -> tuple[Floats, Floats]:
    """Powers in W that the pack of `vehicle`, at rest at charges `soc` (n,), gives and takes for ten seconds (B3).

    Raises:
        VehicleError: no battery, a charge outside 0 to 1, a temperature at which the cell is not known.
    """
    battery = vehicle.need("battery", Battery)
    levels, count = _levels(battery.cell), battery.series * battery.parallel
    # a look takes half a second: only the levels on either side of the charges that occur
    near = np.unique(np.clip(np.searchsorted(levels, np.ravel(soc)), 1, len(levels) - 1))
    used = levels[np.unique(np.concatenate([near - 1, near]))]
    table = count * np.array([_powers(battery.cell, float(level), temperature) for level in used])
    return np.interp(soc, used, table[:, 0]), np.interp(soc, used, table[:, 1])


def instant_powers(vehicle: Vehicle, soc: float, temperature: float = 298.15) -> tuple[float, float]:
    """The same by the published formula (5.7), in microseconds: from charge and current alone, without what the voltage drops under load.

    Raises:
        VehicleError: no battery.
    """
    battery = vehicle.need("battery", Battery)
    cell, count = load_cell(battery.cell), battery.series * battery.parallel
    give, take = published_power(cell, [soc, *[0.0] * (len(states(cell)) - 1)], temperature, _HORIZON)
    return count * max(float(give), 0.0), count * max(-float(take), 0.0)


@lru_cache(maxsize=16)
def _levels(cell: str) -> Floats:
    limits = load_cell(cell).limits
    low, high = limits.soc_min, limits.soc_max
    between = np.arange(low + _SPACING, high - 0.5 * _SPACING, _SPACING)
    return np.unique(np.clip([0.0, *(low + x for x in _NEAR_ENDS), *between, *(high - x for x in _NEAR_ENDS), 1.0], 0.0, 1.0))


@lru_cache(maxsize=4096)
def _powers(name: str, soc: float, temperature: float) -> tuple[float, float]:
    cell = load_cell(name)
    found = available_power(cell, [soc, *[0.0] * (len(states(cell)) - 1)], temperature, horizons=(_HORIZON,))
    return found.discharge[0].power, found.charge[0].power


def battery_profile(
    limits: SpeedLimits, journey_time: float | None, soc: float, *, price: float | None = None, temperature: float = 298.15
) -> BatteryDrive:
    """The least-energy profile that the battery can make: within its power along the way, and with charge until the end.

    Args:
        limits: what else bounds the speed.
        journey_time: allowed time, s; None with a price, or for the least possible.
        soc: charge at the start, 0 to 1.
        price: of time, W, instead.
        temperature: of the cells, K.

    Raises:
        InfeasibleError: even the thriftiest drive runs out of charge: the station that it reaches, and the energy that is missing.
        PlanningError: a charge out of range.
        VehicleError: a car without a battery.
    """
    if not 0.0 <= soc <= 1.0:
        raise PlanningError(f"{limits.name}: state of charge {soc}, expected 0 to 1")
    least = _least_charge(limits.vehicle)
    if soc <= least:
        raise InfeasibleError(
            f"{limits.name}: state of charge {soc:.3f} at the start, expected more than the least of {limits.vehicle.name}'s battery, {least:.3f}, "
            "at which it gives no power"
        )
    solver = EcoSolver(limits)
    asked = solver.priced(price).journey_time if price is not None else solver.least_time if journey_time is None else journey_time
    found = _lasting(limits, asked if price is None else None, soc, price, temperature, least)
    if found is not None:
        return found
    slowest = _settled(limits, None, soc, 0.0, temperature, least)
    if not _lasts(slowest, least):
        _refuse_empty(slowest, least)
    return _put_off(limits, asked, slowest, soc, temperature)


def _least_charge(vehicle: Vehicle) -> float:
    return float(load_cell(vehicle.need("battery", Battery).cell).limits.soc_min)


def _lasts(drive: BatteryDrive, least: float) -> bool:
    return drive.charge.shortage is None and float(np.min(drive.soc)) >= least


def _lasting(
    limits: SpeedLimits,
    journey_time: float | None,
    soc: float,
    price: float | None,
    temperature: float,
    least: float,
    guess: Floats | None = None,
) -> BatteryDrive | None:
    """The drive, or None where none was found: the battery has not the power or the charge for it."""
    if journey_time is not None:
        # what the bare limits do not allow, no battery can mend
        refuse_too_early(limits.name, journey_time, EcoSolver(limits).least_time)
    try:
        found = _settled(limits, journey_time, soc, price, temperature, least, guess)
    except (InfeasibleError, SolverError):
        return None
    return found if _lasts(found, least) else None


def _settled(
    limits: SpeedLimits,
    journey_time: float | None,
    soc: float,
    price: float | None,
    temperature: float,
    least: float,
    guess: Floats | None = None,
) -> BatteryDrive:
    """Power limits from the charge along the way, the way from the power limits, until both agree or the charge runs out."""
    charge = np.full(len(limits.s), soc) if guess is None else guess
    change = np.inf
    for count in range(1, _ROUNDS + 1):
        give, take = battery_powers(limits.vehicle, charge, temperature)
        bound = BatteryPower(np.minimum(give[1:], give[:-1]), np.minimum(take[1:], take[:-1])).added(_bare(limits))
        solver = EcoSolver(bound)
        profile = solver.priced(price or 0.0) if journey_time is None else solver.arriving(journey_time)
        ledger = _charge(bound, profile, soc, temperature)
        found = np.interp(limits.s, ledger.distance, ledger.soc)
        change, charge = float(np.max(np.abs(found - charge))), found
        drive = BatteryDrive(profile, bound, charge, ledger, profile.journey_time if journey_time is None else journey_time, count)
        if change < _SETTLED or not _lasts(drive, least):
            return drive
    raise SolverError(f"{limits.name}: the charge along the way still changes by {change:.2g} after {_ROUNDS} rounds")


def _bare(limits: SpeedLimits) -> SpeedLimits:
    return replace(limits, forces=tuple(limit for limit in limits.forces if not isinstance(limit, ElectricPower)))


def _charge(limits: SpeedLimits, profile: SpeedProfile, soc: float, temperature: float) -> ChargeLedger:
    return charge_over_cycle(limits.vehicle, arrival_times(limits, profile.v), profile.v, limits.slope, soc=soc, temperature=temperature)


def _put_off(limits: SpeedLimits, asked: float, late: BatteryDrive, soc: float, temperature: float) -> BatteryDrive:
    """The earliest arrival at which power and charge last, by bisection between a time at which they do not and one at which they do."""
    least = _least_charge(limits.vehicle)
    low, high, best = asked, late.profile.journey_time, late
    while high - low > _TIME_ACCURACY * high:
        middle = 0.5 * (low + high)
        found = _lasting(limits, middle, soc, None, temperature, least, best.soc)
        if found is None:
            low = middle
        else:
            high, best = middle, found
    return replace(best, asked_time=asked)


def _refuse_empty(drive: BatteryDrive, least: float) -> None:
    """Raise InfeasibleError that says where the battery of the thriftiest drive is empty."""
    limits, ledger = drive.limits, drive.charge
    at = float(ledger.shortage.distance) if ledger.shortage is not None else float(limits.s[int(np.argmax(drive.soc < least))])
    rest = np.interp([at, limits.s[-1]], ledger.distance[1:], np.cumsum(ledger.power * np.diff(ledger.time)))
    missing = max(float(rest[1] - rest[0]), 0.0) + ledger.unserved
    raise InfeasibleError(
        f"{limits.name}: the battery ({limits.vehicle.name}, state of charge {drive.soc[0]:.3f}) is empty at s = {at:.1f} m of "
        f"{limits.s[-1]:.1f} m even when driven as thriftily as can be: {missing / KWH:.3f} kWh are missing"
    )
