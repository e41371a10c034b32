"""Roads, networks and routes as text for a person, and their figure as a file."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from roads import Road
from roads.check import MOST_PLACES

from ..picture import save_picture
from ..style import KMH

if TYPE_CHECKING:
    from pathlib import Path

    from roads import Network
    from roads.networks.routing import Step

#: A table shows so many roads.
MOST_ROWS = 25


def road_table(road: Road) -> str:
    """A road in ten lines, and what its reader noticed or assumed."""
    s = np.linspace(0.0, road.length, min(max(int(road.length), 50), MOST_PLACES) + 1)
    kappa, slope = road.reference.curvature(s), road.slope_at(s)
    sharpest = int(np.argmax(np.abs(kappa)))
    width = road.left - road.right
    finite = road.speed_limit[np.isfinite(road.speed_limit)]
    height = road.height_at(s)
    lines = [
        f"{road.name}: {road.length:z.2f} m, {'closed' if road.closed else 'open'}, traffic keeps {'left' if road.left_hand else 'right'}",
        f"width        {np.min(width):z.2f} to {np.max(width):z.2f} m",
        f"lanes        {_lanes(road)}",
        f"bends        radius down to {1.0 / max(abs(kappa[sharpest]), 1e-9):z.1f} m at s = {s[sharpest]:z.0f} m, "
        f"integral of squared curvature {road.reference.squared_curvature():.4g} 1/m"
        if abs(kappa[sharpest]) > 1e-6
        else "bends        none",
        f"height       {np.min(height):z.1f} to {np.max(height):z.1f} m, slope {100 * np.min(slope):+z.1f} to {100 * np.max(slope):+z.1f} %",
        f"bank         {np.degrees(np.min(road.bank)):z.1f} to {np.degrees(np.max(road.bank)):z.1f} degrees",
        f"speed limit  {KMH * np.min(finite):z.0f} to {KMH * np.max(finite):z.0f} km/h" if len(finite) else "speed limit  none posted",
    ]
    if np.any(road.friction != 1.0):
        lines.append(f"friction     {np.min(road.friction):z.2f} to {np.max(road.friction):z.2f}")
    if road.columns:
        lines.append(f"columns      {', '.join(road.columns)}")
    if road.origin is not None:
        lines.append(f"origin       latitude {road.origin[0]:z.6f}, longitude {road.origin[1]:z.6f}")
    lines += [str(finding) for finding in road.findings]
    return "\n".join(lines)


def _lanes(road: Road) -> str:
    """Lanes that run from start to end one by one; of others how many lie side by side."""
    way = {1: "forward", -1: "backward", 0: "both ways"}
    there = np.array([~np.isnan(lane.right) for lane in road.lanes])
    found = []
    for lane in (lane for lane, present in zip(road.lanes, there, strict=True) if present.all()):
        width = lane.left - lane.right
        span = f"{np.min(width):z.2f}" if np.ptp(width) < 0.005 else f"{np.min(width):z.2f} to {np.max(width):z.2f}"
        found.append(f"{lane.name + ' ' if lane.name else ''}{way[lane.direction]} {span} m")
    if not there.all():
        count = np.sum(there, axis=0)
        low, high = int(np.min(count)), int(np.max(count))
        found.append(f"{low} to {high} side by side" if low < high else f"{low} side by side")
    return "; ".join(found) + (" (from right to left)" if there.all() and len(found) > 1 else "")


def network_table(network: Network) -> str:
    """A network: what it holds, and its longest roads."""
    longest = sorted(network.roads, key=lambda name: -network.lengths[name])
    total = sum(network.lengths.values())
    lanes = dict.fromkeys(network.roads, 0)
    for link in network.links.values():
        lanes[link.road] += 1
    lines = [
        f"{network.name}: {network.format}, {len(longest)} roads, {total / 1000.0:z.3f} km, {len(network.links)} lanes for cars",
        "",
        f"{'road':>24}  {'length m':>10}  {'lanes':>6}",
    ]
    lines += [f"{name:>24}  {network.lengths[name]:z10.1f}  {lanes[name]:6d}" for name in longest[:MOST_ROWS]]
    if len(longest) > MOST_ROWS:
        lines.append(f"{'...':>24}  {len(longest) - MOST_ROWS} more")
    lines += ["", "Choose one with --road ID, or a route with --from and --to (a position 'x,y' or the id of a road or lane)."]
    return "\n".join(lines)


def route_table(steps: list[list[Step]]) -> str:
    """A route lane by lane; a change of lane that one cross-section leaves unfinished goes on in the next one."""
    lines = [f"{'lane':>32}  {'from m':>9}  {'to m':>9}"]
    for before, group in zip([[], *steps[:-1]], steps, strict=True):
        for k, step in enumerate(group):
            goes_on = any(step.link.id in other.link.successors for other in before[1:])
            note = "" if k == 0 else "  change of lane goes on" if goes_on else "  change of lane"
            lines.append(f"{step.link.id:>32}  {step.start:z9.1f}  {step.end:z9.1f}{note}")
    return "\n".join(lines) + "\n"


def save_road_figure(made: Road | Network, out: Path) -> None:
    """Draw a road or a network into the picture file `out`, whole or not at all.

    Raises:
        PlanningError: a suffix that is no picture's, or a place that cannot be written to.
    """
    from .figure import draw_network, draw_road

    save_picture(lambda path: draw_road(made, path) if isinstance(made, Road) else draw_network(made, path), out)
