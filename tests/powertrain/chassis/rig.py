"""The ROMO's plant in steps of a millisecond, and what tests do with a plant."""

import numpy as np

from powertrain import load_vehicle
from powertrain.chassis import DoubleTrack, Machine

ROMO = load_vehicle("romo")
PLANT = DoubleTrack(ROMO)
MACHINE = Machine(PLANT, 1e-3)


def named(plant: DoubleTrack, x) -> dict[str, float]:
    return dict(zip(plant.states, x, strict=True))


def settle(plant: DoubleTrack, machine: Machine, x, u, seconds: float):
    x = np.asarray(x, dtype=float)
    for _ in range(round(seconds / machine.dt)):
        x = machine.step(x, u)
    return x
