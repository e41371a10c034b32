"""Cars in generic position: nothing in them is alike, level or lossless, so that no term of a model vanishes or cancels another.

`FOUR` has a motor and a steering drive in each wheel, `TWO` one motor behind a differential and a rack in front; both have axles that differ in arm,
track, roll share, tyres and brakes, recuperate less than they drive, lose power in their gears, weaken their fields, and have cells side by side.
"""

from msgspec.structs import replace

from powertrain import Vehicle, load_vehicle
from powertrain.description.sections import Thermal, Weakening

_BODY = {"front_axle_m": 1.05, "rear_axle_m": 1.4, "front_track_m": 1.62, "rear_track_m": 1.31, "cog_height_m": 0.57, "roll_front_share": 0.64}
_HOT = Thermal(heat_capacity_jpk=9e3, resistance_kpw=1.5, reference_k=340.0)


def _odd(base: str, weakening: Weakening, drive: dict[str, float], brakes: tuple[float, float], steering: dict[str, float]) -> Vehicle:
    car = load_vehicle(base)
    assert car.body
    assert car.brakes
    assert car.steering
    assert car.battery
    front, rear = car.tyres()
    rear = replace(rear, stiffness_factor=1.3 * front.stiffness_factor, slip_stiffness_n=1.4 * front.slip_stiffness_n, peak_n=1.15 * front.peak_n)
    rear = replace(rear, nominal_load_n=0.8 * front.nominal_load_n, pneumatic_trail_m=0.5 * front.pneumatic_trail_m)
    rear = replace(rear, relaxation_longitudinal_m=0.25, relaxation_lateral_m=0.55)
    return replace(
        car,
        name=f"odd {base}",
        body=replace(car.body, **_BODY),
        drive=replace(car.drive, weakening=weakening, thermal=_HOT, gear_efficiency=0.93, torque_lag_s=0.017, **drive),
        brakes=replace(car.brakes, front_torque_max_nm=brakes[0], rear_torque_max_nm=brakes[1], lag_s=0.07),
        steering=replace(car.steering, caster_trail_m=0.03, scrub_radius_m=0.015, gear_drag_nm=0.02, **steering),
        battery=replace(car.battery, parallel=2),
        limits=replace(car.limits, acceleration_max_mps2=2.4, deceleration_max_mps2=1.7),
        rear_tyre=rear,
    )


FOUR = _odd(
    "romo",
    Weakening(inductance_h=6e-4, current_max_a=90.0, dc_voltage_v=250.0),
    {"gear_ratio": 1.3, "regen_torque_max_nm": 95.0, "regen_power_max_w": 9e3, "rotor_inertia_kgm2": 0.11},
    (690.0, 410.0),
    {"rate_max_radps": 1.2},
)
TWO = _odd(
    "compact",
    Weakening(inductance_h=7e-5, current_max_a=570.0, dc_voltage_v=355.0),
    {"power_max_w": 9e4, "rotor_inertia_kgm2": 0.08},
    (1600.0, 1050.0),
    {},
)
ODD = {"four": FOUR, "two": TWO}
