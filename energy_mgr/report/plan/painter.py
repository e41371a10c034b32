"""Draws in a process of its own, which loads the drawing library and prepares the figure while this one plans: on two cores that hides a second.

with Painter() as painter:
    made = plan(...)
    save_plan(made, folder, draw=painter.draw)
"""

from __future__ import annotations

import gc
import os
import pickle
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Self

from ...errors import PlanningError

if TYPE_CHECKING:
    from collections.abc import Callable
    from os import PathLike

    from ...planning import Plan


class Painter:
    """A process that waits for one plan to draw; it ends with the `with` block, or when this process dies."""

    def __enter__(self) -> Self:
        # modules are looked for where this process does, not in the folder that a user stands in, whose random.py is not Python's
        code = f"import sys; sys.path[:] = {sys.path!r}; from energy_mgr.report.plan.painter import main; main()"
        self._words = tempfile.TemporaryFile()  # a pipe that nobody reads would stop a process with much to say
        command = [sys.executable, "-P", "-c", code]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=self._words)
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait()
        if self._process.stdin is not None:
            self._process.stdin.close()
        self._words.close()

    def draw(self, plan: Plan, path: str | PathLike[str]) -> Callable[[], None]:
        """Begin to draw `plan` into the picture file `path`.

        Returns:
            Call it to wait until the file is there. It raises PlanningError where the process failed; its last words are quoted.
        """
        from .picture import PlanPicture

        assert self._process.stdin is not None
        try:
            self._process.stdin.write(pickle.dumps((PlanPicture.of(plan), str(Path(path).absolute()))))
            self._process.stdin.close()
        except OSError:
            pass  # it is gone; `wait` tells why
        return lambda: self._wait(path)

    def _wait(self, path: str | PathLike[str]) -> None:
        if self._process.wait() != 0:
            self._words.seek(0)
            words = self._words.read()
            last = (words.decode(errors="replace").strip().splitlines() or ["no message"])[-1]
            raise PlanningError(f"{path}: drawing failed: {last}")


def main() -> None:
    """Prepare a figure, then read one picture from standard input and draw it; end quietly where none comes."""
    gc.disable()  # one figure and out: nothing is worth collecting
    from .figure import PlanFigure

    figure = PlanFigure()
    figure.warm()
    message = sys.stdin.buffer.read()
    if message:
        picture, path = pickle.loads(message)
        figure.show(picture)
        figure.save(path)
    sys.stderr.flush()
    os._exit(0)  # the file is written; taking down the interpreter takes longer than drawing a panel
