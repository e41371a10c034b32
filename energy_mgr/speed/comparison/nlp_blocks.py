"""Puts a large sparse nonlinear programme together from small functions that repeat over many places (`nlp`).

Each `Block` is compiled once and mapped over its places. Gradient, Jacobian and Hessian of the whole are weighted sums of the small dense ones,
written as one product with a constant sparse matrix each: no colouring, no large expression graph.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from powertrain.symbolic import ca

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]


class Local(NamedTuple):
    """One place on CasADi symbols: unknowns (k), data (d), and in them cost, duration and rows (r)."""

    unknown: Any
    data: Any
    cost: Any
    duration: Any
    rows: Any


@dataclass(frozen=True, eq=False)
class Block:
    """The same `Local` at many places.

    Attributes:
        columns: (k, N) numbers of the unknowns.
        data: (d, N).
        low: (r, N) bounds of the rows.
        high: (r, N).
        until: (t, N) weights with which durations enter the rows on time.
        values: mapped function of unknowns and data: cost, duration, rows.
        slopes: mapped function of the same: gradients of cost and duration, Jacobian of the rows.
        bend: mapped function of the same and multipliers of cost, duration, rows: Hessian of their sum.
    """

    columns: Ints
    data: Floats
    low: Floats
    high: Floats
    until: Floats
    values: Any
    slopes: Any
    bend: Any

    @classmethod
    def of(cls, local: Local, columns: Ints, data: Floats, low: Floats, high: Floats, until: Floats) -> Block:
        """The block with the derivatives of `local`."""
        unknown, count = local.unknown, columns.shape[1]
        weight = ca.SX.sym("weight", 2 + local.rows.shape[0])
        total = weight[0] * local.cost + weight[1] * local.duration + ca.dot(weight[2:], local.rows)
        hessian, _ = ca.hessian(total, unknown)
        slopes = [ca.gradient(local.cost, unknown), ca.gradient(local.duration, unknown), ca.jacobian(local.rows, unknown)]
        made = [
            ca.Function(name, given, ca.cse([ca.densify(part) for part in parts])).map(count)
            for name, given, parts in (
                ("values", [unknown, local.data], [local.cost, local.duration, local.rows]),
                ("slopes", [unknown, local.data], slopes),
                ("bend", [unknown, local.data, weight], [hessian]),
            )
        ]
        return cls(columns, data, low, high, until, *made)


class _Sum(NamedTuple):
    """A sparse matrix whose entries are weighted sums of a vector's."""

    pattern: Any
    weights: Any

    @classmethod
    def at(cls, rows: Ints, columns: Ints, source: Ints, weight: Floats, shape: tuple[int, int], sources: int) -> _Sum:
        """Entry (rows, columns) gets weight times the vector's entry `source`; what meets in a place is added."""
        places, into = np.unique(columns * shape[0] + rows, return_inverse=True)
        pattern = ca.Sparsity.triplet(*shape, (places % shape[0]).tolist(), (places // shape[0]).tolist())
        which = ca.Sparsity.triplet(len(places), sources, into.tolist(), source.tolist())
        return cls(pattern, ca.DM(which, weight[np.lexsort((into, source))]))

    def of(self, vector: Any) -> Any:
        """The matrix."""
        return ca.MX(self.pattern, ca.densify(ca.mtimes(self.weights, vector)))


def assembled(blocks: Sequence[Block], size: int) -> tuple[dict[str, Any], dict[str, Any]]:
    """The programme in `size` unknowns for `casadi.nlpsol`, and its derivatives as options; rows of the blocks first, then those on time."""
    many, timed = sum(block.low.size for block in blocks), len(blocks[0].until)
    x, p = ca.MX.sym("x", size), ca.MX.sym("p", 0)
    factor, duals = ca.MX.sym("factor"), ca.MX.sym("duals", many + timed)
    cost, arrival, rows, slopes, bend, at = 0.0, 0.0, [], [], [], 0
    for block in blocks:
        local, until = ca.reshape(x[block.columns.ravel("F").tolist()], *block.columns.shape), ca.DM(block.until)
        part, duration, own = block.values(local, block.data)
        cost, arrival, rows = cost + ca.sum2(part), arrival + ca.mtimes(until, duration.T), [*rows, ca.vec(own)]
        slopes.append([ca.vec(by) for by in block.slopes(local, block.data)])
        dual = ca.reshape(duals[at : at + block.low.size], *block.low.shape)
        weight = ca.vertcat(ca.repmat(factor, 1, block.columns.shape[1]), ca.mtimes(duals[many:].T, until), dual)
        bend.append(ca.vec(block.bend(local, block.data, weight)))
        at += block.low.size
    g = ca.vertcat(*rows, arrival)
    by_cost, by_time, by_rows = (ca.vertcat(*parts) for parts in zip(*slopes, strict=True))
    gradient, jacobian, hessian = _gradient(blocks, size), _jacobian(blocks, size), _hessian(blocks, size)
    given = {
        "grad_f": ca.Function("grad_f", [x, p], [cost, gradient.of(by_cost)], ["x", "p"], ["f", "grad_f_x"]),
        "jac_g": ca.Function("jac_g", [x, p], [g, jacobian.of(ca.vertcat(by_rows, by_time))], ["x", "p"], ["g", "jac_g_x"]),
        "hess_lag": ca.Function(
            "hess_lag", [x, p, factor, duals], [hessian.of(ca.vertcat(*bend))], ["x", "p", "lam_f", "lam_g"], ["triu_hess_gamma_x_x"]
        ),
    }
    return {"x": x, "p": p, "f": cost, "g": g}, given


# CasADi stores a mapped (a, b) matrix place by place, each column by column: the order (place, column, row) of a C-ordered array


def _gradient(blocks: Sequence[Block], size: int) -> _Sum:
    into = np.concatenate([block.columns.T.ravel() for block in blocks])
    return _Sum.at(into, np.zeros_like(into), np.arange(len(into)), np.ones(len(into)), (size, 1), len(into))


def _jacobian(blocks: Sequence[Block], size: int) -> _Sum:
    rows, columns, at = [], [], 0
    for block in blocks:
        own = block.columns.T
        shape = (*own.shape, block.low.shape[0])
        number = at + np.arange(block.low.size).reshape(shape[0], 1, shape[2])
        rows.append(np.broadcast_to(number, shape).ravel())
        columns.append(np.broadcast_to(own[:, :, None], shape).ravel())
        at += block.low.size
    into = np.concatenate([block.columns.T.ravel() for block in blocks])
    until = np.concatenate([np.repeat(block.until, len(block.columns), axis=1) for block in blocks], axis=1)
    row, source = np.nonzero(until)
    own = sum(len(part) for part in rows)
    return _Sum.at(
        np.concatenate([*rows, at + row]),
        np.concatenate([*columns, into[source]]),
        np.concatenate([np.arange(own), own + source]),
        np.concatenate([np.ones(own), until[row, source]]),
        (at + len(until), size),
        own + len(into),
    )


def _hessian(blocks: Sequence[Block], size: int) -> _Sum:
    """The upper half."""
    pairs = [np.broadcast_arrays(own[:, None, :], own[:, :, None]) for own in (block.columns.T for block in blocks)]
    i, j = (np.concatenate([pair[k].ravel() for pair in pairs]) for k in range(2))
    upper = np.flatnonzero(i <= j)
    return _Sum.at(i[upper], j[upper], upper, np.ones(len(upper)), (size, size), len(i))
