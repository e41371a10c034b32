from pathlib import Path

import pytest

from powertrain import Vehicle, VehicleError, load_vehicle
from powertrain.vehicle import SHELF


def test_romo_has_the_published_values(romo: Vehicle):
    assert romo.chassis.mass_kg == 1013.0
    assert romo.chassis.wheel_radius_m == pytest.approx((17 * 25.4 / 2 + 0.35 * 165) / 1000, abs=1e-9)
    assert romo.drive.motor_count * romo.drive.torque_max_nm == 640.0
    assert romo.effective_mass == pytest.approx(1013.0 + 4 * 0.65 / 0.27365**2)


CASES = [
    ("mass_kg = 1013.0", "mass_kg = nan", r"chassis\.mass_kg is nan, expected float > 0"),
    ("mass_kg = 1013.0", "mass_kg = -5", r"chassis\.mass_kg is -5, expected float > 0"),
    ("mass_kg = 1013.0", "mass_kg = inf", r"chassis\.mass_kg is inf, expected float < "),
    ("mass_kg = 1013.0", "mass_kg = 'heavy'", r"chassis\.mass_kg is 'heavy', expected float, got str"),
    ("mass_kg = 1013.0", "mass = 1013.0", r"unknown key chassis\.mass, expected in chassis only mass_kg"),
    ("mass_kg = 1013.0", "", r"key chassis\.mass_kg is missing"),
    ("[limits]", "[limit]", "unknown key limit, expected in the file only name, chassis"),
    ("motor_count = 4", "motor_count = 2.5", r"drive\.motor_count is 2\.5, expected int"),
    ("motor_count = 4", "motor_count = ", "not TOML"),
    ("motor_count = 4", "motor_count = 3", r"drive\.motor_count is '3', expected 1 or 2 or 4"),
    ('model = "magic"', 'model = "magics"', r"tyre\.model is 'magics', expected linear or magic or mf"),
    ("shape_factor =", "shap_factor =", r"unknown key tyre\.shap_factor, expected in tyre only nominal_load_n"),
    ('steered = "all"', 'steered = "left"', r"steering\.steered is 'left', expected all or front or rear"),
    ("series = 90", "series = 0", r"battery\.series is 0, expected int >= 1"),
]


@pytest.mark.parametrize(("old", "new", "words"), CASES)
def test_bad_descriptions_are_refused_with_file_and_key(tmp_path: Path, old: str, new: str, words: str):
    file = tmp_path / "car.toml"
    text = (SHELF / "romo.toml").read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))
    with pytest.raises(VehicleError, match=words) as caught:
        load_vehicle(file)
    assert str(caught.value).startswith(str(file))
    assert "\n" not in str(caught.value)


def test_names_and_files_that_do_not_exist_are_refused(tmp_path: Path):
    with pytest.raises(VehicleError, match="expected a TOML file or one of compact, dual_motor, romo, van"):
        load_vehicle("beetle")
    with pytest.raises(VehicleError, match="no such file"):
        load_vehicle(tmp_path / "beetle.toml")


def test_a_vehicle_cannot_be_changed(romo: Vehicle):
    with pytest.raises(AttributeError):
        romo.chassis.mass_kg = 1.0  # pyright: ignore[reportAttributeAccessIssue]


def test_tyre_files_are_found_beside_the_car_and_among_the_shipped_ones(tmp_path: Path):
    from powertrain.tyre import MagicTyre, MfTyre

    text = (SHELF / "romo.toml").read_text()
    start, end = text.index("[tyre]"), text.index("[steering]")
    file = tmp_path / "car.toml"
    file.write_text(text[:start] + '[tyre]\nmodel = "mf"\nfile = "car205_60r15"\n\n[rear_' + text[start + 1 : end] + text[end:])
    front, rear = load_vehicle(file).tyres()
    assert isinstance(front, MfTyre)
    assert isinstance(rear, MagicTyre)
    file.write_text(text[:start] + '[tyre]\nmodel = "mf"\nfile = "none.tir"\n\n' + text[end:])
    with pytest.raises(VehicleError, match=r"none\.tir"):
        load_vehicle(file).tyres()
