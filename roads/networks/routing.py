"""The cheapest way through a network's lanes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Literal

import numpy as np

from ..errors import RoadError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .links import Link, LinkMap

    Floats = NDArray[np.float64]

Place = str | tuple[float, float]
Cost = Literal["length", "time"] | Callable[["Floats", "Floats", "Floats"], float]

#: A change of lane costs as much as this share of an average link, and at least this way, m; it keeps routes from weaving.
CHANGE_WAY = 20.0
#: Stretches shorter than this are no place to change lanes, m.
SHORT = 15.0
#: Lanes that narrow to less lead nowhere by themselves, m.
NARROW = 2.0
#: Speed where no limit is posted, m/s.
UNPOSTED = 50.0 / 3.6
#: A position may be this far from the middle of the nearest lane, m.
FAR = 50.0


@dataclass(frozen=True)
class Step:
    """A stretch of one link: from `start` to `end` (m along it), and whether the next step is a neighbour of the same cross-section."""

    link: Link
    start: float
    end: float


def find_route(network: LinkMap, start: Place, goal: Place, cost: Cost) -> list[list[Step]]:
    """The steps from `start` to `goal`, those within one cross-section together in one list (the lanes that are changed along it).

    Raises:
        RoadError: no such place, no way, or a cost that can be earned without end by going round.
    """
    begin, finish = _options(network, start, 0.0), _options(network, goal, 1.0)
    ids = list(network.links)
    row = {name: k for k, name in enumerate(ids)}
    price = _prices(network, ids, cost)
    steps = _best(network, ids, row, price, begin, finish)
    if steps is None:
        # a position stands for the whole cross-section if the lane it is nearest to has no way
        around = [_around(network, place, found) for place, found in ((start, begin), (goal, finish))]
        steps = _best(network, ids, row, price, *around)
    if steps is None:
        raise RoadError(f"{network.path}: no way from {shown(start)} to {shown(goal)} along the lanes' directions")
    return steps


def _best(
    network: LinkMap, ids: list[str], row: dict[str, int], price: Floats, begin: list[tuple[str, float]], finish: list[tuple[str, float]]
) -> list[list[Step]] | None:
    best: tuple[float, list[list[Step]]] | None = None
    distances, before = _shortest(network, ids, row, price, [row[name] for name, _ in begin])
    for k, (name, share) in enumerate(begin):
        for last, until in finish:
            found = _way(network, ids, row, price, (name, share), (last, until), distances[k], before[k])
            if found is not None and (best is None or found[0] < best[0]):
                best = found
    return None if best is None else best[1]


def _around(network: LinkMap, place: Place, found: list[tuple[str, float]]) -> list[tuple[str, float]]:
    if isinstance(place, str):
        return found
    ((name, share),) = found
    link = network.links[name]
    return [(other, 1.0 - share if against else share) for other, against in zip(link.beside, link.against, strict=True)]


def _options(network: LinkMap, place: Place, share: float) -> list[tuple[str, float]]:
    """Links that `place` may mean, each with a share of its length: lanes side by side where it names a position or a road."""
    if not isinstance(place, str):
        name, s, distance = network.nearest(*place)
        if distance > FAR:
            raise RoadError(
                f"{network.path}: ({place[0]:.1f}, {place[1]:.1f}) is {distance:.0f} m from the nearest lane {name}, expected at most {FAR:.0f} m"
            )
        return [(name, s / network.links[name].length)]
    if place in network.links:
        return [(place, share)]
    if place not in network.lengths:
        raise RoadError(f"{network.path}: no road or lane {place!r}, expected an id such as {', '.join(list(network.lengths)[:6])} or a position x,y")
    own = [link for link in network.links.values() if link.road == place]
    if not own:
        raise RoadError(f"{network.path}: road {place} has no drivable lane")
    which = 0 if share == 0.0 else 1
    ends = [link for link in own if link.at_ends[which]]
    # a lane that begins or ends in a taper is no place to begin or end
    found = [link for link in ends if link.end_widths[which] >= NARROW] or ends
    return [(link.id, share) for link in found]


def _prices(network: LinkMap, ids: list[str], cost: Cost) -> Floats:
    if not callable(cost) and cost not in ("length", "time"):
        raise RoadError(f"cost {cost!r} is unknown, expected length, time or a function")
    found = np.full(len(ids), np.inf)
    for k, name in enumerate(ids):
        link = network.links[name]
        try:
            s, height = link.stations, link.centre[:, 2]
        except RoadError:
            continue
        limit = link.limit_at(s)
        if callable(cost):
            found[k] = cost(s, height, limit)
        elif cost == "length":
            found[k] = s[-1]
        else:
            found[k] = float(np.sum(np.diff(s) / np.where(np.isfinite(limit[:-1]), limit[:-1], UNPOSTED)))
        if np.isnan(found[k]):
            raise RoadError(f"cost of lane {name} is not a number")
    return found


def _edges(network: LinkMap, row: dict[str, int], price: Floats) -> tuple[list[int], list[int], list[float]]:
    finite = price[np.isfinite(price)]
    total = float(sum(link.length for k, link in enumerate(network.links.values()) if np.isfinite(price[k])))
    change = CHANGE_WAY * float(np.sum(np.abs(finite))) / max(total, 1e-9)
    begins, ends, weights = [], [], []
    for name, link in network.links.items():
        k = row[name]
        if not np.isfinite(price[k]):
            continue
        for after in link.successors:
            if np.isfinite(price[row[after]]):
                begins.append(k)
                ends.append(row[after])
                # through a taper drives only who has no lane beside it
                tapers = (link.left or link.right) and link.end_widths[1] < NARROW
                tapers = tapers or ((later := network.links[after]).end_widths[0] < NARROW and bool(later.left or later.right))
                weights.append(float(price[k]) + (1e3 * change if tapers else 0.0))
        for beside in (link.left, link.right):
            if beside is not None and np.isfinite(price[row[beside]]):
                begins.append(k)
                ends.append(row[beside])
                weights.append(change * (1.0 if link.length > SHORT else 50.0))
    return begins, ends, weights


def _shortest(network: LinkMap, ids: list[str], row: dict[str, int], price: Floats, sources: list[int]) -> tuple[Floats, NDArray[np.int32]]:
    """Least cost from the beginning of each source link to the beginning of every link, and the link before it on that way."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import NegativeCycleError, bellman_ford, dijkstra

    begins, ends, weights = _edges(network, row, price)
    least: dict[tuple[int, int], float] = {}
    for begin, end, weight in zip(begins, ends, weights, strict=True):
        # csgraph takes a zero for no edge
        least[begin, end] = min(weight if weight != 0.0 else 1e-12, least.get((begin, end), np.inf))
    keys = np.array(list(least), dtype=np.intp).reshape(-1, 2)
    values = np.array(list(least.values()))
    graph = csr_array((values, (keys[:, 0], keys[:, 1])), shape=(len(ids), len(ids)))
    solve = bellman_ford if np.any(values < 0.0) else dijkstra
    try:
        distances, before = solve(graph, indices=sources, return_predecessors=True)
    except NegativeCycleError:
        raise RoadError(f"{network.path}: the cost falls without end on a way round, expected a cost that going round does not lower") from None
    return distances, before


def _way(
    network: LinkMap,
    ids: list[str],
    row: dict[str, int],
    price: Floats,
    begin: tuple[str, float],
    finish: tuple[str, float],
    distances: Floats,
    before: NDArray[np.int32],
) -> tuple[float, list[list[Step]]] | None:
    """Cost and steps of the cheapest way from one link and share of it to another; None where there is none."""
    (first, share), (last, until) = begin, finish
    start_link, goal_link = network.links[first], network.links[last]
    # neighbours of a damaged file need not know of each other
    same_way = dict(zip(goal_link.beside, goal_link.against, strict=True)).get(first) is False
    side_by_side = last == first or (last in start_link.beside and same_way)
    if side_by_side and share < until:
        chain = _across(network, first, last)
        if chain is not None:
            whole = float(price[row[first]])
            cost = whole * (until - share) + abs(whole) / max(start_link.length, 1e-9) * CHANGE_WAY * (len(chain) - 1)
            return cost, [[_step(network.links[name], share, until) for name in chain]]
    target = row[last]
    chain_rows = [target]
    way = float(distances[target])
    if last in start_link.beside:
        # the goal lies behind or level on the same stretch: the way leads round and enters the stretch anew
        entries = [
            row[name] for name, link in network.links.items() if last in link.successors and np.isfinite(distances[row[name]] + price[row[name]])
        ]
        if not entries:
            return None
        entry = min(entries, key=lambda k: distances[k] + price[k])
        chain_rows.append(entry)
        way = float(distances[entry] + price[entry])
    if not np.isfinite(way):
        return None
    while before[chain_rows[-1]] >= 0:
        chain_rows.append(int(before[chain_rows[-1]]))
    groups = _by_cross_section(network, [ids[k] for k in reversed(chain_rows)])
    cost = way - share * float(price[row[first]]) + until * float(price[target])
    steps = []
    for k, group in enumerate(groups):
        low, high = share if k == 0 else 0.0, until if k == len(groups) - 1 else 1.0
        steps.append([_step(network.links[name], low, high) for name in group])
    return cost, steps


def _by_cross_section(network: LinkMap, names: list[str]) -> list[list[str]]:
    """Links of a way, those that are changed between on one stretch together."""
    groups: list[list[str]] = [[names[0]]]
    for name, after in pairwise(names):
        link = network.links[name]
        if after in (link.left, link.right) and after not in link.successors:
            groups[-1].append(after)
        else:
            groups.append([after])
    return groups


def _across(network: LinkMap, first: str, last: str) -> list[str] | None:
    """Neighbours from `first` to `last`, both included."""
    for side in ("left", "right"):
        chain = [first]
        while chain[-1] != last:
            after = getattr(network.links[chain[-1]], side)
            if after is None or after in chain:
                break
            chain.append(after)
        if chain[-1] == last:
            return chain
    return None


def _step(link: Link, low: float, high: float) -> Step:
    return Step(link, low * link.length, high * link.length)


def shown(place: Place) -> str:
    """A place in words: the id, or (x, y) in m."""
    return place if isinstance(place, str) else f"({place[0]:.1f}, {place[1]:.1f})"
