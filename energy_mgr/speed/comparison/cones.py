"""Collects a cone programme in blocks and hands it to Clarabel.

minimise q'x   subject to linear equalities, inequalities and rotated second-order cones
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import clarabel
import numpy as np
import scipy.sparse as sp

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]
    #: (column per row, coefficient or coefficients)
    Part = tuple[Ints, float | Floats]


class ConeProgramme:
    """Rows `rhs - A x` in cones; every method adds a block of rows."""

    def __init__(self, variables: int) -> None:
        self._variables = variables
        self._blocks: dict[str, list[tuple[Ints, Ints, Floats, Floats]]] = {"zero": [], "positive": [], "second": []}

    def equal(self, parts: Sequence[Part], rhs: Floats) -> None:
        """Sum of parts = rhs, one row per entry of rhs."""
        self._blocks["zero"].append(self._rows(parts, rhs))

    def at_most(self, parts: Sequence[Part], rhs: Floats) -> None:
        """Sum of parts <= rhs."""
        self._blocks["positive"].append(self._rows(parts, rhs))

    def total_at_most(self, columns: Ints, weights: Floats, bound: float) -> None:
        """The sum of all `columns` times `weights` <= bound, one row."""
        rows = np.zeros(len(columns), dtype=np.intp)
        self._blocks["positive"].append((rows, columns, weights, np.array([bound])))

    def rotated(
        self,
        low_constant: Floats,
        low: Sequence[Part],
        first: Sequence[Part],
        first_constant: Floats,
        second: Sequence[Part],
        second_constant: Floats,
    ) -> None:
        """(low + low_constant)^2 <= (first + first_constant) (second + second_constant), one cone per entry of the constants."""
        count = len(low_constant)
        sums = [*first, *second]
        differences = [*first, *((columns, -np.asarray(values)) for columns, values in second)]
        triples = [
            (sums, first_constant + second_constant),
            ([(columns, 2.0 * np.asarray(values)) for columns, values in low], 2.0 * low_constant),
            (differences, first_constant - second_constant),
        ]
        rows, columns, values, rhs = [], [], [], np.zeros(3 * count)
        for place, (parts, constant) in enumerate(triples):
            rhs[place::3] = constant
            for column, value in parts:
                rows.append(3 * np.arange(count) + place)
                columns.append(column)
                values.append(np.broadcast_to(-np.asarray(value, dtype=np.float64), count))
        self._blocks["second"].append((np.concatenate(rows), np.concatenate(columns), np.concatenate(values), rhs))

    @staticmethod
    def _rows(parts: Sequence[Part], rhs: Floats) -> tuple[Ints, Ints, Floats, Floats]:
        count = len(rhs)
        rows = np.tile(np.arange(count), len(parts))
        columns = np.concatenate([column for column, _ in parts])
        values = np.concatenate([np.broadcast_to(np.asarray(value, dtype=np.float64), count) for _, value in parts])
        return rows, columns, values, np.asarray(rhs, dtype=np.float64)

    def solve(self, q: Floats) -> tuple[Floats | None, bool]:
        """The minimiser, or None if there is none, and whether Clarabel's full tolerances are met (else only its reduced ones)."""
        rows, columns, values, rhs, cones = [], [], [], [], []
        offset = 0
        for kind, blocks in self._blocks.items():
            start = offset
            for row, column, value, right in blocks:
                rows.append(row + offset)
                columns.append(column)
                values.append(value)
                rhs.append(right)
                offset += len(right)
            cones += _cones(kind, offset - start)
        matrix = sp.csc_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(offset, self._variables))
        nothing = sp.csc_matrix((self._variables, self._variables))
        # refining every linear solve costs a third of the time; the tolerances on the result are the same, so first try without
        for refined in (False, True):
            settings = clarabel.DefaultSettings()
            settings.verbose = False
            settings.iterative_refinement_enable = refined
            solution = clarabel.DefaultSolver(nothing, q, matrix, np.concatenate(rhs), cones, settings).solve()
            if solution.status == clarabel.SolverStatus.Solved:
                return np.array(solution.x), True
        return (np.array(solution.x) if solution.status == clarabel.SolverStatus.AlmostSolved else None), False


def _cones(kind: str, rows: int) -> list[Any]:
    if rows == 0:
        return []
    if kind == "second":
        return [clarabel.SecondOrderConeT(3)] * (rows // 3)
    return [clarabel.ZeroConeT(rows) if kind == "zero" else clarabel.NonnegativeConeT(rows)]
