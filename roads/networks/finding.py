"""The road from one place to another: the cheapest way that can be drawn, or why there is none."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import RoadError
from .assembly import UndrivableError, assemble
from .lattice import Lattice
from .refusals import why_no_way
from .routing import Route, Stretch, around, names_along, route_of, shown, spots_of

if TYPE_CHECKING:
    from ..road import Road
    from .ground import Ground
    from .routing import Cost, Place

#: Ways that cannot be drawn as a road after which the next cheapest one is no longer tried.
MOST_TRIES = 8
#: Costs whose graphs are kept.
MOST_COSTS = 4


class Finder:
    """Finds ways through one network; what was worked out for one way serves the next ones."""

    def __init__(self, ground: Ground) -> None:
        self.ground = ground
        self._lattices: dict[Cost, Lattice] = {}
        self._last: tuple[tuple[Place, Place, Cost], tuple[Route, Road]] | None = None

    def find(self, name: str, start: Place, goal: Place, cost: Cost) -> tuple[Route, Road]:
        """The cheapest way from `start` to `goal` and its road.

        Raises:
            RoadError: no such place, no way, or a cost that can be earned without end by going round.
        """
        key = start, goal, cost
        if self._last is None or self._last[0] != key or self._last[1][1].name != name:
            self._last = key, self._find(name, start, goal, self._lattice(cost))
        return self._last[1]

    def alone(self, name: str) -> Road:
        """The road of one link from its beginning to its end, whether it could be driven or not.

        Raises:
            RoadError: a link without sound geometry.
        """
        ground = self.ground
        stretch = Stretch(0.0, 1.0, {0: name}, 0)
        return assemble(f"{Path(ground.network.path).stem}: {name}", Route(ground, [stretch], np.array([0.0, ground.links[name].length]), []))

    def _lattice(self, cost: Cost) -> Lattice:
        if cost not in self._lattices:
            made = Lattice(self.ground, cost)
            while len(self._lattices) >= MOST_COSTS:
                del self._lattices[next(iter(self._lattices))]
            self._lattices[cost] = made
        return self._lattices[cost]

    def _find(self, name: str, start: Place, goal: Place, lattice: Lattice) -> tuple[Route, Road]:
        ground = self.ground
        begins, goals = spots_of(ground, start, 0), spots_of(ground, goal, 1)
        on_lanes = all(lattice.next_on(*spot) for spot in (*begins, *goals))
        if lattice.way(begins, goals) is None and not (on_lanes and why_no_way(ground, begins, goals)):
            # a position stands for the whole cross-section if the lane it is nearest to is too narrow there or leads nowhere
            begins, goals = around(ground, start, begins), around(ground, goal, goals)
        without: set[tuple[str, str]] = set()
        reasons: list[str] = []
        for _ in range(MOST_TRIES):
            way = lattice.way(begins, goals, frozenset(without))
            if way is None:
                break
            route = route_of(ground, way)
            try:
                return route, assemble(name, route)
            except UndrivableError as error:
                reasons.append(str(error).removeprefix(f"{ground.network.path}: "))
                barred = _barred(route, error.stretch)
                if barred <= without:
                    break
                without |= barred
            except RoadError as error:
                raise error if str(error).startswith(ground.network.path) else RoadError(f"{ground.network.path}: {error}") from None
        unfit = [ground.unfit[place] for place in (start, goal) if isinstance(place, str) and place in ground.unfit]
        reason = "; ".join(dict.fromkeys(reasons or unfit)) or why_no_way(ground, begins, goals)
        where = f"{ground.network.path}: no way from {shown(start)} to {shown(goal)} along the lanes' directions"
        raise RoadError(f"{where} that can be driven: {reason}" if reason else where)


def _barred(route: Route, stretch: int) -> set[tuple[str, str]]:
    """The links from lane to lane to go without after a route could not be drawn along one of its stretches."""
    names = names_along(route)
    # those that lead onto the stretch and off it
    return set(names[max(stretch - 1, 0) : stretch + 1])
