"""The three archetypes of everyday driving, and how they are made.

They stand in for the three roads of the energy manager's published experiments (E2, E3, E4; section 3.7 of the source), whose data were never
published: same length, same features, two lanes of 3.5 m. `python -m roads.gallery.archetypes` writes them anew.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..builder import RoadBuilder
from ..formats import write
from .shelf import SHELF

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..road import Road

    Floats = NDArray[np.float64]

KMH = 1.0 / 3.6


def commute() -> Road:
    """E2: 2.5 km, flat, three sharp bends, a roundabout, an s-curve; from a site through open country to a station."""
    road = RoadBuilder("commute").limit(50 * KMH)
    road.straight(80).bend(15, np.radians(90), 10).straight(60).bend(12, -np.radians(90), 10).straight(50).bend(15, np.radians(80), 10)
    road.straight(60).limit(80 * KMH).straight(100)
    road.bend(200, np.radians(30), 20).straight(110).bend(200, -np.radians(30), 20).straight(60)
    road.limit(50 * KMH).roundabout(entry=18, ring=16, angle=np.radians(135), blend=10)
    road.straight(40).limit(80 * KMH).straight(180).bend(120, np.radians(40), 20).straight(100).bend(150, -np.radians(50), 20)
    road.straight(120).bend(250, np.radians(30), 20).straight(300)
    road.limit(50 * KMH).bend(25, -np.radians(60), 12).bend(25, np.radians(60), 12)
    return road.straight(2500.0 - road.length).build()


def rural() -> Road:
    """E3: 3 km of country road over rolling hills with a right-angled crossing at one and at two thirds."""
    road = RoadBuilder("rural").limit(80 * KMH)
    road.straight(150).bend(300, np.radians(30), 30).straight(180).bend(200, -np.radians(45), 30).straight(120)
    road.bend(250, np.radians(25), 30).straight(60)
    road.limit(60 * KMH).straight(40).bend(12, np.radians(90), 10).straight(40).limit(80 * KMH)
    road.straight(160).bend(400, -np.radians(20), 30).straight(180).bend(180, np.radians(40), 30).straight(130)
    road.limit(60 * KMH).straight(60).bend(15, -np.radians(90), 10).straight(40).limit(80 * KMH)
    road.straight(150).bend(150, np.radians(60), 30).straight(140).bend(350, -np.radians(35), 30)

    def hills(s: Floats) -> Floats:
        return 300.0 + 20.0 * np.sin(2.0 * np.pi * s / 1500.0) * np.sin(np.pi * s / 3000.0) ** 2

    return road.straight(3000.0 - road.length).build(height=hills)


def descent() -> Road:
    """E4: 3 km down 120 m, long smooth bends at both ends and two pairs of serpentines between."""
    road = RoadBuilder("descent").limit(70 * KMH)
    road.straight(80).bend(120, np.radians(50), 25).straight(60).bend(90, -np.radians(70), 25).straight(70)
    road.bend(200, np.radians(35), 30).straight(50).bend(100, np.radians(45), 25).straight(60).bend(80, -np.radians(60), 25).straight(80)
    for _ in range(2):
        road.bend(16, np.radians(150), 12).straight(60).bend(16, -np.radians(150), 12).straight(60)
    road.straight(60).bend(150, np.radians(45), 30).straight(80).bend(100, -np.radians(60), 25).straight(70).bend(220, np.radians(40), 30)
    road.straight(60).bend(130, -np.radians(55), 25).straight(90).bend(180, np.radians(50), 30).straight(70).bend(250, -np.radians(30), 30)

    def falls(s: Floats) -> Floats:
        # 60 m of run-out at either end, between them a constant grade blended in over the run-outs
        run, length, drop = 60.0, 3000.0, 120.0
        grade = drop / (length - run)
        ramp = np.clip(s, 0.0, run) ** 2 / (2 * run) + np.clip(s - run, 0.0, length - 2 * run)
        tail = np.clip(s - (length - run), 0.0, run)
        return 700.0 - grade * (ramp + tail - tail**2 / (2 * run))

    return road.straight(3000.0 - road.length).build(height=falls)


ARCHETYPES = (commute, rural, descent)

if __name__ == "__main__":
    for make in ARCHETYPES:
        made = make()
        write(made, SHELF / f"{made.name}.csv")
        print(f"{made.name}: {made.length:.1f} m")
