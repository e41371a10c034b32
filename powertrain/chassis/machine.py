"""One model, made fast: a fixed step compiled through CasADi, its exact Jacobian, batches, and an adaptive reference.

A model has `states`, `inputs` and `derivative(x, u)` in NumPy operations. `Machine` writes the classical Runge-Kutta step of it (RK4, inputs held)
as one expression, removes what is computed twice, and calls it through buffers, without Python objects in between.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ..errors import VehicleError
from ..symbolic import ca
from . import compiled

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]


class Model(Protocol):
    """What a machine runs: `derivative` of `states` under `inputs`, by position, on numbers, arrays or symbols."""

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        ...

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs."""
        ...

    def derivative(self, x: Sequence[Any], u: Sequence[Any]) -> Sequence[Any]:
        """d x/dt."""
        ...


def runge_kutta(derivative: Callable[[Any], Sequence[Any]], x: Sequence[Any], dt: float) -> list[Any]:
    """`x` after one classical Runge-Kutta step of `dt` (s): lists of numbers, arrays or symbols."""
    k1 = derivative(x)
    k2 = derivative([a + 0.5 * dt * k for a, k in zip(x, k1, strict=True)])
    k3 = derivative([a + 0.5 * dt * k for a, k in zip(x, k2, strict=True)])
    k4 = derivative([a + dt * k for a, k in zip(x, k3, strict=True)])
    return [a + dt / 6.0 * (p + 2.0 * q + 2.0 * r + s) for a, p, q, r, s in zip(x, k1, k2, k3, k4, strict=True)]


class Machine:
    """The compiled step of a model.

    `compile_c` turns the step into machine code where a C compiler is at hand; all calls stay the same.
    """

    def __init__(
        self, model: Model, dt: float, *, substeps: int = 1, integrands: Callable[[Sequence[Any], Sequence[Any]], Sequence[Any]] | None = None
    ) -> None:
        """Write and optimise the step of `model`.

        Args:
            model: the equations.
            dt: step, s.
            substeps: Runge-Kutta steps in a step.
            integrands: rates to be integrated beside the states with the same weights; `step` leaves their increments in `integrals`.

        Raises:
            VehicleError: a step or number of substeps that is not positive.
        """
        if not (np.isfinite(dt) and dt > 0.0 and substeps >= 1):
            raise VehicleError(f"step of {dt} s in {substeps} parts, expected a positive time and number")
        self.model, self.dt, self.substeps = model, float(dt), substeps
        n, m = len(model.states), len(model.inputs)
        x, u = ca.SX.sym("x", n), ca.SX.sym("u", m)
        xs, us = ca.vertsplit(x), ca.vertsplit(u)
        more = list(integrands(xs, us)) if integrands else []
        count = len(more)
        # the equations are walked through once; the stages of the step are made of the expression
        rates = ca.Function("rates", [x, u], [ca.cse(ca.vertcat(*model.derivative(xs, us), *more))])
        after: list[Any] = [ca.vertcat(x, ca.SX.zeros(count))]
        for _ in range(substeps):
            after = runge_kutta(lambda state: [rates(state[0][:n], u)], after, self.dt / substeps)
        expressions = ca.cse([after[0][:n], after[0][n:]])
        self._step = ca.Function("step", [x, u], expressions, ["x", "u"], ["x_next", "integrals"])
        self._derivative = ca.Function("derivative", [x, u], [rates(x, u)[:n]])
        self._many: Callable[[list[Floats], list[Floats], int], None] | None = None
        self._jacobians: dict[str, Any] = {}
        self.integrals: Floats = np.zeros(count)
        self.turned: Floats = np.zeros(count)
        self._fast: Any = None
        self._several: _Several | None = None
        self._attach(self._step)

    def _attach(self, function: Any) -> None:
        """Let `step` call `function` on arrays of this object, without copies in between."""
        self._x, self._u = np.zeros(len(self.model.states)), np.zeros(max(len(self.model.inputs), 1))
        self._next = np.zeros_like(self._x)
        self._buffer, self._run = function.buffer()
        self._buffer.set_arg(0, self._x.data)
        if self.model.inputs:
            self._buffer.set_arg(1, self._u.data)
        self._buffer.set_res(0, self._next.data)
        if len(self.integrals):
            self._buffer.set_res(1, self.integrals.data)

    def step(self, x: ArrayLike, u: ArrayLike) -> Floats:
        """The state (n,) after one step from `x` (n,) under inputs `u` (m,), held."""
        self._x[:] = x
        self._u[:] = u
        self._run()
        return self._next.copy()

    def advance(self, x: ArrayLike, u: ArrayLike, count: int) -> Floats:
        """The state (n,) after `count` steps under the same inputs, in one call; `integrals` then holds the sums, `turned` those of magnitudes."""
        if self._several is None or self._several.count != count:
            self._several = _Several(self._fast or self._step, count)
        return self._several(x, u, self.integrals, self.turned)

    def compile_c(self) -> None:
        """Turn `step`, `advance` and `batch` into machine code: seconds once, then about a fifth and a twentieth of the time.

        Raises:
            VehicleError: there is no C compiler, or it refused.
        """
        self.compile_scalar()
        xs, us = ca.SX.sym("x", len(self.model.states)), ca.SX.sym("u", len(self.model.inputs))
        self._many = compiled.build(ca.Function("step", [xs, us], [self._step(xs, us)[0]]))

    def compile_scalar(self) -> None:
        """As `compile_c`, for `step` and `advance` alone: about a second.

        Raises:
            VehicleError: there is no C compiler, or it refused.
        """
        self._fast, self._several = compiled.scalar(self._step), None
        self._attach(self._fast)

    def batch(self, x: ArrayLike, u: ArrayLike) -> Floats:
        """The states (n, N) of N cars after one step from `x` (n, N) under inputs `u` (m, N) or (m,).

        Raises:
            VehicleError: shapes that do not fit.
        """
        n, m = len(self.model.states), len(self.model.inputs)
        states, inputs = np.ascontiguousarray(x, dtype=np.float64), np.asarray(u, dtype=np.float64)
        inputs = inputs[:, None] if inputs.ndim == 1 else inputs
        if states.ndim != 2 or len(states) != n or inputs.ndim != 2 or len(inputs) != m or inputs.shape[1] not in (1, states.shape[1]):
            raise VehicleError(f"batch of states {states.shape} and inputs {inputs.shape}, expected ({n}, N) and ({m}, N) or ({m},)")
        if self._many is not None:
            after = np.empty_like(states)
            self._many([states, np.ascontiguousarray(np.broadcast_to(inputs, (m, states.shape[1])))], [after], states.shape[1])
            return after
        after = states
        for _ in range(self.substeps):
            after = np.array(runge_kutta(lambda rows: self.model.derivative(rows, list(inputs)), list(after), self.dt / self.substeps))
        return after

    def derivative(self, x: ArrayLike, u: ArrayLike) -> Floats:
        """d x/dt (n,)."""
        return np.asarray(self._derivative(x, u), dtype=np.float64).ravel()

    def jacobian(self, x: ArrayLike, u: ArrayLike, *, of: str = "step") -> tuple[Floats, Floats]:
        """Exact Jacobians (n, n) and (n, m) of the `step` or the `derivative` by state and inputs.

        Raises:
            ValueError: another word for `of`.
        """
        if of not in self._jacobians:
            if of not in ("step", "derivative"):
                raise ValueError(f"of = {of!r}, expected step or derivative")
            xs, us = ca.SX.sym("x", len(self.model.states)), ca.SX.sym("u", len(self.model.inputs))
            value = self._step(xs, us)[0] if of == "step" else self._derivative(xs, us)
            self._jacobians[of] = ca.Function("jacobian", [xs, us], [ca.jacobian(value, xs), ca.jacobian(value, us)])
        by_x, by_u = self._jacobians[of](x, u)
        return np.asarray(by_x.full()), np.asarray(by_u.full())

    def reference(self, x: ArrayLike, u: ArrayLike, duration: float, *, tolerance: float = 1e-10) -> Floats:
        """The state after `duration` (s) under held inputs by CVODES with relative and absolute `tolerance`.

        Raises:
            VehicleError: the integrator gave up.
        """
        xs, us = ca.SX.sym("x", len(self.model.states)), ca.SX.sym("u", len(self.model.inputs))
        problem = {"x": xs, "p": us, "ode": self._derivative(xs, us)}
        # fewer steps than this never sufficed for a second of driving with events
        options = {"reltol": tolerance, "abstol": tolerance, "max_num_steps": 1_000_000}
        try:
            found = ca.integrator("reference", "cvodes", problem, 0.0, duration, options)(x0=x, p=u)["xf"]
        except RuntimeError as error:
            raise VehicleError(f"CVODES gave up within {duration} s: {str(error).splitlines()[-1]}") from None
        return np.asarray(found.full()).ravel()


class _Several:
    """Some steps under the same inputs as one function: the calls in between cost as much as the steps in machine code."""

    def __init__(self, step: Any, count: int) -> None:
        x, u = ca.MX.sym("x", step.size1_in(0)), ca.MX.sym("u", step.size1_in(1))
        after, total, turned = x, ca.MX(0.0), ca.MX(0.0)
        for _ in range(count):
            after, integrals = step(after, u)
            total, turned = total + integrals, turned + ca.fabs(integrals)
        self.count = count
        self._function = ca.Function("advance", [x, u], [after, total, turned])
        self._buffer, self._run = self._function.buffer()
        self._x, self._u, self._next = np.zeros(x.numel()), np.zeros(max(u.numel(), 1)), np.zeros(x.numel())
        self._total, self._turned = np.zeros(total.numel()), np.zeros(total.numel())
        for k, array in enumerate((self._x, self._u)):
            self._buffer.set_arg(k, array.data)
        for k, array in enumerate((self._next, self._total, self._turned)):
            self._buffer.set_res(k, array.data)

    def __call__(self, x: ArrayLike, u: ArrayLike, total: Floats, turned: Floats) -> Floats:
        self._x[:], self._u[:] = x, u
        self._run()
        total[:], turned[:] = self._total, self._turned
        return self._next.copy()
