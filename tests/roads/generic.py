"""Roads in generic position: nothing symmetric, level, even, parallel or constant, and a circuit whose seam lies in a bend; with a plain reading."""

from __future__ import annotations

import numpy as np

from roads import Road

Floats = np.ndarray

#: Offsets of the borders between lanes from right to left, m: unequal widths, none of them at the reference.
_BORDERS = (-5.3, -1.9, 1.2, 4.4)
_DIRECTIONS = (1, 1, -1)


def generic(seed: int = 1, *, closed: bool = False, pieces: bool = False, snug: bool = False, even: bool = False) -> Road:
    """A road of some 350 m with 8 m to 15 m between its uneven stations, three lanes of changing widths, and everything else changing too.

    With `pieces` its lanes have sections: the rightmost one ends on the way, the leftmost one begins later. With `snug` its edges are those of its
    lanes, with `even` lanes have constant widths: some formats hold no others.
    """
    rng = np.random.default_rng(seed)
    count = 31
    angle = np.cumsum(rng.uniform(0.7, 1.3, count))
    angle = 2.0 * np.pi * (angle - angle[0]) / (angle[-1] - angle[0] + 1.1) + 0.4
    radius = 55.0 + 7.0 * np.sin(2.0 * angle + 0.3) + 4.0 * np.cos(3.0 * angle - 1.0)
    points = radius[:, None] * np.column_stack([1.2 * np.cos(angle), np.sin(angle)]) + [37.0, -21.0]
    borders = [base + (0.0 if even else 1.0) * rng.uniform(-0.5, 0.5, count) for base in _BORDERS]
    beside = rng.uniform(0.0 if snug else 0.1, 0.0 if snug else 0.9, (2, count))
    lanes = [(direction, low, high) for direction, low, high in zip(_DIRECTIONS, borders[:-1], borders[1:], strict=True)]
    if pieces:
        beyond, before = np.arange(count) > 19, np.arange(count) < 8
        lanes[0] = (1, np.where(beyond, np.nan, borders[0]), np.where(beyond, np.nan, borders[1]))
        lanes[2] = (-1, np.where(before, np.nan, borders[2]), np.where(before, np.nan, borders[3]))
    return Road.from_points(
        "generic", points, borders[0] - beside[0], borders[-1] + beside[1], closed=closed,
        height=100.0 + 4.0 * np.sin(angle) + rng.uniform(-0.2, 0.2, count), speed_limit=rng.choice([8.0, 11.0, 14.0, 17.0, 22.0, 30.0], count),
        lane_edges=lanes, bank=rng.uniform(-0.06, 0.09, count), friction=rng.uniform(0.4, 1.1, count), columns={"wear": rng.uniform(0.0, 1.0, count)},
    )  # fmt: skip


def plain(road: Road, values: Floats, s: Floats) -> Floats:
    """Columns read by hand: linear between the two stations beside, over the seam of a circuit too; NaN where either of them has nothing."""
    found = np.empty(len(s))
    for at, station in enumerate(s):
        station = station % road.length if road.closed else min(max(station, 0.0), road.length)
        k = max(int(np.sum(road.s <= station)) - 1, 0)
        start, end = road.s[k], road.s[k + 1] if k + 1 < len(road.s) else road.length
        share = 0.0 if end == start else (station - start) / (end - start)
        after = values[(k + 1) % len(values)] if road.closed else values[min(k + 1, len(values) - 1)]
        found[at] = values[k] if share < 1e-9 else after if share > 1.0 - 1e-9 else (1.0 - share) * values[k] + share * after
    return found


def limits(road: Road, s: Floats) -> Floats:
    """Posted limits read by hand: that of the last station passed."""
    inside = np.mod(s, road.length) if road.closed else s
    return np.array([road.speed_limit[int(np.sum(road.s <= station)) - 1] for station in inside])


def line(road: Road, offset: Floats, s: Floats) -> Floats:
    """Places (k, 2) of what lies at an offset (n,) from the reference, at stations `s` (k,)."""
    return road.reference.position(s) + plain(road, offset, s)[:, None] * road.reference.normal(s)


def scene(road: Road, s: Floats) -> dict[str, Floats]:
    """What stands where at stations `s`, in the plane: borders, lanes, height, bank, friction, limit and further columns; no station in it."""
    found = {"right": line(road, road.right, s), "left": line(road, road.left, s), "heading": road.reference.tangent(s)}
    found |= {"height": road.height_at(s), "slope": road.slope_at(s), "limit": limits(road, s)}
    found |= {name: plain(road, values, s) for name, values in (("bank", road.bank), ("friction", road.friction), *road.columns.items())}
    for k, lane in enumerate(road.lanes):
        found |= {f"{k} right": line(road, lane.right, s), f"{k} left": line(road, lane.left, s), f"{k} leads": np.array([lane.direction])}
    return found


def from_the_other_side(found: dict[str, Floats]) -> dict[str, Floats]:
    """The same scene as who comes the other way tells it."""
    count = sum(name.endswith("leads") for name in found)
    sides = {"right": "left", "left": "right"}
    told = {}
    for name, values in found.items():
        number, _, side = name.rpartition(" ")
        other = f"{count - 1 - int(number)} {sides.get(side, side)}" if number else sides.get(name, name)
        told[other] = -values if name in ("heading", "slope", "bank") or side == "leads" else values
    return told
