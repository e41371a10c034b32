"""The plant comes to rest and stays there."""

import numpy as np
import pytest

from powertrain import load_vehicle, shipped
from powertrain.chassis import DoubleTrack, Machine
from powertrain.chassis.double_track import WHEELS
from powertrain.vehicle import GRAVITY

from .rig import MACHINE, PLANT, ROMO, named, settle


@pytest.mark.parametrize("slope", [0.0, 0.15, -0.15])
def test_a_braked_car_stays_where_it_is(slope: float, figure):
    u = PLANT.command(brake_cmd=400.0, grade=slope)
    clamped = {f"clamp_{wheel}": 400.0 for wheel in WHEELS}
    x = settle(PLANT, MACHINE, PLANT.initial(0.0, **clamped), u, 3.0)
    rest = named(PLANT, settle(PLANT, MACHINE, x, u, 60.0))
    assert np.all(np.isfinite(list(rest.values())))
    figure(f"creep of a braked car in a minute, slope {slope:g}", 1e3 * abs(rest["x"] - named(PLANT, x)["x"]), "{:.4f} mm", asked="1 mm")
    # a millimetre in a minute is what was asked for
    assert abs(rest["x"] - named(PLANT, x)["x"]) < 2e-5
    assert abs(rest["v_x"]) < 1e-7
    # taking up the load, body, tyres and pads give by as much as their stiffness says
    force, body = ROMO.chassis.mass_kg * GRAVITY * slope / np.hypot(1.0, slope), PLANT.body
    pitch = force * body.cog_height_m / (body.pitch_stiffness_nmprad - ROMO.chassis.mass_kg * GRAVITY * body.cog_height_m)
    tyre = force * PLANT.tyres[0].relaxation_longitudinal_m / (4.0 * PLANT.tyres[0].slip_stiffness_n)
    # the sudden load swings to up to twice its size, and the pad keeps what it gave by then
    share, give = force / 4.0 * ROMO.chassis.wheel_radius_m / 400.0, PLANT.brakes.presliding_rad * ROMO.chassis.wheel_radius_m
    pad = -np.log1p(-abs(share)) * give * np.sign(slope), -np.log1p(-2.0 * abs(share)) * give * np.sign(slope)
    low, high = sorted(-(pitch * body.cog_height_m + tyre + part) for part in pad)
    assert low - 1e-5 <= rest["x"] <= high + 1e-5


def test_braking_ends_at_rest_without_rolling_back():
    u = PLANT.command(brake_cmd=300.0)
    x = settle(PLANT, MACHINE, PLANT.initial(6.0), u, 6.0)
    again = settle(PLANT, MACHINE, x, u, 10.0)
    assert abs(named(PLANT, x)["v_x"]) < 1e-6
    assert abs(named(PLANT, again)["x"] - named(PLANT, x)["x"]) < 1e-6


@pytest.mark.parametrize("name", shipped())
def test_a_full_stop_on_clamped_wheels_does_not_throw_the_car_back(name: str):
    """A tyre is stretched by its force over its stiffness, not by the slip of a locked wheel: body and tyres rock back by centimetres."""
    plant = DoubleTrack(load_vehicle(name))
    machine, at = Machine(plant, 1e-3), {state: k for k, state in enumerate(plant.states)}
    brakes = {f"brake_cmd_{wheel}": 1e5 for wheel in WHEELS}
    u, x, far, back = np.array(plant.command(**brakes)), np.array(plant.initial(20.0)), 0.0, 0.0
    for _ in range(8000):
        x = machine.step(x, u)
        far, back = max(far, x[at["x"]]), min(back, x[at["v_x"]])
    assert far - x[at["x"]] < 0.05
    assert back > -0.35
    assert abs(x[at["v_x"]]) < 1e-4
    # commands beyond the brakes clamp what the brakes can
    assert x[at["clamp_fl"]] == pytest.approx(plant.brakes.front_torque_max_nm, rel=1e-6)


def test_a_released_pad_does_not_push_the_car_when_it_is_pressed_on_again():
    clamped = PLANT.command(brake_cmd=300.0)
    x = settle(PLANT, MACHINE, PLANT.initial(3.0), clamped, 3.0)
    x = settle(PLANT, MACHINE, x, PLANT.command(), 2.0)
    before = named(PLANT, x)["x"]
    after = named(PLANT, settle(PLANT, MACHINE, x, clamped, 2.0))["x"]
    assert abs(after - before) < 2e-4
