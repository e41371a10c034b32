"""Draws in a process of its own, which loads the drawing library while this one plans: on two cores that hides half a second.

with Painter() as painter:
    made = plan(...)
    save_plan(made, folder, draw=painter.draw)
"""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Self

from ..errors import PlanningError

if TYPE_CHECKING:
    from os import PathLike

    from ..planning import Plan


class Painter:
    """A process that waits for one plan to draw; it ends with the `with` block, or when this process dies."""

    def __enter__(self) -> Self:
        command = [sys.executable, "-m", "energy_mgr.report.painter"]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.communicate()

    def draw(self, plan: Plan, path: str | PathLike[str]) -> None:
        """Draw `plan` into the picture file `path`.

        Raises:
            PlanningError: the process failed; its last words are quoted.
        """
        _, words = self._process.communicate(pickle.dumps((plan, str(Path(path).absolute()))))
        if self._process.returncode != 0:
            last = (words.decode(errors="replace").strip().splitlines() or ["no message"])[-1]
            raise PlanningError(f"{path}: drawing failed: {last}")


def main() -> None:
    """Load the drawing library, then read one plan from standard input and draw it; end quietly where none comes."""
    from .. import planning  # noqa: F401  what a plan is made of, needed to unpack one
    from .figure import draw_plan

    message = sys.stdin.buffer.read()
    if message:
        plan, path = pickle.loads(message)
        draw_plan(plan, path)


if __name__ == "__main__":
    main()
