"""The friction ellipse as a part of the limits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from powertrain.vehicle import GRAVITY

from . import forces
from .parts import Everywhere, forced, positive, refuse_bank, slower

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from powertrain import Vehicle

    from .parts import AnyLimits

    Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Grip(Everywhere):
    """The friction ellipse: `friction` on dry asphalt times the road's share of it, load by bank and curvature.

    Driving forces act on the driven axles alone, with their share of the weight at rest; so do recuperating ones, unless friction brakes
    are among the limits: then all wheels brake.
    """

    friction: float = 1.0

    def added(self, limits: AnyLimits) -> AnyLimits:
        """See `Part`.

        Raises:
            PlanningError: a bank on which a car at rest slides.
        """
        positive("friction", self.friction, "")
        samples = limits.ground.samples
        mu, slides = self.friction * samples.friction, np.abs(np.tan(samples.bank))
        refuse_bank(limits, slides - mu, "the friction needed at rest is {value:.3f}, more than there is", slides)
        ground = limits.ground
        least, most = ground.least_within(samples.kappa), -ground.least_within(-samples.kappa)
        kappa = np.where(np.abs(least) > np.abs(most), least, most)
        bank = 0.5 * (ground.bank[1:] + ground.bank[:-1])
        data = ground.least_within(mu), kappa, bank
        # what bounds the force must leave some at the bound on speed: both look at least friction and largest curvature of an interval
        sampled = ground.least_beside(_grip_speed(mu, samples.kappa, samples.bank))
        speed = _grip_speed(data[0], kappa, bank)
        before, after = speed[-1:] if limits.closed else speed[:1], speed[:1] if limits.closed else speed[-1:]
        speed = np.minimum(sampled, np.minimum(np.append(before, speed), np.append(speed, after)))
        drive = driven_share(limits.vehicle)
        found = forced(limits, forces.Grip(1, drive, *data), forces.Grip(-1, 1.0 if limits.brake > 0.0 else drive, *data))
        return slower(found, "grip", speed)


def _grip_speed(mu: Floats, kappa: Floats, bank: Floats) -> Floats:
    """Speed at which friction holds the car in the bend and no more, m/s."""
    side = np.sign(kappa) * bank
    hold, ask = mu * np.cos(side) - np.sin(side), np.abs(kappa) * (np.cos(side) + mu * np.sin(side))
    return np.sqrt(GRAVITY * np.maximum(hold, 0.0) / np.maximum(ask, 1e-6))


def driven_share(vehicle: Vehicle) -> float:
    """Share of the weight at rest on the driven axles; half per axle where the body is not described."""
    front, rear = vehicle.drive.driven_wheels[0], vehicle.drive.driven_wheels[2]
    on_front = 0.5 if vehicle.body is None else vehicle.body.rear_axle_m / vehicle.body.wheelbase_m
    return (on_front if front else 0.0) + (1.0 - on_front if rear else 0.0)
