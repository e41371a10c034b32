"""What a path costs: squared curvature over arc length, mixed with length, distance from a centre and curvature rate if wanted.

    J = int kappa^2 + w_rate (d kappa/ds)^2 ds + w_length int ds + w_offset int (e - e_centre)^2 dq

With N = o' x o'' and S = |o'|^2 the first integrand over the spline parameter is N^2 S^(-5/2), from (3.11); the source integrates kappa^2 over the
parameter instead (3.10). Integrals are taken by the Gauss-Legendre rule with four points per segment.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...errors import PlanningError

if TYPE_CHECKING:
    import scipy.sparse as sp
    from numpy.typing import NDArray

    from .spline import ReducedSpline

    Floats = NDArray[np.float64]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True)
class Weights:
    """What is mixed into the integral of squared curvature.

    Attributes:
        length: cost of a metre, 1/m^2; 1e-4 makes a metre as dear as driving it with 100 m radius.
        offset: cost of a square metre beside the lane's centre, per metre of way, 1/m^4.
        curvature_rate: cost of the squared derivative of curvature, m^2; its root is the length over which the path settles into a bend.
    """

    length: float = 0.0
    offset: float = 0.0
    curvature_rate: float = 0.0

    def __post_init__(self) -> None:
        if not all(0.0 <= weight < 1e12 for weight in (self.length, self.offset, self.curvature_rate)):
            raise PlanningError(f"{self}, expected numbers from 0 on")


class Model(NamedTuple):
    """Cost, gradient (3n,) and Gauss-Newton Hessian (3n, 3n), which is convex, at a point."""

    cost: float
    gradient: Floats
    hessian: sp.csc_matrix


@dataclass(frozen=True, eq=False)
class Objective:
    """The cost on a spline.

    Attributes:
        spline: the spline.
        weights: the mix.
        centre: (segments, 4) offset that `weights.offset` counts from, at the stations `nodes`, m.
    """

    spline: ReducedSpline
    weights: Weights
    centre: Floats

    @cached_property
    def share(self) -> tuple[Floats, Floats]:
        """Stations of the Gauss points and their weights in the spline parameter, (k,) each."""
        return nodes(self.spline).ravel(), (0.5 * self.spline.h[:, None] * _WEIGHTS).ravel()

    @cached_property
    def maps(self) -> tuple[Floats, Floats]:
        """(k, 4 or 6, 6) first and second (and third) derivatives by a segment's variables; (k, 4 or 6) their constant parts."""
        q = self.share[0]
        segment = np.repeat(np.arange(len(self.spline.h)), len(_NODES))
        orders = (1, 2, 3) if self.weights.curvature_rate > 0.0 else (1, 2)
        found = [self.spline.basis(q, order, segment) for order in orders]
        return np.concatenate([one.matrix for one in found], axis=1), np.concatenate([one.constant for one in found], axis=1)

    @cached_property
    def sideways(self) -> tuple[Floats, Floats]:
        """Rows (k, 6) and constants (k,) of the weighted distance from the centre."""
        q = self.share[0]
        basis = self.spline.basis(q, 0)
        reference = self.spline.reference
        normal = reference.normal(q)
        root = np.sqrt(self.weights.offset * self.share[1] / self.spline.unit)
        rows = np.matmul(normal[:, None, :], basis.matrix)[:, 0]
        constant = np.sum(normal * (basis.constant - (reference.position(q) - self.spline.origin)), axis=1) - self.centre.ravel()
        return root[:, None] * rows, root * constant

    def _local(self, x: Floats) -> Floats:
        return np.repeat(x[self.spline.columns], len(_NODES), axis=0)

    def _state(self, local: Floats) -> Floats:
        matrix, constant = self.maps
        return np.matmul(matrix, local[:, :, None])[:, :, 0] + constant

    def residuals(self, x: Floats) -> Floats:
        """(segments, 4) residuals whose squares add up to the integral of squared curvature, `sqrt(w |o'|) kappa`."""
        p, q = np.split(self._state(self._local(x))[:, :4], 2, axis=1)
        return (np.sqrt(self.share[1]) * _cross(p, q) * np.sum(p**2, axis=1) ** -1.25).reshape(-1, len(_NODES))

    def cost(self, x: Floats) -> float:
        """The cost at `x`."""
        local = self._local(x)
        state = self._state(local)
        total = float(np.sum(self._curvature(state)))
        weights, share = self.weights, self.share[1]
        if weights.length > 0.0:
            total += weights.length * float(share @ np.hypot(state[:, 0], state[:, 1]))
        if weights.curvature_rate > 0.0:
            total += float(np.sum(_rate_residual(state, weights.curvature_rate * share)[0] ** 2))
        if weights.offset > 0.0:
            rows, constant = self.sideways
            total += float(np.sum((np.sum(rows * local, axis=1) + constant) ** 2))
        return total

    def _curvature(self, state: Floats) -> Floats:
        p, q = state[:, :2], state[:, 2:4]
        return self.share[1] * _cross(p, q) ** 2 * (p[:, 0] ** 2 + p[:, 1] ** 2) ** -2.5

    def model(self, x: Floats) -> Model:
        """Cost, gradient and Gauss-Newton Hessian at `x`; of length and distance from the centre the Hessian is exact."""
        local = self._local(x)
        state, share, weights = self._state(local), self.share[1], self.weights
        matrix, _ = self.maps
        residual, slope = _curvature_residual(state, share)
        rows = [_through(slope, matrix[:, :4])]
        cost, gradient = float(residual @ residual), 2.0 * residual[:, None] * rows[0]
        if weights.curvature_rate > 0.0:
            residual, slope = _rate_residual(state, weights.curvature_rate * share)
            rows.append(_through(slope, matrix))
            cost += float(residual @ residual)
            gradient += 2.0 * residual[:, None] * rows[-1]
        if weights.offset > 0.0:
            sideways, constant = self.sideways
            residual = np.sum(sideways * local, axis=1) + constant
            rows.append(sideways)
            cost += float(residual @ residual)
            gradient += 2.0 * residual[:, None] * sideways
        if weights.length > 0.0:
            speed, along, across = _length_terms(state, weights.length * share)
            rows.append(_through(across, matrix[:, :2]))
            cost += float(np.sum(speed))
            gradient += _through(along, matrix[:, :2])
        stacked = np.concatenate([row.reshape(-1, len(_NODES), 6) for row in rows], axis=1)
        block = 2.0 * np.matmul(stacked.transpose(0, 2, 1), stacked)
        # what the equalities leave free is fixed by the cost; the floor only spares the QP solvers a singular block
        block += np.eye(6) * (1e-10 * float(block.max()))
        spline = self.spline
        return Model(cost, spline.gather(gradient.reshape(-1, len(_NODES), 6).sum(axis=1)), spline.assemble(block))


def nodes(spline: ReducedSpline) -> Floats:
    """(segments, 4) stations of the Gauss points, m."""
    start, length = spline.breaks[:-1, None], np.diff(spline.breaks)[:, None]
    return start + 0.5 * length * (1.0 + _NODES)


def thin_beam(spline: ReducedSpline) -> sp.csc_matrix:
    """Hessian of the integral of the squared second derivative by the spline parameter, 4/3 of (3.2) for knots one apart."""
    # over a segment the second derivative is linear: h (f0 f0 + f0 f1 + f1 f1) / 3 with the values f at its ends
    ends = [spline.basis(at, 2, np.arange(len(spline.h))).matrix for at in (spline.breaks[:-1], spline.breaks[1:])]
    cross = np.matmul(ends[0].transpose(0, 2, 1), ends[1])
    squares = sum(np.matmul(end.transpose(0, 2, 1), end) for end in ends)
    block = (2.0 / 3.0 * spline.h)[:, None, None] * (squares + 0.5 * (cross + cross.transpose(0, 2, 1)))
    return spline.assemble(block + np.eye(6) * (1e-12 * float(np.max(block))))


def _cross(p: Floats, q: Floats) -> Floats:
    return p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]


def _through(slope: Floats, matrix: Floats) -> Floats:
    """(k, 6) derivatives by a segment's variables of what has derivatives (k, m) by the curve's."""
    return np.matmul(slope[:, None, :], matrix)[:, 0]


def _curvature_residual(state: Floats, share: Floats) -> tuple[Floats, Floats]:
    """Residuals sqrt(w |o'|) kappa, that is sqrt(w) N S^(-5/4), and their Jacobian (k, 4) by first and second derivative."""
    p, q = state[:, :2], state[:, 2:4]
    square, cross = p[:, 0] ** 2 + p[:, 1] ** 2, _cross(p, q)
    by_state = np.stack([q[:, 1], -q[:, 0], -p[:, 1], p[:, 0]], axis=1)
    by_state[:, :2] -= (2.5 * cross / square)[:, None] * p
    root = np.sqrt(share) * square**-1.25
    return root * cross, root[:, None] * by_state


def _length_terms(state: Floats, weight: Floats) -> tuple[Floats, Floats, Floats]:
    """Lengths w |o'|, their gradients (k, 2) by o', and the rows (k, 2) whose squares, twice, are their Hessians."""
    p = state[:, :2]
    speed = np.hypot(p[:, 0], p[:, 1])
    across = np.sqrt(0.5 * weight / speed**3)[:, None] * np.stack([-p[:, 1], p[:, 0]], axis=1)
    return weight * speed, (weight / speed)[:, None] * p, across


def _rate_residual(state: Floats, weight: Floats) -> tuple[Floats, Floats]:
    """Residuals sqrt(w |o'|) d kappa/ds and their Jacobian (k, 6) by the three derivatives of the curve."""
    p, q, t = state[:, :2], state[:, 2:4], state[:, 4:6]
    square, along = p[:, 0] ** 2 + p[:, 1] ** 2, np.sum(p * q, axis=1)
    second, third = _cross(p, q), _cross(p, t)
    root = np.sqrt(weight)
    first_power, second_power = square**-1.75, square**-2.75
    residual = root * (third * first_power - 3.0 * second * along * second_power)

    def turned(v: Floats) -> Floats:
        return np.stack([v[:, 1], -v[:, 0]], axis=1)

    by_p = turned(t) * first_power[:, None] - 3.5 * (third * first_power / square)[:, None] * p
    by_p -= 3.0 * second_power[:, None] * (turned(q) * along[:, None] + second[:, None] * q)
    by_p += 16.5 * (second * along * second_power / square)[:, None] * p
    by_q = -3.0 * second_power[:, None] * (-turned(p) * along[:, None] + second[:, None] * p)
    by_t = -turned(p) * first_power[:, None]
    return residual, root[:, None] * np.concatenate([by_p, by_q, by_t], axis=1)
