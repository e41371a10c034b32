"""Cones of two colours as the edges of a road: columns x, y and a colour (or side, tag, class), in any order of columns and of rows.

Blue cones are left and yellow ones right, as in Formula Student; so are cones called left and right. Of two other words or numbers the order of the
rows tells which is left. Orange cones mark the start and are no edge; a row called `car_start` marks it too.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...errors import RoadError
from .cone_road import road_between
from .cone_strip import Cones
from .path_table import SYNONYMS
from .table import LARGEST, shown

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ...road import Road
    from .table import Rows

    Floats = NDArray[np.float64]

LABELS = ("colour", "color", "tag", "side", "class", "cone", "type", "label", "kind")
LEFT, RIGHT = ("blue", "left", "blau", "links", "b", "l"), ("yellow", "right", "gelb", "rechts", "y", "r")
#: Fewer cones of a colour are no edge; more in all are no cones (triangles among cones on straight lines take time with the square of their number).
FEWEST, MOST = 3, 10_000


class Columns(NamedTuple):
    """Which columns hold x, y and the label, and how many there are."""

    x: int
    y: int
    label: int
    width: int


def columns_of(rows: Rows) -> Columns | None:
    """Which columns are which; None where this is no table of cones: none that is called a colour, and not two numbers and a word in each row."""
    if rows.names:
        stems = [SYNONYMS.get(stem := name.split("[")[0].split("(")[0].strip().split("_")[0], stem) for name in rows.names]
        labels = [k for k, stem in enumerate(stems) if stem in LABELS]
        if not labels or stems.count("x") != 1 or stems.count("y") != 1:
            return None
        return Columns(stems.index("x"), stems.index("y"), labels[0], len(stems))
    words = rows.layout.words(rows.bodies[0])
    texts = [k for k, word in enumerate(words) if np.isnan(_number(rows, word)) and word.replace("_", "").isalpha()]
    if len(words) != 3 or len(texts) != 1:
        return None
    x, y = (k for k in range(3) if k != texts[0])
    return Columns(x, y, texts[0], 3)


def of_rows(rows: Rows, columns: Columns, *, closed: bool | None) -> Road:
    """The road between the cones.

    Raises:
        RoadError: rows that are no cones, not two colours of at least three cones each, or cones that bound no road; with the line.
    """
    if len(rows.bodies) > MOST:
        raise RoadError(f"{rows.path}: holds {len(rows.bodies)} cones, expected at most {MOST}")
    places, words = _read(rows, columns)
    by_word = {word: Cones(word, places[found], found) for word in dict.fromkeys(words) if len(found := np.flatnonzero(np.array(words) == word))}
    starts = [cones for word, cones in by_word.items() if "orange" in word or "start" in word]
    edges = [cones for cones in by_word.values() if cones not in starts]
    if len(edges) != 2:
        found = shown([f"{len(cones.rows)} {cones.name or 'without a word'}" for cones in by_word.values()])
        raise RoadError(f"{rows.path}: holds cones {found}; expected two colours, left and right of the road, and perhaps orange ones at the start")
    for cones in edges:
        if len(cones.rows) < FEWEST:
            at = f"{rows.path}:{rows.lines[int(cones.rows[-1])]}"
            raise RoadError(f"{at}: one of {len(cones.rows)} cones called {cones.name[:40]!r}, expected at least {FEWEST} of each colour")
    left, right, known = _sides(*edges)
    start = np.mean(starts[-1].places if "start" not in starts[0].name else starts[0].places, axis=0) if starts else None
    return road_between(rows, left, right, start=start, orange=sum(len(cones.rows) for cones in starts), known=known, closed=closed)


def _sides(one: Cones, other: Cones) -> tuple[Cones, Cones, bool]:
    """Left and right cones, and whether their names say so."""
    if one.name in LEFT or other.name in RIGHT:
        return one, other, not (one.name in RIGHT or other.name in LEFT)
    if one.name in RIGHT or other.name in LEFT:
        return other, one, True
    return one, other, False


def _read(rows: Rows, columns: Columns) -> tuple[Floats, list[str]]:
    places, labels = np.empty((len(rows.bodies), 2)), []
    for k, (line, body) in enumerate(zip(rows.lines, rows.bodies, strict=True)):
        words = rows.layout.words(body)
        if len(words) != columns.width:
            raise RoadError(f"{rows.path}:{line}: {len(words)} columns, expected {columns.width}")
        for axis, column in enumerate((columns.x, columns.y)):
            places[k, axis] = _number(rows, words[column])
            if not abs(places[k, axis]) < LARGEST:
                raise RoadError(f"{rows.path}:{line}: {'xy'[axis]} is {words[column][:40]!r}, expected a finite number below {LARGEST:g}")
        labels.append(words[columns.label].lower())
    return places, labels


def _number(rows: Rows, word: str) -> float:
    try:
        return float(rows.layout.plain(word)) if word.isascii() and "_" not in word else float("nan")
    except ValueError:
        return float("nan")
