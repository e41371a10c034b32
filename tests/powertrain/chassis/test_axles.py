"""What belongs to each axle of the plant: a car whose axles are unlike in everything keeps them apart."""

import msgspec
import pytest

from powertrain import load_vehicle
from powertrain.chassis import DoubleTrack
from powertrain.chassis.double_track import WHEELS

COMPACT = load_vehicle("compact")


def test_roll_shifts_load_by_the_moment_of_each_axle_over_its_own_track():
    """The couple of an axle's loads, their difference over half its track each, is its share of the moment of roll springs and dampers."""
    body = msgspec.structs.replace(DoubleTrack(COMPACT).body, front_track_m=1.7, rear_track_m=1.3, roll_front_share=0.6)
    plant = DoubleTrack(msgspec.structs.replace(COMPACT, body=body))
    s, c = plant.named(plant.initial(15.0, roll=0.02, roll_rate=-0.05), plant.command())
    fl, fr, rl, rr = plant.loads(s, c)
    moment = body.roll_stiffness_nmprad * 0.02 - body.roll_damping_nmsprad * 0.05
    # no wheel lifts, which would cut its load off at zero
    assert min(fl, fr, rl, rr) > 500.0
    assert 0.5 * body.front_track_m * (fr - fl) == pytest.approx(0.6 * moment, rel=1e-9)
    assert 0.5 * body.rear_track_m * (rr - rl) == pytest.approx(0.4 * moment, rel=1e-9)


def test_brakes_of_each_axle_clamp_as_far_as_they_can_and_no_further():
    plant = DoubleTrack(COMPACT)
    front, rear = plant.brakes.front_torque_max_nm, plant.brakes.rear_torque_max_nm
    assert rear < front
    most = dict(zip(WHEELS, (front, front, rear, rear), strict=True))
    x = plant.initial(15.0, **{f"clamp_{wheel}": torque for wheel, torque in most.items()})
    rate = dict(zip(plant.states, plant.derivative(x, plant.command(brake_cmd=1e5)), strict=True))
    for wheel, torque in most.items():
        # asked for more than it can, a brake that is clamped as far as it can stays so
        assert rate[f"clamp_{wheel}"] == pytest.approx(0.0, abs=1e-9 * torque)
