"""Lines that are no roads: each ends within bounded work, in a plan or in one line that names the station."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from energy_mgr.errors import PlanningError
from energy_mgr.path import plan_path
from energy_mgr.path.proof import certificate
from roads import Road, RoadError
from roads.border_line import border_lines, refuse_turning_back

Floats = NDArray[np.float64]


def wave() -> Floats:
    s = np.arange(0.0, 120.0)
    return np.column_stack([s, 5.0 * np.sin(s / 30.0)])


def ring(more: list[list[float]]) -> Floats:
    """A loop of 150 m from (0, 0) with further points after it."""
    angle = np.linspace(0.0, 2.0 * np.pi, 151)[:-1]
    return np.vstack([24.0 * np.column_stack([np.sin(angle), 1.0 - np.cos(angle)]), *more])


def corner(degrees: float, step: float) -> Floats:
    way, angle = np.arange(0.0, 40.0, step), np.radians(degrees)
    return np.vstack([np.column_stack([way, 0.0 * way]), [way[-1], 0.0] + way[1:, None] * [np.cos(angle), np.sin(angle)]])


def moved(row: int, by: float) -> Floats:
    line = wave()
    line[row] += [0.0, by]
    return line


def stepped(by: float) -> Floats:
    line = wave()
    line[60:] += [0.0, by]
    return line


def noise(count: int, size: float, seed: int = 0) -> Floats:
    return np.column_stack([0.5 * np.arange(count), np.zeros(count)]) + np.random.default_rng(seed).normal(size=(count, 2)) * size


#: Lines that no car can follow at any width: they turn on the spot.
TURN_BACK: dict[str, Callable[[], tuple[Floats, bool]]] = {
    "out and back on one line": lambda: (np.vstack([wave(), wave()[::-1][1:]]), False),
    "one step back": lambda: (np.insert(wave(), 61, wave()[60] - [0.01, 0.0], axis=0), False),
    "cusps": lambda: (np.array([[8.0 * (q - np.sin(q)), 8.0 * (1.0 - np.cos(q))] for q in np.linspace(0.0, 20.0, 400)]), False),
    "corner of 179 degrees": lambda: (corner(179.0, 1.0), False),
    "noise beyond its step": lambda: (noise(2000, 0.5), False),
    "random walk": lambda: (np.cumsum(np.random.default_rng(1).normal(size=(5000, 2)), axis=0), False),
    "zigzag": lambda: (np.column_stack([0.5 * np.arange(3000.0), 2.0 * (np.arange(3000) % 2)]), False),
}
#: Lines that are odd and end in a message or in a plan.
ODD: dict[str, Callable[[], tuple[Floats, bool]]] = {
    "a row too many after a loop": lambda: (ring([[0.0, 0.0], [1.0, 0.0]])[1:], True),
    "a point 1 km aside": lambda: (moved(60, 1000.0), False),
    "a point 20 m aside": lambda: (moved(60, 20.0), False),
    "a step of 1 km": lambda: (stepped(1000.0), False),
    "a step of 30 m": lambda: (stepped(30.0), False),
    "corner of 150 degrees": lambda: (corner(150.0, 1.0), False),
    "dense corner of 90 degrees": lambda: (corner(90.0, 0.05), False),
    "two laps": lambda: (np.vstack([ring([]), ring([]) + 0.3]), False),
    "two points": lambda: (np.array([[0.0, 0.0], [100.0, 0.0]]), False),
    "millimetres": lambda: (np.column_stack([1e-4 * np.arange(10.0), np.zeros(10)]), False),
    "a quarter of the globe": lambda: (np.array([[0.0, 0.0], [1e8, 0.0], [2e8, 1e7]]), False),
}


def road_of(points: Floats, closed: bool, half: float = 3.0) -> Road:
    return Road.from_points("odd", points, -half, half, closed=closed)


@pytest.mark.parametrize("name", TURN_BACK)
def test_a_line_that_turns_back_is_refused_before_anything_is_solved(name: str, monkeypatch: pytest.MonkeyPatch):
    def solved(*_: object, **__: object) -> None:
        raise AssertionError("it was planned")

    monkeypatch.setattr("energy_mgr.path.planner.path_in", solved)
    monkeypatch.setattr("energy_mgr.path.planner._follow_lane", solved)
    road = road_of(*TURN_BACK[name]())
    for kind in ("optimal", "lane"):
        with pytest.raises(RoadError, match=r"odd: the road's line turns back on itself near s = [\d.]+ m, at \(.* degrees within"):
            plan_path(road, 1.0, extent="road", kind=kind)


def test_the_place_where_it_turns_back_is_named():
    road = road_of(np.vstack([wave(), wave()[::-1][1:]]), closed=False)
    with pytest.raises(RoadError) as caught:
        refuse_turning_back(road.corridor("road"))
    x, y = wave()[-1]
    words = str(caught.value)
    at = float(words.split("s = ")[1].split(" m")[0])
    # the spline runs past the turning point by a part of its step
    assert abs(at - road.length / 2) < 1.5
    assert np.hypot(*(np.array([float(word) for word in words.split("at (")[1].split(")")[0].split(",")]) - [x, y])) < 1.5


@pytest.mark.parametrize("name", ODD)
@pytest.mark.parametrize("kind", ["optimal", "lane"])
def test_work_is_bounded(name: str, kind, monkeypatch: pytest.MonkeyPatch):
    pairs = [0]
    most = [0]

    def counted(a: Floats, b: Floats, which: NDArray[np.intp], *more: object) -> Floats:
        pairs[0] += len(which)
        most[0] = max(most[0], len(which))
        return distance(a, b, which, *more)  # type: ignore[arg-type]

    distance = certificate._distance
    monkeypatch.setattr(certificate, "_distance", counted)
    road = road_of(*ODD[name]())
    made, words = None, ""
    try:
        made = plan_path(road, 1.0, extent="road", kind=kind)
    except (RoadError, PlanningError) as error:
        words = str(error)
    if made is None:
        assert words.startswith("odd: ")
    else:
        assert made.report.certified or kind == "lane"  # the lane's centre may be a millimetre beyond
    # easy roads take 10 to 100 pairs per metre and proof; a corner takes a thousand per metre of a short road, in up to thirty proofs
    assert pairs[0] <= 50_000 * road.length
    # what is looked at together bounds the memory: some 200 bytes a pair
    assert most[0] <= 1_100_000


@pytest.mark.parametrize(("radius", "half"), [(6.0, 3.0), (3.0, 3.0), (3.0, 10.0), (1.5, 10.0)])
def test_hairpins_whose_inner_border_folds_are_no_such_lines(radius: float, half: float):
    way, turn = np.arange(0.0, 60.0), np.linspace(0.0, np.pi, 9)[1:-1]
    bend = np.column_stack([60.0 + radius * np.sin(turn), radius - radius * np.cos(turn)])
    points = np.vstack([np.column_stack([way, 0.0 * way]), bend, np.column_stack([way[::-1], 0.0 * way + 2.0 * radius])])
    made = plan_path(road_of(points, closed=False, half=half), 1.0, extent="road")
    assert made.report.certified


def test_a_turn_that_two_points_draw_is_planned():
    # its one piece turns by 185 degrees, with a radius of 0.9 m: crude bounds of its curvature would call it a cusp
    way = np.arange(140.0, 200.0)
    out = np.column_stack([way, 5.0 * np.sin(way / 30.0)])
    back = out[::-1] + np.array([0.3, 6.0])
    made = plan_path(road_of(np.vstack([out, back]), closed=False, half=5.0), 1.0, extent="road")
    assert made.report.certified


def test_bounds_of_a_piece_that_turns_far_hold():
    # one cubic that turns by more than a right angle: the bound on its border's bend must still bound what is there
    road = road_of(np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 6.0], [0.0, 6.0]]), closed=False)
    corridor = road.corridor("road")
    for line, offset in zip(border_lines(corridor, 2e-3), (-3.0, 3.0), strict=True):
        s = np.linspace(line.s[0], line.s[-1], 20_001)
        true = road.reference.position(s) + offset * road.reference.normal(s)
        piece = np.clip(np.searchsorted(line.s, s, side="right") - 1, 0, len(line.s) - 2)
        share = ((s - line.s[piece]) / np.diff(line.s)[piece])[:, None]
        chord = line.points[piece] * (1.0 - share) + line.points[piece + 1] * share
        # beyond this the border folds and is drawn in
        inside = np.sign(offset) * road.reference.curvature(s) * abs(offset) < 0.9
        assert inside.any()
        assert np.all(np.hypot(*(chord - true).T)[inside] <= line.sag[piece][inside] + 1e-6)
