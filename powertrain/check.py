"""Whether a car's description makes sense: findings that ranges alone do not see."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from .energy.performance import acceleration_time, best_point, steepest_slope, top_speed, understeer_gradient
from .errors import VehicleError
from .vehicle import GRAVITY, Vehicle, load_vehicle

if TYPE_CHECKING:
    from os import PathLike


class Finding(NamedTuple):
    """Something to know about a description: `error` cannot be used, `warning` is implausible, `note` is missing but not needed for all."""

    severity: Literal["error", "warning", "note"]
    place: str
    words: str

    def __str__(self) -> str:
        return f"{self.severity:8s}{self.place}: {self.words}"


def check(name_or_path: str | PathLike[str]) -> list[Finding]:
    """All findings about a shipped car or a TOML file, errors first."""
    try:
        vehicle = load_vehicle(name_or_path)
    except VehicleError as error:
        place, _, words = str(error).partition(": ")
        return [Finding("error", place, words)]
    found = [*_missing(vehicle), *_motion(vehicle), *_drive(vehicle), *_handling(vehicle), *_supply(vehicle), *_battery(vehicle)]
    return sorted(found, key=lambda finding: ("error", "warning", "note").index(finding.severity))


def _missing(vehicle: Vehicle) -> list[Finding]:
    uses = {
        "body": "lateral dynamics",
        "tyre": "lateral dynamics",
        "steering": "the double-track plant",
        "brakes": "the double-track plant",
        "electrics": "auxiliary consumption",
        "battery": "charge and range",
    }
    return [Finding("note", f"[{name}]", f"not given, needed for {use}") for name, use in uses.items() if getattr(vehicle, name) is None]


def _supply(vehicle: Vehicle) -> list[Finding]:
    if vehicle.electrics is not None and vehicle.electrics.auxiliary_w > 5000.0:
        return [Finding("warning", "electrics.auxiliary_w", f"{vehicle.electrics.auxiliary_w:g} W all the time, expected below 5 kW")]
    return []


def _motion(vehicle: Vehicle) -> list[Finding]:
    found = []
    reached, stated = top_speed(vehicle), vehicle.limits.speed_max_mps
    if reached == 0.0:
        found.append(Finding("error", "drive", "the car cannot start on a level road"))
    elif reached < stated * 0.999:
        found.append(Finding("warning", "limits.speed_max_mps", f"{stated:.1f} m/s, but the motors reach {reached:.1f} m/s on a level road"))
    if 0.0 < steepest_slope(vehicle) < 0.1:
        found.append(Finding("warning", "drive", f"climbs {100 * steepest_slope(vehicle):.1f} %, expected 10 % or more"))
    up, down = vehicle.limits.acceleration_max_mps2, vehicle.limits.deceleration_max_mps2
    if up > GRAVITY or down > 1.3 * GRAVITY:
        beyond = f"acceleration {up:g} or deceleration {down:g} m/s^2 beyond what tyres give"
        found.append(Finding("warning", "limits", f"{beyond}, expected at most {GRAVITY:.1f} and {1.3 * GRAVITY:.1f} m/s^2"))
    if acceleration_time(vehicle, min(10.0, stated)) < 1.0:
        found.append(Finding("warning", "drive.torque_max_nm", "0 to 10 m/s in less than 1 s, expected more"))
    return found


def _drive(vehicle: Vehicle) -> list[Finding]:
    best = best_point(vehicle).efficiency
    if not 0.8 < best < 0.98:
        return [Finding("warning", "drive", f"best efficiency {100 * best:.1f} %, expected 80 to 98 % of a motor with its inverter")]
    return []


def _handling(vehicle: Vehicle) -> list[Finding]:
    body = vehicle.body
    if body is None:
        return []
    found = []
    if vehicle.chassis.wheel_count != 4 or vehicle.chassis.wheel_inertia_kgm2 == 0.0:
        found.append(Finding("error", "chassis", "a car with a body needs four wheels with inertia"))
    tips = 0.5 * min(body.front_track_m, body.rear_track_m) / body.cog_height_m
    if tips < 0.7:
        found.append(Finding("warning", "body.cog_height_m", f"tips over at {tips:.2f} g of lateral acceleration, expected 0.7 g or more"))
    heel = vehicle.chassis.mass_kg * GRAVITY * body.cog_height_m
    stiffness = {key: getattr(body, key) for key in ("roll_stiffness_nmprad", "pitch_stiffness_nmprad")}
    found.extend(
        Finding("error", f"body.{key}", f"{value:g} Nm/rad, expected more than the weight's {heel:.0f} Nm/rad")
        for key, value in stiffness.items()
        if value <= heel
    )
    track, width = max(body.front_track_m, body.rear_track_m), vehicle.chassis.width_m
    if track > width:
        found.append(Finding("error", "body", f"a track of {track:g} m is wider than chassis.width_m, {width:g} m"))
    if vehicle.tyre is not None:
        found += _tyres(vehicle)
    return found


def _tyres(vehicle: Vehicle) -> list[Finding]:
    found = []
    try:
        tyres = vehicle.tyres()
    except VehicleError as error:
        return [Finding("error", "tyre", str(error))]
    for place, tyre in zip(("tyre", "rear_tyre"), tyres, strict=True):
        findings: Any = getattr(tyre, "check", list)()
        found.extend(Finding("warning", place, str(finding)) for finding in findings)
        if abs(tyre.rolling_radius / vehicle.chassis.wheel_radius_m - 1.0) > 0.05:
            radius, wheel = tyre.rolling_radius, vehicle.chassis.wheel_radius_m
            found.append(Finding("warning", place, f"rolling radius {radius:.3f} m, chassis.wheel_radius_m is {wheel:.3f} m"))
    gradient = understeer_gradient(vehicle)
    if abs(gradient) > 0.01:
        found.append(Finding("warning", "tyre", f"understeer gradient {1e3 * gradient:.1f} mrad per m/s^2, expected -10 to 10"))
    return found


def _battery(vehicle: Vehicle) -> list[Finding]:
    if vehicle.battery is None:
        return []
    from .battery import load_cell

    try:
        cell = load_cell(vehicle.battery.cell)
    except VehicleError as error:
        return [Finding("error", "battery.cell", str(error))]
    voltage = float(cell.ocv_v(0.5)) * vehicle.battery.series
    power = vehicle.drive.motor_count * vehicle.drive.power_max_w
    most = voltage * cell.limits.discharge_peak_a * vehicle.battery.parallel
    if most < power:
        return [Finding("warning", "battery", f"gives {most / 1e3:.0f} kW at a state of charge of 0.5, the motors take {power / 1e3:.0f} kW")]
    return []
