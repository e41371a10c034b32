"""Every parameter of a car as validated, frozen data, read from TOML."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, cast

import msgspec

from .description.sections import Battery, Body, Brakes, Chassis, Drive, Electrics, Limits, Resistance, Section, Steering, TyreFile
from .description.toml_file import find, on_shelf, read_toml
from .errors import VehicleError
from .tyre.linear import LinearTyre
from .tyre.magic import MagicTyre

if TYPE_CHECKING:
    from os import PathLike

SHELF = Path(__file__).parent / "vehicles"

#: m/s^2
GRAVITY = 9.81

_T = TypeVar("_T")


class Vehicle(Section, frozen=True, kw_only=True):
    """A car. All values SI, units in the names; see `powertrain/vehicles/romo.toml` for a described example.

    The first four sections are enough to plan. The others are needed by what models them; `need` fetches one or says that it is missing.
    """

    name: Annotated[str, msgspec.Meta(min_length=1)]
    chassis: Chassis
    resistance: Resistance
    drive: Drive
    limits: Limits
    body: Body | None = None
    steering: Steering | None = None
    brakes: Brakes | None = None
    electrics: Electrics | None = None
    battery: Battery | None = None
    tyre: LinearTyre | MagicTyre | TyreFile | None = None
    rear_tyre: LinearTyre | MagicTyre | TyreFile | None = None

    def __post_init__(self) -> None:
        """Refuse a torque and power envelope that voltage and current cannot reach.

        Raises:
            ValueError: with the speed and the torques.
        """
        if self.drive.weakening is not None:
            from .drive.machine import unreachable

            if words := unreachable(self.drive, self.limits.speed_max_mps * self.motor_ratio):
                raise ValueError(words)

    @property
    def effective_mass(self) -> float:
        """Mass plus what the spin of wheels and rotors adds to it, kg."""
        chassis, drive = self.chassis, self.drive
        wheels = chassis.wheel_count * chassis.wheel_inertia_kgm2 / chassis.wheel_radius_m**2
        return chassis.mass_kg + wheels + drive.motor_count * drive.rotor_inertia_kgm2 * self.motor_ratio**2

    @property
    def motor_ratio(self) -> float:
        """Motor speed over vehicle speed, rad/m; also driving force over one motor's torque, N/Nm."""
        return self.drive.gear_ratio / self.chassis.wheel_radius_m

    def tyres(self) -> tuple[Any, Any]:
        """The tyre models of a front and a rear wheel.

        Raises:
            VehicleError: the description has none, or its tyre file cannot be used.
        """
        front = self.need("tyre", object)
        rear = front if self.rear_tyre is None else self.rear_tyre
        return _tyre_model(front), _tyre_model(rear)

    def need(self, section: str, kind: type[_T]) -> _T:
        """The optional section of that name.

        Raises:
            VehicleError: this car's description lacks it.
        """
        found = getattr(self, section)
        if found is None:
            raise VehicleError(
                f"{self.name}: the description has no section [{section}], which is needed here; the page on cars and cells says what is in it"
            )
        return cast("_T", found)


def shipped() -> list[str]:
    """Names of the cars that ship with the package."""
    return on_shelf(SHELF)


def load_vehicle(name_or_path: str | PathLike[str]) -> Vehicle:
    """The shipped car of that name, or the car described by a TOML file.

    Raises:
        VehicleError: no such car, or a file that is not TOML, lacks a key, has an unknown one or a value out of range.
    """
    path = find(name_or_path, SHELF, "vehicle")
    return _with_files(read_toml(path, Vehicle), path.parent)


def _with_files(vehicle: Vehicle, folder: Path) -> Vehicle:
    """`vehicle` with the loss map and the tyre files that its description names beside itself.

    Raises:
        VehicleError: a loss map that cannot be used.
    """
    changes: dict[str, Any] = {}
    if vehicle.drive.map is not None:
        from .drive.motor_map import read_map

        file = str(folder / vehicle.drive.map)
        changes["drive"] = msgspec.structs.replace(read_map(file).drive(vehicle.drive), map=file)
    for name in ("tyre", "rear_tyre"):
        tyre = getattr(vehicle, name)
        if isinstance(tyre, TyreFile) and (folder / tyre.file).is_file():
            changes[name] = msgspec.structs.replace(tyre, file=str(folder / tyre.file))
    return msgspec.structs.replace(vehicle, **changes)


def _tyre_model(tyre: Any) -> Any:
    if isinstance(tyre, TyreFile):
        from .tyre.tir import read_tir

        return read_tir(tyre.file)
    return tyre
