"""ESC, the enhanced self-correcting model of G. L. Plett (5.1): series resistance, one filtered current, hysteresis. The baseline.

`u = U_OCV(l) + h - R_0 i - R_1 f_1`, `df_1/dt = w (i - f_1)`. The filter is a differential equation here, so no explicit Euler step is built in.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .tables import look_up

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .cell import Cell, Esc

STATES = ("soc", "hysteresis", "f1")


def _section(cell: Cell) -> Esc:
    assert cell.esc is not None
    return cell.esc


def states(cell: Cell) -> tuple[str, ...]:
    """Names of the states."""
    return STATES


def poles(cell: Cell, temperature: Any) -> list[Any]:
    """Pole of the filter at `temperature` (K), rad/s."""
    return [look_up(_section(cell).pole_radps, 0.5, temperature, 0.0)]


def inputs(filters: Sequence[Any], current: Any) -> list[Any]:
    """The filter's input: the current."""
    return [current]


def resistances(cell: Cell, soc: Any, current: Any, temperature: Any) -> tuple[Any, list[Any]]:
    """Series resistance, and that of the filtered current, Ohm."""
    part = _section(cell)
    return look_up(part.ohmic_ohm, soc, temperature, current), [look_up(part.resistance_ohm, soc, temperature, current)]
