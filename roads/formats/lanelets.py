"""What CommonRoad, Lanelet2 and SUMO files have in common: lanes as pairs of polylines with neighbours and successors."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ..borders import way_along
from ..errors import RoadError
from ..networks.links import Link
from ..networks.network import Network

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from ..findings import Findings

    Floats = NDArray[np.float64]

#: Vertices closer than this are one, m.
SAME = 1e-3
#: No single lane is longer, m.
LONGEST = 1e6
#: Pieces at the ends of a lane, whose neighbours are other lanes', count as short ones from this length on, m.
ALONE = 5.0


class TooShortError(RoadError):
    """A lane without any length."""


@dataclass(eq=False)
class Lanelet:
    """One lane between two places: borders in its direction of travel.

    Attributes:
        id: unique.
        left: (n, 3) left border, m.
        right: (m, 3) right border, m; where n = m vertices lie beside each other.
        place: file and line.
        successors: ids.
        beside_left: (id, True if it leads the same way) of the neighbour to the left.
        beside_right: as `beside_left`.
        limit: m/s, inf where none is posted.
        kind: what it is for.
    """

    id: str
    left: Floats
    right: Floats
    place: str
    successors: list[str] = field(default_factory=list)
    beside_left: tuple[str, bool] | None = None
    beside_right: tuple[str, bool] | None = None
    limit: float = np.inf
    kind: str = "driving"


def network_of(
    path: Path, format_name: str, lanelets: dict[str, Lanelet], findings: Findings, *, left_hand: bool = False, name: str = "", geographic: str = ""
) -> Network:
    """The network of `lanelets`; those without sound borders become errors among `findings` and are left out.

    Raises:
        RoadError: no usable lanelet.
    """
    shapes: dict[str, tuple[Floats, Floats]] = {}
    crossed: set[str] = set()
    for lanelet in lanelets.values():
        try:
            shapes[lanelet.id] = paired(lanelet, findings)
        except TooShortError as error:
            crossed.add(lanelet.id)
            findings.warn(lanelet.place, f"{str(error).removeprefix(lanelet.place + ': ')}; it is skipped, lanes are linked across it")
        except RoadError as error:
            findings.error(error)
    if not shapes:
        errors = findings.errors()
        raise RoadError(f"{errors[0].place}: {errors[0].message}" if errors else f"{path}: holds no lane to drive on, expected at least one")
    links: dict[str, Link] = {}
    for identity, shape in shapes.items():
        lanelet = lanelets[identity]
        link = Link(identity, identity, lanelet.kind, partial(_given, shape), limits=((0.0, lanelet.limit),), left_hand=left_hand)
        unknown = [other for other in lanelet.successors if other not in lanelets]
        if unknown:
            findings.warn(lanelet.place, f"lane {identity} leads on to {', '.join(unknown[:5])}, which the file does not hold")
        link.successors = [other for other in _onward(lanelet, lanelets, crossed) if other in shapes]
        links[identity] = link
    for identity, link in links.items():
        _set_beside(link, identity, lanelets, shapes)
    lengths = {identity: link.length for identity, link in links.items()}
    return Network(name or path.stem, str(path), format_name, links, lengths, findings.all(), None, geographic)


def _onward(lanelet: Lanelet, lanelets: dict[str, Lanelet], crossed: set[str]) -> list[str]:
    """Successors, those of the lanes in `crossed` instead of these."""
    found: dict[str, None] = {}
    seen: set[str] = set()
    waiting = lanelet.successors[::-1]
    while waiting:
        other = waiting.pop()
        if other not in crossed:
            found[other] = None
        elif other not in seen:
            seen.add(other)
            waiting += lanelets[other].successors[::-1]
    return list(found)


def _given(shape: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    return shape


def _set_beside(link: Link, identity: str, lanelets: dict[str, Lanelet], shapes: dict[str, tuple[Floats, Floats]]) -> None:
    """Walk to both sides; beyond a lane that leads the other way left and right change places."""
    sides: list[list[tuple[str, bool]]] = []
    for to_left in (False, True):
        found: list[tuple[str, bool]] = []
        seen = {identity}
        here, same = identity, True
        while True:
            lanelet = lanelets[here]
            beside = lanelet.beside_left if to_left == same else lanelet.beside_right
            if beside is None or beside[0] in seen or beside[0] not in shapes:
                break
            here, same = beside[0], same == beside[1]
            seen.add(here)
            found.append((here, not same))
        sides.append(found)
    row = [*sides[0][::-1], (identity, False), *sides[1]]
    link.beside = tuple(other for other, _ in row)
    link.against = tuple(against for _, against in row)
    link.right = sides[0][0][0] if sides[0] and not sides[0][0][1] else None
    link.left = sides[1][0][0] if sides[1] and not sides[1][0][1] else None


def paired(lanelet: Lanelet, findings: Findings) -> tuple[Floats, Floats]:
    """Borders with vertices beside each other: as given where their numbers agree, else at all vertices of both by their share of the length.

    Heights that are missing (NaN) are led over from those that are there.

    Raises:
        RoadError: fewer than two places, a border that stands still, or borders that do not lie apart.
    """
    left, right = lanelet.left, lanelet.right
    if np.isnan(left).any() or np.isnan(right).any():
        findings.note(
            lanelet.place, "lanes with points without a height among others with one: heights are led over along the lane, 0 where it has none"
        )
        left, right = _with_heights(left, right)
    if len(left) < 2 or len(right) < 2:
        raise RoadError(f"{lanelet.place}: lane {lanelet.id} has borders of {len(left)} and {len(right)} points, expected at least 2")
    left, right = _once(left, right)
    if len(left) != len(right):
        shares = [_shares(lanelet, border) for border in (left, right)]
        both = np.union1d(*shares)
        left, right = (
            np.column_stack([np.interp(both, share, border[:, axis]) for axis in range(3)])
            for share, border in zip(shares, (left, right), strict=True)
        )
    centre = 0.5 * (left + right)
    steps = np.hypot(*np.diff(centre[:, :2], axis=0).T)
    keep = np.append(True, steps > SAME)
    if np.count_nonzero(keep) < 2:
        raise TooShortError(f"{lanelet.place}: lane {lanelet.id} is {float(np.sum(steps)):.4f} m long, expected more")
    if float(np.sum(steps)) > LONGEST:
        raise RoadError(f"{lanelet.place}: lane {lanelet.id} is {float(np.sum(steps)):.3g} m long, expected at most {LONGEST:g} m")
    left, right, centre = left[keep], right[keep], centre[keep]
    # left must be to the left of the way; a lanelet drawn the wrong way round would be driven on the wrong side
    way = np.gradient(centre[:, :2], axis=0)
    across = (left - right)[:, :2]
    area = np.sum(way[:, 0] * across[:, 1] - way[:, 1] * across[:, 0])
    if area <= 0.0:
        raise RoadError(
            f"{lanelet.place}: lane {lanelet.id} has its left border on the right or none apart from the right one, expected left of the way"
        )
    return _graded(left, right)


def _once(left: Floats, right: Floats) -> tuple[Floats, Floats]:
    """Borders without vertices that are given twice, where as many are on either side: one at the start of the left border and one at the end of the
    right one would put all vertices between them beside the wrong partner.
    """
    kept = [line[np.append(True, np.hypot(*np.diff(line[:, :2], axis=0).T) > SAME)] for line in (left, right)]
    return (kept[0], kept[1]) if len(left) == len(right) and len(kept[0]) == len(kept[1]) > 1 else (left, right)


def _with_heights(left: Floats, right: Floats) -> tuple[Floats, Floats]:
    """Heights where none are given: between those along the same border, else those of the other border, else 0."""
    made = []
    for line, other in ((left, right), (right, left)):
        line = line.copy()
        source = next((side for side in (line, other) if not np.isnan(side[:, 2]).all()), None)
        if source is None:
            line[:, 2] = 0.0
        else:
            s, of_source = (way_along(side) / max(way_along(side)[-1], 1e-9) for side in (line, source))
            there, missing = ~np.isnan(source[:, 2]), np.isnan(line[:, 2])
            line[missing, 2] = np.interp(s[missing], of_source[there], source[there, 2])
        made.append(line)
    return made[0], made[1]


def _graded(left: Floats, right: Floats) -> tuple[Floats, Floats]:
    """Further places on long straight pieces, close to where shorter ones begin.

    A spline through places at very uneven distances swings out over the long piece, by a share of its length; places at doubling distances
    from its ends keep it straight. Pieces between evenly spread places are left as they are: there the spline is the better curve.
    """
    steps = np.hypot(*np.diff(0.5 * (left + right)[:, :2], axis=0).T)
    before, after = np.append(ALONE, steps[:-1]), np.append(steps[1:], ALONE)
    shares = [np.array([0.0])]
    for step, first, last in zip(steps, before, after, strict=True):
        marks = [0.0, 1.0]
        for short, at_end in ((first, False), (last, True)):
            if step > 3.0 * short:
                marks += [1.0 - d / step if at_end else d / step for d in short * (2.0 ** np.arange(1, 30) - 1.0) if d < 0.5 * step]
        shares.append(len(shares) - 1 + np.unique(marks)[1:])
    index = np.concatenate(shares)
    if len(index) == len(left):
        return left, right
    known = np.arange(len(left))
    return tuple(np.column_stack([np.interp(index, known, line[:, axis]) for axis in range(3)]) for line in (left, right))  # pyright: ignore[reportReturnType]


def _shares(lanelet: Lanelet, border: Floats) -> Floats:
    s = way_along(border)
    if s[-1] <= SAME:
        raise RoadError(f"{lanelet.place}: lane {lanelet.id} has a border of {s[-1]:.4f} m, expected a longer one")
    return s / s[-1]


def offset_polyline(line: Floats, offset: float) -> Floats:
    """`line` (n, 3) moved sideways by `offset` (m, positive left), corners mitred."""
    step = np.diff(line[:, :2], axis=0)
    unit = step / np.maximum(np.hypot(*step.T), 1e-9)[:, None]
    normal = np.column_stack([-unit[:, 1], unit[:, 0]])
    first, last = np.vstack([normal[:1], normal]), np.vstack([normal, normal[-1:]])
    middle = first + last
    # a mitre of more than twice the offset belongs to a corner no lane has
    scale = 2.0 / np.maximum(np.sum(middle**2, axis=1), 1.0)
    moved = line.copy()
    moved[:, :2] += offset * scale[:, None] * middle
    return moved
