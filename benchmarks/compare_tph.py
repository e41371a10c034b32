"""TUM's trajectory-planning-helpers beside ours on the same smoothed tracks: `python -m benchmarks.compare_tph TRACK.csv ...`.

The peer runs in an environment of its own, made on first use in out/bench/tph (its pins do not install beside ours). Prints a Markdown table.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

import roads
from energy_mgr.path import PathOptions, plan_path

HOME = Path("out/bench/tph")
WORKER = Path(__file__).parent / "peers" / "tph_worker.py"
BOUND, CLEARANCE, SMOOTHING = 0.12, 1.7, 0.3


def peer_python() -> Path:
    """The peer's interpreter; its environment is made if need be."""
    python = HOME / "env" / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", str(HOME / "env")], check=True)
        pip = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        subprocess.run([*pip, "--no-deps", "trajectory-planning-helpers==0.79"], check=True)
        subprocess.run([*pip, "numpy", "scipy", "quadprog"], check=True)
    return python


def judged(points: list[list[float]]) -> tuple[float, float]:
    """Integral of squared curvature (1/m) and largest curvature (1/m) of the periodic spline through points, every 0.1 m."""
    line = np.array([*points, points[0]])
    u = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    spline = CubicSpline(u, line, bc_type="periodic")
    at = np.linspace(0.0, u[-1], int(u[-1] / 0.1))
    first, second = spline(at, 1), spline(at, 2)
    speed = np.hypot(*first.T)
    kappa = (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / speed**3
    return float(np.trapezoid(kappa**2 * speed, at)), float(np.max(np.abs(kappa)))


def row(track: Path) -> str:
    """A line of the table; both planners run here and now."""
    out = HOME / f"{track.stem}.json"
    subprocess.run(
        [str(peer_python()), str(WORKER), str(track), str(out), "--kappa", str(BOUND)], check=False, env={**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    )
    theirs = json.loads(out.read_text())
    options = PathOptions(curvature_max=BOUND)
    walls = []
    for _ in range(5):
        started = time.perf_counter()
        smooth, _ = roads.smoothed(roads.read(track), SMOOTHING)
        plan_path(smooth, CLEARANCE, extent="road", options=options)
        walls.append(time.perf_counter() - started)
    wall = float(np.median(walls))
    centre = theirs["centre"]
    same = roads.Road.from_points(track.stem, np.array(centre["points"]), -np.array(centre["right"]), np.array(centre["left"]), closed=True)
    path = plan_path(same, CLEARANCE, extent="road", options=options)
    kappa = float(np.max(np.abs(path.curve.curvature(np.arange(0.0, path.curve.length, 0.1)))))
    one, converged = judged(theirs["one"]["points"]), judged(theirs["converged"]["points"])
    once, whole = theirs["smoothing_s"] + theirs["splines_s"] + theirs["one"]["s"], theirs["smoothing_s"] + theirs["converged"]["s"]
    return (
        f"| {track.stem} | {theirs['n']} | {one[0]:.4f} / {converged[0]:.4f} | {path.report.cost:.4f} | {one[1]:.3f} / {converged[1]:.3f} | "
        f"{kappa:.3f} | {once:.1f} / {whole:.1f} | {wall:.2f} | {once / wall:.0f} / {whole / wall:.0f} |"
    )


def main(tracks: list[str]) -> int:
    """Compare on the tracks and print the table."""
    HOME.mkdir(parents=True, exist_ok=True)
    lines = ["| track | n | peer: one QP / converged, 1/m | ours | peer: max curvature | ours | peer s | ours s | times ours |", "|" + "---|" * 9]
    for track in tracks:
        lines.append(row(Path(track)))
        print(lines[-1], file=sys.stderr)
    sys.stdout.write("\n".join(lines) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
