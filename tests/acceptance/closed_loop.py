"""The published closed-loop experiments E0 to E4, on our plant: as functions for the tests, and as tables for people.

    python -m tests.acceptance.closed_loop            # all tables of docs/results.md, "Closed loop"; some minutes

E2, E3 and E4 are driven on the shipped archetypes `commute`, `rural` and `descent`: the roads of the source are not public, so that energies compare
in sign and order only.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

import energy_mgr
from energy_mgr import Drive, DriveRules, Event, Trajectory, simulate
from energy_mgr.planning.comparison import KWH
from powertrain import Vehicle, drive_energy, load_vehicle

#: As the source drives: its three PDs, its two-step allocation.
PUBLISHED = {"follower": "pd", "allocator": "two-step"}
#: Savings that the source prints (Tables 3.5 to 3.7), kWh and %, against non-opt heuristic: non-opt physical, opt heuristic, opt physical.
PRINTED = {
    "commute": ((0.0038, 1.135), (-0.0380, -11.350), (-0.0342, -10.215)),
    "rural": ((0.0063, 1.532), (-0.0155, -3.771), (-0.0101, -2.457)),
    "descent": ((0.0060, 32.967), (-0.0060, -32.970), (0.0003, 1.648)),
}


def double_lane_change(shift: float = 3.0, step: float = 0.25) -> Trajectory:
    """E1: 70 m, `shift` m to the left over 25 m, back after 12 m, quintic; 3 to 13 to 7 m/s at 2 m/s^2."""

    def blend(u: Any) -> Any:
        u = np.clip(u, 0.0, 1.0)
        return u**3 * (10.0 - 15.0 * u + 6.0 * u**2)

    def lane(x: Any) -> Any:
        return shift * (blend((x - 4.0) / 25.0) - blend((x - 41.0) / 25.0))

    fine = np.linspace(0.0, 70.0, 7001)
    s = np.arange(0.0, 70.0 + 1e-9, step)
    x = np.interp(s, np.append(0.0, np.cumsum(np.hypot(np.diff(fine), np.diff(lane(fine))))), fine)
    h = 1e-4
    slope, bend = (lane(x + h) - lane(x - h)) / (2.0 * h), (lane(x + h) - 2.0 * lane(x) + lane(x - h)) / h**2
    v = np.sqrt(np.where(s <= 40.0, 9.0 + 4.0 * s, 169.0 - 4.0 * (s - 40.0)))
    return Trajectory.along(s, x, lane(x), np.arctan(slope), bend / (1.0 + slope**2) ** 1.5, v, name="double lane change")


@cache
def romo() -> Vehicle:
    """The car of all experiments."""
    return load_vehicle("romo")


@cache
def lane_change(what: str) -> Drive:
    """E1 driven in one of the ways of `LANE_CHANGES`."""
    return simulate(double_lane_change(), romo(), compiled=False, **LANE_CHANGES[what])


@cache
def plans(road: str) -> dict[str, Trajectory]:
    """Trajectories along a shipped road at one arrival time: lane centre by V1 (`reference`), optimal path by V1 (`path_only`), ours (`both`)."""
    compared = energy_mgr.plan(road, romo(), corridor="road").comparison
    runs = {name: getattr(compared, name) for name in ("reference", "path_only", "both")}
    return {name: Trajectory.of(run.path, run.limits, run.profile, run.ledger) for name, run in runs.items()}


@cache
def published(road: str, plan: str, cost: str) -> Drive:
    """The published law and allocation on one of `plans`."""
    return simulate(plans(road)[plan], romo(), cost=cost, **PUBLISHED)


@cache
def ours(road: str, allocator: str = "efficient", cost: str = "physical") -> Drive:
    """Our plan, law and allocation."""
    return simulate(plans(road)["both"], romo(), allocator=allocator, cost=cost)


@dataclass(frozen=True)
class Account:
    """A closed-loop drive beside its quasi-static plan, J."""

    plan: float
    tyre: float
    drive: float

    @classmethod
    def of(cls, drive: Drive) -> Account:
        """Of a drive: what the plan counts, what its tyres lost in sliding, which no plan counts, and what the drives took."""
        lam = drive.trajectory
        return cls(drive_energy(drive.vehicle, lam.s, lam.v, lam.z).total, drive.ledger.energy["tyre"], drive.drive_energy)


def offset_drive(law: str = "linearising", friction: float | None = None) -> Drive:
    """E0: 2 m beside the lane of `descent` at the speed of the trajectory; from the first second on with `friction`."""
    plan = energy_mgr.plan("descent", romo(), corridor="lane", path="lane", speed="fast", rules=DriveRules(start_speed=12.0))
    events = () if friction is None else (Event(part="friction", kind="value", share=friction, time_s=1.0),)
    return simulate(plan.trajectory, romo(), follower=law, offset=2.0, events=events, longest=9.0, compiled=False)


def rows(road: str, *, preview: bool = False) -> list[tuple[str, Drive, tuple[float, float] | None]]:
    """The table of one road: what, drive, printed change against the first row in kWh and %."""
    printed = PRINTED[road]
    found: list[tuple[str, Drive, tuple[float, float] | None]] = [
        ("lane, heuristic", published(road, "reference", "heuristic"), (0.0, 0.0)),
        ("lane, physical", published(road, "reference", "physical"), printed[0]),
        ("path, heuristic", published(road, "path_only", "heuristic"), printed[1]),
        ("path, physical", published(road, "path_only", "physical"), printed[2]),
        ("ours, heuristic", ours(road, cost="heuristic"), None),
        ("ours, physical", ours(road), None),
    ]
    return [*found, ("ours, preview", ours(road, "preview"), None)] if preview else found


def table(road: str, *, preview: bool = False) -> str:
    """The table of one road, Markdown."""
    lines = [
        f"| `{road}` | time s | battery kWh | change kWh | change % | printed kWh, % | offset rms, max m | torque rate Nm/s | "
        "drives over plan % | without tyre slip % |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    base = None
    for what, drive, printed in rows(road, preview=preview):
        battery, account = drive.battery_energy / KWH, Account.of(drive)
        base = battery if base is None else base
        said = "" if printed is None else f"{printed[0]:+.4f}, {printed[1]:+.1f}"
        beyond, explained = account.drive - account.plan, account.drive - account.tyre - account.plan
        share = [100.0 * value / abs(account.plan) for value in (beyond, explained)]
        lines.append(
            f"| {what} | {drive.journey_time:.2f} | {battery:.4f} | {battery - base:+.4f} | {100.0 * (battery - base) / abs(base):+.1f} | {said} | "
            f"{drive.offset_rms:.3f}, {drive.offset_max:.3f} | {drive.torque_jitter:.2f} | {share[0]:+.1f} | {share[1]:+.1f} |"
        )
    return "\n".join(lines)


def lane_change_table() -> str:
    """E1, Markdown."""
    lam = double_lane_change()
    lines = [f"quasi-static {drive_energy(romo(), lam.s, lam.v).total / 1e3:.2f} kJ, printed 59.88 (physical 59.875, heuristic 59.882)", ""]
    lines += ["| E1 | drives kJ | tyre slip kJ | brake kJ | offset rms, max m |", "|---|---|---|---|---|"]
    for what in LANE_CHANGES:
        drive = lane_change(what)
        energy = drive.ledger.energy
        lines.append(
            f"| {what} | {drive.drive_energy / 1e3:.2f} | {energy['tyre'] / 1e3:.2f} | {energy['brake'] / 1e3:.2f} | "
            f"{drive.offset_rms:.3f}, {drive.offset_max:.3f} |"
        )
    return "\n".join(lines)


LANE_CHANGES: dict[str, dict[str, Any]] = {
    "published, heuristic": {"cost": "heuristic", **PUBLISHED},
    "published, physical": {"cost": "physical", **PUBLISHED},
    "ours, heuristic": {"cost": "heuristic"},
    "ours, physical": {},
    "ours, preview": {"allocator": "preview"},
    "equal split": {"allocator": "equal-split"},
}


def main(arguments: list[str]) -> None:
    """Print the tables."""
    print(lane_change_table(), flush=True)
    for road in arguments or list(PRINTED):
        print("\n" + table(road, preview=True), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
