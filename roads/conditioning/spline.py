"""Penalised cubic B-splines on an even grid: smooth curves through noisy data, outliers weighed down, the smoothness found by cross-validation.

What is minimised over the coefficients c is `sum w_k |y_k - (B c)_k|^2 + lam sum v_i |(D c)_i|^2` with D the differences of an order
(P. H. C. Eilers, B. D. Marx: Flexible smoothing with B-splines and penalties, Statistical Science 11, 1996). The weights w follow Huber's rule.
Where `sharp`, the weights v are led to `1 / |D c|`, which makes the penalty the sum of magnitudes: changes then gather in few places, bends are
kept and straights are straight (total variation, as in trend filtering). Every step costs time in proportion to the length of the data.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import solveh_banded

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

#: Residuals beyond this multiple of the typical one count less (Huber): of lines, and of heights. None is left out, and a line's points keep
#: more weight: a rare bend lies as far off at first as an outlier.
HUBER_LINE, HUBER = 3.0, 1.5
#: Of the normal distribution: median magnitude to standard deviation.
MEDIAN = 1.4826
#: Rounds of reweighting, and while smoothnesses are compared.
_ROUNDS, _FEW_ROUNDS = 6, 3
#: The ladder of smoothness: decades about the scale at which data and penalty weigh the same.
_LADDER = np.arange(-4.0, 12.1, 0.5)
#: Parts that the data are left out in.
_FOLDS = 5
#: No more points decide on the smoothness.
_MOST_VALIDATED, _STRETCHES = 3000, 6
#: Typical residuals are not taken to be smaller, in the unit of the data.
_LEAST_SCALE = 1e-4


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted spline.

    Attributes:
        start: parameter where the grid begins.
        spacing: distance of its knots.
        coefficients: (n, k).
        weight: (m,) what each datum counted in the end, 0 to 1.
        lam: the smoothness.
    """

    start: float
    spacing: float
    coefficients: Floats
    weight: Floats
    lam: float

    def __call__(self, u: Floats, order: int = 0) -> Floats:
        """Values (m, k) at parameters `u` (m,), or those of a derivative."""
        c, h = self.coefficients, self.spacing
        for _ in range(order):
            c = np.diff(c, axis=0) / h
        cell, basis = _basis(u, self.start, h, len(self.coefficients) - 3, 3 - order)
        return np.sum([basis[k][:, None] * c[cell + k] for k in range(4 - order)], axis=0)


class Smoother:
    """The data of one curve, ready to be fitted with any smoothness.

    Args:
        u: (m,) parameters.
        y: (m, k) values.
        spacing: distance of the knots.
        order: of the differences that are penalised: 2 for heights (their bend), 3 for lines (the change of their bend).
        weight: (m,) what each datum counts.
        sharp: see the module.
    """

    def __init__(self, u: Floats, y: Floats, spacing: float, order: int, weight: Floats, *, sharp: bool = False) -> None:
        self._u, self._y, self._weight, self._sharp, self._order = u, y, weight, sharp, order
        self._start = float(np.min(u))
        cells = max(int(np.ceil((float(np.max(u)) - self._start) / spacing)), 1)
        self._spacing = max((float(np.max(u)) - self._start) / cells, 1e-9)
        self._cell, self._basis = _basis(u, self._start, self._spacing, cells, 3)
        self._count = cells + 3
        self._rule = np.array([(-1.0) ** k * _choose(order, k) for k in range(order, -1, -1)]) / self._spacing ** (order - 0.5)
        # what is solved for is the way from a curve along the data: that keeps its digits where the penalty outweighs the data by far
        at, order_of = self._start + self._spacing * (np.arange(self._count) - 1.0), np.argsort(u, kind="stable")
        self._near = np.column_stack([np.interp(at, u[order_of], column[order_of]) for column in y.T])
        # where data and penalty weigh the same
        self.scale = float(np.sum(weight) / self._count / np.sum(self._rule**2))

    def fit(self, lam: float, rounds: int = _ROUNDS) -> Fit:
        """The curve of smoothness `lam`."""
        robust, sharpness = np.ones(len(self._u)), np.ones(max(self._count - self._order, 0))
        c = self._solved(robust, sharpness, lam)
        for _ in range(rounds):
            robust = _robust(self.residual(c), HUBER_LINE if self._sharp else HUBER)
            if self._sharp:
                size = np.linalg.norm(self._differences(c), axis=1)
                typical = float(np.sqrt(np.mean(size**2)))
                # no change is taken to be smaller than a hundredth of the typical one: the weights stay finite
                sharpness = typical / np.maximum(size, 0.01 * typical) if typical > 0.0 else np.ones_like(size)
            c = self._solved(robust, sharpness, lam)
        return Fit(self._start, self._spacing, c, robust, lam)

    def residual(self, c: Floats) -> Floats:
        """(m,) distances of the data from the curve with the coefficients `c`."""
        return np.linalg.norm(self._y - self._values(c), axis=1)

    def _values(self, c: Floats) -> Floats:
        return np.sum([self._basis[k][:, None] * c[self._cell + k] for k in range(4)], axis=0)

    def _differences(self, c: Floats) -> Floats:
        size = self._count - self._order
        return np.sum([rule * c[k : k + size] for k, rule in enumerate(self._rule)], axis=0)

    def _solved(self, robust: Floats, sharpness: Floats, lam: float) -> Floats:
        weight, miss = self._weight * robust, self._y - self._values(self._near)
        bands = np.zeros((4, self._count))
        for a in range(4):
            for b in range(a, 4):
                bands[3 - (b - a)] += np.bincount(self._cell + b, weight * self._basis[a] * self._basis[b], self._count)
        right = np.column_stack(
            [np.sum([np.bincount(self._cell + k, weight * self._basis[k] * column, self._count) for k in range(4)], axis=0) for column in miss.T]
        )
        size, penalty = len(sharpness), np.zeros_like(bands)
        pull = lam * sharpness[:, None] * self._differences(self._near)
        for k, rule in enumerate(self._rule):
            right[k : k + size] -= rule * pull
        for a, first in enumerate(self._rule):
            for b, second in enumerate(self._rule[a:], a):
                penalty[3 - (b - a), b : b + size] += first * second * sharpness
        # a trace of a ridge: the grid reaches where no datum is
        ridge = 1e-12 * (lam * float(np.mean(penalty[3])) + float(np.mean(bands[3])))
        bands[3] += ridge
        return self._near + solveh_banded(bands + lam * penalty, right, check_finite=False)


def cross_validated(u: Floats, y: Floats, spacing: float, order: int, weight: Floats, *, sharp: bool = False, lenient: bool = False) -> float:
    """The smoothness that foretells best: fitted without every fifth datum in turn, compared with these by the mean magnitude of what it misses.

    `lenient` takes the smoothest of those that do not differ by more than a standard error from the best one: what cannot be told from noise is
    left out. Without it, what may be a bend is kept.
    """
    order_of = np.argsort(u, kind="stable")
    u, y, weight = u[order_of], y[order_of], weight[order_of]
    scale = Smoother(u, y, spacing, order, weight, sharp=sharp).scale
    parts: list[tuple[Ints, Smoother]] = []
    for stretch in _validated(len(u)):
        for part in range(_FOLDS):
            fold = np.arange(len(stretch)) % _FOLDS == part
            rest = stretch[~fold]
            parts.append((stretch[fold], Smoother(u[rest], y[rest], spacing, order, weight[rest], sharp=sharp)))
    missed: dict[float, Floats] = {}

    def look(exponent: float) -> float:
        if exponent not in missed:
            lam = scale * 10.0**exponent
            off = [np.linalg.norm(y[out] - smoother.fit(lam, _FEW_ROUNDS)(u[out]), axis=1) * weight[out] for out, smoother in parts]
            missed[exponent] = np.concatenate(off)
        return float(missed[exponent].mean())

    best = min(_LADDER[::2].tolist(), key=look)
    best = min((best - 0.5, best, best + 0.5), key=look)
    if lenient:
        for exponent in sorted(missed, reverse=True):
            more = missed[exponent] - missed[best]
            if more.mean() <= more.std() / np.sqrt(len(more)) + 1e-12:
                return scale * 10.0**exponent
    return scale * 10.0**best


def within(smoother: Smoother, accuracy: float) -> Fit:
    """The smoothest curve, on the ladder, from which the data lie no farther than `accuracy` in the root mean square, outliers included."""
    best = smoother.fit(smoother.scale * 10.0 ** _LADDER[0])
    for factor in _LADDER[1:]:
        fit = smoother.fit(smoother.scale * 10.0**factor)
        if float(np.sqrt(np.mean(smoother.residual(fit.coefficients) ** 2))) > accuracy:
            break
        best = fit
    return best


def noise_of(values: Floats) -> float:
    """Standard deviation of the noise in values (n,) or (n, k) per column, from their third differences, which what changes slowly hardly enters."""
    if len(values) < 5:
        return 0.0
    third = np.diff(values.reshape(len(values), -1), 3, axis=0)
    return MEDIAN * float(np.median(np.abs(third))) / np.sqrt(20.0)


def _robust(off: Floats, multiple: float) -> Floats:
    """Weights (m,) by Huber's rule; the scale is that of the median."""
    scale = max(MEDIAN * float(np.median(off)), _LEAST_SCALE)
    return np.minimum(1.0, multiple * scale / np.maximum(off, 1e-12))


def _validated(count: int) -> list[Ints]:
    """Indices of the data that decide on the smoothness: all, or stretches spread over them."""
    if count <= _MOST_VALIDATED:
        return [np.arange(count)]
    size = _MOST_VALIDATED // _STRETCHES
    return [np.arange(start, start + size) for start in np.linspace(0, count - size, _STRETCHES).astype(np.intp).tolist()]


def _basis(u: Floats, start: float, spacing: float, cells: int, degree: int) -> tuple[Ints, list[Floats]]:
    """The cell of each parameter, and the values of the `degree` + 1 B-splines that live there."""
    at = (u - start) / spacing
    cell = np.clip(np.floor(at), 0, cells - 1).astype(np.intp)
    x = at - cell
    if degree == 3:
        y = 1.0 - x
        return cell, [y**3 / 6.0, (3.0 * x**3 - 6.0 * x**2 + 4.0) / 6.0, (3.0 * y**3 - 6.0 * y**2 + 4.0) / 6.0, x**3 / 6.0]
    if degree == 2:
        return cell, [0.5 * (1.0 - x) ** 2, 0.5 + x - x**2, 0.5 * x**2]
    return cell, [1.0 - x, x]


def _choose(n: int, k: int) -> float:
    return {(2, 0): 1.0, (2, 1): 2.0, (2, 2): 1.0, (3, 0): 1.0, (3, 1): 3.0, (3, 2): 3.0, (3, 3): 1.0}[n, k]
