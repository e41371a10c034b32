"""RC model: a series resistance and n pairs of resistor and capacitor, with tables over charge and temperature, optionally with hysteresis.

The state of a pair is the current through its resistor, `tau_j df_j/dt = i - f_j`; its voltage is R_j f_j. Without hysteresis and with constant
resistances it is passive: what goes in comes out, is stored in a capacitor or becomes heat, and every loss R_j f_j^2 is not negative.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .tables import look_up

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .cell import Cell, Rc


def _section(cell: Cell) -> Rc:
    assert cell.rc is not None
    return cell.rc


def states(cell: Cell) -> tuple[str, ...]:
    """Names of the states; as many filters as pairs."""
    return ("soc", "hysteresis", *(f"f{j + 1}" for j in range(len(_section(cell).pairs))))


def poles(cell: Cell, temperature: Any) -> list[Any]:
    """Inverse time constants of the pairs at `temperature` (K), rad/s."""
    return [1.0 / look_up(pair.time_constant_s, 0.5, temperature, 0.0) for pair in _section(cell).pairs]


def inputs(filters: Sequence[Any], current: Any) -> list[Any]:
    """What each pair sees: the current."""
    return [current] * len(filters)


def resistances(cell: Cell, soc: Any, current: Any, temperature: Any) -> tuple[Any, list[Any]]:
    """Series resistance, and those of the pairs, Ohm."""
    part = _section(cell)
    return look_up(part.ohmic_ohm, soc, temperature, current), [look_up(pair.resistance_ohm, soc, temperature, current) for pair in part.pairs]
