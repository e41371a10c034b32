"""What is told of a drive: table, account, files, figure."""

import json
import math
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from energy_mgr import PlanningError
from energy_mgr.report import draw_drive, drive_table, save_drive
from energy_mgr.report.drive.table import account, event_words, planned_energy, planned_time
from energy_mgr.simulation import Drive, Event
from powertrain import Vehicle, drive_energy
from roads import RoadBuilder

from .rig import bending_drive, stopping_drive


@pytest.fixture(scope="module")
def stopping(romo: Vehicle) -> Drive:
    return stopping_drive(romo)


@pytest.fixture(scope="module")
def bending(romo: Vehicle) -> Drive:
    return bending_drive(romo)


def test_account_adds_up_to_what_the_battery_gave_for_driving(stopping: Drive):
    energy = stopping.ledger.energy
    given = energy["chemical"] - energy["heat"] - energy["polarisation"] - energy["auxiliary"] - energy["converter"]
    rows = {row.name: row for row in account(stopping)}
    assert sum(row.drive for row in rows.values()) == pytest.approx(given, rel=1e-9)
    # what is left is at most what the drives draw in the battery's last, unfinished step of 20 ms: 322 W of inverters, since the car stands
    assert abs(rows["rest"].drive) < 0.02 * 400.0
    # from rest to rest nothing of the motion is left
    assert abs(rows["motion"].drive) < 1e-3 * given
    assert rows["tyre slip"].plan == 0.0
    assert rows["tyre slip"].drive > 0.0


def test_account_of_the_plan_is_the_quasi_static_one(stopping: Drive, romo: Vehicle):
    line = stopping.trajectory
    expected = drive_energy(romo, line.s, line.v, line.z)
    assert sum(row.plan for row in account(stopping)) == pytest.approx(expected.total, rel=1e-12)
    # the trajectory names no power of its own
    assert planned_energy(stopping) == pytest.approx(expected.total, rel=1e-12)


def test_resistances_of_a_slow_straight_drive_are_those_of_the_plan(stopping: Drive):
    rows = {row.name: row for row in account(stopping)}
    assert rows["rolling"].drive == pytest.approx(rows["rolling"].plan, rel=0.02)
    assert rows["drag"].drive == pytest.approx(rows["drag"].plan, rel=0.05)


def test_a_drive_that_ends_early_is_compared_with_the_part_it_drove(romo: Vehicle):
    from energy_mgr.simulation import simulate

    from .rig import there_and_stop

    half = simulate(there_and_stop(), romo, longest=5.0, compiled=False)
    assert half.outcome == "late"
    way = float(half["s_m"][-1])
    assert 10.0 < way < 40.0
    # 2 m/s^2 up to 8 m/s, then 8 m/s; the speeds lie on 31 stations, which cut the corner
    expected = way / 8.0 + 2.0
    assert planned_time(half) == pytest.approx(expected, abs=0.05)
    rows = {row.name: row for row in account(half)}
    assert rows["motion"].plan == pytest.approx(0.5 * romo.effective_mass * 8.0**2, rel=0.01)
    assert "for this part of the way" in drive_table(half)


def test_table_tells_outcome_trouble_and_account(stopping: Drive):
    text = drive_table(stopping)
    assert text.startswith("there and stop: 60 of 60 m, ROMO, follower linearising, allocator efficient")
    assert "\noutcome        arrived\n" in text
    assert "not a number 25" in text
    assert "3.00 s: measurement nan" in text
    assert "friction 0.6" in text
    for name in ("rolling", "drag", "copper", "inverter", "tyre slip", "steering", "motion", "drives"):
        assert f"\n  {name} " in text
    total = next(line for line in text.splitlines() if line.startswith("  drives "))
    assert "\nenergy in Wh " in text
    assert float(total.split()[2]) == pytest.approx(1e3 * stopping.energy_kwh, abs=6e-5)


def test_events_in_words():
    assert event_words(Event(part="motor_2", kind="weak", share=0.4)) == "motor_2 weak (40% left)"
    assert event_words(Event(part="measurement", kind="jump", size=2.0)) == "measurement jump by 2 m"
    assert event_words(Event(part="measurement", kind="late", size=0.3)) == "measurement late by 0.3 s"
    assert event_words(Event(part="friction", kind="value", share=0.25)) == "friction 0.25"


def test_files_hold_what_they_say(stopping: Drive, tmp_path: Path):
    files = save_drive(stopping, tmp_path / "new" / "out")
    assert sorted(file.name for file in (tmp_path / "new" / "out").iterdir()) == ["drive.json", "drive.png", "log.parquet"]
    assert list(tmp_path.iterdir()) == [tmp_path / "new"]
    table = pq.read_table(files[0])
    assert table.column_names == list(stopping.columns)
    assert np.array_equal(table.column("v_x_mps").to_numpy(), stopping["v_x_mps"])
    found = json.loads(files[1].read_text())
    assert found["outcome"] == "arrived"
    assert found["refused"]["not a number"] == 25
    assert found["drive_energy_kwh"] == pytest.approx(stopping.energy_kwh)
    parts = found["energy_by_component_kwh"].values()
    assert sum(part["drive"] for part in parts) == pytest.approx(found["drive_energy_kwh"], abs=1e-12)
    assert found["happened"][0]["part"] == "measurement"
    assert files[2].read_bytes().startswith(b"\x89PNG")


def test_numbers_that_are_none_are_null_in_the_file(stopping: Drive, tmp_path: Path):
    from dataclasses import replace

    columns = {**stopping.columns, "a_ref_mps2": np.full(len(stopping["t_s"]), 9.0)}
    restless = replace(stopping, columns=columns)
    assert math.isnan(restless.torque_jitter)
    assert json.loads(save_drive(restless, tmp_path)[1].read_text())["torque_jitter_nmps"] is None
    assert "no stretch of constant driving" in drive_table(restless)


@pytest.mark.parametrize("blow", [PlanningError("no ink"), KeyboardInterrupt(), OSError(28, "No space left on device")])
def test_what_breaks_while_writing_leaves_the_folder_as_it_was(blow: BaseException, stopping: Drive, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "mine.txt").write_text("keep me")
    (tmp_path / "drive.json").write_text("older")

    def broken(drive: Drive, path: Path, **_: object) -> None:
        path.write_bytes(b"half a picture")
        raise blow

    monkeypatch.setattr("energy_mgr.report.drive.figure.draw_drive", broken)
    expected = PlanningError if isinstance(blow, Exception) else KeyboardInterrupt
    for folder in (tmp_path, tmp_path / "other"):
        with pytest.raises(expected, match="no ink|cannot be written|^$"):
            save_drive(stopping, folder)
    assert {file.name: file.read_text() for file in tmp_path.iterdir()} == {"mine.txt": "keep me", "drive.json": "older"}


def test_places_that_are_taken_are_named_beforehand(tmp_path: Path):
    from energy_mgr.report.drive import files as drive_files

    (tmp_path / "drive.png").mkdir()
    with pytest.raises(PlanningError, match=r"drive\.png: is a folder"):
        drive_files.check_place(tmp_path)
    (tmp_path / "file").write_text("")
    with pytest.raises(PlanningError, match="cannot be written"):
        drive_files.check_place(tmp_path / "file" / "out")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["drive.png", "file"]


@pytest.mark.parametrize(("which", "suffix", "start"), [("stopping", "png", b"\x89PNG"), ("stopping", "pdf", b"%PDF"), ("bending", "svg", b"<?xml")])
def test_figure_is_drawn_in_the_formats_of_papers(which: str, suffix: str, start: bytes, request: pytest.FixtureRequest, tmp_path: Path):
    road = RoadBuilder("road").straight(80).build() if which == "stopping" else None
    draw_drive(request.getfixturevalue(which), tmp_path / f"drive.{suffix}", road=road, dpi=50)
    assert (tmp_path / f"drive.{suffix}").read_bytes().startswith(start)
