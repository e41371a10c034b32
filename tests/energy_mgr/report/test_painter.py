"""The process that draws: the same picture as in this one, clear words where it fails, and it never stays behind."""

import os
import signal
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from energy_mgr import Plan, PlanningError
from energy_mgr.planning import plan
from energy_mgr.report import draw_plan
from energy_mgr.report.plan.figure import PlanFigure
from energy_mgr.report.plan.painter import Painter
from energy_mgr.report.plan.picture import PlanPicture
from roads import RoadBuilder


@pytest.fixture(scope="module")
def made() -> Plan:
    return plan(RoadBuilder("two bends").straight(60).bend(30, 1.0, 10).bend(30, -1.0, 10).straight(60).build())


def test_it_draws_what_this_process_draws(made: Plan, tmp_path: Path):
    with Painter() as painter:
        painter.draw(made, tmp_path / "there.png")()
    draw_plan(made, tmp_path / "here.png")
    assert np.array_equal(imread(tmp_path / "there.png"), imread(tmp_path / "here.png"))


def test_a_figure_made_beforehand_shows_the_same(made: Plan, tmp_path: Path):
    figure = PlanFigure()
    figure.warm()
    figure.show(PlanPicture.of(made))
    figure.save(tmp_path / "warm.png")
    draw_plan(made, tmp_path / "cold.png")
    assert np.array_equal(imread(tmp_path / "warm.png"), imread(tmp_path / "cold.png"))


def test_the_picture_holds_the_drives_and_the_sharpest_bend(made: Plan):
    picture = PlanPicture.of(made)
    for series, run in ((picture.baseline, made.baseline), (picture.plan, made.chosen)):
        # what is drawn over the way: km/h from m/s, kW whose integral over time is the energy of the run
        assert np.max(series.speed) == pytest.approx(3.6 * np.max(run.profile.v))
        interval = np.diff(run.profile.s) / (0.5 * (run.profile.v[:-1] + run.profile.v[1:]))
        assert float(np.sum(series.power[:-1] * interval)) / 3600.0 == pytest.approx(run.energy_kwh, rel=1e-6, abs=1e-9)
    # the bends have 30 m radius: the baseline's square lies where its curvature is near 1/30, and on the plan's path
    assert np.max(np.abs(picture.baseline.curvature)) == pytest.approx(1.0 / 30.0, rel=0.1)
    gap = np.min(np.hypot(*(made.chosen.path.curve.position(np.linspace(0.0, made.chosen.path.curve.length, 5000)) - picture.square).T))
    assert gap < 0.05
    assert len(picture.bend) == 1


def test_a_place_that_cannot_be_written_to_is_told_in_one_line(made: Plan, tmp_path: Path):
    with Painter() as painter, pytest.raises(PlanningError, match=r"missing.*picture\.png: drawing failed: .*No such file") as caught:
        painter.draw(made, tmp_path / "missing" / "picture.png")()
    assert "\n" not in str(caught.value)


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no such signal on this system")
def test_a_process_that_was_killed_is_told_and_nothing_hangs(made: Plan, tmp_path: Path):
    with Painter() as painter:
        os.kill(painter._process.pid, signal.SIGKILL)
        painter._process.wait()
        with pytest.raises(PlanningError, match=r"drawing failed: no message"):
            painter.draw(made, tmp_path / "picture.png")()
    assert not list(tmp_path.iterdir())


def test_without_a_plan_it_ends_with_the_block():
    with Painter() as painter:
        process = painter._process
    assert process.poll() is not None


def test_files_of_the_folder_that_a_user_stands_in_are_not_run(made: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    for name in ("random", "signal", "copy", "logging"):
        (tmp_path / f"{name}.py").write_text("raise RuntimeError('mine')")
    monkeypatch.chdir(tmp_path)
    with Painter() as painter:
        painter.draw(made, tmp_path / "picture.png")()
    assert (tmp_path / "picture.png").stat().st_size > 10_000


def test_a_process_with_much_to_say_does_not_stop(made: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("PYTHONVERBOSE", "1")  # more than a pipe holds
    with Painter() as painter:
        painter.draw(made, tmp_path / "picture.png")()
    assert (tmp_path / "picture.png").exists()
