"""The commands `vehicle` and `battery` as a person runs them."""

from pathlib import Path

import numpy as np
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


def test_vehicle_cycle_tells_energy_charge_and_range(capsys: pytest.CaptureFixture[str]):
    assert main(["vehicle", "cycle", "wltc_3b", "--vehicle", "compact"]) == 0
    text = capsys.readouterr().out
    assert "23.27 km in 30 min" in text
    for word in ("consumption", "  drag", "  auxiliary", "battery", "range"):
        assert f"\n{word}" in text
    assert "90.0 % to 80.9 % of charge" in text
    shares = [float(line.split()[-1]) for line in text.splitlines() if line.startswith("  ") and len(line.split()) in (4, 5) and "kWh" not in line]
    assert sum(shares) == pytest.approx(100.0, abs=0.5)


def test_vehicle_cycle_until_empty_agrees_with_what_one_cycle_promises(capsys: pytest.CaptureFixture[str]):
    ranges = []
    for more in ([], ["--until-empty"]):
        assert main(["vehicle", "cycle", "nedc", "--vehicle", "van", "--soc", "0.5", *more]) == 0
        line = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("range"))
        ranges.append(float(line.split()[1]))
    assert "cycles, then the battery is empty at 5.0 %" in line
    assert ranges[1] == pytest.approx(ranges[0], rel=0.1)


def test_vehicle_cycle_names_what_a_full_and_an_empty_battery_do_not_do(capsys: pytest.CaptureFixture[str]):
    assert main(["vehicle", "cycle", "ece15", "--vehicle", "romo", "--soc", "1"]) == 0
    assert "of recuperation, first after" in capsys.readouterr().out
    assert main(["vehicle", "cycle", "ece15", "--vehicle", "romo", "--soc", "0.05"]) == 0
    assert "for driving, first after 0 s and 0.00 km" in capsys.readouterr().out
    assert main(["vehicle", "cycle", "ece15", "--vehicle", "romo", "--soc", "0.05", "--until-empty"]) == 0
    assert "range          0 km" in capsys.readouterr().out


def test_vehicle_cycle_writes_columns_that_hold_the_energy(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    file, out = tmp_path / "own.csv", tmp_path / "new" / "out.csv"
    file.write_text("t_s,v_mps\n0,0\n10,12\n40,12\n50,0\n")
    assert main(["vehicle", "cycle", str(file), "--vehicle", "compact", "--out", str(out)]) == 0
    table = np.genfromtxt(out, delimiter=",", names=True)
    assert table.dtype.names == ("t_s", "distance_m", "v_mps", "power_w", "current_a", "voltage_v", "soc")
    assert table["distance_m"][-1] == pytest.approx(60.0 + 360.0 + 60.0)
    energy = np.sum(table["power_w"][:-1] * np.diff(table["t_s"])) / 3.6e6
    assert f"{energy:.3f} kWh in all" in capsys.readouterr().out


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_vehicle_cycle_draws_a_picture_whole(tmp_path: Path, suffix: str):
    out = tmp_path / f"cycle.{suffix}"
    assert main(["vehicle", "cycle", "us06", "--vehicle", "romo", "--soc", "1", "--out", str(out)]) == 0
    assert out.read_bytes().startswith(b"\x89PNG" if suffix == "png" else b"<?xml")
    assert [path.name for path in tmp_path.iterdir()] == [out.name]


CYCLE_ERRORS = [
    (["wltc_9", "--vehicle", "compact"], "no such file and no shipped cycle"),
    (["wltc_1", "--vehicle", "beetle"], "no shipped vehicle"),
    (["wltc_1", "--vehicle", "compact", "--soc", "90"], "soc is 90.0, expected 0 to 1"),
    (["wltc_1", "--vehicle", "compact", "--out", "x.txt"], "unknown kind of file '.txt', expected one of .csv"),
    (["wltc_1", "--vehicle", "compact", "--soc", "0.01", "--until-empty", "--out", "x.png"], "nothing to show"),
    (["wltc_1"], "Missing option '--vehicle'"),
]


@pytest.mark.parametrize(("arguments", "words"), CYCLE_ERRORS)
def test_vehicle_cycle_errors_are_one_line(
    arguments: list[str], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    assert main(["vehicle", "cycle", *arguments]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert words in error
    assert not list(tmp_path.iterdir())


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
