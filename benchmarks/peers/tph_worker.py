"""A peer's minimum-curvature line: TUM's trajectory-planning-helpers, called from outside, in an environment of its own.

    python tph_worker.py TRACK.csv OUT.json [--width 3.4] [--kappa 0.12] [--step 3.0] [--iterations 30]

This script runs under the python of that environment, never under ours; it needs numpy, trajectory_planning_helpers and the
quadprog beneath that, no more:

    python3 -m venv ENV
    ENV/bin/pip install --no-deps trajectory-planning-helpers==0.79
    ENV/bin/pip install numpy scipy quadprog

(the package pins quadprog 0.1.7 of years ago, and asks for a matplotlib which nothing called here imports). Set OPENBLAS_NUM_THREADS=1
outside for times on one core.

The way follows TUM's global_racetrajectory_optimization with its defaults: smooth the surveyed centre line, lay splines through it, solve
the quadratic program once (their "mincurv"), then again and again, each linearised about the last answer (their "mincurv_iqp": at least three
times, the first two steps shortened, until linearised and true curvature agree to 0.01 1/m). OUT.json holds the times, the smoothed centre line
with its widths, and both lines; a part that fails holds the exception's text as its status, and the parts before it stay.
"""

import argparse
import json
import os
import platform
import time
from collections.abc import Callable
from importlib import metadata
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import quadprog
import trajectory_planning_helpers as tph

Result = dict[str, Any]


def adapt_to_current_numpy() -> None:
    """Two places of the smoothing lean on arrays of one element passing for numbers; hand them numbers. Nothing else is changed."""
    smoothing = tph.spline_approximation
    distance, fmin = smoothing.dist_to_p, smoothing.optimize.fmin
    smoothing.dist_to_p = lambda t_glob, path, p: distance(float(np.ravel(t_glob)[0]), path, p)
    smoothing.optimize = SimpleNamespace(fmin=lambda *args, **kwargs: float(fmin(*args, **kwargs)[0]))


class Watch:
    """Stands in for one function: counts its calls, adds up their time, and keeps what `note` picks from their results."""

    def __init__(self, function: Callable[..., Any], note: Callable[[Any], float] | None = None) -> None:
        self.function = function
        self.note = note
        self.reset()

    def reset(self) -> None:
        """Forget the calls so far."""
        self.calls, self.seconds = 0, 0.0
        self.notes: list[float] = []

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """Call through."""
        self.calls += 1
        start = time.perf_counter()
        try:
            result = self.function(*args, **kwargs)
        finally:
            self.seconds += time.perf_counter() - start
        if self.note is not None:
            self.notes.append(self.note(result))
        return result


def clock() -> np.ndarray:
    """Seconds on the wall and seconds of processor: the two part when the machine is busy with something else."""
    return np.array((time.perf_counter(), time.process_time()))


def since(start: np.ndarray, part: str = "") -> Result:
    """The two times since then, named."""
    wall, processor = (clock() - start).tolist()
    return {f"{part}s": wall, f"{part}cpu_s": processor}


def smoothed(track: np.ndarray, step: float) -> np.ndarray:
    """The centre line as smoothed by TPH, with widths to its right and left: rows of x, y, right, left; not closed."""
    return tph.spline_approximation.spline_approximation(track=track, k_reg=3, s_reg=10, stepsize_prep=1.0, stepsize_reg=step)


def splines(track: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Coefficients in x and y, the matrix of the spline's equations and the unit normals, for the closed line through the track's points."""
    closed = np.vstack((track[:, :2], track[0, :2]))
    return tph.calc_splines.calc_splines(path=closed, use_dist_scaling=False)


def line(track: np.ndarray, normals: np.ndarray, alpha: np.ndarray) -> list[list[float]]:
    """The points moved by alpha along their normals."""
    return (track[:, :2] + alpha[:, None] * normals).tolist()


def one_qp(track: np.ndarray, normals: np.ndarray, matrix: np.ndarray, args: argparse.Namespace, solver: Watch) -> Result:
    """A single quadratic program about the centre line."""
    solver.reset()
    start = clock()
    alpha, error = tph.opt_min_curv.opt_min_curv(
        reftrack=track.copy(), normvectors=normals, A=matrix, kappa_bound=args.kappa, w_veh=args.width, closed=True
    )
    taken = since(start)
    return {"status": "solved", "quadprog_s": solver.seconds, "curvature_error": float(error), "points": line(track, normals, alpha)} | taken


def converged(
    track: np.ndarray, coefficients: tuple[np.ndarray, np.ndarray], normals: np.ndarray, matrix: np.ndarray, args: argparse.Namespace, solver: Watch
) -> Result:
    """Quadratic programs one after another through TPH's own loop; its time holds the first program as well."""
    xs, ys = coefficients
    solver.reset()
    inner = tph.opt_min_curv.opt_min_curv
    qp = Watch(inner, note=lambda result: float(result[1]))

    def bounded(*given: Any, **named: Any) -> Any:
        alpha, error = qp(*given, **named)
        # TPH's loop knows no limit; told of no error at all, it stops
        return alpha, 0.0 if qp.calls >= args.iterations else error

    tph.opt_min_curv.opt_min_curv = bounded
    start = clock()
    try:
        every = np.arange(len(track))
        lengths = tph.calc_spline_lengths.calc_spline_lengths(coeffs_x=xs, coeffs_y=ys)
        psi, kappa, dkappa = tph.calc_head_curv_an.calc_head_curv_an(
            coeffs_x=xs, coeffs_y=ys, ind_spls=every, t_spls=np.zeros(len(track)), calc_dcurv=True
        )
        alpha, last_track, last_normals = tph.iqp_handler.iqp_handler(
            reftrack=track.copy(),
            normvectors=normals,
            A=matrix,
            spline_len=lengths,
            psi=psi,
            kappa=kappa,
            dkappa=dkappa,
            kappa_bound=args.kappa,
            w_veh=args.width,
            print_debug=False,
            plot_debug=False,
            stepsize_interp=args.step,
            iters_min=min(3, args.iterations),
            curv_error_allowed=args.tolerance,
        )[:3]
        found = {"status": "converged" if qp.notes[-1] <= args.tolerance else "stopped at the limit", "points": line(last_track, last_normals, alpha)}
    except Exception as error:
        found = {"status": failure(error)}
    finally:
        tph.opt_min_curv.opt_min_curv = inner
    return found | since(start) | {"qp_s": qp.seconds, "quadprog_s": solver.seconds, "iterations": qp.calls, "curvature_errors": qp.notes}


def failure(error: Exception) -> str:
    """An exception in one line."""
    return f"failed: {type(error).__name__}: {error}"


def run(args: argparse.Namespace) -> Result:
    """All parts in turn."""
    versions = {name: metadata.version(name) for name in ("trajectory-planning-helpers", "numpy", "scipy", "quadprog")}
    out: Result = {
        "track": args.track.stem,
        "settings": {"width": args.width, "kappa": args.kappa, "step": args.step, "tolerance": args.tolerance, "iterations": args.iterations},
        "versions": versions | {"python": platform.python_version()},
        "blas_threads": os.environ.get("OPENBLAS_NUM_THREADS"),
        "status": "solved",
    }
    quadprog.solve_qp = solver = Watch(quadprog.solve_qp)
    try:
        survey = np.loadtxt(args.track, delimiter=",", comments="#")[:, :4]
        start = clock()
        track = smoothed(survey, args.step)
        out |= {"n": len(track)} | since(start, "smoothing_")
        out["centre"] = {"points": track[:, :2].tolist(), "right": track[:, 2].tolist(), "left": track[:, 3].tolist()}
        start = clock()
        xs, ys, matrix, normals = splines(track)
        out |= since(start, "splines_")
        try:
            out["one"] = one_qp(track, normals, matrix, args, solver)
        except Exception as error:
            out["one"] = {"status": failure(error)}
        out["converged"] = converged(track, (xs, ys), normals, matrix, args, solver)
        if any(out[part]["status"].startswith("failed") for part in ("one", "converged")):
            out["status"] = "; ".join(f"{part} {out[part]['status']}" for part in ("one", "converged"))
    except Exception as error:
        out["status"] = failure(error)
    return out


def main() -> int:
    """Read the arguments, run, write; 1 if any part failed."""
    parser = argparse.ArgumentParser(description="minimum-curvature line by trajectory-planning-helpers")
    parser.add_argument("track", type=Path, help="CSV of x_m, y_m, w_tr_right_m, w_tr_left_m")
    parser.add_argument("out", type=Path, help="JSON to write")
    parser.add_argument("--width", type=float, default=3.4, help="the vehicle's width with its safety margin, m")
    parser.add_argument("--kappa", type=float, default=0.12, help="bound of the curvature, 1/m")
    parser.add_argument("--step", type=float, default=3.0, help="distance of the points, m")
    parser.add_argument("--tolerance", type=float, default=0.01, help="error of the linearised curvature that ends the loop, 1/m")
    parser.add_argument("--iterations", type=int, default=30, help="at most so many quadratic programs")
    args = parser.parse_args()
    adapt_to_current_numpy()
    out = run(args)
    args.out.write_text(json.dumps(out), encoding="utf-8")
    return 0 if out["status"] == "solved" else 1


if __name__ == "__main__":
    raise SystemExit(main())
