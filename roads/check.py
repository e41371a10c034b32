"""Everything that a reader of a road file notices, and what looks wrong about the road itself."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .border_line import refuse_turning_back
from .errors import RoadError
from .findings import Finding, Findings
from .formats.registry import NETWORKS, read, read_network

if TYPE_CHECKING:
    from os import PathLike

    from .networks.network import Network
    from .road import Road

#: Beyond these a public road is unusual: radius m, slope, lane width m, kink of the height (change of slope within a metre).
TIGHTEST, STEEPEST, NARROWEST, KINK = 4.0, 0.25, 2.0, 0.05
#: A road is looked at in no more places.
MOST_PLACES = 1_000_000


def check(path: str | PathLike[str], **options: Any) -> list[Finding]:
    """Findings about the file at `path`, errors first: those of its reader, and of each road in it.

    Args:
        path: any file that `roads.read` or `roads.read_network` takes.
        **options: as in `roads.read`.
    """
    path = Path(path)
    findings = Findings()
    try:
        if path.suffix.lower() in NETWORKS:
            network = read_network(path)
            findings.items += network.check()
            wanted = options.get("road")
            drivable = {link.road for link in network.links.values()}
            for identity in network.roads if wanted is None else [wanted]:
                if identity in drivable or identity == wanted:
                    _look_at(network, identity, findings)
        else:
            made = read(path, **options)
            findings.items += made.findings
            look(made, str(path), findings)
    except RoadError as error:
        findings.error(error)
    return findings.all()


def _look_at(network: Network, identity: str, findings: Findings) -> None:
    try:
        road = network.road(identity)
    except RoadError as error:
        found = Findings()
        found.error(error)
        # making the road was tried by the network's own check too
        findings.items += [finding for finding in found.items if finding not in findings.items]
        return
    look(road, f"{network.path}: road {identity}", findings)


def look(road: Road, place: str, findings: Findings) -> None:
    """Add warnings about geometry that no public road has."""
    s = np.linspace(0.0, road.length, min(max(int(road.length), 2), MOST_PLACES) + 1)
    kappa = np.abs(road.reference.curvature(s))
    at = int(np.argmax(kappa))
    if kappa[at] > 1.0 / TIGHTEST:
        findings.warn(f"{place} at s = {s[at]:z.1f} m", f"bends with a radius of {1.0 / kappa[at]:z.2f} m, expected at least {TIGHTEST:g} m")
    try:
        refuse_turning_back(road.corridor("road"))
    except RoadError as error:
        findings.warn(place, str(error).removeprefix(f"{road.name}: "))
    slope = road.slope_at(s)
    at = int(np.argmax(np.abs(slope)))
    if abs(slope[at]) > STEEPEST:
        findings.warn(f"{place} at s = {s[at]:z.1f} m", f"slope of {100.0 * slope[at]:z.1f} %, expected at most {100.0 * STEEPEST:z.0f} %")
    change = np.abs(np.diff(slope))
    at = int(np.argmax(change))
    if change[at] > KINK:
        findings.warn(f"{place} at s = {s[at]:z.1f} m", f"the slope changes by {100.0 * change[at]:z.1f} % within a metre, expected a smooth profile")
    try:
        lane = road.driving_lane()
    except RoadError as error:
        findings.warn(place, str(error))
        return
    width = lane.left - lane.right
    at = int(np.argmin(width))
    if width[at] < NARROWEST:
        findings.warn(f"{place} at s = {road.s[at]:z.1f} m", f"the lane to drive is {width[at]:z.2f} m wide, expected at least {NARROWEST:g} m")
