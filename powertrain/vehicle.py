"""Every parameter of a car as validated, frozen data, read from TOML."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import msgspec

from .errors import VehicleError

if TYPE_CHECKING:
    from os import PathLike

SHELF = Path(__file__).parent / "vehicles"

#: m/s^2
GRAVITY = 9.81

Positive = Annotated[float, msgspec.Meta(gt=0.0, lt=1e9)]
NotNegative = Annotated[float, msgspec.Meta(ge=0.0, lt=1e9)]
Count = Annotated[int, msgspec.Meta(ge=1, le=8)]


class _Section(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A TOML table; every key is required unless it has a default here."""


class Chassis(_Section, frozen=True, kw_only=True):
    """Body and wheels."""

    mass_kg: Positive
    width_m: Positive
    wheel_radius_m: Positive
    wheel_inertia_kgm2: NotNegative
    wheel_count: Count = 4


class Resistance(_Section, frozen=True, kw_only=True):
    """Driving resistances (M6): drag area and the rolling resistance polynomial.

    `rolling_0 + rolling_1 (v / 100 km/h) + rolling_4 (v / 100 km/h)^4` is the rolling resistance coefficient.
    """

    drag_coefficient: NotNegative
    frontal_area_m2: NotNegative
    air_density_kgpm3: NotNegative
    rolling_0: NotNegative
    rolling_1: NotNegative = 0.0
    rolling_4: NotNegative = 0.0


class Drive(_Section, frozen=True, kw_only=True):
    """Equal permanent-magnet motors with their inverters (M1); losses as in (3.39). Values per motor."""

    motor_count: Count
    gear_ratio: Positive = 1.0
    torque_max_nm: Positive
    regen_torque_max_nm: NotNegative
    power_max_w: Positive
    regen_power_max_w: NotNegative
    inverter_constant_w: NotNegative
    inverter_per_current_wpa: NotNegative
    phase_resistance_ohm: Annotated[float, msgspec.Meta(ge=1e-4, lt=1e3)]
    pole_pairs: Annotated[int, msgspec.Meta(ge=1, le=200)]
    magnet_flux_wb: Positive
    hysteresis_nm: NotNegative
    eddy_nms: NotNegative
    friction_nm: NotNegative


class Limits(_Section, frozen=True, kw_only=True):
    """What the car or its passengers allow."""

    speed_max_mps: Positive
    acceleration_max_mps2: Positive
    deceleration_max_mps2: Positive
    lateral_acceleration_max_mps2: Positive
    turning_radius_min_m: Positive | None = None


class Vehicle(_Section, frozen=True, kw_only=True):
    """A car. All values SI, units in the names; see `powertrain/vehicles/romo.toml` for a described example."""

    name: Annotated[str, msgspec.Meta(min_length=1)]
    chassis: Chassis
    resistance: Resistance
    drive: Drive
    limits: Limits

    @property
    def effective_mass(self) -> float:
        """Mass plus what the wheels' spin adds to it, kg."""
        chassis = self.chassis
        return chassis.mass_kg + chassis.wheel_count * chassis.wheel_inertia_kgm2 / chassis.wheel_radius_m**2

    @property
    def motor_ratio(self) -> float:
        """Motor speed over vehicle speed, rad/m; also driving force over one motor's torque, N/Nm."""
        return self.drive.gear_ratio / self.chassis.wheel_radius_m


def shipped() -> list[str]:
    """Names of the cars that ship with the package."""
    return sorted(path.stem for path in SHELF.glob("*.toml"))


def load_vehicle(name_or_path: str | PathLike[str]) -> Vehicle:
    """The shipped car of that name, or the car described by a TOML file.

    Raises:
        VehicleError: no such car, or a file that is not TOML, lacks a key, has an unknown one or a value out of range.
    """
    path = Path(name_or_path)
    if path.suffix == "" and not path.is_file():
        if str(name_or_path) not in shipped():
            raise VehicleError(f"{name_or_path}: no such file and no shipped vehicle, expected a TOML file or one of {', '.join(shipped())}")
        path = SHELF / f"{name_or_path}.toml"
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise VehicleError(f"{path}: no such file") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise VehicleError(f"{path}: not TOML: {error}") from None
    except OSError as error:
        raise VehicleError(f"{path}: cannot be read: {error.strerror}") from None
    try:
        return msgspec.convert(table, Vehicle)
    except msgspec.ValidationError as error:
        raise VehicleError(f"{path}: {_explain(str(error), table)}") from None


def _explain(message: str, table: dict[str, Any]) -> str:
    """The validator's message with the key in plain dots and the value that was found."""
    text, _, place = message.partition(" - at `$")
    key = place.strip("`.")
    field = re.search(r"field `(\w+)`", text)
    if field:
        dotted = f"{key}.{field[1]}" if key else field[1]
        if "unknown" not in text:
            return f"key {dotted} is missing"
        section = key or "a vehicle"
        fields = {"chassis": Chassis, "resistance": Resistance, "drive": Drive, "limits": Limits}.get(key, Vehicle)
        return f"unknown key {dotted}, expected in {section} only {', '.join(fields.__struct_fields__)}"
    value: Any = table
    for word in filter(None, key.split(".")):
        value = value.get(word) if isinstance(value, dict) else value
    return f"{key} is {value!r}, {text[0].lower()}{text[1:]}".replace("`", "")
