"""The grid of `dp`: speeds at the stations, the transitions that the limits allow, and the cheapest way through at a price of time."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from powertrain import driving_resistance
from powertrain.energy.balance import COMPONENTS, balance

from ...errors import SolverError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from ..bounds.speed_limits import SpeedLimits

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

#: v^2/2 may pass a limit by this fraction of its largest value: rounding must not forbid the fastest profile.
_ROUNDING = 1e-8
#: So many transitions are kept from price to price, 12 bytes each; what is beyond is computed again every time.
_KEPT = 20_000_000


class _Move(NamedTuple):
    """Transitions over one interval, from every speed to a band of speeds.

    Attributes:
        to: (a, w) numbers of the band's speeds.
        energy: (a, w) J, inf where a limit is broken.
        time: (a, w) s.
    """

    to: NDArray[np.int32]
    energy: NDArray[np.float32]
    time: NDArray[np.float32]


class SpeedGrid:
    """Dynamic programming over the stations of some limits, starting at station number `shift` (0 but on circuits).

    Args:
        limits: what must be kept; jerk and windows are not looked at.
        levels: increasing speeds (m/s) at the stations in the order of the way, n of them.
        shift: number of the station where the way starts.
        ends: numbers of the speeds there from which ways are sought; on circuits they end with the same.
    """

    def __init__(self, limits: SpeedLimits, levels: Sequence[Floats], shift: int, ends: Sequence[int]) -> None:
        self.limits, self.levels, self.ends = limits, levels, np.asarray(ends, dtype=np.intp)
        self._order = np.roll(np.arange(len(limits.ds)), -shift)
        self._shift, self._slopes = shift, (limits.slope_against(1), limits.slope_against(-1))
        self._slack = _ROUNDING * float(np.max(limits.energy_max))
        self._moves: dict[int, _Move] = {}
        self._room = _KEPT

    def cheapest(self, price: float) -> Floats:
        """Speeds (n,) of the way of least energy plus `price` (W) times time.

        Raises:
            SolverError: the grid has no way through.
        """
        # one row per end: circuits try several
        costs = np.full((len(self.ends), len(self.levels[-1])), np.inf)
        costs[np.arange(len(self.ends)), self.ends if self.limits.closed else -1] = 0.0
        choice: list[NDArray[np.int32]] = []
        for k in range(len(self._order) - 1, -1, -1):
            move = self._moves.get(k) or self._move(k)
            own = move.energy + np.float32(price) * move.time
            rows = np.arange(len(own))
            chosen, known = np.empty((len(costs), len(own)), dtype=np.int32), costs
            costs = np.empty((len(costs), len(own)))
            for which, cost in enumerate(known):
                total = cost[move.to] + own
                best = total.argmin(axis=1)
                costs[which], chosen[which] = total[rows, best], move.to[rows, best]
            choice.append(chosen)
        found = costs[np.arange(len(self.ends)), self.ends]
        which = int(np.argmin(found))
        if not np.isfinite(found[which]):
            raise SolverError(f"{self.limits.name}: no row of speeds of the grid keeps the limits from start to end; more levels, or method eco")
        return self._walked(which, choice[::-1])

    def _walked(self, which: int, choice: list[NDArray[np.int32]]) -> Floats:
        at = int(self.ends[which])
        v = [self.levels[0][at]]
        for speeds, chosen in zip(self.levels[1:], choice, strict=True):
            at = int(chosen[which, at])
            v.append(speeds[at])
        if not self.limits.closed:
            return np.array(v)
        turned = np.roll(v[:-1], self._shift)
        return np.append(turned, turned[0])

    def _move(self, k: int) -> _Move:
        """The transitions of interval number `k` on the way; kept while there is room."""
        at = int(self._order[k])
        v0, v1 = self.levels[k], self.levels[k + 1]
        low0, high0, regen0 = self._reach(at, v0)
        low1, high1, regen1 = self._reach(at, v1)
        ds, e0, e1 = float(self.limits.ds[at]), 0.5 * v0**2, 0.5 * v1**2
        first = np.searchsorted(e1, e0 + ds * low0 - self._slack)
        last = np.searchsorted(e1, e0 + ds * high0 + self._slack, side="right")
        band = first[:, None] + np.arange(max(int((last - first).max()), 1))
        to = np.minimum(band, len(v1) - 1)
        rise = e1[to] - e0[:, None]
        broken = (band >= last[:, None]) | (rise > (ds * high1 + self._slack)[to]) | (rise < (ds * low1 - self._slack)[to])
        brake = 0.0
        if self.limits.brake > 0.0:
            needed = -self.limits.vehicle.effective_mass * rise / ds - np.minimum(regen0[:, None], regen1[to])
            brake = np.where(broken, 0.0, np.maximum(needed, 0.0))
        found = balance(self.limits.vehicle, ds, v0[:, None], v1[to], self.limits.slope[at] * ds, brake)
        energy = np.asarray(sum(found.energies[name] for name in COMPONENTS))
        move = _Move(to.astype(np.int32), np.where(broken, np.inf, energy).astype(np.float32), found.time.astype(np.float32))
        if energy.size <= self._room:
            self._room -= energy.size
            self._moves[k] = move
        return move

    def _reach(self, at: int, v: Floats) -> tuple[Floats, Floats, Floats]:
        """Least and largest acceleration (m/s^2) at speeds `v` in interval `at`, and the force (N) that recuperation and resistance brake with."""
        limits, vehicle = self.limits, self.limits.vehicle
        uphill, downhill = (driving_resistance(vehicle, v, slope[at]) for slope in self._slopes)
        most, least, regen = np.full_like(v, np.inf), np.full_like(v, np.inf), np.full_like(v, np.inf)
        for limit in limits.forces:
            force = limit.ceiling(vehicle, v, tuple(np.asarray(row)[at] for row in limit.data))
            if limit.sign > 0:
                most = np.minimum(most, force)
            elif limit.of == "motors":
                regen = np.minimum(regen, force)
            else:
                least = np.minimum(least, force)
        least = np.minimum(least, regen + limits.brake)
        mass = vehicle.effective_mass
        low = -np.minimum((least + downhill) / mass, limits.deceleration[at])
        return low, np.minimum((most - uphill) / mass, limits.acceleration[at]), regen + downhill
