"""A picture file appears whole or not at all."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import PlanningError

if TYPE_CHECKING:
    from collections.abc import Callable

PICTURES = (".png", ".svg", ".pdf")
TABLE = ".csv"


def save_picture(draw: Callable[[Path], None], out: Path, *, kinds: tuple[str, ...] = PICTURES) -> None:
    """Let `draw` write the file `out`, a picture unless `kinds` of suffixes say otherwise, under another name first.

    Raises:
        PlanningError: a suffix that is no picture's, or a place that cannot be written to.
    """
    if out.suffix.lower() not in kinds:
        raise PlanningError(f"{out}: unknown kind of picture {out.suffix!r}, expected one of {', '.join(PICTURES)}")
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=out.parent, prefix=".figure-") as folder:
            staged = Path(folder) / f"picture{out.suffix.lower()}"
            draw(staged)
            staged.replace(out)
    except OSError as error:
        raise PlanningError(f"{out}: cannot be written: {error.strerror}") from None
