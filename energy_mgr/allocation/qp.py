"""A small dense QP solved again and again: DAQP with a kept workspace, every answer checked by its optimality conditions.

    min 0.5 z' H z + f' z    subject to    lower <= (z, A z) <= upper

"Solved" is our word: what the solver returns counts only if stationarity, bounds and complementarity hold to `TOLERANCE`, each over its own scale.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import daqp
import numpy as np

from powertrain.symbolic import ca

from .compiled import Compiled

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

#: Largest scaled residual of the optimality conditions that counts as solved.
TOLERANCE = 1e-6
#: DAQP measures rows by the inverse of H: where holding the steering at standstill makes H large, sound rows look like zero to its defaults.
_SETTINGS = {"zero_tol": 1e-16, "sing_tol": 1e-16}
#: Nothing times a number is nothing; times what is no number it is none.
_NOTHING = 1e-300


class Answer(NamedTuple):
    """An answer of the solver: point, multipliers of bounds then rows (positive at an upper one), scaled KKT residual, iterations."""

    z: Floats
    multipliers: Floats
    residual: float
    iterations: int

    @property
    def solved(self) -> bool:
        """Whether the optimality conditions hold."""
        return self.residual <= TOLERANCE


class DenseQP:
    """A QP of fixed size whose numbers change."""

    def __init__(self, size: int, rows: int, equal: tuple[int, ...] = ()) -> None:
        """Room for `size` unknowns with bounds and `rows` constraint rows, of which those in `equal` (counted from zero) are equalities.

        Write the numbers into the arrays, then `solve`.
        """
        self._sense = np.zeros(size + rows, dtype=np.int32)
        for row in equal:
            self._sense[size + row] = 5
        #: H and A' column by column, f, lower, upper
        self.numbers: list[Floats] = [
            np.zeros(shape, order="F") for shape in ((size, size), (size, 1), (size, rows), (size + rows, 1), (size + rows, 1))
        ]
        h, f, at, lower, upper = self.numbers
        self._given = h.T, f[:, 0], at.T, upper[:, 0], lower[:, 0]
        self._model: Any = None
        shapes = [*(numbers.shape for numbers in self.numbers), (size, 1), (size + rows, 1)]
        # of matrices, so that products are done by loops and not instruction by instruction
        symbols = [ca.MX.sym("numbers", *shape) for shape in shapes]
        self._check = Compiled("check", symbols, [residual(*symbols)], self.numbers)
        self._z, self._multipliers = self._check.arguments[-2:]
        self._found = self._check.results[0]

    def forget(self) -> None:
        """Begin the next solve cold, as a new object would."""
        self._model = None

    def solve(self) -> Answer:
        """Solve it from where the last solve ended."""
        h, f, a, upper, lower = self._given
        model = self._model
        if model is None:
            model = self._model = daqp.Model()
            model.settings = {**model.settings, **_SETTINGS}
            flag, _ = model.setup(h, f, a, upper, lower, self._sense.copy())
        else:
            # an array without rows is one that DAQP cannot update
            flag = model.update(h, f, a if len(a) else None, upper, lower)
        if flag >= 0:
            z, _, flag, info = model.solve()
            if flag >= 1:
                self._z[:], self._multipliers[:] = z, info["lam"]
                self._check.run()
                return Answer(z, info["lam"], self._found.item(), info["iterations"])
        # what the solver remembers of a failure must not spoil the next answer
        self._model = None
        return Answer(np.zeros(len(self._z)), np.zeros(len(self._multipliers)), np.inf, 0)


def residual(H: Any, f: Any, At: Any, lower: Any, upper: Any, z: Any, multipliers: Any) -> Any:
    """Largest violation of stationarity (over the gradient's size), of bounds, and of complementarity (over the gradient's size); matrix symbols."""
    n = z.numel()
    push, values = multipliers[:n] + At @ multipliers[n:], ca.vertcat(z, At.T @ z)
    above, below = upper - values, values - lower
    size = ca.fmax(1.0, ca.fmax(ca.norm_inf(f), ca.norm_inf(push)))
    over = ca.fmax(0.0, -ca.fmin(ca.mmin(above), ca.mmin(below)))
    slack = ca.fmax(ca.norm_inf(ca.fmax(multipliers, 0.0) * above), ca.norm_inf(ca.fmin(multipliers, 0.0) * below))
    worst = ca.fmax(over, ca.fmax(ca.norm_inf(H @ z + f + push), slack) / size)
    # a maximum passes over what is no number; a sum does not
    return worst + _NOTHING * (ca.sumsqr(z) + ca.sumsqr(multipliers))
