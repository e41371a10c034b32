"""From identified parameters at some temperatures to a cell with tables over all of them."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from ..cell import Cell, CellLimits, Esc, Mesc, Pair, Rc, Validity
from ..tables import ZERO_CELSIUS, Table
from .readers import REFERENCE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .regression import Drive, Tables
    from .structure import Structure

    Floats = NDArray[np.float64]

#: Widest distance of temperature nodes between which Arrhenius curves are interpolated linearly, K.
_WIDEST = 10.5


def temperature_nodes(tested: Sequence[float]) -> Floats:
    """Tested temperatures with further ones between them, K."""
    parts = [np.linspace(a, b, int(np.ceil((b - a) / _WIDEST)) + 1)[:-1] for a, b in pairwise(tested)]
    return np.concatenate([*parts, [tested[-1]]])


def arrhenius(tested: Floats, values: Floats, wanted: Floats) -> Floats:
    """Values (one row per tested temperature) at other temperatures: the logarithm is linear in 1/T between neighbours."""
    floor = 1e-3 * max(float(np.max(values)), 1e-12)  # a value of zero has no logarithm
    logs = np.log(np.maximum(values, 0.0) + floor).reshape(len(tested), -1)
    inverse = 1.0 / tested
    out = np.stack([np.interp(-1.0 / wanted, -inverse, column) for column in logs.T], axis=1)
    return np.maximum(np.exp(out) - floor, 0.0).reshape(len(wanted), *values.shape[1:])


def _tuples(values: Any) -> Any:
    if isinstance(values, list):
        return tuple(_tuples(entry) for entry in values)
    return float(f"{values:.5g}") if abs(values) > 1e-12 else 0.0  # what rounding leaves of a zero


def _table(grid: Floats, soc: Sequence[float], temperature: Floats | None, current: Sequence[float] = ()) -> float | Table:
    """A table over the axes that have more than one node; `grid` is (soc, temperature, current)."""
    axes: dict[str, Any] = {}
    keep = []
    degc = [] if temperature is None else np.round(temperature - ZERO_CELSIUS, 6).tolist()
    for name, nodes in (("soc", list(soc)), ("temperature_degc", degc), ("current_a", list(current))):
        if len(nodes) > 1:
            axes[name] = _tuples([float(x) for x in nodes])
        keep.append(slice(None) if len(nodes) > 1 else 0)
    values = _tuples(grid[tuple(keep)].tolist())
    return Table(values=values, **axes) if axes else values


def _ocv(found: Tables, structure: Structure, span: Floats | None) -> Table:
    ends = None if span is None else span[[0, -1]]
    columns = [found.ocv] if ends is None else [found.ocv + (t - REFERENCE) * found.slope for t in ends.tolist()]
    table = _table(np.stack(columns, axis=1)[:, :, None], structure.ocv_nodes, ends)
    assert isinstance(table, Table)
    return table


def build_cell(
    found: Tables, drives: Sequence[Drive], structure: Structure, *, name: str, source: str, limits: CellLimits, heat_capacity: float
) -> Cell:
    """The cell that these parameters describe; its voltage error is not known yet."""
    tested = np.array([drive.temperature for drive in drives])
    span = temperature_nodes(tested.tolist()) if len(tested) > 1 else None
    wanted = tested if span is None else span
    ampere_hours = float(np.mean([drive.capacity for drive in drives])) / 3600.0

    def over_temperature(parts: list[Floats], nodes: tuple[float, ...], current: tuple[float, ...] = ()) -> float | Table:
        shaped = np.stack(parts).reshape(len(tested), len(nodes), max(len(current), 1))
        return _table(np.moveaxis(arrhenius(tested, shaped, wanted), 0, 1), nodes, span, [c * ampere_hours for c in current])

    count = len(found.resistances[0])
    by_branch = [
        over_temperature(
            [each[b] / ampere_hours for each in found.resistances], structure.resistance_nodes, structure.current_nodes if b == 0 else ()
        )
        for b in range(count)
    ]
    efficiency = _table(np.array([min(d.efficiency, 1.0) for d in drives])[None, :, None], (), tested if len(tested) > 1 else None)
    gap = over_temperature(found.hysteresis, structure.hysteresis_nodes) if structure.hysteresis else 0.0
    socs, currents = [d.soc for d in drives], [d.current for d in drives]
    validity = Validity(
        soc=(_round(min(np.min(s) for s in socs)), _round(max(np.max(s) for s in socs))),
        temperature_degc=(_round(tested[0] - ZERO_CELSIUS), _round(tested[-1] - ZERO_CELSIUS)),
        current_a=(_round(min(np.min(i) for i in currents)), _round(max(np.max(i) for i in currents))),
    )
    return Cell(
        name=name, model=structure.model, source=source, capacity_ah=_round(ampere_hours), coulombic_efficiency=efficiency,  # pyright: ignore[reportArgumentType]
        hysteresis_rate=_round(found.rate) if structure.hysteresis else 0.0, heat_capacity_jpk=_round(heat_capacity), limits=limits,
        validity=validity, ocv_v=_ocv(found, structure, span), hysteresis_v=gap, **_section(structure, found.time_constants, by_branch),
    )  # fmt: skip


def _round(x: Any) -> float:
    return float(f"{float(x):.5g}")


def _section(structure: Structure, time_constants: Sequence[float], resistances: list[float | Table]) -> dict[str, Any]:
    """The table of the model's own parameters."""
    rates: tuple[float, ...] = tuple(_round(1.0 / tau) for tau in time_constants)
    ohmic = resistances[0] if structure.ohmic else 0.0
    stages = resistances[1:] if structure.ohmic else resistances
    if structure.model == "esc":
        return {"esc": Esc(ohmic_ohm=ohmic, resistance_ohm=stages[0], pole_radps=rates[0])}
    if structure.model == "rc":
        taus = [_round(tau) for tau in time_constants]
        return {"rc": Rc(ohmic_ohm=ohmic, pairs=tuple(Pair(resistance_ohm=r, time_constant_s=tau) for r, tau in zip(stages, taus, strict=True)))}
    poles = rates if len(rates) == 4 else rates[0]
    return {"mesc": Mesc(pole_radps=poles, resistance_ohm=stages[-1], ohmic_ohm=ohmic, stage_ohm=tuple(stages[:-1]))}
