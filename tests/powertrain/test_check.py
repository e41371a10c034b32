from pathlib import Path

import pytest

from powertrain import shipped
from powertrain.check import check
from powertrain.vehicle import SHELF


@pytest.mark.parametrize("name", shipped())
def test_shipped_cars_have_no_findings(name: str):
    assert check(name) == []


CASES = [
    ("mass_kg = 1013.0 ", "mass_kg = -1.0 ", "error", "chassis.mass_kg is -1.0"),
    ("cog_height_m = 0.45", "cog_height_m = 1.45", "warning", "tips over at 0.47 g of lateral acceleration, expected 0.7 g or more"),
    ("roll_stiffness_nmprad = 44400.0", "roll_stiffness_nmprad = 400.0", "error", "expected more than the weight's 4472 Nm/rad"),
    ("front_track_m = 1.35", "front_track_m = 1.95", "error", "a track of 1.95 m is wider than chassis.width_m, 1.7 m"),
    ("rolling_radius_m = 0.27365", "rolling_radius_m = 0.3722", "warning", "rolling radius 0.372 m, chassis.wheel_radius_m is 0.274 m"),
    ('cell = "nmc_40ah"', 'cell = "lead"', "error", "no such file and no shipped cell"),
    ("power_max_w = 16000.0", "power_max_w = 90000.0", "warning", "the motors take 360 kW"),
    ("phase_resistance_ohm = 0.099", "phase_resistance_ohm = 9.9", "warning", "best efficiency"),
    ("auxiliary_w = 200.0", "auxiliary_w = 1e8", "warning", "expected below 5 kW"),
    ("wheel_count = 4", "wheel_count = 8", "error", "needs four wheels with inertia"),
    ("caster_trail_m = 0.02516", "caster_trail_m = nan", "error", "caster_trail_m is nan"),
    ("rolling_0 = 0.009", "rolling_0 = 0.9", "error", "the car cannot start on a level road"),
    ("drag_coefficient = 0.3 ", "drag_coefficient = 30.0 ", "warning", "but the motors reach"),
]


@pytest.mark.parametrize(("old", "new", "severity", "words"), CASES)
def test_implausible_values_are_found(tmp_path: Path, old: str, new: str, severity: str, words: str):
    text = (SHELF / "romo.toml").read_text()
    assert old in text
    file = tmp_path / "car.toml"
    file.write_text(text.replace(old, new, 1))
    findings = check(file)
    assert any(finding.severity == severity and words in f"{finding}" for finding in findings), findings


def test_missing_sections_are_notes(tmp_path: Path):
    text = (SHELF / "romo.toml").read_text()
    start, end = text.index("[body]"), text.index("[tyre]")
    file = tmp_path / "car.toml"
    file.write_text(text[:start] + text[end:])
    assert [str(finding) for finding in check(file)] == ["note    [body]: not given, needed for lateral dynamics"]
