"""What is left of a road that a receiver recorded: `python -m benchmarks.recorded_drives`.

Drives along shipped roads are recorded with noise (a place a second, a stop of 25 s), made a road and compared with the one they came from: how far
the line is off, rise and fall, and the energy that a score reckons against that of the true speeds over the true heights, as a share of all that
moves. Medians over ten seeds, and the range.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from energy_mgr.planning.score import recorded_ledger
from powertrain import load_vehicle
from roads import Recorded, Road, open_road
from roads.conditioning.conditioned import conditioned, with_drive
from roads.conditioning.wish import Wish
from tests.roads.conditioning.drives import Receiver, driven, gain, recorded

SEEDS = range(10)
RECEIVERS = {
    "exact": Receiver(),
    "good": Receiver(1.0, 0.5),
    "telephone": Receiver(2.5, 1.0),
    "in whole metres": Receiver(2.5, 0.3, 1.0),
    "poor": Receiver(5.0, 3.0),
}


def measured(road: Road, receiver: Receiver, seed: int) -> tuple[float, float, float, float, float]:
    """Root mean square and largest distance from the road, rise and fall as shares of the road's (m where it has none), energy as a share."""
    stop = 0.4 * road.length, 25.0
    found = conditioned(recorded(road, receiver, seed, stop), Wish(), False)
    tree = cKDTree(road.reference.position(np.arange(0.0, road.length, 0.1)))
    off, _ = tree.query(found.points)
    z = road.height_at(np.arange(0.0, road.length, 5.0))
    made = with_drive(Road.from_points("made", found.points, -1.75, 1.75, height=found.height), found)
    car = load_vehicle("romo")
    t, s = driven(road, 1.0, stop)
    truth = recorded_ledger(replace(road, recorded=Recorded(t, s, np.maximum(np.gradient(s, t), 0.0))), car)
    rise, fall = (gain(sign * found.height) / gain(sign * z) if gain(sign * z) > 1.0 else gain(sign * found.height) for sign in (1.0, -1.0))
    moved = sum(abs(value) for value in truth.components.values())
    return float(np.sqrt(np.mean(off**2))), float(off.max()), rise, fall, (recorded_ledger(made, car).energy - truth.energy) / moved


def main() -> None:
    """Print the table."""
    print(f"{'road':9}{'receiver':18}{'off m (rms)':>18}{'at most':>9}{'rise':>7}{'fall':>7}{'energy off, % of what moves':>32}")
    for name in ("rural", "commute", "descent"):
        road = open_road(name)
        for label, receiver in RECEIVERS.items():
            rows = np.array([measured(road, receiver, seed) for seed in SEEDS])
            middle = np.median(rows, axis=0)
            off, energy = rows[:, 0], 100.0 * rows[:, 4]
            print(
                f"{name:9}{label:18}{middle[0]:7.2f} ({off.min():.2f} to {off.max():.2f}){middle[1]:7.1f}{middle[2]:8.2f}{middle[3]:7.2f}"
                f"{100.0 * middle[4]:14.1f} ({energy.min():.1f} to {energy.max():.1f})"
            )


if __name__ == "__main__":
    main()
