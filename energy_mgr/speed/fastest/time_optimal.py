"""The fastest profile by TOPP-RA (reachability analysis, Pham and Pham 2018), through the package `toppra`: a peer of `fastest_profile`.

TOPP-RA takes bounds that are linear in x = v^2 and u = dv^2/2ds. Bounds on speed and acceleration are so as they stand. What forces leave,

    u <= A(x),  -u <= B(x)      at both ends of every interval, where the end is x + 2 ds u,

is not (power over speed; rolling resistance with its root of x): it is replaced by tangents about the last profile and solved again until the speeds
no longer change. At the fixed point the tangents are exact, so all of `SpeedLimits.forces` are kept, which is checked; nothing is left out but jerk
and windows, which are refused.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import InfeasibleError, PlanningError, SolverError
from ..checks import check_profile
from ..result import SpeedProfile
from .forward_backward import friction_braking

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..bounds.speed_limits import SpeedLimits

    Floats = NDArray[np.float64]

#: The sequence ends when no speed changes by more than this, m/s.
_SETTLED = 1e-5
_SOLVES = 30
#: The first tangents are laid at these parts of the bounds on speed, one after the other until TOPP-RA finds a profile: tangents of falling, hollow
#: bounds lie below them, so that any profile found is one to go on from; low ones leave more room at rest, high ones at speed.
_FIRST = (0.3, 0.6, 0.9)
#: Zero speed squared is widened to this, m^2/s^2, speeds at ends of circuits lowered by this part: TOPP-RA's sets must have an inside.
_REST = 1e-8
_INSIDE = 1e-6
_FREE = 1e3


def toppra_profile(limits: SpeedLimits) -> SpeedProfile:
    """The fastest profile within limits, by TOPP-RA.

    On circuits the way starts at the slowest station with the bound on speed there; where the car cannot reach that, there is no profile.

    Raises:
        InfeasibleError: TOPP-RA finds no profile within the limits; it does not say why (`fastest_profile` does).
        PlanningError: jerk or windows among the limits, which this method does not know.
        SolverError: the tangents do not settle, or the profile breaks a limit by more than 0.1 %.
    """
    started = time.perf_counter()
    if np.isfinite(limits.jerk):
        raise PlanningError(f"{limits.name}: a jerk limit of {limits.jerk:g} m/s^3, which method toppra does not know; use eco or nlp")
    if limits.windows:
        raise PlanningError(f"{limits.name}: a window at s = {limits.windows[0].s:g} m, which method toppra does not know; use eco or nlp")
    programme = _Turned(limits)
    x, count = programme.started()
    change = np.inf
    while change > _SETTLED:
        if count == _SOLVES:
            raise SolverError(f"{limits.name}: TOPP-RA's profile still changes by {change:.2g} m/s after {count} solves")
        last, x = x, programme.solved(x)
        # without forces there are no tangents to settle
        change = float(np.max(np.abs(np.sqrt(x) - np.sqrt(last)))) if limits.forces else 0.0
        count += 1
    v = np.minimum(np.sqrt(x), np.sqrt(2.0 * limits.energy_max))
    brake = friction_braking(limits, v)
    check_profile(limits, v, brake)
    return SpeedProfile(limits.s, v, "solved", count, 1e3 * (time.perf_counter() - started), brake=brake, method="toppra")


class _Turned:
    """The limits with stations in the order of the way: on circuits from the slowest one on."""

    def __init__(self, limits: SpeedLimits) -> None:
        self.limits = limits
        self.shift = int(np.argmin(limits.energy_max[:-1])) if limits.closed else 0
        self.ds = np.roll(limits.ds, -self.shift)
        self.s = np.concatenate([[0.0], np.cumsum(self.ds)])
        self.bound = self._stations(2.0 * limits.energy_max)

    def _stations(self, values: Floats) -> Floats:
        if not self.limits.closed:
            return values
        turned = np.roll(values[:-1], -self.shift)
        return np.append(turned, turned[0])

    def started(self) -> tuple[Floats, int]:
        """Squared speeds of a first profile, and the solves it took.

        Raises:
            InfeasibleError: there is none.
        """
        top = 2.0 * self.limits.energy_max
        # the last try: the speed at the ends is held, as round a ring
        tries = [*(share**2 * top for share in _FIRST), np.minimum(top, max(self.bound[0], self.bound[-1]))]
        for count, about in enumerate(tries[:-1]):
            try:
                return self.solved(about), count + 1
            except InfeasibleError:
                continue
        return self.solved(tries[-1]), len(tries)

    def solved(self, about: Floats) -> Floats:
        """(n,) squared speeds of the fastest profile with tangents at squared speeds `about`, m^2/s^2.

        Raises:
            InfeasibleError: there is none.
        """
        import toppra
        from toppra.algorithm import TOPPRA
        from toppra.constraint import JointVelocityConstraintVarying, LinearConstraint

        s, rows = self.s, self._rows(about)

        class Rows(LinearConstraint):
            """by_u u + by_x x <= most at every station."""

            def __init__(self) -> None:
                super().__init__()
                self.dof, self.identical = 1, True

            def compute_constraint_params(self, path: Any, gridpoints: Any, *args: Any, **kwargs: Any) -> Any:
                by_u, by_x, most = rows
                return by_u, by_x, -most, np.eye(by_u.shape[1]), np.zeros(by_u.shape[1]), None, None

        top = np.sqrt(np.maximum(self.bound, _REST))
        speed = JointVelocityConstraintVarying(lambda at: np.array([[-1.0, 1.0]]) * np.interp(at, s, top))
        path = toppra.SplineInterpolator(s, s[:, None])
        solver = TOPPRA([speed, Rows()], path, gridpoints=s, solver_wrapper="seidel")
        # on circuits, where the ends are free, a little inside: TOPP-RA's sets are rounded
        ends = np.sqrt(self.bound[[0, -1]]) * (1.0 - (_INSIDE if self.limits.closed else 0.0))
        rates = solver.compute_parameterization(float(ends[0]), float(ends[1]))[1]
        if rates is None or not np.all(np.isfinite(rates)):
            at = f"{ends[0]:.2f} and {ends[1]:.2f} m/s at its ends"
            if self.limits.closed:  # the fastest round might be slower there
                at = f"{ends[0]:.2f} m/s at s = {self.limits.s[self.shift]:.1f} m, its slowest station; forward-backward also tries less"
            raise InfeasibleError(f"{self.limits.name}: TOPP-RA finds no profile with {at}")
        x = np.asarray(rates, dtype=np.float64).ravel() ** 2
        if self.limits.closed:
            x = np.roll(x[:-1], self.shift)
            x = np.append(x, x[0])
        return x

    def _rows(self, about: Floats) -> tuple[Floats, Floats, Floats]:
        """Coefficients (n, 6) of u, of x and right-hand sides, m/s^2: acceleration, deceleration, forces at both ends either way."""
        limits, ds = self.limits, self.limits.ds
        one = np.ones_like(ds)
        by_u, by_x = [one, -one], [0.0 * one, 0.0 * one]
        most = [np.minimum(limits.acceleration, _FREE), np.minimum(limits.deceleration, _FREE)]
        if limits.forces:
            for sign in (1, -1):
                for end in (0, 1):
                    x = about[end : len(about) - 1 + end]
                    value, slope = self._tangent(x, sign)
                    # sign u <= value + slope (x + 2 ds u end - x_about)
                    by_u.append(sign * one - end * 2.0 * ds * slope)
                    by_x.append(-slope)
                    most.append(np.minimum(value - slope * x, _FREE))
        return self._intervals(by_u, 0.0), self._intervals(by_x, 0.0), self._intervals(most, 1.0)

    def _intervals(self, columns: list[Floats], last: float) -> Floats:
        """(n, k) in the order of the way; no interval follows the last station, where any `last` will do."""
        return np.column_stack([np.append(np.roll(column, -self.shift), last) for column in columns])

    def _tangent(self, x: Floats, sign: int) -> tuple[Floats, Floats]:
        """What the forces leave at squared speeds `x` (n-1,), m/s^2, and its slope."""
        width = 1e-6 * float(np.max(self.bound))
        low = np.maximum(x - width, 0.25 * width)
        high = low + 2.0 * width
        at_low, at_high = (self.limits.ceiling(np.sqrt(side), sign) for side in (low, high))
        slope = (at_high - at_low) / (2.0 * width)
        return at_low + slope * (x - low), slope
