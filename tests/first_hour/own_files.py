"""The files that stand for the reader's own in the documents: `python own_files.py FOLDER`, in the fresh environment, in the fresh copy.

One function per file, named after it. What the documents show themselves (the road of the tutorial, the faults of the how-to) is not here: those
files are the documents' own blocks.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import numpy as np

import energy_mgr.trajectory.files
import roads
from powertrain.battery import load_cell, simulate
from powertrain.battery.identify import laboratory
from roads.editing.network_builder import bridging

KMH = 1.0 / 3.6
WARM = 298.15
SHIPPED_CARS = Path("powertrain/vehicles")


def my_track(folder: Path) -> None:
    """1.1 km with two bends, which 95 s are enough for."""
    track = roads.RoadBuilder("my track").limit(60 * KMH).straight(300).bend(80, np.radians(60), 20).straight(250).bend(60, -np.radians(80), 20)
    roads.write(track.straight(1100.0 - track.length).build(), folder / "my_track.csv")


def my_car(folder: Path) -> None:
    """The shipped compact car as if it were the reader's."""
    shutil.copy(SHIPPED_CARS / "compact.toml", folder / "my_car.toml")


def car(folder: Path) -> None:
    """What the tutorial says: a copy of `romo.toml` with a value changed."""
    text = (SHIPPED_CARS / "romo.toml").read_text(encoding="utf-8")
    (folder / "car.toml").write_text(text.replace('name = "ROMO"', 'name = "my car"'), encoding="utf-8")


def town(folder: Path) -> None:
    """Road 12 from the west, which forks into 17 (on to the east) and 40 (to the south), so that the places in the documents lie on its lanes."""
    net = roads.NetworkBuilder("town")
    west, east, south = (840.0, 37.25, 0.0), (920.0, 37.25, 0.0), (881.75, 0.0, -0.5 * np.pi)
    net.road("12", roads.RoadBuilder("12", (0.0, 37.25), 0.0).straight(840).elements(), limit=50 * KMH)
    on = roads.RoadBuilder("17", east[:2], east[2]).straight(300).bend(150, np.radians(40), 25).straight(600)
    net.road("17", on.elements(), limit=70 * KMH)
    down = roads.RoadBuilder("40", south[:2], south[2]).straight(200).bend(100, np.radians(30), 20).straight(150)
    net.road("40", down.elements(), limit=50 * KMH)
    net.enters("fork", ("12", "end"))
    for name, start in (("17", east), ("40", south)):
        net.enters("fork", (name, "start"))
        net.road(f"to {name}", [bridging(west, start)], left=[], limit=30 * KMH, junction="fork")
        net.connect("fork", ("12", "end"), f"to {name}", (name, "start"), (-1, -1, -1))
    net.write(folder / "town.xodr")


def tour(folder: Path) -> None:
    """A winding way over a hill, as a telephone in a car writes it: a point every second, some metres off."""
    rng = np.random.default_rng(7)
    t = np.arange(0.0, 115.0)
    s = 13.0 * t + 15.0 * np.sin(t / 9.0)
    north, height = 60.0 * np.sin(s / 200.0), 500.0 + 15.0 * np.sin(s / 400.0)
    points = [
        f'<trkpt lat="{48.0 + (y + a) / 111_194.9:.7f}" lon="{11.0 + (x + b) / 74_500.0:.7f}"><ele>{z + c:.1f}</ele>'
        f"<time>2026-05-04T07:{31 + int(when) // 60}:{int(when) % 60:02d}Z</time></trkpt>"
        for when, x, y, z, (a, b, c) in zip(t, s, north, height, rng.normal(0.0, 1.5, (len(t), 3)), strict=True)
    ]
    head = '<?xml version="1.0"?>\n<gpx version="1.1" creator="first hour" xmlns="http://www.topografix.com/GPX/1/1"><trk><name>tour</name><trkseg>\n'
    (folder / "tour.gpx").write_text(head + "\n".join(points) + "\n</trkseg></trk></gpx>\n", encoding="utf-8")


def raceline(folder: Path) -> None:
    """The path that the first command planned, as a table of s, x, y, psi, v, kappa."""
    planned = energy_mgr.Trajectory.load("out/plan/trajectory.csv")
    energy_mgr.trajectory.files.write_path_table(planned, folder / "raceline.csv")


def noisy(folder: Path) -> None:
    """`noisy.csv` and `track.csv`: a surveyed road whose points miss the road by some centimetres."""
    rng = np.random.default_rng(1)
    survey = roads.RoadBuilder("survey").straight(100).bend(60, np.radians(70), 20).straight(150).bend(80, -np.radians(50), 20).straight(100)
    road = survey.build()
    x, y = road.reference.position(np.arange(0.0, road.length, 5.0)).T
    rows = np.column_stack([x, y, np.full_like(x, 3.5), np.full_like(x, 3.5)])
    rows[1:-1, :2] += rng.normal(0.0, 0.03, (len(rows) - 2, 2))
    for name in ("noisy.csv", "track.csv"):
        np.savetxt(folder / name, rows, "%.4f", delimiter=",", header="x_m,y_m,w_tr_right_m,w_tr_left_m")


class Bench:
    """The shipped 40 Ah cell on a cycler that switches off at the cell's limits of voltage and charge."""

    cell = load_cell("nmc_40ah")

    def run(self, time: np.ndarray, current: np.ndarray, temperature: float) -> np.ndarray:
        """Terminal voltage until the cycler switches off."""
        run = simulate(self.cell, time, current, temperature, 1.0)
        slow = (current < 0.0) & (current > -8.0)
        ends = np.flatnonzero((run.soc < 0.0) | (run.voltage < 2.5) | (slow & (run.soc > 1.0)))
        return run.voltage[: int(ends[0])] if len(ends) else run.voltage


def cell_tests(folder: Path) -> None:
    """`tests/*.csv`: slow and dynamic tests at 25 degC, each with its scripts, in the columns of the cyclers (docs/cars.md).

    The first scripts empty the cell and what they leave is nothing, so those that would take out or put in the rest are pauses.
    """
    (folder / "tests").mkdir(exist_ok=True)
    (slow,), (dynamic,) = laboratory(Bench(), 40.0, [WARM])
    taken = dynamic.drive.current
    both = np.concatenate([taken, np.full(6 * 3600, -7.9)])
    voltage = Bench().run(np.arange(len(both), dtype=float), both, WARM)
    back = _rows(np.arange(len(voltage) - len(taken), dtype=float), both[len(taken) : len(voltage)], voltage[len(taken) :])
    pause = _rows(np.array([0.0, 60.0]), np.zeros(2), np.full(2, 3.7))
    there, home = (_rows(script.time, script.current, script.voltage) for script in (slow.discharge, slow.charge))
    for number, rows in enumerate((there, pause, home, pause), start=1):
        rows = rows * [1.0, 1.0, -1.0, 1.0, 1.0, 1.0]  # this cycler counts current into the cell
        columns = "Test_Time(s),Step_Index,Current(A),Voltage(V),Charge_Capacity(Ah),Discharge_Capacity(Ah)"
        np.savetxt(folder / "tests" / f"LAB_OCV_P25_S{number}.csv", rows, "%.6f", delimiter=",", header=columns, comments="")
    for number, rows in enumerate((_rows(dynamic.drive.time, taken, dynamic.drive.voltage), pause, back), start=1):
        columns = "time,step,current,voltage,chgAh,disAh"
        np.savetxt(folder / "tests" / f"LAB_DYN_P25_s{number}.csv", rows, "%.6f", delimiter=",", header=columns, comments="")


def _rows(time: np.ndarray, current: np.ndarray, voltage: np.ndarray) -> np.ndarray:
    """Time, step, current (positive on discharge), voltage and the counters of charge, Ah, as a cycler writes them."""
    moved = np.append(0.0, current[:-1] * np.diff(time)) / 3600.0
    return np.column_stack([time, np.ones_like(time), current, voltage, np.cumsum(np.maximum(-moved, 0.0)), np.cumsum(np.maximum(moved, 0.0))])


if __name__ == "__main__":
    for make in (my_track, my_car, car, town, tour, raceline, noisy, cell_tests):
        make(Path(sys.argv[1]))
