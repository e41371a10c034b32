"""The allocation: our allocator against the published ones, and its QP against other solvers on the same numbers.

Processor time of one thread, over 300 situations of a closed drive: ten periods in a row at each of 30 places, so that a solver that is started from
the last answer has one that is near. Every row of the solvers also times ours in between, problem by problem, so that `found` has a ratio that a
busy machine does not spoil. Residuals are scaled as in `energy_mgr.allocation.qp`, of the answer that the solver gave with its multipliers.
"""

from __future__ import annotations

import time
import warnings
from functools import cache
from typing import NamedTuple

import casadi
import numpy as np
import osqp
import pytest
import qpsolvers
from scipy import sparse

from energy_mgr.allocation import ALLOCATORS, EfficientAllocator, PreviewAllocator, Situation
from energy_mgr.allocation.qp import DenseQP
from powertrain import load_vehicle

from .bench_manager import ClosedLoop, times

pytestmark = pytest.mark.benchmark(timer=time.process_time)

#: Places of the lap, and periods in a row at each.
PLACES, ROW = 30, 10
#: Times that every situation is met.
AGAIN = 5
QP = f"QP of the allocation, 12 unknowns, 33 rows, {PLACES * ROW} situations; figures are for one"
WHOLE = f"allocation, whole call, {PLACES * ROW} situations; figures are for one"
#: What the QP's numbers call no limit.
NONE = 1e29


@cache
def situations() -> list[Situation]:
    """Of a lap of `handling`, with the demands to come."""
    loop = ClosedLoop(horizon=PreviewAllocator(load_vehicle("romo")).horizon)
    allocate, seen = loop.manager.allocator.allocate, []

    def noted(now):
        seen.append(now._replace(before=now.before.copy()))
        return allocate(now)

    loop.manager.allocator.allocate = noted
    loop.steps(times(int(loop.manager.follower.trajectory.journey_time / loop.manager.period)))
    firsts = np.linspace(0, len(seen) - ROW, PLACES).astype(int)
    return [seen[first + k] for first in firsts for k in range(ROW)]


# -- whole calls --------------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ALLOCATORS)
def bench_allocate(benchmark, name):
    benchmark.group = WHOLE
    allocator, ours = ALLOCATORS[name](load_vehicle("romo")), EfficientAllocator(load_vehicle("romo"))
    found, reference, mine = [], [], []
    turns = iter(situations() * (AGAIN + 1))

    def setup():
        now = next(turns)
        began = time.process_time()
        ours.allocate(now)
        reference.append(time.process_time() - began)
        return (now,), {}

    def work(now):
        began = time.process_time()
        found.append(allocator.allocate(now))
        mine.append(time.process_time() - began)

    benchmark.pedantic(work, setup=setup, rounds=len(situations()) * AGAIN, warmup_rounds=len(situations()))
    missed = [max(abs(a - b) for a, b in zip(one.given, now.demand, strict=True)) for one, now in zip(found, situations() * (AGAIN + 1), strict=True)]
    solved = np.mean([one.status == "solved" for one in found])
    words = [
        f"{np.median(mine) / np.median(reference):.2f} times ours in between",
        f"worst residual {max(one.residual for one in found):.1e}",
        f"{100 * solved:.1f} % met, worst miss {max(missed):.2g} m/s2",
    ]
    if name == "efficient":
        words = ["asked 60 us", *words[1:]]
    benchmark.extra_info.update(method=name, ours=name == "efficient", found="; ".join(words))


# -- the QP alone -------------------------------------------------------------------------------------------------------------------------


class Numbers(NamedTuple):
    """min 0.5 z' H z + f' z with lower <= (z, A z) <= upper."""

    H: np.ndarray
    f: np.ndarray
    At: np.ndarray
    lower: np.ndarray
    upper: np.ndarray


@cache
def problems() -> list[Numbers]:
    """The numbers that our allocator gives its solver in every situation."""
    allocator, found = EfficientAllocator(load_vehicle("romo")), []
    for now in situations():
        allocator.allocate(now)
        found.append(Numbers(*(numbers.copy(order="F") for numbers in allocator._qp.numbers)))
    return found


def scaled_residual(p: Numbers, z, multipliers) -> float:
    """The largest violation of the optimality conditions, scaled as in `energy_mgr.allocation.qp`, but in NumPy: our check is not its own judge.

    Multipliers are of bounds, then of rows, positive at an upper one.
    """
    n = len(z)
    push, values = multipliers[:n] + p.At @ multipliers[n:], np.concatenate([z, z @ p.At])
    # a side that is none takes no part: infinity times zero is no number
    above, below = np.minimum(p.upper[:, 0], 1e30) - values, np.maximum(p.lower[:, 0], -1e30) - values
    size = max(1.0, float(np.abs(p.f).max()), float(np.abs(push).max()))
    slack = float(np.abs(np.where(multipliers > 0.0, above, below) * multipliers).max())
    over = max(0.0, float(-above.min()), float(below.max()))
    return max(over, float(np.abs(p.H @ z + p.f[:, 0] + push).max()) / size, slack / size)


class OurSolver:
    """`DenseQP` as the allocator calls it. Here and in the peers `given` and `read` are not timed."""

    def __init__(self) -> None:
        self._qp = DenseQP(*problems()[0].At.shape)

    def given(self, p: Numbers) -> Numbers:
        """What `solve` takes."""
        for place, numbers in zip(self._qp.numbers, p, strict=True):
            place[:] = numbers
        return p

    def solve(self, p: Numbers):
        """The answer; this is timed."""
        return self._qp.solve()

    def read(self, p: Numbers, answer):
        """Point, multipliers, and whether the solver calls it found."""
        return answer.z, answer.multipliers, answer.solved


class ByQpsolvers:
    """`qpsolvers.solve_problem`; its problem is put together beforehand, in the form that the solver likes."""

    def __init__(self, solver: str, **options) -> None:
        self._solver, self._options, self._sparse = solver, options, solver in ("osqp", "clarabel")

    def given(self, p: Numbers):
        """What `solve` takes."""
        n = len(p.f)
        above, below = self._sides(p)
        G = np.vstack([p.At.T[above], -p.At.T[below]])
        h = np.concatenate([p.upper[n:, 0][above], -p.lower[n:, 0][below]])
        P, G = (sparse.csc_matrix(p.H), sparse.csc_matrix(G)) if self._sparse else (np.ascontiguousarray(p.H), G)
        return qpsolvers.Problem(P, p.f[:, 0].copy(), G, h, lb=p.lower[:n, 0].copy(), ub=p.upper[:n, 0].copy())

    @staticmethod
    def _sides(p: Numbers):
        n = len(p.f)
        return np.flatnonzero(p.upper[n:, 0] < NONE), np.flatnonzero(p.lower[n:, 0] > -NONE)

    def solve(self, problem):
        """The answer; this is timed."""
        return qpsolvers.solve_problem(problem, self._solver, **self._options)

    def read(self, p: Numbers, answer):
        """Point, multipliers, and whether the solver calls it found."""
        n, rows = p.At.shape
        if answer.x is None:
            return np.zeros(n), np.zeros(n + rows), False
        above, below = self._sides(p)
        push = np.zeros(n + rows)
        push[:n] = answer.z_box
        push[n + above] += answer.z[: len(above)]
        push[n + below] -= answer.z[len(above) :]
        return answer.x, push, answer.found


class KeptOsqp:
    """OSQP without qpsolvers: set up once, its numbers changed, started from the last answer."""

    def __init__(self, **options) -> None:
        p = problems()[0]
        n = len(p.f)
        P = sparse.csc_matrix(np.triu(np.ones((n, n))))
        # places that are zero in every problem are left out
        used = np.any([q.At.T != 0.0 for q in problems()], axis=0)
        A = sparse.csc_matrix(np.vstack([np.eye(n), used]))
        self._of_p, self._of_a = ((m.indices, np.repeat(np.arange(n), np.diff(m.indptr))) for m in (P, A))
        self._solver = osqp.OSQP()
        self._solver.setup(P, p.f[:, 0], A, *self._bounds(p), verbose=False, **options)

    @staticmethod
    def _bounds(p: Numbers):
        return np.where(p.lower[:, 0] > -NONE, p.lower[:, 0], -np.inf), np.where(p.upper[:, 0] < NONE, p.upper[:, 0], np.inf)

    def given(self, p: Numbers):
        """What `solve` takes."""
        whole = np.vstack([np.eye(len(p.f)), p.At.T])
        low, high = self._bounds(p)
        return {"Px": p.H[self._of_p], "q": p.f[:, 0].copy(), "Ax": whole[self._of_a], "l": low, "u": high}

    def solve(self, numbers):
        """The answer; this is timed."""
        self._solver.update(**numbers)
        return self._solver.solve()

    def read(self, p: Numbers, answer):
        """Point, multipliers, and whether the solver calls it found."""
        return answer.x, answer.y, answer.info.status_val == osqp.SolverStatus.OSQP_SOLVED


class ByCasadi:
    """DAQP as CasADi offers it; conversions to its matrices are made beforehand."""

    def __init__(self) -> None:
        n, rows = problems()[0].At.shape
        shapes = {"h": casadi.Sparsity.dense(n, n), "a": casadi.Sparsity.dense(rows, n)}
        self._solver = casadi.conic("allocation", "daqp", shapes, {"error_on_fail": False})

    def given(self, p: Numbers):
        """What `solve` takes."""
        n, dm = len(p.f), casadi.DM
        box, rows = (dm(p.lower[:n]), dm(p.upper[:n])), (dm(p.lower[n:]), dm(p.upper[n:]))
        return {"h": dm(p.H), "g": dm(p.f), "a": dm(p.At.T), "lbx": box[0], "ubx": box[1], "lba": rows[0], "uba": rows[1]}

    def solve(self, numbers):
        """The answer; this is timed."""
        return self._solver(**numbers)

    def read(self, p: Numbers, answer):
        """Point, multipliers, and whether the solver calls it found."""
        push = np.concatenate([answer["lam_x"].full(), answer["lam_a"].full()])[:, 0]
        return answer["x"].full()[:, 0], push, bool(self._solver.stats()["success"])


POLISHED = {"polishing": True, "max_iter": 20_000}
SOLVERS = {
    "ours: DAQP kept, answer checked": OurSolver,
    "qpsolvers, OSQP, as it comes": lambda: ByQpsolvers("osqp"),
    "qpsolvers, OSQP, 1e-6": lambda: ByQpsolvers("osqp", eps_abs=1e-6, eps_rel=1e-6, max_iter=20_000),
    "qpsolvers, OSQP, 1e-6, polished": lambda: ByQpsolvers("osqp", eps_abs=1e-6, eps_rel=1e-6, **POLISHED),
    "qpsolvers, OSQP, 1e-8, polished": lambda: ByQpsolvers("osqp", eps_abs=1e-8, eps_rel=1e-8, **POLISHED),
    "OSQP kept, 1e-6, polished": lambda: KeptOsqp(eps_abs=1e-6, eps_rel=1e-6, **POLISHED),
    "qpsolvers, DAQP": lambda: ByQpsolvers("daqp"),
    "qpsolvers, Clarabel": lambda: ByQpsolvers("clarabel"),
    "qpsolvers, PIQP dense": lambda: ByQpsolvers("piqp", backend="dense"),
    "qpsolvers, PIQP dense, 1e-10": lambda: ByQpsolvers("piqp", backend="dense", eps_abs=1e-10, eps_rel=1e-10),
    "CasADi conic, DAQP": ByCasadi,
}


@pytest.mark.parametrize("name", SOLVERS)
def bench_qp(benchmark, name):
    benchmark.group = QP
    if name.startswith("CasADi") and not casadi.has_conic("daqp"):
        pytest.skip("this CasADi has no DAQP")
    solver, ours = SOLVERS[name](), OurSolver()
    again = AGAIN if name.startswith("ours") else 2
    turns = iter(problems() * (again + 1))
    answers, reference, mine, inner = [], [], [], []

    def setup():
        p = next(turns)
        ours.given(p)
        began = time.process_time()
        ours.solve(p)
        reference.append(time.process_time() - began)
        return (p, solver.given(p)), {}

    def work(p, given):
        began = time.process_time()
        answer = solver.solve(given)
        mine.append(time.process_time() - began)
        if len(answers) < len(problems()):
            answers.append(solver.read(p, answer))
            inner.append(getattr(answer, "solve_time", None))

    with warnings.catch_warnings():
        # of an answer that was not found; counted below
        warnings.simplefilter("ignore")
        benchmark.pedantic(work, setup=setup, rounds=len(problems()) * again, warmup_rounds=len(problems()))
    residuals = np.array([scaled_residual(p, np.asarray(z), np.asarray(push)) for p, (z, push, _) in zip(problems(), answers, strict=True)])
    failed = sum(not good for _, _, good in answers)
    words = [f"residual: median {np.median(residuals):.1e}, worst {residuals.max():.1e}"]
    if not name.startswith("ours"):
        words.insert(0, f"{np.median(mine) / np.median(reference):.1f} times ours in between")
    if inner[0] is not None:
        words.append(f"{1e6 * np.median(inner):.0f} us of it in the solver's own solve")
    words += [f"{failed} not found"] * bool(failed)
    benchmark.extra_info.update(method=name, ours=name.startswith("ours"), found="; ".join(words))
