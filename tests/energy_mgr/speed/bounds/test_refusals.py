"""The words in which roads that cannot be driven are refused: which limit, where, by how much."""

import re

import numpy as np
import pytest

from energy_mgr import InfeasibleError
from energy_mgr.speed import FrictionBrakes, Grip, Stop, fastest_profile
from energy_mgr.speed.fastest.forward_backward import scaled_profile
from powertrain import driving_resistance
from powertrain.vehicle import GRAVITY

from ..rig import ROMO, changed, limits_of


def number(pattern: str, words: str) -> float:
    found = re.search(pattern, words)
    assert found, words
    return float(found.group(1))


@pytest.mark.parametrize(
    ("part", "limit", "gives"),
    [
        (None, "motor torque", 4 * 160 / 0.27365),
        (Grip(0.2), "grip", 0.2 * ROMO.chassis.mass_kg * GRAVITY),
    ],
)
def test_a_climb_names_the_weakest_limit_and_the_missing_force(part, limit: str, gives: float):
    with pytest.raises(InfeasibleError, match=f"{re.escape(ROMO.name)} cannot climb the slope of 35.0 %") as found:
        fastest_profile(limits_of(extra=[Stop(100.0), *([part] if part else [])], height=lambda s: 0.35 * np.clip(s - 100, 0, 60)))
    words = str(found.value)
    assert "\n" not in words
    # from rest at the foot of the ramp: no momentum helps
    assert number(r"at s = ([\d.]+) m", words) == 100.0
    needs = float(driving_resistance(ROMO, 0.0, 0.35))
    assert number(r"needs ([\d.]+) N", words) == pytest.approx(needs, abs=1.0)
    assert limit in words
    # the ellipse is rounded by less than 1 % here
    assert number(rf"{limit} gives ([\d.]+) N", words) == pytest.approx(gives, rel=1e-2)
    assert number(r"([\d.]+) N are missing", words) == pytest.approx(needs - gives, rel=1e-2)


def test_a_descent_that_cannot_be_held_names_the_missing_force():
    with pytest.raises(InfeasibleError, match="cannot hold back on the slope of -35.0 %") as found:
        fastest_profile(limits_of(extra=[Stop(110.0)], height=lambda s: -0.35 * np.clip(s - 50, 0, 60)))
    needs, gives = -float(driving_resistance(ROMO, 0.0, -0.35)), 4 * 160 / 0.27365
    assert number(r"needs ([\d.]+) N", str(found.value)) == pytest.approx(needs, abs=1.0)
    assert number(r"([\d.]+) N are missing", str(found.value)) == pytest.approx(needs - gives, abs=2.0)


def test_friction_brakes_hold_where_recuperation_does_not():
    steep = {"height": lambda s: -0.35 * np.clip(s - 50, 0, 60)}
    profile = fastest_profile(limits_of(extra=[Stop(110.0), FrictionBrakes(4000.0)], **steep))
    assert profile.brake is not None
    assert np.max(profile.brake) > 0.0
    assert np.all(profile.brake <= 4000.0 * (1 + 1e-9))


@pytest.mark.parametrize(("speed", "posted"), [(15.0, 20.0), (18.0, 25.0)])
def test_a_start_too_fast_for_the_stop_ahead_names_both_and_by_how_much(speed: float, posted: float):
    with pytest.raises(InfeasibleError, match=f"start speed {speed:.3f} m/s at s = 0.0 m is .* m/s too fast") as found:
        fastest_profile(limits_of(extra=[Stop(25.0)], start_speed=speed, posted=posted))
    words = str(found.value)
    # 2 m/s^2 over 25 m: 10 m/s
    assert number(r"is ([\d.]+) m/s too fast", words) == pytest.approx(speed - 10.0, abs=1e-3)
    assert number(r"only ([\d.]+) m/s", words) == pytest.approx(10.0, abs=1e-3)
    assert "limit `stop` at s = 25.0 m" in words


def test_an_end_that_cannot_be_reached_names_what_is_before_it():
    with pytest.raises(InfeasibleError, match="end speed 15.000 m/s at s = 200.0 m is 5.000 m/s too fast") as found:
        fastest_profile(limits_of(extra=[Stop(175.0)], end_speed=15.0))
    assert "acceleration" in str(found.value)
    assert "limit `stop` at s = 175.0 m" in str(found.value)


def test_an_end_speed_beyond_the_power_of_the_car_is_refused():
    weak = changed(ROMO, drive={"power_max_w": 1500.0})
    with pytest.raises(InfeasibleError, match="end speed 19.000 m/s at s = 400.0 m is .* m/s too fast"):
        fastest_profile(limits_of(weak, length=400.0, end_speed=19.0, height=lambda s: 0.04 * s))


def test_a_scaled_profile_says_by_how_much_the_time_is_too_short():
    limits = limits_of()
    least = fastest_profile(limits).journey_time
    with pytest.raises(InfeasibleError, match=rf"the least possible time is {np.ceil(100 * least) / 100:.2f} s, ") as found:
        scaled_profile(limits, least - 5.0)
    assert number(r", ([\d.]+) s more", str(found.value)) == pytest.approx(5.0, abs=0.02)
