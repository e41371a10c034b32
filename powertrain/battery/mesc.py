"""MESC, the modified enhanced self-correcting model (5.2)-(5.6): a current filter of four stages, `u = U_OCV(l) + h - R_i(l, i, T) f_4`.

Errata 16 and 17 are in: current positive on discharge, hysteresis drawn to -M by discharge and to +M by charge, capacity in A s. The published
filter is critically damped (one pole). It lets no current through at once, so a step of current shows in the voltage only after 1/w: with one
pole the model either lags behind steps or is blind to diffusion. The options of `Mesc` (four poles, a resistance per stage, an ohmic part)
cure this with the same six states. The filter is not passive in the circuit sense, its heat R_i f_4^2 is never negative.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .tables import look_up

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .cell import Cell, Mesc

STATES = ("soc", "hysteresis", "f1", "f2", "f3", "f4")


def _section(cell: Cell) -> Mesc:
    assert cell.mesc is not None
    return cell.mesc


def states(cell: Cell) -> tuple[str, ...]:
    """Names of the states."""
    return STATES


def poles(cell: Cell, temperature: Any) -> list[Any]:
    """Poles of the four stages at `temperature` (K), rad/s."""
    given = _section(cell).pole_radps
    each = given if isinstance(given, tuple) else (given,) * 4
    return [look_up(pole, 0.5, temperature, 0.0) for pole in each]


def inputs(filters: Sequence[Any], current: Any) -> list[Any]:
    """What each stage filters: the stage before it, the first one the current."""
    return [current, *filters[:-1]]


def resistances(cell: Cell, soc: Any, current: Any, temperature: Any) -> tuple[Any, list[Any]]:
    """Resistance that acts at once, and those of the stages, Ohm."""
    part = _section(cell)
    stages = (*(part.stage_ohm or (0.0, 0.0, 0.0)), part.resistance_ohm)
    return look_up(part.ohmic_ohm, soc, temperature, current), [look_up(r, soc, temperature, current) for r in stages]
