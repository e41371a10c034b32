"""`energy-mgr score`, and plans of recorded drives, as a person sees them."""

import json
from pathlib import Path

import pytest

from energy_mgr.cli.main import main
from roads import open_road

from ...roads.conditioning.drives import Receiver, gpx, recorded


@pytest.fixture
def drive(tmp_path: Path) -> Path:
    return gpx(recorded(open_road("rural"), Receiver(1.0, 0.5), 0, (1200.0, 20.0)), tmp_path / "drive.gpx")


def test_score_tells_what_was_and_what_could_have_been(capsys: pytest.CaptureFixture[str], drive: Path, tmp_path: Path):
    assert main(["score", str(drive), "--out", str(tmp_path / "score.json")]) == 0
    said = capsys.readouterr().out
    assert "as recorded" in said
    assert "A plan would save" in said
    assert "in the same time, with the same stops" in said
    told = json.loads((tmp_path / "score.json").read_text())
    assert told["saving_kwh"] == pytest.approx(told["energy_kwh"] - told["plan"]["energy_kwh"])
    assert told["energy_kwh"] == pytest.approx(sum(told["energy_by_component_kwh"].values()))
    assert told["plan"]["duration_s"] == pytest.approx(told["duration_s"], abs=0.05)
    assert told["saving_percent"] > 0.0
    assert any("recorded drive of" in finding for finding in told["findings"])


def test_plan_has_a_row_as_recorded(capsys: pytest.CaptureFixture[str], drive: Path, tmp_path: Path):
    assert main(["plan", str(drive), "--out", str(tmp_path / "plan")]) == 0
    said = capsys.readouterr().out
    (row,) = [line for line in said.splitlines() if line.startswith("  as recorded")]
    (own,) = [line for line in said.splitlines() if line.startswith("> ")]
    assert row.split()[2] == own.split()[4]
    told = json.loads((tmp_path / "plan" / "plan.json").read_text())
    assert told["as_recorded"]["journey_time_s"] == pytest.approx(told["journey_time_s"], abs=0.01)
    assert told["as_recorded"]["energy_kwh"] > told["energy_kwh"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["commute"], "records neither times nor speeds"),
        (["commute", "--raw"], "leave width, lane, raw, accuracy and leg out"),
        (["FILE", "--accuracy", "3,1,2"], "expected one distance in m, or two"),
        (["FILE", "--accuracy", "-1"], "accuracy in the plane -1.0 m"),
        (["FILE", "--leg", "4"], "leg 4 of a drive that has 1"),
    ],
)
def test_what_cannot_be_scored_is_one_line(capsys: pytest.CaptureFixture[str], drive: Path, arguments: list[str], message: str):
    assert main(["score", *(str(drive) if word == "FILE" else word for word in arguments)]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
