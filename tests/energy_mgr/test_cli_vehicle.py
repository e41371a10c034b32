"""The commands `vehicle` and `battery` as a person runs them."""

from pathlib import Path

import pytest

from energy_mgr.cli.main import main
from powertrain import shipped
from tests.conftest import DATA


@pytest.mark.parametrize("name", shipped())
def test_vehicle_info_says_what_a_car_can_do(name: str, capsys: pytest.CaptureFixture[str]):
    assert main(["vehicle", "info", name]) == 0
    text = capsys.readouterr().out
    for word in ("drive", "best point", "top speed", "acceleration", "climbs", "handling", "consumption", "battery", "range"):
        assert f"\n{word}" in text


def test_vehicle_info_of_the_romo_has_its_published_figures(capsys: pytest.CaptureFixture[str]):
    main(["vehicle", "info", "romo"])
    text = capsys.readouterr().out
    assert "4 motors of 160 Nm and 16 kW, one per wheel, all wheels, direct" in text
    assert "continuous     40 Nm" in text
    assert "0 to 80 km/h in 10.6 s" in text


def test_vehicle_check_counts_findings_and_fails_on_errors(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    assert main(["vehicle", "check", "romo"]) == 0
    assert capsys.readouterr().out == "0 errors, 0 warnings, 0 notes\n"
    bad = tmp_path / "bad.toml"
    bad.write_text("name = 'x'\n")
    assert main(["vehicle", "check", str(bad)]) == 1
    assert "error" in capsys.readouterr().out


def test_vehicle_map_writes_a_picture_whole_or_not_at_all(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    out = tmp_path / "map.png"
    assert main(["vehicle", "map", "compact", "--out", str(out)]) == 0
    assert out.read_bytes().startswith(b"\x89PNG")
    assert main(["vehicle", "map", "romo", "--out", str(tmp_path / "map.txt")]) == 2
    assert "unknown kind of picture" in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["map.png"]


def test_unknown_cars_end_in_one_line(capsys: pytest.CaptureFixture[str]):
    assert main(["vehicle", "info", "beetle"]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "no shipped vehicle" in error


def test_battery_fit_names_what_is_missing(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    assert main(["battery", "fit", str(tmp_path / "none.csv"), "-o", str(tmp_path / "cell.toml")]) == 2
    assert "none.csv" in capsys.readouterr().err
    assert not (tmp_path / "cell.toml").exists()


@pytest.mark.skipif(not (DATA / "battery").is_dir(), reason="real cell data are not here")
def test_battery_fit_writes_a_cell_that_loads(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    from powertrain.battery import load_cell

    files = sorted(str(path) for path in (DATA / "battery" / "a123").glob("*P25*"))
    out = tmp_path / "cell.toml"
    assert main(["battery", "fit", *files, "-o", str(out)]) == 0
    assert "mV" in capsys.readouterr().out
    assert 1.9 < load_cell(out).capacity_ah < 2.5
