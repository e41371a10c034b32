"""Look-up tables over state of charge, temperature and current: multilinear, the same on numbers, arrays and CasADi symbols."""

from __future__ import annotations

from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING, Any, Literal

import msgspec
import numpy as np

from ..errors import VehicleError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

#: degC to K
ZERO_CELSIUS = 273.15
#: The axes a table may have, in the order of the nesting of its values.
AXES = ("soc", "temperature_degc", "current_a")

Nodes = tuple[float, ...]
Values = tuple[float | tuple[float | tuple[float, ...], ...], ...]


class Table(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True, omit_defaults=True, dict=True):
    """A multilinear table over one to three axes; outside of them clamped or continued linearly.

    Call it with (soc, temperature in K, current in A): axes that the table does not have are ignored. The file states temperatures in degC.

    Attributes:
        soc: nodes without unit, increasing.
        temperature_degc: nodes, degC, increasing.
        current_a: nodes, A, positive on discharge, increasing.
        values: nested once per axis that is given, in this order.
        extrapolate: what lies outside the nodes: "clamp" the outermost value, or "linear".

    Raises:
        VehicleError: no axis, nodes that do not increase, values of the wrong shape, numbers that are not finite.
    """

    values: Values
    soc: Nodes | None = None
    temperature_degc: Nodes | None = None
    current_a: Nodes | None = None
    extrapolate: Literal["clamp", "linear"] = "clamp"

    def __post_init__(self) -> None:
        named = [(name, getattr(self, name)) for name in AXES if getattr(self, name) is not None]
        if not named:
            raise VehicleError(f"table has no axis, expected at least one of {', '.join(AXES)}")
        for name, nodes in named:
            if len(nodes) < 2 or not np.all(np.isfinite(nodes)) or not np.all(np.diff(nodes) > 0.0):
                raise VehicleError(f"table axis {name} is {list(nodes)}, expected at least two finite, increasing nodes")
        shape = tuple(len(nodes) for _, nodes in named)
        try:
            grid = np.array(self.values, dtype=np.float64)
        except ValueError:
            raise VehicleError(f"table values have rows of different length, expected shape {shape} over {[name for name, _ in named]}") from None
        if grid.shape != shape:
            raise VehicleError(f"table values have shape {grid.shape}, expected {shape} over {[name for name, _ in named]}")
        if not np.all(np.isfinite(grid)):
            raise VehicleError(f"table value at {[int(k) for k in np.argwhere(~np.isfinite(grid))[0]]} is not finite")

    @cached_property
    def grid(self) -> Floats:
        """The values as a read-only array."""
        grid = np.array(self.values, dtype=np.float64)
        grid.setflags(write=False)
        return grid

    @cached_property
    def axes(self) -> tuple[tuple[int, Floats], ...]:
        """(place in the call, nodes in SI units) of each axis."""
        shift = (0.0, ZERO_CELSIUS, 0.0)
        given = [(k, getattr(self, name)) for k, name in enumerate(AXES)]
        return tuple((k, np.array(nodes) + shift[k]) for k, nodes in given if nodes is not None)

    def __call__(self, soc: Any = 0.5, temperature: Any = 298.15, current: Any = 0.0) -> Any:
        """The value at `soc`, `temperature` (K) and `current` (A): floats, arrays or lists that broadcast, or CasADi symbols.

        A NaN gives NaN in numbers, but 0 in a CasADi function of a clamped table (its fmin and fmax drop the NaN): check what goes in there.
        """
        points = [np.asarray(x, dtype=np.float64) if isinstance(x, list | tuple) else x for x in (soc, temperature, current)]
        at = [(nodes, points[k]) for k, nodes in self.axes]
        if all(isinstance(x, int | float | np.ndarray | np.generic) for _, x in at):
            return self._numeric(at)
        return self._symbolic(at)

    def at_temperature(self, temperature: float) -> float | Table:
        """The table at one temperature (K): without that axis, a number if it was the only one."""
        if self.temperature_degc is None:
            return self
        nodes = dict(self.axes)
        own = np.meshgrid(*(nodes[k] for k in nodes if k != 1), indexing="ij")
        points: list[Any] = [0.0, temperature, 0.0]
        for k, grid in zip((k for k in nodes if k != 1), own, strict=True):
            points[k] = grid
        values = _tuples(np.asarray(self(*points)).tolist())
        left = {name: getattr(self, name) for name in ("soc", "current_a") if getattr(self, name) is not None}
        return Table(values=values, extrapolate=self.extrapolate, **left) if left else float(values)

    def _numeric(self, at: list[tuple[Floats, Any]]) -> Any:
        places, weights = [], []
        for nodes, x in at:
            j = np.minimum(np.maximum(np.searchsorted(nodes, x, side="right") - 1, 0), len(nodes) - 2)
            w = (x - nodes[j]) / (nodes[j + 1] - nodes[j])
            places.append(j)
            weights.append(np.minimum(np.maximum(w, 0.0), 1.0) if self.extrapolate == "clamp" else w)
        total: Any = 0.0
        for corner in product((0, 1), repeat=len(at)):
            share: Any = 1.0
            for w, up in zip(weights, corner, strict=True):
                share = share * (w if up else 1.0 - w)
            total = total + share * self.grid[tuple(j + up for j, up in zip(places, corner, strict=True))]
        return total

    def _symbolic(self, at: list[tuple[Floats, Any]]) -> Any:
        hats = [_hats(nodes, x, clamp=self.extrapolate == "clamp") for nodes, x in at]
        # current outermost: what depends on charge and temperature only is then the same expression wherever one looks for a current
        return _contract(self.grid.T, hats[::-1])


def _tuples(values: Any) -> Any:
    return tuple(_tuples(entry) for entry in values) if isinstance(values, list) else float(values)


def _contract(grid: Floats, hats: list[list[Any]]) -> Any:
    if not hats:
        return float(grid)
    total: Any = 0.0
    for part, hat in zip(grid, hats[0], strict=True):
        total = total + hat * _contract(part, hats[1:])
    return total


def _hats(nodes: Floats, x: Any, *, clamp: bool) -> list[Any]:
    """The hat functions of the nodes at `x`; without `clamp` the outermost two on each side go on linearly."""
    last, hats = len(nodes) - 1, []
    for j in range(last + 1):
        rise = (x - float(nodes[j - 1])) / float(nodes[j] - nodes[j - 1]) if j > 0 else None
        fall = (float(nodes[j + 1]) - x) / float(nodes[j + 1] - nodes[j]) if j < last else None
        if rise is not None and (clamp or j > 1):
            rise = np.fmax(rise, 0.0)
        if fall is not None and (clamp or j < last - 1):
            fall = np.fmax(fall, 0.0)
        if rise is None or fall is None:
            hat: Any = fall if rise is None else rise
        else:
            hat = np.fmin(rise, fall)
        hats.append(np.fmin(hat, 1.0) if clamp else hat)
    return hats


def look_up(value: float | Table, soc: Any, temperature: Any, current: Any) -> Any:
    """A parameter that is either one number or a table."""
    return value(soc, temperature, current) if isinstance(value, Table) else value


def smallest(value: float | Table) -> float:
    """The smallest value a parameter can take inside its nodes."""
    return float(np.min(value.grid)) if isinstance(value, Table) else float(value)


def capacity_correction(slope_pa: float, offset: float, current_min_a: float, current_max_a: float, nodes: int = 41) -> Table:
    """k_i over current as a table, (5.3) with its branches on the sides that discharge-positive current needs.

    `slope i + offset` for discharge (i > 0), `exp(slope i) + offset - 1` for charge; continuous with value `offset` at rest.

    Args:
        slope_pa: c_i > 0, 1/A.
        offset: k_0, the correction at rest.
        current_min_a: strongest charge current (negative), A.
        current_max_a: strongest discharge current, A.
        nodes: how many.

    Raises:
        VehicleError: a correction that is not positive over the range.
    """
    current = np.unique(np.append(np.linspace(current_min_a, current_max_a, nodes), 0.0))
    k = np.where(current > 0.0, slope_pa * current + offset, np.exp(slope_pa * np.minimum(current, 0.0)) + offset - 1.0)
    if not np.all(k > 0.0):
        raise VehicleError(f"capacity correction falls to {np.min(k):g} within {current_min_a:g} to {current_max_a:g} A, expected above 0")
    return Table(current_a=tuple(current.tolist()), values=tuple(k.tolist()))
