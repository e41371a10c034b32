"""Sparse derivatives of a programme whose every interval is the same small function of a few variables.

    f = c' O(x) + d' x,   g = A x + S O(x),   O = (outputs of all intervals)

CasADi could differentiate that by itself, through graph colouring; putting together the small Jacobians and Hessians of the intervals gives the same
numbers thirty times sooner.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from powertrain.symbolic import ca

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]


class Assembled(NamedTuple):
    """The programme and its derivatives, as `casadi.nlpsol` takes them."""

    nlp: dict[str, Any]
    derivatives: dict[str, Any]


class _Scatter(NamedTuple):
    """Where the entries of all small matrices go: `nonzeros = matrix @ entries` in a matrix of the given sparsity."""

    matrix: Any
    sparsity: Any

    @classmethod
    def of(cls, rows: Ints, columns: Ints, entries: Ints, values: Floats, shape: tuple[int, int], count: int) -> _Scatter:
        """`values` times the entry number `entries` of `count` is added at (row, column) of a matrix of that shape."""
        keys, place = np.unique(columns * shape[0] + rows, return_inverse=True)
        matrix = sp.csc_matrix((values, (place.ravel(), entries)), shape=(len(keys), count))
        pattern = ca.Sparsity.triplet(*shape, (keys % shape[0]).tolist(), (keys // shape[0]).tolist())
        return cls(ca.DM(matrix), pattern)

    def __call__(self, entries: Any) -> Any:
        """The sparse matrix."""
        return ca.MX(self.sparsity, ca.mtimes(self.matrix, entries))


def assemble(function: Any, table: Floats, places: Ints, cost: Floats, price: Floats, linear: sp.csc_matrix, select: sp.csc_matrix) -> Assembled:
    """The programme with exact sparse derivatives.

    Args:
        function: outputs (r,) of an interval by its local variables (k,) and its column of the table.
        table: (t, m) constants of the intervals.
        places: (k, m) indices of the variables of each interval, none twice in one.
        cost: (r m,) c, by interval, outputs first.
        price: (variables,) d.
        linear: A, a row per constraint.
        select: S, a row per constraint, columns as `cost`.
    """
    variables = int(linear.shape[1])
    m = table.shape[1]
    x = ca.MX.sym("x", variables)
    local, constants = ca.reshape(x[places.ravel(order="F").tolist()], len(places), m), ca.DM(table)
    outputs = ca.vec(function.map(m)(local, constants))
    f = ca.dot(ca.DM(cost), outputs) + ca.dot(ca.DM(price), x)
    g = ca.mtimes(ca.DM(linear), x) + ca.mtimes(ca.DM(select), outputs)
    slopes, bends, slope_mask, bend_mask = _small(function)
    entries = ca.vec(slopes.map(m)(local, constants))
    gradient = _slope_scatter(sp.csc_matrix(cost[None]), places, slope_mask, variables)(entries)
    jacobian = _slope_scatter(select, places, slope_mask, variables)(entries) + ca.DM(linear)
    scale, multipliers = ca.MX.sym("scale"), ca.MX.sym("multipliers", int(linear.shape[0]))
    weights = scale * ca.DM(cost) + ca.mtimes(ca.DM(select.T.tocsc()), multipliers)
    curved = ca.vec(bends.map(m)(local, constants, ca.reshape(weights, function.size1_out(0), m)))
    hessian = _bend_scatter(places, bend_mask, variables)(curved)
    nothing = ca.MX.sym("p", 0)
    derivatives = {
        "grad_f": ca.Function("nlp_grad_f", [x, nothing], [f, ca.densify(gradient.T) + ca.DM(price)], ["x", "p"], ["f", "grad_f_x"]),
        "jac_g": ca.Function("nlp_jac_g", [x, nothing], [g, jacobian], ["x", "p"], ["g", "jac_g_x"]),
        "hess_lag": ca.Function("nlp_hess_l", [x, nothing, scale, multipliers], [hessian], ["x", "p", "lam_f", "lam_g"], ["triu_hess_gamma_x_x"]),
    }
    return Assembled({"x": x, "f": f, "g": g}, derivatives)


def _small(function: Any) -> tuple[Any, Any, NDArray[np.bool_], NDArray[np.bool_]]:
    """Dense Jacobian and weighted Hessian of an interval as functions, and which of their entries can differ from zero."""
    local, constants = ca.SX.sym("local", function.size1_in(0)), ca.SX.sym("constants", function.size1_in(1))
    weights = ca.SX.sym("weights", function.size1_out(0))
    (outputs,) = function.call([local, constants])
    slope = ca.jacobian(outputs, local)
    bend = ca.triu(ca.hessian(ca.dot(weights, outputs), local)[0])
    slopes = ca.Function("slopes", [local, constants], [ca.densify(slope)])
    bends = ca.Function("bends", [local, constants, weights], [ca.densify(bend)])
    return slopes, bends, _mask(slope), _mask(bend)


def _mask(matrix: Any) -> NDArray[np.bool_]:
    return np.array(ca.DM(matrix.sparsity(), 1.0).full()) > 0.0


def _slope_scatter(select: sp.csc_matrix, places: Ints, mask: NDArray[np.bool_], variables: int) -> _Scatter:
    """Jacobian of `select` times the outputs, from all small Jacobians stacked by columns."""
    chosen: Any = select.tocoo()
    outputs, (size, m) = len(mask), places.shape
    interval, output = np.divmod(chosen.col.astype(np.intp), outputs)
    at, column = np.nonzero(mask[output])
    entry = interval[at] * outputs * size + column * outputs + output[at]
    row = chosen.row.astype(np.intp)[at]
    shape = (int(select.shape[0]), variables)
    return _Scatter.of(row, places[column, interval[at]], entry, chosen.data[at], shape, outputs * size * m)


def _bend_scatter(places: Ints, mask: NDArray[np.bool_], variables: int) -> _Scatter:
    """Upper triangle of the Hessian from the upper triangles of all small ones."""
    size, m = places.shape
    row, column = np.nonzero(mask)
    a, b = places[row], places[column]
    entry = np.arange(m) * size * size + (column * size + row)[:, None]
    upper = np.minimum(a, b), np.maximum(a, b)
    return _Scatter.of(upper[0].ravel(), upper[1].ravel(), entry.ravel(), np.ones(entry.size), (variables, variables), size * size * m)
