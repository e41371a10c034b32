"""The sections of a car's description: frozen, range-checked, units in the key names."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

Positive = Annotated[float, msgspec.Meta(gt=0.0, lt=1e9)]
NotNegative = Annotated[float, msgspec.Meta(ge=0.0, lt=1e9)]
Count = Annotated[int, msgspec.Meta(ge=1, le=8)]
Fraction = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]
Efficiency = Annotated[float, msgspec.Meta(gt=0.0, le=1.0)]
Angle = Annotated[float, msgspec.Meta(ge=0.0, le=1.7453292519943295)]
Lever = Annotated[float, msgspec.Meta(ge=-1.0, le=1.0)]
Kelvin = Annotated[float, msgspec.Meta(gt=150.0, lt=1000.0)]
Axles = Literal["front", "rear", "all"]


class Section(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A TOML table; every key is required unless it has a default here."""


class Chassis(Section, frozen=True, kw_only=True):
    """Body and wheels."""

    mass_kg: Positive
    width_m: Positive
    wheel_radius_m: Positive
    wheel_inertia_kgm2: NotNegative
    wheel_count: Count = 4


class Body(Section, frozen=True, kw_only=True):
    """What lateral and vertical dynamics need beyond `Chassis`: a rigid body on two axles that rolls and pitches on its springs.

    Roll and pitch axis lie on the ground; what the suspension's roll centres carry is part of the stiffness.
    """

    front_axle_m: Positive
    rear_axle_m: Positive
    front_track_m: Positive
    rear_track_m: Positive
    cog_height_m: Positive
    yaw_inertia_kgm2: Positive
    roll_inertia_kgm2: Positive
    pitch_inertia_kgm2: Positive
    roll_stiffness_nmprad: Positive
    roll_damping_nmsprad: NotNegative
    roll_front_share: Fraction = 0.5
    pitch_stiffness_nmprad: Positive
    pitch_damping_nmsprad: NotNegative

    @property
    def wheelbase_m(self) -> float:
        """Distance of the axles, m."""
        return self.front_axle_m + self.rear_axle_m

    @property
    def wheel_x(self) -> tuple[float, float, float, float]:
        """How far each wheel (front left, front right, rear left, rear right) is ahead of the centre of gravity, m."""
        return self.front_axle_m, self.front_axle_m, -self.rear_axle_m, -self.rear_axle_m

    @property
    def wheel_y(self) -> tuple[float, float, float, float]:
        """How far each wheel is left of the centre of gravity, m."""
        front, rear = 0.5 * self.front_track_m, 0.5 * self.rear_track_m
        return front, -front, rear, -rear


class Resistance(Section, frozen=True, kw_only=True):
    """Driving resistances (M6): drag area and the rolling resistance polynomial.

    `rolling_0 + rolling_1 (v / 100 km/h) + rolling_4 (v / 100 km/h)^4` is the rolling resistance coefficient.
    """

    drag_coefficient: NotNegative
    frontal_area_m2: NotNegative
    air_density_kgpm3: NotNegative
    rolling_0: NotNegative
    rolling_1: NotNegative = 0.0
    rolling_4: NotNegative = 0.0


class Weakening(Section, frozen=True, kw_only=True):
    """What the voltage limit of a motor depends on: given, the drive weakens its field above base speed."""

    inductance_h: Positive
    current_max_a: Positive
    dc_voltage_v: Positive


class Thermal(Section, frozen=True, kw_only=True):
    """One quasi-stationary thermal node."""

    heat_capacity_jpk: Positive
    resistance_kpw: Positive
    reference_k: Kelvin = 353.15
    copper_per_k: NotNegative = 0.00393
    max_k: Kelvin = 443.15


class Drive(Section, frozen=True, kw_only=True):
    """Equal permanent-magnet motors with their inverters (M1); losses as in (3.39). Values per motor, at the warm resistance.

    `driven` names the driven axles. A motor alone on its axle drives both wheels through a differential, two on an axle drive a wheel each. Left
    out, one motor drives the rear axle, two drive an axle each, four a wheel each.
    """

    motor_count: Literal[1, 2, 4]
    driven: Axles | None = None
    gear_ratio: Positive = 1.0
    gear_efficiency: Efficiency = 1.0
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
    rotor_inertia_kgm2: NotNegative = 0.0
    torque_lag_s: Positive = 0.01
    torque_rate_nmps: Positive = 2000.0
    map: str | None = None
    weakening: Weakening | None = None
    thermal: Thermal | None = None

    def __post_init__(self) -> None:
        """Refuse layouts that do not exist.

        Raises:
            ValueError: one motor for both axles, or four for one.
        """
        if self.motor_count == 1 and self.driven == "all":
            raise ValueError("one motor drives one axle, expected driven = front or rear")
        if self.motor_count == 4 and self.driven in ("front", "rear"):
            raise ValueError("four motors drive all wheels, expected driven = all")

    @property
    def per_wheel(self) -> bool:
        """Whether each driven wheel has a motor of its own."""
        return self.motor_count == 4 or (self.motor_count == 2 and self.driven in ("front", "rear"))

    @property
    def driven_wheels(self) -> tuple[bool, bool, bool, bool]:
        """Which wheels (front left, front right, rear left, rear right) are driven."""
        axles = self.driven or ("rear" if self.motor_count == 1 else "all")
        front, rear = axles != "rear", axles != "front"
        return front, front, rear, rear

    @property
    def motor_of_wheel(self) -> tuple[int | None, ...]:
        """The motor that drives each wheel, None where none does; motors count from the front left."""
        driven = self.driven_wheels
        if self.per_wheel:
            numbers = iter(range(self.motor_count))
            return tuple(next(numbers) if drives else None for drives in driven)
        first_rear = 1 if driven[0] else 0
        return tuple((0 if wheel < 2 else first_rear) if driven[wheel] else None for wheel in range(4))


class Steering(Section, frozen=True, kw_only=True):
    """Steering drives (M2), one per steered wheel: motor, gear and what the tyre's contact asks of them.

    Where wheels do not turn `individual`ly, a rack joins those of an axle: whoever steers the car turns them alike.
    """

    steered: Axles
    individual: bool = False
    angle_max_rad: Angle
    rate_max_radps: Positive
    lag_s: Positive = 0.02
    gear_ratio: Positive
    gear_efficiency: Efficiency
    gear_drag_nm: NotNegative = 0.0
    motor_inertia_kgm2: NotNegative
    wheel_yaw_inertia_kgm2: NotNegative
    caster_trail_m: Lever = 0.0
    scrub_radius_m: Lever = 0.0
    contact_radius_m: NotNegative
    inverter_constant_w: NotNegative = 0.0
    inverter_per_current_wpa: NotNegative = 0.0
    phase_resistance_ohm: Positive
    pole_pairs: Annotated[int, msgspec.Meta(ge=1, le=200)]
    magnet_flux_wb: Positive
    hysteresis_nm: NotNegative
    eddy_nms: NotNegative
    friction_nm: NotNegative

    @property
    def steered_wheels(self) -> tuple[bool, bool, bool, bool]:
        """Which wheels (front left, front right, rear left, rear right) are steered."""
        front, rear = self.steered != "rear", self.steered != "front"
        return front, front, rear, rear


class Brakes(Section, frozen=True, kw_only=True):
    """Friction brakes (M9), by wire; torques are per wheel.

    `presliding_rad` is how far the wheel turns until the full torque holds it, `sliding_time_s` how long that takes at speed.
    """

    front_torque_max_nm: NotNegative
    rear_torque_max_nm: NotNegative
    lag_s: Positive = 0.05
    presliding_rad: Positive = 0.01
    sliding_time_s: Positive = 0.002


class Electrics(Section, frozen=True, kw_only=True):
    """On-board supply: what the auxiliaries take, the DC/DC converter (M7) and the backup battery (M8)."""

    auxiliary_w: NotNegative
    converter_efficiency: Efficiency
    converter_constant_w: NotNegative
    voltage_v: Positive = 13.5
    backup_capacity_ah: NotNegative = 0.0
    backup_resistance_ohm: Positive = 0.01
    backup_heat_capacity_jpk: Positive = 5000.0
    backup_thermal_resistance_kpw: Positive = 2.0


class Battery(Section, frozen=True, kw_only=True):
    """The traction battery: which cell, how many of them, how warm they get."""

    cell: Annotated[str, msgspec.Meta(min_length=1)]
    series: Annotated[int, msgspec.Meta(ge=1, le=1000)]
    parallel: Annotated[int, msgspec.Meta(ge=1, le=1000)] = 1
    thermal_resistance_kpw: Positive = 0.05


class TyreFile(Section, frozen=True, kw_only=True, tag_field="model", tag="mf"):
    """A measured tyre: an MF-Tyre property file (.tir), beside the description or shipped."""

    file: Annotated[str, msgspec.Meta(min_length=1)]


class Limits(Section, frozen=True, kw_only=True):
    """What the car or its passengers allow."""

    speed_max_mps: Positive
    acceleration_max_mps2: Positive
    deceleration_max_mps2: Positive
    lateral_acceleration_max_mps2: Positive
    turning_radius_min_m: Positive | None = None
