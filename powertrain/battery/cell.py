"""Every parameter of a battery cell as validated, frozen data, read from TOML and written to it."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_type_hints

import msgspec
import numpy as np

from ..description.sections import NotNegative, Positive
from ..description.toml_file import dump_toml, find, on_shelf, read_toml
from ..errors import VehicleError
from .tables import ZERO_CELSIUS, Table, smallest

if TYPE_CHECKING:
    from os import PathLike

SHELF = Path(__file__).parent / "cells"

Degrees = Annotated[float, msgspec.Meta(gt=-100.0, lt=200.0)]
Share = Annotated[float, msgspec.Meta(ge=-0.1, le=1.1)]
Resistance = NotNegative | Table
Rate = Positive | Table


class _Section(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True, omit_defaults=True):
    """A TOML table; every key is required unless it has a default here. Checked when it is made by hand, too; msgspec checks decoded data only.

    Raises:
        VehicleError: a field of another kind, out of its range or not finite.
    """

    def __post_init__(self) -> None:
        for name, kind in _kinds(type(self)).items():
            value = _plain(getattr(self, name))
            try:
                msgspec.convert(value, kind)
            except msgspec.ValidationError as error:
                reason = str(error).partition(" - at ")[0].replace("`", "")
                raise VehicleError(f"{type(self).__name__}.{name} is {value!r}, {reason[0].lower()}{reason[1:]}") from None


@cache
def _kinds(section: type) -> dict[str, Any]:
    return get_type_hints(section, include_extras=True)


def _plain(value: Any) -> Any:
    """Numbers of NumPy as plain ones, which msgspec wants."""
    if isinstance(value, tuple):
        return tuple(_plain(entry) for entry in value)
    return value.item() if isinstance(value, np.generic) else value


class Mesc(_Section, frozen=True, kw_only=True):
    """Modified enhanced self-correcting model (5.2)-(5.6): a filter of four stages and R_i on the last.

    The published form has one pole and `resistance_ohm` only. Two options go beyond it: four poles of their own, and resistances of what acts at
    once (`ohmic_ohm`) and of the first three stages (`stage_ohm`).
    """

    pole_radps: Rate | Annotated[tuple[Rate, ...], msgspec.Meta(min_length=4, max_length=4)]
    resistance_ohm: Resistance
    ohmic_ohm: Resistance = 0.0
    stage_ohm: tuple[Resistance, ...] = ()


class Esc(_Section, frozen=True, kw_only=True):
    """Enhanced self-correcting model of Plett (5.1): series resistance and one filtered current."""

    ohmic_ohm: Resistance
    resistance_ohm: Resistance
    pole_radps: Rate


class Pair(_Section, frozen=True, kw_only=True):
    """A resistor with a capacitor beside it."""

    resistance_ohm: Resistance
    time_constant_s: Rate


class Rc(_Section, frozen=True, kw_only=True):
    """A series resistance and pairs of resistor and capacitor: passive."""

    ohmic_ohm: Resistance
    pairs: Annotated[tuple[Pair, ...], msgspec.Meta(min_length=1, max_length=6)]


class CellLimits(_Section, frozen=True, kw_only=True):
    """What the cell stands. Currents as magnitudes; the peak ones for at most `peak_duration_s`."""

    voltage_min_v: Positive
    voltage_max_v: Positive
    discharge_max_a: Positive
    charge_max_a: Positive
    discharge_peak_a: Positive
    charge_peak_a: Positive
    peak_duration_s: Positive = 10.0
    soc_min: Share = 0.0
    soc_max: Share = 1.0
    temperature_min_degc: Degrees
    temperature_max_degc: Degrees

    def __post_init__(self) -> None:
        super().__post_init__()
        for low, high in (("voltage_min_v", "voltage_max_v"), ("soc_min", "soc_max"), ("temperature_min_degc", "temperature_max_degc")):
            if not getattr(self, low) < getattr(self, high):
                raise VehicleError(f"{low} is {getattr(self, low):g}, expected less than {high} {getattr(self, high):g}")
        for steady, peak in (("discharge_max_a", "discharge_peak_a"), ("charge_max_a", "charge_peak_a")):
            if getattr(self, steady) > getattr(self, peak):
                raise VehicleError(f"{steady} is {getattr(self, steady):g}, expected at most {peak} {getattr(self, peak):g}")

    @property
    def temperature_range(self) -> tuple[float, float]:
        """Lowest and highest temperature, K."""
        return self.temperature_min_degc + ZERO_CELSIUS, self.temperature_max_degc + ZERO_CELSIUS


class Validity(_Section, frozen=True, kw_only=True):
    """Where the parameters were identified, and how well they met the voltage there.

    Attributes:
        soc: lowest and highest charge.
        temperature_degc: lowest and highest temperature; equal for a cell that was tested at one only.
        current_a: strongest charge (negative) and discharge current.
        voltage_rmse_v: RMSE of the voltage over the worst of the tests it was identified on.
    """

    soc: tuple[float, float]
    temperature_degc: tuple[float, float]
    current_a: tuple[float, float]
    voltage_rmse_v: NotNegative = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("soc", "temperature_degc", "current_a"):
            low, high = getattr(self, name)
            if not (-1e9 < low <= high < 1e9) or (name == "current_a" and low == high):
                raise VehicleError(f"{name} is {[low, high]}, expected two finite, increasing numbers")


class Cell(_Section, frozen=True, kw_only=True):
    """A cell. Units in the names; `powertrain/battery/cells/` holds described examples.

    Attributes:
        capacity_ah: charge between full and empty at rest.
        coulombic_efficiency: share of the charging current that is stored; discharge counts in full.
        capacity_correction: k_i(i, T), multiplies the current in the charge balance (5.2), (5.3).
        ocv_v: U_OCV(l, T), mean of the charge and discharge branches.
        hysteresis_v: M(l, T), half the distance of those branches.
        hysteresis_rate: gamma, how fast the hysteresis voltage changes, per full capacity moved.
        heat_capacity_jpk: of one cell.
    """

    name: Annotated[str, msgspec.Meta(min_length=1)]
    model: Literal["mesc", "esc", "rc"]
    source: str = ""
    capacity_ah: Positive
    coulombic_efficiency: Annotated[float, msgspec.Meta(gt=0.0, le=1.0)] | Table = 1.0
    capacity_correction: Positive | Table = 1.0
    hysteresis_rate: NotNegative = 0.0
    heat_capacity_jpk: Positive
    limits: CellLimits
    validity: Validity
    ocv_v: Table
    hysteresis_v: NotNegative | Table = 0.0
    mesc: Mesc | None = None
    esc: Esc | None = None
    rc: Rc | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        given = [name for name in ("mesc", "esc", "rc") if getattr(self, name) is not None]
        if given != [self.model]:
            raise VehicleError(f"model is {self.model!r} with the tables {given}, expected the table [{self.model}] and no other model's")
        if self.mesc and len(self.mesc.stage_ohm) not in (0, 3):
            raise VehicleError(f"mesc.stage_ohm has {len(self.mesc.stage_ohm)} entries, expected three (or none)")
        for name, value, floor in self._bounded():
            if isinstance(value, Table) and value.soc and ("pole" in name or "time" in name or "efficiency" in name or "correction" in name):
                raise VehicleError(f"{name} depends on soc, expected a number or a table without that axis")
            if not smallest(value) >= floor:
                raise VehicleError(f"{name} has a value of {smallest(value):g}, expected none below {floor:g}")
            if isinstance(value, Table) and value.extrapolate == "linear":
                raise VehicleError(f"{name} continues linearly, expected extrapolate = 'clamp' (it could become negative)")

    def _bounded(self) -> list[tuple[str, float | Table, float]]:
        tiny = 1e-12
        found: list[tuple[str, float | Table, float]] = [
            ("hysteresis_v", self.hysteresis_v, 0.0),
            ("coulombic_efficiency", self.coulombic_efficiency, tiny),
            ("capacity_correction", self.capacity_correction, tiny),
        ]
        if self.mesc:
            poles = self.mesc.pole_radps if isinstance(self.mesc.pole_radps, tuple) else (self.mesc.pole_radps,)
            found += [("mesc.pole_radps", pole, tiny) for pole in poles]
            found += [("mesc resistance", r, 0.0) for r in (self.mesc.resistance_ohm, self.mesc.ohmic_ohm, *self.mesc.stage_ohm)]
        if self.esc:
            found += [("esc resistance", r, 0.0) for r in (self.esc.ohmic_ohm, self.esc.resistance_ohm)]
            found.append(("esc.pole_radps", self.esc.pole_radps, tiny))
        if self.rc:
            found += [("rc resistance", r, 0.0) for r in (self.rc.ohmic_ohm, *(pair.resistance_ohm for pair in self.rc.pairs))]
            found += [("rc.time_constant_s", pair.time_constant_s, tiny) for pair in self.rc.pairs]
        return found

    @property
    def capacity(self) -> float:
        """Capacity C_N, A s."""
        return 3600.0 * self.capacity_ah


def frozen_at(cell: Cell, temperature: float) -> Cell:
    """The same cell with every table at one temperature (K): the same answers there, in half the time."""
    return _frozen(cell, temperature)


def _frozen(value: Any, temperature: float) -> Any:
    if isinstance(value, Table):
        return value.at_temperature(temperature)
    if isinstance(value, tuple):
        return tuple(_frozen(entry, temperature) for entry in value)
    if not isinstance(value, Cell | Mesc | Esc | Rc | Pair):
        return value
    return msgspec.structs.replace(value, **{name: _frozen(getattr(value, name), temperature) for name in value.__struct_fields__})


def shipped_cells() -> list[str]:
    """Names of the cells that ship with the package."""
    return on_shelf(SHELF)


def load_cell(name_or_path: str | PathLike[str]) -> Cell:
    """The shipped cell of that name, or the cell described by a TOML file.

    Raises:
        VehicleError: no such cell, or a file that is not TOML, lacks a key, has an unknown one or a value out of range.
    """
    return read_toml(find(name_or_path, SHELF, "cell"), Cell)


def dump_cell(cell: Cell) -> str:
    """The cell as TOML text; `load_cell` of it gives an equal cell."""
    return dump_toml(msgspec.to_builtins(cell))
