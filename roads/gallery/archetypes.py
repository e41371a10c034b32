"""The shipped roads, and how they are made: three archetypes of everyday driving, a handling course, a network with a roundabout.

The archetypes stand in for the three roads of the energy manager's published experiments (E2, E3, E4; section 3.7 of the source), whose data were
never published: same length, same features, two lanes of 3.5 m. `python -m roads.gallery.archetypes` writes them anew.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..editing.builder import RoadBuilder
from ..editing.network_builder import NetworkBuilder, bridging
from ..formats import write
from ..geometry.plan_view import Clothoid
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


def handling() -> Road:
    """A closed course of one lane, 7 m wide, driven counter-clockwise: a hairpin, a chicane, a sweep; two straights are as long as closing needs."""

    def course(first: float, second: float) -> RoadBuilder:
        road = RoadBuilder("handling").straight(first).bend(30, np.radians(90), 15)
        road.straight(second).bend(12, np.radians(180), 10).straight(30)
        road.bend(25, -np.radians(110), 12).straight(20).bend(25, np.radians(70), 12).bend(40, -np.radians(60), 15)
        road.straight(60).bend(60, np.radians(100), 25)
        return road.straight(40).bend(35, np.radians(90), 15)

    # the end moves along with the straights' directions, +x and +y
    gap = course(200.0, 200.0).end()[0]
    return course(200.0 - gap[0], 200.0 - gap[1]).build(lanes=((1, -3.5, 3.5),), closed=True)


def roundabout() -> NetworkBuilder:
    """Four roads of two lanes that meet at a roundabout of one lane, 16 m in radius: ids `north`, `south`, `east`, `west`."""
    town = NetworkBuilder("roundabout")
    inner, out, half = 14.0, 40.0, np.radians(25)
    arms = {"east": 0.0, "north": 0.5 * np.pi, "west": np.pi, "south": 1.5 * np.pi}
    bends = {"east": np.radians(30), "north": -np.radians(25), "west": np.radians(20), "south": -np.radians(35)}
    names = list(arms)

    def on_ring(angle: float) -> tuple[float, float, float]:
        return inner * float(np.cos(angle)), inner * float(np.sin(angle)), float(angle + 0.5 * np.pi)

    def arc(start: float, end: float) -> Clothoid:
        return Clothoid(*on_ring(start), inner * (end - start), 1.0 / inner, 1.0 / inner)

    for name, angle in arms.items():
        at = (out * float(np.cos(angle)), out * float(np.sin(angle)))
        arm = RoadBuilder(name, at, float(angle)).straight(120).bend(80, bends[name], 20).straight(100)
        town.road(name, arm.elements(), limit=50 * KMH)
        town.road(f"ring after {name}", [arc(angle + half, angle + 0.5 * np.pi - half)], right=[(4.5, 4.5)], left=[], limit=30 * KMH)
        town.road(f"ring past {name}", [arc(angle - half, angle + half)], right=[(4.5, 4.5)], left=[], limit=30 * KMH, junction=name)
        entry = bridging((*at, float(angle + np.pi)), on_ring(angle + half))
        town.road(f"{name} in", [entry], right=[(3.5, 4.5)], left=[], limit=30 * KMH, junction=name)
        leave = bridging(on_ring(angle - half), (*at, float(angle)))
        town.road(f"{name} out", [leave], right=[(4.5, 3.5)], left=[], limit=30 * KMH, junction=name)
    for k, name in enumerate(names):
        before, after, arm = (f"ring after {names[k - 1]}", "end"), (f"ring after {name}", "start"), (name, "start")
        for end in (before, after, arm):
            town.enters(name, end)
        town.connect(name, before, f"ring past {name}", after, (-1, -1, -1))
        town.connect(name, arm, f"{name} in", after, (1, -1, -1))
        town.connect(name, before, f"{name} out", arm, (-1, -1, -1))
    return town


ROADS = (commute, rural, descent, handling)

if __name__ == "__main__":
    for make in ROADS:
        made = make()
        write(made, SHELF / f"{made.name}.xodr")
        print(f"{made.name}: {made.length:.1f} m")
    roundabout().write(SHELF / "roundabout.xodr")
