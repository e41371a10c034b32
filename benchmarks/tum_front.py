"""Time against energy for a formula car on race tracks: `python -m benchmarks.tum_front [TRACK.csv ...] [--figure FILE]`.

Beside TUM's minimum-time study with an energy limit: Berlin in 85.43 s with 2.225 kWh at the wheel, with 1.6 kWh, 28 % less, in 87.19 s, 2.1 % later.
What differs: Berlin is not among the tracks; their path is found together with the speed and differs with the limit, ours is the gentlest one in the
road, the same for all; they have downforce and wheel loads that move; see `peers/formula_car.toml`. Prints a Markdown table. Three cars:

    as TUM      no losses behind the wheel, no recuperation: energy is that at the wheel
    no regen    losses, all braking by friction
    regen       losses, motors and friction brakes both brake

Least energy is least energy at the battery; "wheel" is the integral of positive power at the wheels, their measure.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

import msgspec
import numpy as np
from scipy.optimize import brentq

import roads
from energy_mgr import SpeedLimits
from energy_mgr.errors import SolverError
from energy_mgr.path import PathOptions, plan_path
from energy_mgr.speed import Comfort, EcoSolver, FrictionBrakes, Front, Grip, Motors, SpeedProfile
from energy_mgr.speed.result import energy_of
from powertrain import Vehicle, load_vehicle

DATA = Path(os.environ.get("ENERGY_MGR_DATA", Path(__file__).parents[2] / "shared" / "data"))
CAR = Path(__file__).parent / "peers" / "formula_car.toml"
#: As the peer's: half of width_opt, curvlim, stepsize_reg, mue, f_brake_max; its centre lines are smoothed.
CLEARANCE, BOUND, STEP, FRICTION, BRAKE, SMOOTHING = 1.7, 0.12, 3.0, 1.0, 20e3, 0.3
#: 1 - 1.6 kWh / 2.225 kWh, and 87.19 s / 85.43 s - 1.
LESS, LATER = 0.281, 0.0206
#: Points of a front, and its slowest time over the least.
POINTS, SLOWEST = 16, 1.08
KWH = 3.6e6


def cars() -> dict[str, Vehicle]:
    """The three cars by name."""
    car = load_vehicle(CAR)
    none = msgspec.structs.replace(car.drive, regen_torque_max_nm=0.0)
    free = msgspec.structs.replace(
        none,
        gear_efficiency=1.0,
        inverter_constant_w=0.0,
        inverter_per_current_wpa=0.0,
        phase_resistance_ohm=1e-4,  # the least that is allowed: 50 W at the largest torque
        hysteresis_nm=0.0,
        eddy_nms=0.0,
        friction_nm=0.0,
    )
    drives = {"as TUM": free, "no regen": none, "regen": car.drive}
    return {name: msgspec.structs.replace(car, drive=drive) for name, drive in drives.items()}


def solvers(track: Path) -> dict[str, EcoSolver]:
    """Solvers for the three cars on the gentlest path round a track."""
    road, _ = roads.smoothed(roads.read(track), SMOOTHING)
    path = plan_path(road, CLEARANCE, extent="road", options=PathOptions(curvature_max=BOUND))
    parts = [Grip(FRICTION), Motors(), FrictionBrakes(BRAKE), Comfort()]
    return {name: EcoSolver(SpeedLimits.along(road, path, car, parts=parts, step=STEP)) for name, car in cars().items()}


def battery(limits: SpeedLimits, profile: SpeedProfile) -> float:
    """Energy drawn from the battery, J."""
    return energy_of(limits, profile).total


def wheel(limits: SpeedLimits, profile: SpeedProfile) -> float:
    """Integral of positive power at the wheels, J."""
    return float(np.sum(np.maximum(energy_of(limits, profile).force, 0.0) * limits.ds))


def saved(solver: EcoSolver, measure, share: float) -> SpeedProfile:
    """The profile that takes `share` less energy by a measure than the fastest one."""
    goal = (1.0 - share) * measure(solver.limits, solver.fastest)

    def beyond(ratio: float) -> float:
        return measure(solver.limits, solver.arriving(ratio * solver.least_time)) / goal - 1.0

    high = 1.02
    while beyond(high) > 0.0:
        high = 1.0 + 2.0 * (high - 1.0)
    return solver.arriving(float(brentq(beyond, 1.0 + 1e-7, high, xtol=1e-5)) * solver.least_time)


def row(track: str, name: str, solver: EcoSolver) -> str:
    """A line of the table."""
    limits, fastest = solver.limits, solver.fastest
    cells = [track, name, f"{fastest.journey_time:.2f}", f"{limits.s[-1] / fastest.journey_time:.1f}"]
    cells += [f"{measure(limits, fastest) / KWH:.4f}" for measure in (battery, wheel)]
    found = None
    for measure in (battery, wheel):
        # without losses and recuperation both are the same
        found = found if found and name == "as TUM" else saved(solver, measure, LESS)
        cells += [f"{found.journey_time:.2f}", f"{100 * (found.journey_time / fastest.journey_time - 1):.2f}", f"{100 * found.gap:.1e}"]
    return "| " + " | ".join(cells) + " |"


def draw(fronts: dict[tuple[str, str], Front], file: str) -> None:
    """The fronts, time over the least against energy over that of the fastest drive, a panel per car."""
    from matplotlib.figure import Figure

    names = list(dict.fromkeys(name for _, name in fronts))
    figure = Figure(figsize=(4.2 * len(names), 4.2), layout="constrained")
    for axes, name in zip(np.atleast_1d(figure.subplots(1, len(names), sharey=True)), names, strict=True):
        for (track, car), front in fronts.items():
            if car == name:
                later, less = front.journey_time / front.journey_time[0] - 1, 1 - front.energy / front.energy[0]
                axes.plot(100 * later, 100 * less, label=track, linewidth=1.2)
        axes.plot(100 * LATER, 100 * LESS, "k*", markersize=10, label="TUM, Berlin")
        axes.set(title=name, xlabel="later than the fastest, %")
        axes.grid(alpha=0.3)
    figure.axes[0].set_ylabel("less energy from the battery, %")
    figure.axes[-1].legend(fontsize=7)
    figure.savefig(file, dpi=150)


def main(given: list[str]) -> int:
    """Print the table, and draw the figure if asked."""
    parser = argparse.ArgumentParser(description="Time against energy for a formula car on race tracks.")
    parser.add_argument("tracks", nargs="*", type=Path, default=sorted((DATA / "roads" / "tum").glob("*.csv")))
    parser.add_argument("--figure", help="file for the figure, its ending tells the format")
    asked = parser.parse_args(given)
    columns = ["track", "car", "least s", "mean m/s", "battery kWh", "wheel kWh"]
    for where in ("battery", "wheel"):
        columns += [f"s, {100 * LESS:.0f} % less at the {where}", "% later", "gap %"]
    print("| " + " | ".join(columns) + " |\n|" + "---|" * len(columns), flush=True)
    fronts = {}
    for track in asked.tracks:
        for name, solver in solvers(track).items():
            try:
                print(row(track.stem, name, solver), flush=True)
                if asked.figure:
                    fronts[track.stem, name] = solver.front(POINTS, slowest=SLOWEST * solver.least_time)
            except SolverError as error:
                print(f"| {track.stem} | {name} | {error} |", flush=True)
    if asked.figure:
        draw(fronts, asked.figure)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
