"""A line without borders, as receivers and phones record it or people draw it, made a road."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime
from typing import TYPE_CHECKING

import numpy as np

from ..conditioning.conditioned import conditioned, with_drive
from ..conditioning.wish import Wish
from ..crossings import crossings_of
from ..errors import RoadError
from ..findings import Finding
from ..road import Road
from .tables.path_table import STANDARD_LANE, TWO_LANES

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..conditioning.recording import Recording

    Floats = NDArray[np.float64]


def road_about(recording: Recording, name: str, *, closed: bool | None, width: float | None, origin: tuple[float, float] | None, wish: Wish) -> Road:
    """A road of `width` (m) about what was recorded: two lanes from 5 m on, one below; one of 3.5 m where no width is given.

    Raises:
        RoadError: a width out of range, or a recording that makes no road.
    """
    findings: tuple[Finding, ...] = ()
    if width is None:
        width = STANDARD_LANE
        words = f"holds a line without borders: one lane of {STANDARD_LANE:g} m is assumed, `width` says otherwise"
        findings = (Finding("note", recording.place, words),)
    if not 0.5 <= width <= 1e3:
        raise RoadError(f"{recording.place}: width {width} m, expected 0.5 to 1000")
    try:
        made = conditioned(recording, wish, closed)
        half = 0.5 * width
        lanes: list[tuple[int, float, float]] = [(1, -half, 0.0), (-1, 0.0, half)] if width >= TWO_LANES else [(1, -half, half)]
        road = Road.from_points(
            name, made.points, -half, half, closed=made.closed, height=made.height, lane_edges=lanes, origin=origin, findings=findings + made.findings
        )
    except RoadError as error:
        raise RoadError(str(error) if str(error).startswith(recording.place) else f"{recording.place}: {error}") from None
    names = recording.names
    crossed = crossings_of(road, lambda point: f"{recording.place}: {names[min(point, len(names) - 1)]}", refuse=False)
    return with_drive(replace(road, findings=road.findings + crossed), made)


def seconds_of(place: str, words: list[tuple[str, str]]) -> Floats:
    """Seconds since 1970 of times as ISO 8601 writes them; `words` holds what to call each and the time.

    Raises:
        RoadError: a word that is no time.
    """
    found = np.empty(len(words))
    for k, (where, word) in enumerate(words):
        try:
            moment = datetime.fromisoformat(word.strip())
        except ValueError:
            raise RoadError(f"{place}: {where}: time is {word[:40]!r}, expected one such as 2026-05-04T07:31:00Z") from None
        found[k] = (moment if moment.tzinfo is not None else moment.replace(tzinfo=UTC)).timestamp()
    return found


def numbered(count: int) -> tuple[str, ...]:
    """What to call the points of a recording."""
    return tuple(f"point {k}" for k in range(count))
