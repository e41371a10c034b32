"""The film of a drive: the car from above with its wheels and their forces, a map, speed and power; GIF or MP4.

Long drives run faster than they were: by default the whole of one takes 20 s of film. What stands still is drawn once; a GIF of 240 frames of 720 by
432 pixels takes some five seconds.
"""

from __future__ import annotations

import subprocess
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rc_context
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from PIL import Image

from powertrain.chassis.double_track import DoubleTrack

from ...errors import PlanningError
from ...simulation.log import labelled
from ..picture import save_picture
from ..style import STYLE
from .scene import COLOURS, DPI, Scene

if TYPE_CHECKING:
    from collections.abc import Callable
    from os import PathLike

    from numpy.typing import NDArray

    from powertrain.chassis.wheel import Wheel
    from roads import Road

    from ...simulation import Drive

    Floats = NDArray[np.float64]

KINDS = (".gif", ".mp4")
#: Steps from each colour of a scene to white in the palette of a GIF.
_STEPS = 8


def check_kind(path: str | PathLike[str]) -> None:
    """Refuse what cannot be written.

    Raises:
        PlanningError: a suffix that is no film's, or an MP4 without ffmpeg.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in KINDS:
        raise PlanningError(f"{path}: unknown kind of film {suffix!r}, expected one of {', '.join(KINDS)}")
    if suffix == ".mp4" and not FFMpegWriter.isAvailable():
        raise PlanningError(f"{path}: MP4 needs the program ffmpeg, expected it on the search path; or ask for a .gif")


def animate_drive(
    drive: Drive,
    path: str | PathLike[str],
    *,
    road: Road | None = None,
    fps: int = 12,
    every: float | None = None,
    seconds: float = 20.0,
    report: Callable[[str], None] | None = None,
) -> Path:
    """Write the film of `drive`, whole or not at all.

    Args:
        drive: what was driven.
        path: .gif, or .mp4 where there is ffmpeg.
        road: whose borders are shown.
        fps: frames per second of film; a GIF rounds to hundredths of a second per frame.
        every: seconds of the drive between two frames; by default as fast as the drive was, or so much faster that all of it fits into `seconds`.
        seconds: length of the film at most; what does not fit is left out at the end.
        report: told about progress.

    Raises:
        PlanningError: as `check_kind`; numbers that make no film; a place that cannot be written to; ffmpeg failed.
    """
    path = Path(path)
    check_kind(path)
    rows = frame_rows(drive["t_s"], fps, every, seconds)
    rate = float(np.median(np.diff(drive["t_s"][rows]))) * fps if len(rows) > 1 else 1.0
    with rc_context(STYLE):
        scene = Scene(drive, wheel_forces(drive, rows), rows, rate, road)
        save_picture(lambda staged: _film(scene, staged, fps, report), path, kinds=KINDS)
    return path


def frame_rows(t: Floats, fps: int, every: float | None = None, seconds: float = 20.0) -> NDArray[np.intp]:
    """The rows of the log with times `t` (s) that are shown, one a frame.

    Raises:
        PlanningError: numbers that make no film.
    """
    if not (1 <= fps <= 60 and 0.1 <= seconds <= 600.0 and (every is None or 1e-3 <= every < 1e6)):
        found = f"a film of {seconds} s with {fps} frames/s, one every {every} s"
        raise PlanningError(f"{found}, expected 0.1 to 600 s, 1 to 60 frames/s, 0.001 to 1e6 s")
    most = max(round(fps * seconds), 2)
    step = max(1.0 / fps, float(t[-1] - t[0]) / (most - 1)) if every is None else every
    count = min(int((t[-1] - t[0]) / step * (1.0 + 1e-12)) + 1, most)
    return np.searchsorted(t, t[0] + step * np.arange(count) - 1e-9).clip(0, len(t) - 1)


def wheel_forces(drive: Drive, rows: Any = slice(None)) -> list[Wheel]:
    """The four wheels at some rows of the log, all at once, by the plant's own equations: forces `body_x`, `body_y` and `load` in N, (len(rows),)."""
    track = DoubleTrack(drive.vehicle)
    columns = drive.columns
    states = {name: columns[labelled(name)][rows] for name in track.states}
    surface = {"grade": columns["slope"][rows], "bank": np.tan(columns["bank_rad"][rows]), "friction": columns["friction"][rows]}
    return track.wheels(states, surface)


def _film(scene: Scene, path: Path, fps: int, report: Callable[[str], None] | None) -> None:
    """Frame by frame into `path`."""
    writer: AbstractMovieWriter = _Gif(fps) if path.suffix.lower() == ".gif" else FFMpegWriter(fps=fps, bitrate=1200)
    Canvas(scene)
    try:
        with writer.saving(scene.figure, str(path), DPI):
            for k in range(scene.count):
                scene.show(k)
                writer.grab_frame()
                if report and k % 10 == 0:
                    report(f"film: {k} of {scene.count} frames")
    except (subprocess.CalledProcessError, BrokenPipeError) as error:
        code = getattr(error, "returncode", None)
        raise PlanningError(f"ffmpeg failed{'' if code is None else f' with code {code}'}: no MP4 was written") from None


class Canvas(FigureCanvasAgg):
    """What stands still is drawn once; a picture in the form that writers of films ask for draws only what moves."""

    def __init__(self, scene: Scene) -> None:
        """The canvas of a scene from now on."""
        super().__init__(scene.figure)
        self._moving = scene.moving
        for artist in self._moving:
            artist.set_animated(True)
        self.draw()
        self._still = self.copy_from_bbox(scene.figure.bbox)

    def print_rgba(self, filename_or_obj: Any, **_: Any) -> None:
        """Write the pixels of the next frame into an open file."""
        self.restore_region(self._still)
        for artist in self._moving:
            if artist.axes is not None:
                artist.axes.draw_artist(artist)
        filename_or_obj.write(self.buffer_rgba())


class _Gif(PillowWriter):
    """With one palette for all frames, which differ the less for it: a third of the size."""

    def setup(self, fig: Any, outfile: Any, dpi: float | None = None) -> None:
        """Begin a film."""
        super().setup(fig, outfile, dpi=dpi)
        self._pictures: list[Image.Image] = []
        self._palette = Image.new("P", (1, 1))
        share = np.arange(1, _STEPS + 1)[:, None] / _STEPS
        shades = [255.0 + share * (255.0 * np.array(to_rgb(colour)) - 255.0) for colour in dict.fromkeys(COLOURS)]
        self._palette.putpalette(np.round(np.vstack([np.full((1, 3), 255.0), *shades])).astype(np.uint8).tobytes())

    def grab_frame(self, **_: Any) -> None:
        """Take a frame."""
        pixels = BytesIO()
        self.fig.savefig(pixels, format="rgba", dpi=self.dpi)
        picture = Image.frombuffer("RGBA", self.frame_size, pixels.getvalue(), "raw", "RGBA", 0, 1).convert("RGB")
        self._pictures.append(picture.quantize(palette=self._palette, dither=Image.Dither.NONE))

    def finish(self) -> None:
        """Write the file; nothing where the film broke off before its first frame."""
        if self._pictures:
            first, *rest = self._pictures
            first.save(self.outfile, format="GIF", save_all=True, append_images=rest, duration=round(1000 / self.fps), loop=0)
