"""The ends of links: where they are, which way lanes lead there, and which lanes turn round on the spot."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .links import Link

    Floats = NDArray[np.float64]

#: Directions at the ends of lanes are those of stretches this long, m: on curves, and on polylines.
STRETCH, COARSE = 1.0, 4.0
#: Borders that are farther apart tell what lies across, m.
SOME = 0.1
#: Polylines shorter than this lead as what is before and after them does, m.
STUB = 1.0
#: Lanes given as polylines are coarse at corners: they may turn by so much where the corner can be rounded, rad.
CORNER = 2.0
#: A lane that turns by more than that, within less way than at this radius, turns round on the spot, m.
TIGHTEST = 2.0
#: Links shorter than this count as nothing, m: what follows them follows what is before them.
NOTHING = 0.05


def ends_of(links: dict[str, Link], lengths: dict[str, float]) -> dict[str, Floats]:
    """The ends of the links that have a length: (2, 6) x, y, the direction of a stretch there, and across the borders (NaN where they are one)."""
    found = {name: _ends(links[name]) for name in lengths}
    stubs = [name for name, length in lengths.items() if length < STUB and not links[name].exact]
    if not stubs:
        return found
    onto = _before(links, lengths)
    for name in stubs:
        after = [found[other][0, 2:4] for other in links[name].successors if other in found]
        before = [found[other][1, 2:4] for other in onto.get(name, [])]
        if after and before:
            sides = np.array([np.mean(after, axis=0), np.mean(before, axis=0)])
            way = np.sum(sides / np.maximum(np.hypot(*sides.T), 1e-9)[:, None], axis=0)
            if np.hypot(*way) > 0.1:
                found[name][:, 2:4] = way
    return found


def _before(links: dict[str, Link], lengths: dict[str, float]) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for name in lengths:
        for other in links[name].successors:
            found.setdefault(other, []).append(name)
    return found


def _ends(link: Link) -> Floats:
    line, s = link.centre[:, :2], link.stations
    left, right = link.borders
    reach = min(STRETCH if link.exact else COARSE, s[-1] / 3.0)
    inner = [np.array([np.interp(at, s, line[:, axis]) for axis in (0, 1)]) for at in (reach, s[-1] - reach)]
    across = (left - right)[:, :2]
    # where a lane opens from no width its borders lie across as they do where it has some
    wide = np.flatnonzero(np.hypot(*across.T) > SOME)
    found = np.full((2, 6), np.nan)
    for row, at, way in ((0, 0, inner[0] - line[0]), (1, -1, line[-1] - inner[1])):
        found[row, :4] = *line[at], *way
        if len(wide):
            found[row, 4:] = across[wide[at], 1], -across[wide[at], 0]
    return found


def on_the_spot(links: dict[str, Link], lengths: dict[str, float], ends: dict[str, Floats]) -> dict[str, str]:
    """Links that turn round on the spot, alone or with those they are cut into, on any way onto them and off them; and what they do, in words."""
    names = list(lengths)
    every = np.array(list(ends.values())).reshape(-1, 2, 6)
    exact = np.array([links[name].exact for name in names], dtype=bool)[:, None, None]
    way = np.where(exact & ~np.isnan(every[:, :, 4:6]), every[:, :, 4:6], every[:, :, 2:4])
    row = {name: k for k, name in enumerate(names)}
    pairs = np.array([(row[name], row[other]) for name in names for other in links[name].successors if other in row], dtype=np.intp)
    pairs = pairs.reshape(-1, 2)
    onto: dict[int, list[tuple[int, float]]] = {}
    off: dict[int, list[tuple[int, float]]] = {}
    for (a, b), joint in zip(pairs.tolist(), turn(way[pairs[:, 0], 1], way[pairs[:, 1], 0]).tolist(), strict=True):
        off.setdefault(a, []).append((b, joint))
        onto.setdefault(b, []).append((a, joint))
    inside, along = turn(way[:, 0], way[:, 1]).tolist(), list(lengths.values())
    found: dict[str, str] = {}
    for first in range(len(names)):
        chain, turned, length = [first], inside[first], along[first]
        while length < np.pi * TIGHTEST:
            beyond = off.get(chain[-1], [(-1, 0.0)])
            least = min(abs(turned + a + b) for _, a in onto.get(first, [(-1, 0.0)]) for _, b in beyond)
            if least > CORNER and length < least * TIGHTEST:
                where = f"turns by {least:.2f} rad within {length:.1f} m, expected a radius of at least {TIGHTEST:g} m"
                found |= {names[k]: f"lane {names[k]} {where}" for k in chain if along[k] >= NOTHING}
                break
            (after, joint), *others = beyond
            if others or after in (-1, *chain) or len(onto[after]) > 1:
                break
            chain.append(after)
            turned, length = turned + joint + inside[after], length + along[after]
    return found


def between(a: Floats, b: Floats) -> Floats:
    """Angles (n,) between vectors (n, 2), rad."""
    return np.abs(turn(a, b))


def turn(a: Floats, b: Floats) -> Floats:
    """Angles (n,) from vectors to vectors (n, 2), rad, positive to the left."""
    return np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], np.sum(a * b, axis=1))
