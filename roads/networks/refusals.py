"""Why there is no way: lanes that no link joins, links that nobody can drive, or changes without room."""

from __future__ import annotations

import itertools
from itertools import pairwise
from typing import TYPE_CHECKING

from .ground import LEAST_CHANGE

if TYPE_CHECKING:
    from .ground import Ground, Side
    from .routing import Spot

#: What a link that cannot be driven, and a change without room, count more than a metre of way.
BARRED = 1e7
#: What a change with room counts, m.
CHANGE = 20.0
#: Most cross-sections looked at for the room of a change.
MOST = 200


def why_no_way(ground: Ground, begins: list[Spot], goals: list[Spot]) -> str:
    """The first thing that bars the way with the fewest such, in words; empty where lanes are not joined at all, whatever could be driven."""
    names = _least_barred(ground, {name for name, _ in begins}, {name for name, _ in goals})
    for k, (name, other) in enumerate(itertools.pairwise(names)):
        if (name, other) in ground.refused:
            return ground.refused[name, other].reason
        side = _side(ground, name, other)
        if side is None or other in ground.after(name):
            continue
        last, count = k + 1, 1
        while last + 1 < len(names) and ground.beside(names[last], side) == names[last + 1]:
            last, count = last + 1, count + 1
        ends = (dict(begins).get(name, 0.0) if k == 0 else None, dict(goals).get(names[last], 1.0) if last == len(names) - 1 else None)
        room = min(_room(ground, a, b, side, ends) for a, b in pairwise(names[k : last + 1]))
        if room < LEAST_CHANGE * count or not ground.common(name, other):
            need = f"takes at least {LEAST_CHANGE * count:g} m, {room:.1f} m are left"
            return f"changing from lane {name} to {names[last]} {need} where both are wide enough"
    if len(names) == 1 or (names and names[0] == names[-1]):
        return ""
    return "its changes of lane have too little room one after the other" if names else ""


def _side(ground: Ground, name: str, other: str) -> Side | None:
    return next((side for side in ("left", "right") if ground.beside(name, side) == other), None)


def _least_barred(ground: Ground, begins: set[str], goals: set[str]) -> list[str]:
    """Links one after the other from a beginning to a goal; empty where nothing leads there."""
    from heapq import heappop, heappush

    best = dict.fromkeys((name for name in begins if name in ground.spans), 0.0)
    before: dict[str, str] = {}
    waiting = [(0.0, name) for name in best]
    while waiting:
        cost, name = heappop(waiting)
        if cost > best[name]:
            continue
        if name in goals and name in ground.spans:
            found = [name]
            while found[-1] in before:
                found.append(before[found[-1]])
            return found[::-1]
        moves = [(other, ground.lengths[name] + BARRED * ((name, other) in ground.refused)) for other in ground.after(name)]
        for side in ("left", "right"):
            other = ground.beside(name, side)
            if other is not None:
                moves.append((other, CHANGE + BARRED * (_room(ground, name, other, side) < LEAST_CHANGE)))
        for other, more in moves:
            if cost + more < best.get(other, float("inf")):
                best[other], before[other] = cost + more, name
                heappush(waiting, (cost + more, other))
    return []


def _room(ground: Ground, name: str, other: str, side: Side, ends: tuple[float | None, float | None] = (None, None)) -> float:
    """How far two neighbours lie side by side, wide enough, with those before and after them, m: the longest such run there.

    `ends` are the shares of their lengths that the way begins and ends at, where it does so on them.
    """
    begin, end = ends
    first, last = 0.0 if begin is None else begin, 1.0 if end is None else end
    spans = [(max(low, first), min(high, last)) for low, high in ground.common(name, other) if low <= last and high >= first]
    if not spans:
        return 0.0
    runs = [(high - low) * ground.mean_length(name, other) for low, high in spans]
    if spans[-1][1] == 1.0 and end is None:
        runs[-1] += _further(ground, name, other, side, ahead=True)
    if spans[0][0] == 0.0 and begin is None:
        runs[0] += _further(ground, name, other, side, ahead=False)
    return max(runs)


def _further(ground: Ground, name: str, other: str, side: Side, *, ahead: bool) -> float:
    total = 0.0
    for _ in range(MOST):
        if total >= 10.0 * LEAST_CHANGE:
            break
        if ahead:
            pairs = ground.side_by_side_after(name, other, side)
        else:
            pairs = [
                (a, b)
                for a in ground.entering.get(name, [])
                if (b := ground.beside(a, side)) is not None and other in ground.onward[b] and (last := ground.common(a, b)) and last[-1][1] == 1.0
            ]
        if not pairs:
            break
        name, other = pairs[0]
        spans = ground.common(name, other)
        low, high = spans[0] if ahead else spans[-1]
        total += (high - low) * ground.mean_length(name, other)
        if high - low < 1.0:
            break
    return total
