"""The film of a drive: its forces are the plant's, its frames are evenly spaced, it is there whole or not at all."""

import io
import math
import os
from pathlib import Path

import numpy as np
import pytest
from matplotlib.animation import FFMpegWriter
from PIL import Image

from energy_mgr import PlanningError
from energy_mgr.report.drive.animation import animate_drive, frame_rows, wheel_forces
from energy_mgr.simulation import Drive
from powertrain import Vehicle
from powertrain.chassis.double_track import DoubleTrack
from powertrain.vehicle import GRAVITY

from .rig import bending_drive


@pytest.fixture(scope="module")
def drive(romo: Vehicle) -> Drive:
    return bending_drive(romo)


def test_wheel_forces_are_those_of_the_plant_one_state_at_a_time(drive: Drive):
    track = DoubleTrack(drive.vehicle)
    rows = [0, 100, 700, len(drive["t_s"]) - 1]
    found = wheel_forces(drive, rows)
    # the log has the states first, in the plant's order
    names = list(drive.columns)[1 : 1 + len(track.states)]
    for k, row in enumerate(rows):
        state = [float(drive[name][row]) for name in names]
        inputs = track.command(grade=drive["slope"][row], bank=math.tan(drive["bank_rad"][row]), friction=drive["friction"][row])
        for batch, single in zip(found, track.wheels(*track.named(state, inputs)), strict=True):
            assert batch.body_x[k] == pytest.approx(single.body_x, rel=1e-12, abs=1e-9)
            assert batch.body_y[k] == pytest.approx(single.body_y, rel=1e-12, abs=1e-9)


def test_wheel_forces_move_the_car_as_newton_says(drive: Drive):
    wheels = wheel_forces(drive)
    mass = drive.vehicle.chassis.mass_kg
    settled = drive["t_s"] > 2.0
    across = sum(wheel.body_y for wheel in wheels)[settled] / mass
    assert np.mean(across) == pytest.approx(np.mean(drive["a_y_mps2"][settled]), rel=0.01)
    assert np.mean(across) == pytest.approx(9.0**2 / 40.0, rel=0.03)
    assert sum(np.mean(wheel.load) for wheel in wheels) == pytest.approx(mass * GRAVITY, rel=1e-6)


def test_frames_are_evenly_spaced_and_as_many_as_the_film_is_long():
    t = 0.004 * np.arange(2501)
    assert np.allclose(np.diff(t[frame_rows(t, 10, 0.2)]), 0.2)
    assert np.allclose(np.diff(t[frame_rows(t, 10, seconds=20.0)]), 0.1)
    short = t[frame_rows(t, 10, seconds=2.0)]
    assert len(short) == 20
    assert (short[0], short[-1]) == (t[0], t[-1])
    assert t[frame_rows(t, 10, 1.0, seconds=0.5)].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]


def test_gif_has_its_frames_and_pace_and_they_differ(drive: Drive, tmp_path: Path):
    out = animate_drive(drive, tmp_path / "new" / "drive.gif", fps=10, seconds=1.0)
    with Image.open(out) as film:
        assert film.n_frames == 10
        assert film.info["duration"] == 100
        first = np.asarray(film.convert("RGB")).astype(int)
        film.seek(9)
        last = np.asarray(film.convert("RGB")).astype(int)
    assert first.shape == (432, 720, 3)
    assert 0.001 < np.mean(np.any(first != last, axis=2)) < 0.5
    assert out.stat().st_size < 500_000
    assert [path.name for path in out.parent.iterdir()] == ["drive.gif"]


def test_still_parts_look_as_if_everything_were_drawn_anew(drive: Drive, tmp_path: Path):
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    from energy_mgr.report.drive.animation import Canvas
    from energy_mgr.report.drive.scene import Scene

    rows = np.array([0, 600])
    quick, slow = (Scene(drive, wheel_forces(drive, rows), rows, 1.0, None) for _ in range(2))
    canvas = Canvas(quick)
    for k in (0, 1):  # nothing of the frame before is left
        quick.show(k)
        canvas.print_rgba(io.BytesIO())
    other = FigureCanvasAgg(slow.figure)
    slow.show(1)
    other.draw()
    apart = np.max(np.abs(np.asarray(canvas.buffer_rgba()).astype(int) - np.asarray(other.buffer_rgba()).astype(int)), axis=2)
    # moving things lie above the frames of their panels instead of below: some pixels
    assert np.mean(apart > 40) < 0.002


@pytest.mark.skipif(not FFMpegWriter.isAvailable(), reason="ffmpeg is not here")
def test_mp4_is_a_film(drive: Drive, tmp_path: Path):
    out = animate_drive(drive, tmp_path / "drive.mp4", fps=10, seconds=0.5)
    assert out.read_bytes()[4:8] == b"ftyp"


@pytest.mark.skipif(FFMpegWriter.isAvailable(), reason="ffmpeg is here")
def test_mp4_without_ffmpeg_is_refused(drive: Drive, tmp_path: Path):
    with pytest.raises(PlanningError, match=r"drive\.mp4: MP4 needs the program ffmpeg"):
        animate_drive(drive, tmp_path / "drive.mp4")
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(os.name != "posix", reason="the stand-in is a shell script")
def test_an_ffmpeg_that_fails_is_told_and_leaves_nothing(drive: Drive, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    broken = tmp_path / "bin" / "ffmpeg"
    broken.parent.mkdir()
    broken.write_text("#!/bin/sh\ncat > /dev/null\nexit 7\n")
    broken.chmod(0o755)
    monkeypatch.setenv("PATH", str(broken.parent), prepend=os.pathsep)
    with pytest.raises(PlanningError, match="ffmpeg failed with code 7"):
        animate_drive(drive, tmp_path / "out" / "drive.mp4", fps=4, seconds=0.5)
    assert not list((tmp_path / "out").iterdir())


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("drive.avi", {}, "unknown kind of film '.avi', expected one of .gif, .mp4"),
        ("drive.gif", {"fps": 0}, "with 0 frames/s"),
        ("drive.gif", {"seconds": math.nan}, "a film of nan s"),
        ("drive.gif", {"every": 0.0}, "one every 0.0 s"),
    ],
)
def test_what_makes_no_film_is_refused(name: str, options: dict[str, float], words: str, drive: Drive, tmp_path: Path):
    with pytest.raises(PlanningError, match=words):
        animate_drive(drive, tmp_path / name, **options)  # pyright: ignore[reportArgumentType]
    assert not list(tmp_path.iterdir())


def test_an_interrupt_in_the_middle_leaves_nothing(drive: Drive, tmp_path: Path):
    def stop(message: str) -> None:
        if message.startswith("film: 10"):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        animate_drive(drive, tmp_path / "drive.gif", report=stop)
    assert not list(tmp_path.iterdir())
