"""The small parts that limits are put together from. Each takes limits and gives them back with one more bound.

`SpeedLimits.along(..., extra=[Grip(0.9), Stop(410.0), Jerk(1.0)])`
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol, TypeVar

import numpy as np

from powertrain.drive.supply import converter_input
from powertrain.vehicle import GRAVITY

from ...errors import InfeasibleError, PlanningError
from . import forces
from .limits import Window

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from .limits import Limits

    Floats = NDArray[np.float64]


#: A part gives back limits of the kind that it was given.
AnyLimits = TypeVar("AnyLimits", bound="Limits")


class Part(Protocol):
    """A bound on the drive."""

    @property
    def stations(self) -> Sequence[float]:
        """Stations on the path that must be among those of the limits, m."""
        ...

    def added(self, limits: AnyLimits) -> AnyLimits:
        """The limits with this bound."""
        ...


def standard_parts() -> list[Part]:
    """What bounds an ordinary drive (V1): posted limits, the car's top speed, lateral acceleration, comfort, the motors."""
    return [Posted(), Lateral(), Comfort(), Motors()]


@dataclass(frozen=True)
class Everywhere:
    """A part that asks for no stations of its own."""

    @property
    def stations(self) -> Sequence[float]:
        """None."""
        return ()


@dataclass(frozen=True)
class Posted(Everywhere):
    """Limits posted at the road."""

    def added(self, limits: AnyLimits) -> AnyLimits:
        """See `Part`."""
        ground = limits.ground
        return slower(limits, "posted", ground.least_beside(ground.samples.posted))


@dataclass(frozen=True)
class Lateral(Everywhere):
    """Lateral acceleration that passengers feel, bank included: |kappa v^2 cos(bank) + g sin(bank)| at most `most` m/s^2; None: the car's."""

    most: float | None = None

    def added(self, limits: AnyLimits) -> AnyLimits:
        """See `Part`.

        Raises:
            PlanningError: a bank on which even a car at rest feels more.
        """
        most = limits.vehicle.limits.lateral_acceleration_max_mps2 if self.most is None else self.most
        positive("lateral acceleration", most, "m/s^2")
        samples = limits.ground.samples
        felt = GRAVITY * np.sin(samples.bank)
        refuse_bank(limits, np.abs(felt) - most, f"lateral acceleration at rest is {{value:.2f}} m/s^2, limit {most:g}", np.abs(felt))
        room = most - np.sign(samples.kappa) * felt
        return slower(limits, "lateral", limits.ground.least_beside(np.sqrt(room / np.maximum(np.abs(samples.kappa) * np.cos(samples.bank), 1e-6))))


@dataclass(frozen=True)
class Comfort(Everywhere):
    """Largest acceleration and deceleration along the way, m/s^2; None: the car's."""

    acceleration: float | None = None
    deceleration: float | None = None

    def added(self, limits: AnyLimits) -> AnyLimits:
        """See `Part`."""
        own = limits.vehicle.limits
        up = own.acceleration_max_mps2 if self.acceleration is None else self.acceleration
        down = own.deceleration_max_mps2 if self.deceleration is None else self.deceleration
        positive("acceleration", up, "m/s^2")
        positive("deceleration", down, "m/s^2")
        return replace(limits, acceleration=np.minimum(limits.acceleration, up), deceleration=np.minimum(limits.deceleration, down))


@dataclass(frozen=True)
class Motors(Everywhere):
    """Torque and power of the motors, driving and recuperating."""

    def added(self, limits: AnyLimits) -> AnyLimits:
        """See `Part`."""
        return forced(limits, *(kind(sign) for kind in (forces.Torque, forces.Power) for sign in (1, -1)))


@dataclass(frozen=True)
class FrictionBrakes(Everywhere):
    """Friction brakes, beside recuperation; the published method leaves them out. `most` in N at the wheels; None: the car's."""

    most: float | None = None

    def added(self, limits: AnyLimits) -> AnyLimits:
        """See `Part`.

        Raises:
            VehicleError: the car's description has no brakes and no force is given.
        """
        most = self.most
        if most is None:
            from powertrain.description.sections import Brakes

            brakes = limits.vehicle.need("brakes", Brakes)
            most = 2.0 * (brakes.front_torque_max_nm + brakes.rear_torque_max_nm) / limits.vehicle.chassis.wheel_radius_m
        positive("force of the friction brakes", most, "N")
        # all wheels brake now, in whatever order the parts came
        others = [replace(limit, share=1.0) if isinstance(limit, forces.Grip) and limit.sign < 0 else limit for limit in limits.forces]
        return replace(limits, brake=most, forces=tuple(others))


@dataclass(frozen=True)
class BatteryPower(Everywhere):
    """Power that the battery gives and takes at its terminals, W, auxiliaries included: numbers, or one value per interval."""

    discharge: float | Floats
    charge: float | Floats

    def added(self, limits: AnyLimits) -> AnyLimits:
        """See `Part`."""
        count, electrics = len(limits.s) - 1, limits.vehicle.electrics
        auxiliary = 0.0 if electrics is None else float(converter_input(electrics, electrics.auxiliary_w))
        rows = []
        for sign, power in ((1, self.discharge), (-1, self.charge)):
            given = np.asarray(power, dtype=np.float64)
            if given.shape not in ((), (count,)):
                raise PlanningError(f"{limits.name}: battery power of shape {given.shape}, expected one number or {count}, one per interval")
            values = np.broadcast_to(given, (count,))
            if not np.all((values >= 0.0) & np.isfinite(values)):
                at = int(np.argmin((values >= 0.0) & np.isfinite(values)))
                raise PlanningError(f"{limits.name}: battery power is {values[at]:g} W at s = {limits.s[at]:.1f} m, expected 0 or more")
            rows.append(forces.ElectricPower(sign, values, auxiliary))
        return forced(limits, *rows)


@dataclass(frozen=True)
class Jerk(Everywhere):
    """Largest magnitude of jerk, m/s^3: the change of acceleration at a station over the time from interval to interval."""

    most: float = 1.0

    def added(self, limits: AnyLimits) -> AnyLimits:
        """See `Part`.

        Raises:
            PlanningError: on a circuit, whose seam the method for jerk does not know.
        """
        positive("jerk", self.most, "m/s^3")
        if limits.closed:
            remedy = "read it as open (--open), or leave the limit out"
            raise PlanningError(f"{limits.name}: a limit of jerk needs an open road, this is a circuit; {remedy}")
        return replace(limits, jerk=min(limits.jerk, self.most))


@dataclass(frozen=True)
class Stop:
    """A stop line at a station on the path, m: the speed there is zero."""

    s: float

    @property
    def stations(self) -> Sequence[float]:
        """The line, and places beside it: between two stations speed is zero at one of them at most."""
        return (self.s,)

    def added(self, limits: AnyLimits) -> AnyLimits:
        """See `Part`."""
        bound = np.full(len(limits.s), np.inf)
        bound[int(np.argmin(np.abs(limits.s - self.s)))] = 0.0
        return slower(limits, "stop", bound)


@dataclass(frozen=True)
class SpeedCap:
    """A bound on speed of one's own: speeds `v` (m/s) from stations `s` (m) on, each up to the next; inf for none."""

    s: ArrayLike
    v: ArrayLike
    name: str = "cap"

    @property
    def stations(self) -> Sequence[float]:
        """Where the bound changes."""
        return [float(s) for s in np.ravel(np.asarray(self.s, dtype=np.float64))]

    def added(self, limits: AnyLimits) -> AnyLimits:
        """See `Part`.

        Raises:
            PlanningError: stations that do not increase, or not as many speeds.
        """
        s, v = np.ravel(np.asarray(self.s, dtype=np.float64)), np.ravel(np.asarray(self.v, dtype=np.float64))
        if s.shape != v.shape or not np.all(np.diff(s) > 0.0) or not len(s):
            found = f"stations of shape {s.shape}, speeds {v.shape}"
            raise PlanningError(f"{limits.name}: cap `{self.name}` with {found}, expected increasing stations and a speed for each")
        inner = 0.5 * (limits.s[1:] + limits.s[:-1])
        at = np.searchsorted(s, inner, side="right") - 1
        within = np.where(at >= 0, v[np.maximum(at, 0)], np.inf)
        return slower(limits, self.name, np.minimum(np.append(within[:1], within), np.append(within, within[-1:])))


@dataclass(frozen=True)
class Arrival:
    """A window in time for passing a station on the path, as at a light that is green from `earliest` to `latest` s."""

    s: float
    earliest: float = 0.0
    latest: float = np.inf

    @property
    def stations(self) -> Sequence[float]:
        """The station."""
        return (self.s,)

    def added(self, limits: AnyLimits) -> AnyLimits:
        """See `Part`.

        Raises:
            PlanningError: a window that ends before it begins.
            InfeasibleError: two windows at one station that have no time in common.
        """
        if not self.s > 0.0:
            raise PlanningError(f"{limits.name}: window at s = {self.s:g} m of the path, expected a station beyond the start, which is passed at 0 s")
        if not 0.0 <= self.earliest <= self.latest or self.latest <= 0.0 or not np.isfinite(self.earliest):
            raise PlanningError(
                f"{limits.name}: window at s = {self.s:g} m of the path from {self.earliest:g} to {self.latest:g} s, expected 0 <= earliest <= latest"
            )
        same = [w for w in limits.windows if abs(w.s - self.s) < 1e-6]
        earliest, latest = max([self.earliest, *(w.earliest for w in same)]), min([self.latest, *(w.latest for w in same)])
        if earliest > latest:
            raise InfeasibleError(
                f"{limits.name}: the windows at s = {self.s:g} m of the path leave no time: one opens at {earliest:g} s, another ends at {latest:g} s"
            )
        others = [w for w in limits.windows if w not in same]
        return replace(limits, windows=tuple(sorted([*others, Window(self.s, earliest, latest)])))


def slower(limits: AnyLimits, name: str, bound: Floats) -> AnyLimits:
    """The limits with a further bound on speed (n,), m/s; bounds of one name go together."""
    before = limits.speeds.get(name)
    return replace(limits, speeds={**limits.speeds, name: bound if before is None else np.minimum(before, bound)})


def forced(limits: AnyLimits, *more: forces.ForceLimit) -> AnyLimits:
    """The limits with further bounds on forces."""
    return replace(limits, forces=(*limits.forces, *more))


def positive(what: str, value: float, unit: str) -> None:
    """Raise PlanningError if `value` is not a positive number."""
    if not 0.0 < value < 1e9:
        raise PlanningError(f"{what} {value} {unit}, expected more than 0".replace(" ,", ","))


def refuse_bank(limits: Limits, beyond: Floats, words: str, values: Floats) -> None:
    """Raise PlanningError at the sample where `beyond` (m,) is largest, if that is positive; `words` tell the value there."""
    if np.any(beyond > 0.0):
        at = int(np.argmax(beyond))
        raise PlanningError(f"{limits.name}: bank at s = {limits.ground.samples.s[at]:.1f} m: {words.format(value=values[at])}")
