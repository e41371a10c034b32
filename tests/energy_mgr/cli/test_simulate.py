"""`energy-mgr simulate` as a person runs it."""

import json
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import roads
from energy_mgr import Trajectory
from energy_mgr.allocation import ALLOCATORS
from energy_mgr.cli.main import cli, main
from energy_mgr.cli.simulate import _is_plan, simulate_command
from energy_mgr.following import LAWS
from energy_mgr.manager import EnergyManager
from energy_mgr.simulation import SENSORS
from roads import RoadBuilder

from ..report.rig import there_and_stop


@pytest.fixture
def plan(tmp_path: Path) -> Path:
    file = tmp_path / "plan.csv"
    there_and_stop(length=24.0).save(file)
    return file


def test_a_plan_is_driven_told_and_written(plan: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    out = tmp_path / "new" / "out"
    assert main(["simulate", str(plan), "--animate", "gif", "--animate-seconds", "1", "--fps", "8", "--out", str(out)]) == 0
    printed = capsys.readouterr()
    assert "\noutcome        arrived\n" in printed.out
    assert printed.out.rstrip().splitlines()[-1] == "written: " + ", ".join(
        str(out / name) for name in ("log.parquet", "drive.json", "drive.png", "drive.gif")
    )
    assert sorted(file.name for file in out.iterdir()) == ["drive.gif", "drive.json", "drive.png", "log.parquet"]
    assert sorted(file.name for file in tmp_path.iterdir()) == ["new", "plan.csv"]
    assert json.loads((out / "drive.json").read_text())["files"] == ["log.parquet", "drive.json", "drive.png", "drive.gif"]


def test_a_road_is_planned_first_and_the_plans_account_stands_beside(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    road, out = tmp_path / "short.xodr", tmp_path / "out"
    roads.write(RoadBuilder("short").limit(8).straight(20).bend(20, 0.5, 5).straight(20).build(), road)
    assert main(["simulate", str(road), "--corridor", "road", "--time", "14", "--offset", "0.3", "--soc", "0.5", "--out", str(out)]) == 0
    text = capsys.readouterr().out
    found = json.loads((out / "drive.json").read_text())
    assert found["trajectory"]["journey_time_s"] == pytest.approx(14.0, abs=0.05)
    assert found["soc_start"] == pytest.approx(0.5, abs=1e-3)
    assert found["offset_max_m"] == pytest.approx(0.3, abs=0.02)
    assert found["energy_by_component_kwh"]["rolling"]["plan"] > 0.0
    planned = sum(part["plan"] for part in found["energy_by_component_kwh"].values())
    assert planned == pytest.approx(found["planned_energy_kwh"], rel=1e-6)
    assert "The plan is quasi-static: tyre slip" in text


def test_a_drive_that_does_not_arrive_ends_with_code_three_and_its_files(plan: Path, tmp_path: Path):
    done = CliRunner().invoke(cli, ["simulate", str(plan), "--longest", "2", "--out", str(tmp_path / "out")])
    assert done.exit_code == 3
    assert done.stderr.splitlines()[-1].startswith("energy-mgr: late: not there in the time allowed, after 2.0 s at ")
    assert "outcome        late" in done.stdout
    assert sorted(file.name for file in (tmp_path / "out").iterdir()) == ["drive.json", "drive.png", "log.parquet"]
    assert main(["simulate", str(plan), "--longest", "2", "--out", str(tmp_path / "out")]) == 3


def test_a_drive_that_is_over_at_once_is_told_all_the_same(plan: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    out = tmp_path / "out"
    assert main(["simulate", str(plan), "--offset", "12", "--animate", "gif", "--out", str(out)]) == 3
    assert "outcome        lost" in capsys.readouterr().out
    assert sorted(file.name for file in out.iterdir()) == ["drive.gif", "drive.json", "drive.png", "log.parquet"]


def test_faults_of_a_file_happen_and_are_noticed(plan: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    faults = tmp_path / "faults.toml"
    faults.write_text('[[event]]\npart = "motor_2"\nkind = "dead"\ntime_s = 1.0\n')
    more = ["--allocator", "weighted", "--cost", "heuristic", "--follower", "geometric", "--sensors", "real", "--seed", "3"]
    assert main(["simulate", str(plan), "--faults", str(faults), *more, "--out", str(tmp_path / "out")]) == 0
    text = capsys.readouterr().out
    assert "follower geometric, allocator weighted, cost heuristic, sensors real" in text
    assert "\noutcome        arrived\n" in text
    assert "happened       1.00 s: motor_2 dead" in text
    noticed = json.loads((tmp_path / "out" / "drive.json").read_text())["noticed"]
    assert any("motor 2" in row["what"] and 1.0 < row["at_s"] < 2.0 for row in noticed)


def test_what_is_a_plan_and_what_a_road(plan: Path, tmp_path: Path):
    assert _is_plan(str(plan))
    trajectory = Trajectory.load(plan)
    trajectory.save(tmp_path / "plan.parquet")
    assert _is_plan(str(tmp_path / "plan.parquet"))
    from energy_mgr.trajectory.files import write_csv, write_path_table

    write_csv(trajectory, tmp_path / "bare.csv", remarks=False)
    assert _is_plan(str(tmp_path / "bare.csv"))
    # a path table has speeds too, but no times: the shape of a road
    write_path_table(trajectory, tmp_path / "table.csv")
    assert not _is_plan(str(tmp_path / "table.csv"))
    (tmp_path / "track.csv").write_text("# x_m,y_m,w_tr_right_m,w_tr_left_m\n0,0,3,3\n")
    assert not _is_plan(str(tmp_path / "track.csv"))
    assert not _is_plan("commute")
    assert not _is_plan(str(tmp_path / "none.csv"))


REFUSED: list[tuple[list[str], str]] = [
    (["PLAN", "--time", "20"], "--time is for planning a road, but "),
    (["PLAN", "--stop", "20"], "--stop is for planning a road, but "),
    (["PLAN", "--route-cost", "time"], "--route-cost is for planning a road, but "),
    (["PLAN", "--soc", "nan"], "Invalid value for --soc: nan, expected 0 to 1"),
    (["PLAN", "--offset", "inf"], "Invalid value for --offset: inf m"),
    (["PLAN", "--longest", "0"], "Invalid value for --longest: 0.0 s"),
    (["PLAN", "--animate", "gif", "--animate-seconds", "nan"], "Invalid value for --animate-seconds: nan s"),
    (["PLAN", "--allocator", "best"], "'best' is not one of 'efficient'"),
    (["PLAN", "--cost", "time"], "'time' is not one of 'physical'"),
    (["PLAN", "--faults", "none.toml"], "none.toml: no such file"),
    (["PLAN", "--faults", "WRONG"], "event 1: part 'motor_9', expected one of motor_1"),
    (["PLAN", "--vehicle", "beetle"], "no shipped vehicle"),
    (["nowhere"], "no such file and no shipped road"),
    (["BROKEN"], "no column s_m"),
    ([], "Missing argument 'ROAD|PLAN'"),
]


@pytest.mark.parametrize(("arguments", "words"), REFUSED)
def test_what_makes_no_sense_ends_in_one_line_and_leaves_nothing(
    arguments: list[str], words: str, plan: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "wrong.toml").write_text('[[event]]\npart = "motor_9"\nkind = "dead"\ntime_s = 1.0\n')
    (tmp_path / "broken.csv").write_text("t_s,v_mps\n0,0\n1,1\n")
    names = {"PLAN": str(plan), "WRONG": "wrong.toml", "BROKEN": "broken.csv"}
    before = sorted(tmp_path.iterdir())
    assert main(["simulate", *(names.get(word, word) for word in arguments), "--out", "out"]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert words in error
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize("place", ["driving", "drawing"])
def test_ctrl_c_leaves_nothing(place: str, plan: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    calls, step = [0], EnergyManager.step

    def interrupted_step(self: EnergyManager, measurements: Any, t: float) -> Any:
        calls[0] += 1
        if calls[0] == 200:
            signal.raise_signal(signal.SIGINT)
        return step(self, measurements, t)

    def interrupted_drawing(drive: Any, path: Path, **_: Any) -> None:
        path.write_bytes(b"half")
        signal.raise_signal(signal.SIGINT)

    # a test process that runs in the background may have been told to pass over Ctrl-C
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    if place == "driving":
        monkeypatch.setattr(EnergyManager, "step", interrupted_step)
    else:
        monkeypatch.setattr("energy_mgr.report.drive.figure.draw_drive", interrupted_drawing)
    try:
        assert main(["simulate", str(plan), "--out", str(tmp_path / "deep" / "out")]) == 130
    finally:
        signal.signal(signal.SIGINT, before)
    assert "interrupted, nothing written" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["plan.csv"]


def test_choices_are_those_of_the_library():
    choices = {option.name: getattr(option.type, "choices", ()) for option in simulate_command.params}
    assert sorted(choices["allocator"]) == sorted(ALLOCATORS)
    assert sorted(choices["follower"]) == sorted(LAWS)
    assert tuple(choices["sensors"]) == SENSORS


def test_no_option_is_given_twice():
    words = [word for option in simulate_command.params for word in (*option.opts, *option.secondary_opts)]
    assert len(words) == len(np.unique(words))
