"""A step of Newton's method for a chain: the equations written down at an iterate, what belongs to one interval eliminated, solved.

What is left after the slacks and the intervals' own unknowns are eliminated is a band of one (with jerk two) off-diagonals, so that a step costs a
fixed number of operations per station. The dense rows go around the band (`band`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .band import bordered, bordered_convex
from .iterate import Direction, Iterate

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .chain import Chain
    from .interval import Slopes
    from .iterate import State

    Floats = NDArray[np.float64]


class Equations(NamedTuple):
    """Newton's equations at an iterate: everything that they are written from.

    Attributes:
        chain: the programme.
        at: the iterate.
        state: its values.
        slopes: derivatives of the intervals.
        gradient: (n,) of the Lagrangian by x.
        local_gradient: (N, locals) of the Lagrangian by the intervals' own unknowns.
        barrier: what products of slacks and multipliers are to become.
    """

    chain: Chain
    at: Iterate
    state: State
    slopes: Slopes
    gradient: Floats
    local_gradient: Floats
    barrier: float


def direction(given: Equations, shift: float) -> tuple[Direction | None, float]:
    """A step of Newton's method, None where the band has no factor, and by how much its diagonal was raised."""
    chain, at, barrier = given.chain, given.at, given.barrier
    rhs, local_rhs, hessian = _condensed(given)
    inner = np.linalg.inv(hessian[:, 2:, 2:]) if chain.locals == 2 else 1.0 / hessian[:, 2:, 2:]
    across = np.matmul(hessian[:, :2, 2:], inner)
    ends = hessian[:, :2, :2] - np.matmul(across, hessian[:, 2:, :2])
    carried = np.matmul(across, local_rhs[:, :, None])[:, :, 0]
    rhs[:-1] -= carried[:, 0]
    rhs[1:] -= carried[:, 1]
    band = _band(chain, at, ends)
    if chain.jerk:
        chain.jerk.add_curvature(band, rhs, at.x, at.jerk_slack, at.jerk_dual, barrier, chain.free)
    rhs[chain.fixed] = 0.0
    dense, diagonal, excess = _dense(given)
    solved = bordered(band, rhs, dense, diagonal, excess)
    if solved is None:
        solved, shift = bordered_convex(band, rhs, dense, diagonal, excess, shift)
    else:
        shift = 0.0
    if solved is None:
        return None, shift
    x, multiplier = solved
    ends_x = np.column_stack([x[:-1], x[1:]])
    local = np.matmul(inner, (local_rhs - np.matmul(hessian[:, 2:, :2], ends_x[:, :, None])[:, :, 0])[:, :, None])[:, :, 0]
    ring = float(multiplier[-1]) if chain.closed else 0.0
    return Direction(x, local, multiplier[: len(at.price)], ring), shift


def change(given: Equations, step: Direction) -> Iterate:
    """The step for everything that an iterate holds."""
    chain, at, state, slopes, barrier = given.chain, given.at, given.state, given.slopes, given.barrier
    local = np.zeros_like(at.local)
    local[:, : chain.locals] = step.local
    along = np.column_stack([step.x[:-1], step.x[1:], local])
    slack = -(state.values.rows + at.slack) - np.matmul(slopes.rows, along[:, :, None])[:, :, 0]
    room, own = chain.room(at.x), np.where(chain.free, at.x, 1.0)
    jerk_slack = jerk_dual = np.zeros((0, 2))
    if chain.jerk:
        jerk_slack = -(state.jerk + at.jerk_slack) - chain.jerk.along(at.x, step.x)
        jerk_dual = barrier / at.jerk_slack - at.jerk_dual - at.jerk_dual / at.jerk_slack * jerk_slack
    return Iterate(
        np.where(chain.free, step.x, 0.0),
        local,
        slack,
        barrier / at.slack - at.dual - at.dual / at.slack * slack,
        np.where(chain.free, barrier / own - at.low - at.low / own * step.x, 0.0),
        np.where(chain.free, barrier / room - at.high + at.high / room * step.x, 0.0),
        barrier / at.price - at.late - at.late / at.price * step.price,
        step.price,
        step.ring,
        jerk_slack,
        jerk_dual,
    )


def _condensed(given: Equations) -> tuple[Floats, Floats, Floats]:
    """Right-hand sides by stations (n,) and local unknowns (N, locals), and the intervals' Hessians, with the slacks of the rows eliminated."""
    chain, at, state, slopes, gradient, local_gradient, barrier = given
    size = 2 + chain.locals
    rows = slopes.rows[:, :, :size].copy()
    hessian = slopes.hessian[:, :size, :size].copy()
    for end, free in ((0, chain.free[:-1]), (1, chain.free[1:])):
        rows[:, :, end] *= free[:, None]
        hessian[:, end, :] *= free[:, None]
        hessian[:, :, end] *= free[:, None]
    weight = at.dual / at.slack
    # what the slacks ask for: barrier / s - y + (y / s) (c + s), added to y
    wanted = barrier / at.slack - at.dual + weight * (state.values.rows + at.slack)
    hessian += np.matmul(rows.transpose(0, 2, 1), weight[:, :, None] * rows)
    push = np.matmul(wanted[:, None, :], rows)[:, 0, :]
    rhs, local_rhs = -gradient, -(local_gradient + push[:, 2:])
    rhs[:-1] -= push[:, 0]
    rhs[1:] -= push[:, 1]
    room, own = chain.room(at.x), np.where(chain.free, at.x, 1.0)
    rhs += np.where(chain.free, barrier / own - at.low, 0.0) - np.where(chain.free, barrier / room - at.high, 0.0)
    return rhs, local_rhs, hessian


def _band(chain: Chain, at: Iterate, ends: Floats) -> Floats:
    """The band in LAPACK's upper storage from the intervals' blocks `ends` (N, 2, 2) and the bounds of x."""
    room, own = chain.room(at.x), np.where(chain.free, at.x, 1.0)
    band = np.zeros((3 if chain.jerk else 2, len(at.x)))
    band[-1] = np.where(chain.free, at.low / own + at.high / room, 1.0)
    band[-1, :-1] += ends[:, 0, 0]
    band[-1, 1:] += ends[:, 1, 1]
    band[-2, 1:] = ends[:, 0, 1]
    return band


def _dense(given: Equations) -> tuple[Floats, Floats, Floats]:
    """Gradients of the deadlines and the ring (m, n), what their slacks put on the diagonal, and the right-hand sides."""
    chain, at, slopes, barrier = given.chain, given.at, given.slopes, given.barrier
    rows, diagonal, excess = [], [], []
    for k in range(len(chain.deadlines)):
        inside = chain.signs[k] / chain.times[k] * chain.within[k][:, None] * slopes.time
        row = np.zeros_like(at.x)
        row[:-1] += inside[:, 0]
        row[1:] += inside[:, 1]
        rows.append(np.where(chain.free, row, 0.0))
        diagonal.append(at.late[k] / at.price[k])
        # (s / y) dy = barrier / y - s + (excess + s) + G dx
        excess.append(given.state.excess[k] + barrier / at.price[k])
    if chain.closed:
        row = np.zeros_like(at.x)
        row[0], row[-1] = 1.0, -1.0
        rows.append(row)
        diagonal.append(0.0)
        excess.append(at.x[0] - at.x[-1])
    return np.array(rows).reshape(len(rows), len(at.x)), np.array(diagonal), np.array(excess)
