"""Preview allocation N2: the programme of one period, joined over a short horizon of demands that are known to come.

At nodes 0 = t_0 < t_1 < ... < t_N every node has the cost, bounds and rows of `Programme` with the demand and the speed it will have; neighbours are
joined by the price of changing commands, spread over the time between them, and by what the actuators can change in it. Only the commands of node 0
are given out. Demands to come are those of the trajectory; what the tracking law corrects now is taken to
fade away.

The programme is sparse, block after block; its pattern is worked out once. PIQP solves it; being an interior-point method it has no warm start, so
what is carried over from one period to the next is the point about which every node is linearised.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import piqp
import scipy.sparse as sp

from powertrain.symbolic import ca

from ..errors import PlanningError
from ..motion import MotionDemand
from .compiled import Compiled
from .efficient import EfficientAllocator, Packed, finisher, met
from .programme import Programme, Weights
from .qp import TOLERANCE
from .situation import Allocation, Situation

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from powertrain import Vehicle

    from .effectiveness import TyreKind

    Floats = NDArray[np.float64]

#: What the tracking law corrects now fades with this time constant, s.
_FADE = 0.3
#: A box of so many seconds has no rates left in it.
_LONG = 1e3


class PreviewAllocator:
    """Least losses over a short horizon.

    Attributes:
        horizon: times (s) at which it wants to be told the demands to come; the first is now.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        *,
        cost: str = "physical",
        tyre: TyreKind = "own",
        weights: Weights | None = None,
        horizon: Sequence[float] = (0.0, 0.06, 0.12, 0.2, 0.3),
        dt: float = 0.004,
    ) -> None:
        """The allocator of a car; arguments as in `EfficientAllocator`, times of the nodes, and the control period `dt` (s).

        Raises:
            VehicleError: the description lacks a section that the double-track model needs.
            PlanningError: a word that is none of these, or times that do not begin with 0 and grow.
        """
        self.horizon = tuple(float(t) for t in horizon)
        if len(self.horizon) < 2 or self.horizon[0] != 0.0 or not all(b > a for a, b in zip(self.horizon[:-1], self.horizon[1:], strict=True)):
            raise PlanningError(f"horizon {self.horizon}, expected times that begin with 0 and grow")
        self._alone = EfficientAllocator(vehicle, cost=cost, tyre=tyre, weights=weights, dt=dt)
        self.layout = self._alone.layout
        self._first = self._alone.programme
        self._later = Programme(self.layout, cost, tyre, weights, smooth=False)
        self._packed = Packed(self.layout)
        self._gaps = np.diff([-dt, *self.horizon])
        self._nodes, self._n = len(self.horizon), self.layout.size
        self._row = self._packed.count
        self._plan: Floats | None = None
        self._write = self._written(dt)
        self._solver: Any = None
        low, high, motion, effect = self._write.results[7:]
        self._finish = finisher(self.layout, self._write.arguments[0][: self._row], motion, effect, low, high)

    def _written(self, dt: float) -> Compiled:
        """The numbers of the sparse programme from the rows of all nodes; remembers the patterns of its matrices."""
        inputs = ca.SX.sym("inputs", self._row * self._nodes)
        rows = [inputs[k * self._row : (k + 1) * self._row] for k in range(self._nodes)]
        found = [(self._first if k == 0 else self._later).at(row) for k, row in enumerate(rows)]
        n, scale = self._n, ca.DM(self.layout.scale)
        P, c = ca.diagcat(*(one[0] for one in found)), [one[1] for one in found]
        sides = [one[2].T for one in found]
        below, above = [one[3][n:] for one in found], [one[4][n:] for one in found]
        joined: list[Any] = []
        for k in range(1, self._nodes):
            step = (rows[k][:n] - rows[k - 1][:n]) / scale
            price = ca.DM(self._first.rates) * dt / float(self._gaps[k])
            pick = ca.SX(n, n * self._nodes)
            pick[:, k * n : (k + 1) * n], pick[:, (k - 1) * n : k * n] = ca.DM.eye(n), -ca.DM.eye(n)
            P = P + pick.T @ ca.diag(price) @ pick
            c[k], c[k - 1] = c[k] + price * step, c[k - 1] - price * step
            room = ca.DM(self.layout.rate * float(self._gaps[k])) / scale
            joined.append(pick)
            below.append(-room - step)
            above.append(room - step)
        G = ca.vertcat(ca.diagcat(*sides), *joined)
        lower, upper = (ca.vertcat(*(one[at][:n] for one in found)) for at in (3, 4))
        self._patterns = [_Pattern.of(matrix) for matrix in (P, G)]
        numbers = [ca.vertcat(*P.nonzeros()), ca.vertcat(*c), ca.vertcat(*G.nonzeros()), ca.vertcat(*below), ca.vertcat(*above), lower, upper]
        motion, effect, low, high = found[0][5:]
        return Compiled("preview", [inputs], [*numbers, low, high, motion, effect])

    def allocate(self, now: Situation) -> Allocation:
        """As `Allocator.allocate`; without `ahead`, or where the horizon's programme finds no answer, that of `EfficientAllocator`."""
        if len(now.ahead) != self._nodes:
            return self._alone.allocate(now)
        self._fill(now)
        self._write.run()
        z, residual, iterations = self._solve()
        if not residual <= TOLERANCE:
            self._solver, self._plan = None, None
            return self._alone.allocate(now)
        steps = z.reshape(self._nodes, self._n) * self.layout.scale
        self._plan = self._write.arguments[0].reshape(self._nodes, self._row)[:, : self._n] + steps
        self._finish.arguments[-1][:] = z[: self._n]
        self._finish.run()
        command, given = self._finish.results[0][:, 0].copy(), MotionDemand(*self._finish.results[1][:, 0].tolist())
        self._plan[0] = command
        return Allocation(command, given, met(self.layout, given, now.demand), residual, iterations)

    def _fill(self, now: Situation) -> None:
        """The rows of all nodes."""
        inputs, first, state = self._write.arguments[0].reshape(self._nodes, self._row), now.ahead[0], now.state
        radius = self.layout.vehicle.chassis.wheel_radius_m
        for k, ahead in enumerate(now.ahead):
            if k == 0:
                self._packed.fill(inputs[0], now)
                continue
            fade = math.exp(-ahead.time / _FADE)
            demand = MotionDemand(*(a + fade * (b - c) for a, b, c in zip(ahead.demand, now.demand, first.demand, strict=True)))
            v_x = max(ahead.v_x + fade * (state.v_x - first.v_x), 0.0)
            then = state._replace(
                v_x=v_x, v_y=fade * state.v_y, yaw_rate=ahead.yaw_rate + fade * (state.yaw_rate - first.yaw_rate), a_x=demand.a_x, a_y=demand.a_y
            )
            about = now.before if self._plan is None else self._plan[k]
            self._packed.fill(inputs[k], now._replace(state=then, demand=demand, before=about, wheel_speeds=(v_x / radius,) * 4, dt=_LONG))

    def _solve(self) -> tuple[Floats, float, int]:
        """The minimiser, its scaled KKT residual, and the solver's iterations."""
        p, c, g, low, high, lower, upper = (result[:, 0] for result in self._write.results[:7])
        P, G = (pattern.filled(data) for pattern, data in zip(self._patterns, (p, g), strict=True))
        arguments = {"P": P, "c": c, "G": G, "h_l": low, "h_u": high, "x_l": lower, "x_u": upper}
        if self._solver is None:
            self._solver = piqp.SparseSolver()
            self._solver.settings.eps_abs, self._solver.settings.eps_rel = 1e-9, 1e-9
            self._solver.settings.max_iter = 60
            self._solver.setup(**arguments)
        else:
            self._solver.update(**arguments)
        self._solver.solve()
        r = self._solver.result
        z, rows, bounds = np.array(r.x), np.subtract(r.z_u, r.z_l), np.subtract(r.z_bu, r.z_bl)
        push, values = G.T @ rows + bounds, G @ z
        size = max(1.0, float(np.abs(c).max()), float(np.abs(push).max()))
        over = max(float((values - high).max()), float((low - values).max()), float((z - upper).max()), float((lower - z).max()), 0.0)
        slack = 0.0
        for m, v, bottom, top in ((rows, values, low, high), (bounds, z, lower, upper)):
            room = np.where(m > 0.0, top - v, bottom - v)
            # a bound that is not there has no multiplier
            slack = max(slack, float(np.abs(np.where(np.isfinite(room), room, 0.0) * m).max()))
        residual = max(over, (float(np.abs(P @ z + c + push).max()) + slack) / size)
        return z, residual, int(r.info.iter)

    def snapshot(self) -> tuple[float, ...]:
        """As `Allocator.snapshot`: the points about which the nodes are linearised."""
        self._solver = None
        self._alone.snapshot()
        return () if self._plan is None else tuple(self._plan.ravel().tolist())

    def restore(self, memory: tuple[float, ...]) -> None:
        """As `Allocator.restore`."""
        self._solver = None
        self._alone.restore(())
        self._plan = np.array(memory).reshape(self._nodes, self._n) if memory else None


class _Pattern(NamedTuple):
    """Where a sparse matrix has its numbers, column by column."""

    rows: NDArray[np.int32]
    starts: NDArray[np.int32]
    shape: tuple[int, int]

    @classmethod
    def of(cls, matrix: Any) -> _Pattern:
        """The pattern of a matrix of symbols."""
        sparsity = matrix.sparsity()
        rows, starts = (np.array(numbers, dtype=np.int32) for numbers in (sparsity.row(), sparsity.colind()))
        return cls(rows, starts, (int(sparsity.size1()), int(sparsity.size2())))

    def filled(self, numbers: Floats) -> Any:
        """The matrix with these numbers."""
        whole: Any = sp.csc_matrix
        return whole((numbers, self.rows, self.starts), shape=self.shape)
