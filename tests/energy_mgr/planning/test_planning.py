import csv
import json
import math
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import energy_mgr
from energy_mgr import PlanningError, Trajectory
from energy_mgr.cli.main import main
from energy_mgr.planning import Plan
from energy_mgr.report import comparison_table, draw_plan, save_plan
from roads import RoadBuilder


@pytest.fixture(scope="module")
def small() -> Plan:
    road = RoadBuilder("small").limit(15).straight(60).bend(15, 1.5, 10).straight(60).build(height=lambda s: 0.02 * s)
    return energy_mgr.plan(road, corridor="road")


@pytest.fixture(scope="module")
def ring() -> Plan:
    oval = RoadBuilder("oval").limit(20)
    for _ in range(2):
        oval.straight(60).bend(25, np.pi, 15)
    return energy_mgr.plan(oval.build(closed=True), corridor="road")


def test_plan_arrives_with_the_baseline_and_takes_less(small: Plan):
    assert small.equal_time
    assert small.journey_time == pytest.approx(small.baseline.journey_time, abs=0.1)
    assert small.energy_kwh < small.baseline.energy_kwh
    assert small.saving_percent is not None
    assert small.saving_percent > 0


def test_decomposition_orders_as_it_must(small: Plan):
    compared = small.comparison
    assert compared.path_only is not None
    assert compared.speed_only is not None
    assert compared.both is small.chosen
    # at the baseline's own least time its lane leaves no other speed
    assert compared.speed_only.energy_kwh == pytest.approx(compared.reference.energy_kwh if compared.reference else 0, rel=1e-9)
    assert compared.both.energy_kwh <= compared.path_only.energy_kwh * (1 + 1e-6)


def test_more_time_gives_the_lane_a_choice_of_speed():
    plan = energy_mgr.plan("commute", journey_time=190.0)
    compared = plan.comparison
    assert compared.speed_only is not None
    assert compared.reference is not None
    assert compared.speed_only.energy_kwh < 0.99 * compared.reference.energy_kwh


def test_fast_drives_at_the_least_time_or_at_the_time_asked_for(small: Plan):
    fast = energy_mgr.plan(small.road, corridor="road", speed="fast")
    assert fast.journey_time < small.journey_time
    assert not fast.equal_time
    timed = energy_mgr.plan(small.road, corridor="road", speed="fast", journey_time=60.0)
    assert timed.journey_time == pytest.approx(60.0, abs=1e-3)


def test_time_between_the_two_least_ones_has_no_comparison_and_says_so(small: Plan):
    least = energy_mgr.plan(small.road, corridor="road", speed="fast").journey_time
    plan = energy_mgr.plan(small.road, corridor="road", journey_time=0.5 * (least + small.baseline.journey_time))
    assert plan.comparison.reference is None
    assert not plan.equal_time
    assert "not a comparison at equal time" in comparison_table(plan)


def test_lane_plan_follows_the_lane(small: Plan):
    plan = energy_mgr.plan(small.road, path="lane", corridor="lane")
    assert plan.chosen.path.report.status == "lane centre"
    assert plan.chosen.path.report.cost == plan.chosen.path.report.cost_centre


@pytest.mark.parametrize("which", ["small", "ring"])
def test_trajectory_is_consistent_in_itself(which: str, request: pytest.FixtureRequest):
    lam: Trajectory = request.getfixturevalue(which).trajectory
    ds = np.diff(lam.s)
    # v dv/ds = a and ds/dt = mean speed on every interval; positions and headings belong together
    assert np.allclose(np.diff(lam.v**2) / (2 * ds), lam.a[:-1], atol=1e-9)
    assert np.allclose(np.diff(lam.t) * 0.5 * (lam.v[1:] + lam.v[:-1]), ds, rtol=1e-9)
    assert np.all(np.hypot(np.diff(lam.x), np.diff(lam.y)) <= ds + 1e-9)
    assert np.allclose(np.diff(lam.psi), ds * 0.5 * (lam.kappa[1:] + lam.kappa[:-1]), atol=5e-3)
    assert np.max(np.abs(np.diff(lam.psi))) < 0.5
    with pytest.raises(ValueError, match="read-only"):
        lam.v[0] = 0.0


def test_energy_in_the_trajectory_is_that_of_the_plan(small: Plan):
    lam = small.trajectory
    assert np.sum(lam.power[:-1] * np.diff(lam.t)) / 3.6e6 == pytest.approx(small.energy_kwh, rel=1e-9)


def test_files_hold_what_the_issue_lists(small: Plan, tmp_path: Path):
    files = save_plan(small, tmp_path / "new" / "out")
    assert sorted(file.name for file in (tmp_path / "new" / "out").iterdir()) == ["plan.json", "plan.png", "trajectory.csv"]
    assert [file.name for file in files] == ["trajectory.csv", "plan.json", "plan.png"]
    with files[0].open() as file:
        rows = list(csv.reader(file))
    assert ",".join(rows[0]) == "s_m,x_m,y_m,z_m,psi_rad,kappa_1pm,v_mps,a_mps2,t_s,power_w,jerk_mps3,slope,bank_rad"
    assert len(rows) == 1 + len(small.trajectory.s)
    assert np.allclose(np.array(rows[1:], dtype=float), small.trajectory.table(), rtol=1e-7, atol=1e-6)
    found = json.loads(files[1].read_text())
    assert set(found["road"]) == {"name", "length_m", "closed"}
    assert set(found["baseline"]) == {"journey_time_s", "energy_kwh"}
    assert {"path_only_percent", "speed_only_percent", "both_percent"} <= set(found["decomposition"])
    assert {"cost_centre", "cost", "iterations", "solve_ms", "max_violation_m", "status"} <= set(found["path"])
    assert {"solve_ms", "status", "iterations"} <= set(found["speed"])
    assert {"rolling", "drag", "slope", "copper", "iron", "inverter", "friction"} <= set(found["energy_by_component_kwh"])
    assert sum(found["energy_by_component_kwh"].values()) == pytest.approx(found["energy_kwh"], abs=1e-9)
    assert found["vehicle"] == "ROMO"
    assert files[2].read_bytes().startswith(b"\x89PNG")


def test_a_failure_while_writing_leaves_the_folder_as_it_was(small: Plan, tmp_path: Path):
    (tmp_path / "mine.txt").write_text("keep me")
    save_plan(small, tmp_path)
    before = {file.name: file.read_bytes() for file in tmp_path.iterdir()}

    def broken(plan: Plan, path: Path) -> None:
        path.write_bytes(b"half a picture")
        raise PlanningError("no ink")

    for folder in (tmp_path, tmp_path / "other"):
        with pytest.raises(PlanningError, match="no ink"):
            save_plan(small, folder, draw=broken)
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == before


def test_a_folder_in_the_place_of_a_file_is_refused_before_anything_is_written(small: Plan, tmp_path: Path):
    (tmp_path / "plan.png").mkdir()
    with pytest.raises(PlanningError, match=r"plan\.png: is a folder"):
        save_plan(small, tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == ["plan.png"]


def test_folder_that_cannot_be_made_is_refused(small: Plan, tmp_path: Path):
    (tmp_path / "file").write_text("")
    with pytest.raises(PlanningError, match="cannot be written"):
        save_plan(small, tmp_path / "file" / "out")


@pytest.mark.parametrize("which", ["small", "ring"])
def test_figure_is_drawn_in_the_formats_of_papers(which: str, request: pytest.FixtureRequest, tmp_path: Path):
    for suffix, start in (("png", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml")):
        draw_plan(request.getfixturevalue(which), tmp_path / f"plan.{suffix}")
        assert (tmp_path / f"plan.{suffix}").read_bytes().startswith(start)


def test_road_that_gives_energy_back_has_no_percentage():
    plan = energy_mgr.plan("descent", corridor="road")
    assert plan.baseline.energy_kwh < 0
    assert plan.saving_percent is None
    assert plan.energy_kwh < plan.baseline.energy_kwh
    assert "percentages would mean nothing" in comparison_table(plan)


@pytest.mark.parametrize("options", [{"margin": -1.0}, {"margin": math.nan}, {"journey_time": 0.0}, {"journey_time": math.nan}])
def test_arguments_out_of_range_are_refused(options: dict[str, float]):
    with pytest.raises(PlanningError, match="expected"):
        energy_mgr.plan("commute", **options)  # pyright: ignore[reportArgumentType]


# -- command line --------------------------------------------------------------------------------------------------------------------


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-m", "energy_mgr.cli.main", *arguments], capture_output=True, text=True, timeout=120)


def test_command_plans_and_writes(tmp_path: Path):
    done = run("plan", "commute", "--corridor", "road", "--out", str(tmp_path / "out"))
    assert done.returncode == 0, done.stderr
    assert "path and speed" in done.stdout
    assert sorted(file.name for file in (tmp_path / "out").iterdir()) == ["plan.json", "plan.png", "trajectory.csv"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nowhere"], "no such file and no shipped road"),
        (["commute", "--time", "50"], "least possible time is"),
        (["commute", "--time", "soon"], "'soon' is not a valid float"),
        (["commute", "--vehicle", "beetle"], "one of compact, dual_motor, romo, van"),
        (["commute", "--corridor", "field"], "is not one of"),
        (["commute", "--margin", "3"], "narrower than the car with its margins at s ="),
        ([], "Missing argument 'ROAD'"),
    ],
)
def test_bad_requests_end_in_one_line_and_code_two(arguments: list[str], words: str, tmp_path: Path):
    done = run("plan", *arguments, "--out", str(tmp_path / "out"))
    assert done.returncode == 2
    assert done.stdout == ""
    assert len(done.stderr.splitlines()) == 1
    assert words in done.stderr
    assert not any(tmp_path.iterdir())


def test_a_place_that_cannot_be_written_to_is_told_before_planning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    def planned(*_: object, **__: object) -> None:
        raise AssertionError("planned in vain")

    monkeypatch.setattr("energy_mgr.planning.plan", planned)
    (tmp_path / "file").write_text("")
    assert main(["plan", "commute", "--out", str(tmp_path / "file" / "out")]) == 2
    assert "cannot be written" in capsys.readouterr().err
    (tmp_path / "out" / "plan.png").mkdir(parents=True)
    assert main(["plan", "commute", "--out", str(tmp_path / "out")]) == 2
    assert "plan.png: is a folder" in capsys.readouterr().err


@pytest.mark.parametrize("share", [0.3, 0.6, 0.9, 0.97])
def test_a_kill_half_way_leaves_all_files_or_none(share: float, tmp_path: Path):
    command = [sys.executable, "-m", "energy_mgr.cli.main", "plan", "rural", "--out"]
    begun = time.monotonic()
    subprocess.run([*command, str(tmp_path / "whole")], check=True, capture_output=True)
    # when it is killed is left to the machine: whatever it was doing, what a user finds is whole
    process = subprocess.Popen([*command, str(tmp_path / "out")], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(share * (time.monotonic() - begun))
    process.kill()
    process.wait()
    if (tmp_path / "out").exists():
        for file in (tmp_path / "whole").iterdir():
            assert (tmp_path / "out" / file.name).stat().st_size > 0.9 * file.stat().st_size
    # only what is hidden may be left of an unfinished one
    assert {path.name for path in tmp_path.iterdir() if not path.name.startswith(".plan-")} <= {"whole", "out"}


def test_help_loads_nothing_but_the_command_line():
    code = """
import sys
before = set(sys.modules)
from energy_mgr.cli.main import main
main(["--help"])
loaded = {name.partition(".")[0] for name in set(sys.modules) - before}
print(sorted(loaded - set(sys.stdlib_module_names)))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "['click', 'energy_mgr', 'lazy_loader']"


def test_no_arguments_shows_help_and_version_is_known(capsys: pytest.CaptureFixture[str]):
    assert main([]) == 2
    assert "Usage" in capsys.readouterr().err
    assert main(["--version"]) == 0
    assert "energy-mgr" in capsys.readouterr().out
