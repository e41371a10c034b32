"""Streets with lanes that open, end and change their numbers."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .curves import Element, Pose, joined
from .records import Lane, Section, Street, Width

KINDS = ("arc", "spiral", "param", "param length", "poly3")
UNITS = ('max="50" unit="km/h"', 'max="30" unit="mph"', 'max="8.33" unit="m/s"', 'max="60" unit="km/h"', 'max="15"')


@dataclass(frozen=True)
class Wish:
    """A cross-section and what happens at its ends.

    Attributes:
        right: number of driving lanes that lead with the reference line.
        left: and against it.
        width: of a driving lane, m.
        inner: kinds of lanes between the reference line and the driving lanes on the right.
        outer: kinds of lanes outside of the driving lanes on both sides.
        opens: for the end and for the start: "", "inner" or "outer": a turn lane opens before the junction there.
        ends: for the start and for the end: a lane that begins there ends in a taper.
        kind: of the lane that opens or ends.
    """

    right: int
    left: int
    width: float = 3.5
    inner: tuple[str, ...] = ()
    outer: tuple[str, ...] = ()
    opens: tuple[str, str] = ("", "")
    ends: tuple[bool, bool] = (False, False)
    kind: str = "driving"


@dataclass
class _Stretch:
    """A lane from station `a` to `b`; its widths count from `a`. `place` orders lanes from the middle outwards."""

    a: float
    b: float
    side: int
    place: float
    lane: Lane
    more: str = field(default="")


def opening(width: float, over: float) -> list[Width]:
    return [(0.0, 0.0, 0.0, 3.0 * width / over**2, -2.0 * width / over**3), (over, width, 0.0, 0.0, 0.0)]


def closing(width: float, after: float, over: float) -> list[Width]:
    return [(0.0, width, 0.0, 0.0, 0.0), (after, width, 0.0, -3.0 * width / over**2, 2.0 * width / over**3)]


def drawn(a: Pose, b: Pose, rng: np.random.Generator) -> list[Element] | None:
    """From pose to pose over a pose between them."""
    reach = float(np.hypot(b.x - a.x, b.y - a.y))
    _ahead, aside, turn = b.seen_from(a)
    if reach < 40.0 or abs(aside) + abs(turn) < 1e-9:
        return joined(a, b, str(rng.choice(KINDS)))
    middle = Pose(0.5 * (a.x + b.x), 0.5 * (a.y + b.y), float(np.arctan2(b.y - a.y, b.x - a.x)))
    middle = middle.moved(0.0, float(rng.uniform(-0.04, 0.04) * reach))
    parts = [joined(a, middle, str(rng.choice(KINDS))), joined(middle, b, str(rng.choice(KINDS)))]
    return None if None in parts else [*parts[0], *parts[1]]  # type: ignore[misc]


def street(identity: str, elements: list[Element], wish: Wish, rng: np.random.Generator, heights: tuple[float, float] = (0.0, 0.0)) -> Street:
    """A road along `elements` with the cross-section that is wished for."""
    length = sum(element.length for element in elements)
    stretches = _through(wish, length)
    room = 0.45 * length
    for side, opens, ends in ((-1, wish.opens[0], wish.ends[0]), (1, wish.opens[1], wish.ends[1])):
        if (wish.right if side < 0 else wish.left) == 0:
            continue
        if opens and room > 20.0:
            held = float(rng.uniform(18.0, min(room, 60.0)))
            over = float(rng.uniform(10.0, min(40.0, held - 4.0)))
            rows = opening(wish.width, over) if side < 0 else closing(wish.width, held - over, over)
            a, b = (length - held, length) if side < 0 else (0.0, held)
            stretches.append(_Stretch(a, b, side, 0.9 if opens == "inner" else 8.0, Lane("turn", wish.kind, rows)))
        if ends and room > 26.0:
            held = float(rng.uniform(25.0, min(room, 60.0)))
            over = float(rng.uniform(12.0, held - 10.0))
            rows = closing(wish.width, held - over, over) if side < 0 else opening(wish.width, over)
            a, b = (0.0, held) if side < 0 else (length - held, length)
            stretches.append(_Stretch(a, b, side, 8.5, Lane("ending", wish.kind, rows)))
    starts = sorted({0.0} | {round(at, 3) for one in stretches for at in (one.a, one.b) if 0.05 < at < length - 0.05})
    sections = []
    for s in starts:
        here = sorted((one for one in stretches if one.a <= s + 2e-3 and one.b > s + 2e-3), key=lambda one: one.place)
        left, right = ([one.lane.starting(max(s - one.a, 0.0)) for one in here if one.side == side] for side in (1, -1))
        sections.append(Section(s, left, right))
    speed = f'<type s="0" type="town"><speed {rng.choice(UNITS)}/></type>'
    made = Street(identity, elements, sections, heights=heights, more=speed)
    made.link_sections()
    return made


def _through(wish: Wish, length: float) -> list[_Stretch]:
    """Lanes that lead from the start to the end."""
    found = []

    def lane(key: str, kind: str, width: float, side: int, place: float) -> None:
        found.append(_Stretch(0.0, length, side, place, Lane(key, kind, [(0.0, width, 0.0, 0.0, 0.0)])))

    for k, kind in enumerate(wish.inner):
        lane(f"inner {k}", kind, wish.width if kind == "bidirectional" else 1.5, -1, 0.1 * k)
    for side, count in ((-1, wish.right), (1, wish.left)):
        for k in range(count):
            lane(f"drive {k}", "driving", wish.width, side, 1.0 + k)
        for k, kind in enumerate(wish.outer if count else ()):
            lane(f"outer {k}", kind, 2.4 if kind == "parking" else 1.5, side, 10.0 + k)
    return found


def wished(rng: np.random.Generator, *, one_way: bool = False) -> Wish:
    """A cross-section as towns have them."""
    right, left = (int(rng.choice([1, 1, 2, 2, 3])) for _ in range(2))
    if one_way:
        right, left = (right, 0) if rng.random() < 0.5 else (0, left)
    inner: tuple[str, ...] = ()
    if right and left:
        inner = [(), (), (), ("median",), ("bidirectional",)][int(rng.integers(5))]
    outer = [(), ("sidewalk",), ("shoulder",), ("parking", "sidewalk"), ("curb", "sidewalk")][int(rng.integers(5))]
    opens = tuple(str(rng.choice(["", "", "inner", "outer"])) for _ in range(2))
    ends = tuple(bool(rng.random() < 0.25) for _ in range(2))
    return Wish(right, left, float(rng.choice([3.3, 3.5, 3.75])), inner, outer, opens, ends)  # type: ignore[arg-type]
