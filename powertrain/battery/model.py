"""One cell, three models: what MESC, ESC and RC share, written once.

All three are `u = U_OCV(l, T) + h - R_0 i - sum_j R_j f_j` with a charge balance (5.2), a hysteresis voltage and linear filters of the current;
they differ in how the filters are connected. Plain functions: floats, arrays of any shape that broadcasts, and CasADi symbols.

Power adds up exactly, at every instant:
`chemical U_OCV i = terminal u i + heat (R_0 i^2 + sum R_j f_j^2) + polarisation (sum R_j f_j (i - f_j) - h i)`.
In the RC model the last term is what goes into the capacitors and the hysteresis; in the others it is defined by this sum.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, cast

import numpy as np

from . import esc, mesc, rc
from .tables import Table, look_up

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .cell import Cell


class CellModel(Protocol):
    """What a model of a cell says about its filters; all else is shared."""

    def states(self, cell: Cell) -> tuple[str, ...]:
        """Names of the states: "soc", "hysteresis", then the filters."""
        ...

    def poles(self, cell: Cell, temperature: Any) -> list[Any]:
        """Pole of each filter, rad/s."""
        ...

    def inputs(self, filters: Sequence[Any], current: Any) -> list[Any]:
        """The current that each filter follows, A."""
        ...

    def resistances(self, cell: Cell, soc: Any, current: Any, temperature: Any) -> tuple[Any, list[Any]]:
        """Resistance that acts at once, and one per filter, Ohm."""
        ...


_MODELS: dict[str, CellModel] = {"mesc": cast("CellModel", mesc), "esc": cast("CellModel", esc), "rc": cast("CellModel", rc)}


class Powers(NamedTuple):
    """Where the power of a cell goes, W; `chemical = terminal + heat + polarisation`.

    `chemical` counts the whole terminal current, that part of a charge current, too, which the coulombic efficiency does not let in; and `heat` is
    that of the resistances only (see `heat`).
    """

    chemical: Any
    terminal: Any
    heat: Any
    polarisation: Any


def model_of(cell: Cell) -> CellModel:
    """The equations of the cell's model."""
    return _MODELS[cell.model]


def varies(cell: Cell) -> bool:
    """Whether a resistance of the cell depends on current."""
    tables: list[Any] = []
    if cell.mesc:
        tables = [cell.mesc.ohmic_ohm, cell.mesc.resistance_ohm, *cell.mesc.stage_ohm]
    elif cell.esc:
        tables = [cell.esc.ohmic_ohm, cell.esc.resistance_ohm]
    elif cell.rc:
        tables = [cell.rc.ohmic_ohm, *(pair.resistance_ohm for pair in cell.rc.pairs)]
    return any(isinstance(table, Table) and table.current_a is not None for table in tables)


def states(cell: Cell) -> tuple[str, ...]:
    """Names of the cell's states, in order."""
    return model_of(cell).states(cell)


def rest(cell: Cell, soc: Any, hysteresis: Any = 0.0) -> tuple[Any, ...]:
    """The state of a cell at rest with charge `soc`; `hysteresis` in V is what its past left."""
    return (soc, hysteresis, *(0.0 * soc for _ in states(cell)[2:]))


def charge_rate(cell: Cell, soc: Any, current: Any, temperature: Any) -> Any:
    """eta k_i i / C_N: how fast the cell discharges, 1/s (5.2). The efficiency counts on charge only."""
    eta = look_up(cell.coulombic_efficiency, soc, temperature, current)
    k = look_up(cell.capacity_correction, soc, temperature, current)
    return (np.fmax(current, 0.0) + eta * np.fmin(current, 0.0)) * k / cell.capacity


def derivative(cell: Cell, state: Sequence[Any], current: Any, temperature: Any, *, capacity_scale: Any = 1.0) -> list[Any]:
    """Time derivative of the state (5.2), one entry per state.

    Args:
        cell: the cell.
        state: as `states(cell)` names them: floats, arrays or symbols.
        current: A, positive on discharge.
        temperature: K.
        capacity_scale: capacity of this cell over `cell`'s.
    """
    soc, hysteresis, *filters = state
    rate = charge_rate(cell, soc, current, temperature) / capacity_scale
    bound = look_up(cell.hysteresis_v, soc, temperature, current)
    model = model_of(cell)
    follow = zip(model.poles(cell, temperature), model.inputs(filters, current), filters, strict=True)
    return [-rate, np.fabs(cell.hysteresis_rate * rate) * (-np.sign(current) * bound - hysteresis), *(w * (u - f) for w, u, f in follow)]


def electromotive(cell: Cell, state: Sequence[Any], current: Any, temperature: Any, *, resistance_scale: Any = 1.0) -> tuple[Any, Any]:
    """(E, R_0) in V and Ohm of `u = E - R_0 i`: what the state holds, and the resistance that acts at once (at `current`)."""
    soc, hysteresis, *filters = state
    ohmic, stages = model_of(cell).resistances(cell, soc, current, temperature)
    held = cell.ocv_v(soc, temperature, current) + hysteresis
    for r, f in zip(stages, filters, strict=True):
        held = held - resistance_scale * r * f
    return held, resistance_scale * ohmic


def voltage(cell: Cell, state: Sequence[Any], current: Any, temperature: Any, *, resistance_scale: Any = 1.0) -> Any:
    """Terminal voltage in V (5.4); arguments as in `derivative`, `resistance_scale` multiplies every resistance."""
    held, ohmic = electromotive(cell, state, current, temperature, resistance_scale=resistance_scale)
    return held - ohmic * current


def powers(cell: Cell, state: Sequence[Any], current: Any, temperature: Any, *, resistance_scale: Any = 1.0) -> Powers:
    """Where the cell's power goes; the four add up exactly."""
    soc, hysteresis, *filters = state
    ohmic, stages = model_of(cell).resistances(cell, soc, current, temperature)
    heating = resistance_scale * ohmic * current**2
    polarisation = -hysteresis * current
    for r, f in zip(stages, filters, strict=True):
        heating = heating + resistance_scale * r * f**2
        polarisation = polarisation + resistance_scale * r * f * (current - f)
    terminal = voltage(cell, state, current, temperature, resistance_scale=resistance_scale) * current
    return Powers(cell.ocv_v(soc, temperature, current) * current, terminal, heating, polarisation)


def heat(cell: Cell, state: Sequence[Any], current: Any, temperature: Any, *, resistance_scale: Any = 1.0) -> Any:
    """Heat of the resistances in W, never negative: R_i f_4^2 in the published MESC form.

    Left out, so a real cell warms a little more: the work of the hysteresis, -h i (part of `polarisation`; over a closed slow cycle the area of
    the loop, about 2 M per charge that goes out and comes back); what the coulombic efficiency loses on charge, (1 - eta) U_OCV |i|; and the
    reversible heat T i dU_OCV/dT, of either sign.
    """
    return powers(cell, state, current, temperature, resistance_scale=resistance_scale).heat
