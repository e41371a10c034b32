"""Bridges and folds: where a road crosses itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import roads
from roads import Road, RoadError
from roads.crossings import crossings_of

HEAD = "x_m,y_m,w_tr_right_m,w_tr_left_m"


def eight(size: float = 130.0, count: int = 320) -> np.ndarray:
    """A lemniscate; it passes its middle between two of its points."""
    a = 2.0 * np.pi * (np.arange(count) + 0.3) / count
    return size * np.column_stack([np.sin(a), np.sin(a) * np.cos(a)])


def loop(radius: float, lead: float = 60.0) -> np.ndarray:
    """Straight on, a full turn to the left, and on: the second passage crosses the first at a right angle."""
    turn = np.linspace(0.0, 1.5 * np.pi, max(int(1.5 * np.pi * radius / 2.0), 12))
    way = np.arange(2.0, lead, 2.0)
    arc = np.column_stack([lead + radius * np.sin(turn), radius - radius * np.cos(turn)])
    into = np.column_stack([way, 0.0 * way])
    out = np.column_stack([0.0 * way + arc[-1, 0], arc[-1, 1] - way])
    return np.vstack([into, arc, out])


def place(point: int) -> str:
    return f"a.csv:{point + 2}"


def track(path: Path, points: np.ndarray, half: float, more: np.ndarray | None = None) -> Path:
    columns = [points, np.full((len(points), 2), half)] + ([] if more is None else [more[:, None]])
    rows = "\n".join(",".join(f"{value:.4f}" for value in row) for row in np.column_stack(columns))
    path.write_text(HEAD + ("" if more is None else ",z_m") + "\n" + rows + "\n")
    return path


@pytest.mark.parametrize(("points", "closed", "angle"), [(eight(), True, 90.0), (loop(40.0), False, 90.0), (loop(15.0), False, 90.0)])
def test_a_clear_crossing_is_a_bridge_with_a_word(points: np.ndarray, closed: bool, angle: float):
    road = Road.from_points("x", points, -4.0, 4.0, closed=closed)
    [finding] = crossings_of(road, place)
    assert finding.severity == "warning"
    assert f"at {angle:.0f} degrees: taken as a bridge" in finding.message
    assert "z_m" in finding.message
    # the two stations that it names are at one place, far apart along the road
    one, other = (float(word.split()[0]) for word in finding.message.split("s = ")[1].split(" and "))
    assert np.hypot(*(road.reference.position(one) - road.reference.position(other))) < 0.3
    assert abs(one - other) > 60.0


def weave(amplitude: float, apart: float) -> np.ndarray:
    """Out along a line and round and back over it, crossing it again and again."""
    s = np.arange(0.0, 300.0, 3.0)
    turn = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 30)[1:-1]
    back = np.column_stack([s, 60.0 * (1.0 - np.cos(s / 300.0 * np.pi)) / 2.0 - 60.0 + apart + amplitude * np.sin(s / 8.0)])
    return np.vstack([np.column_stack([s, 0.0 * s]), np.column_stack([300.0 + 30.0 * np.cos(turn), -30.0 * (1.0 + np.sin(turn))])[::1], back[::-1]])


@pytest.mark.parametrize(
    ("points", "half", "words"),
    [
        (loop(5.0), 3.0, r"it folds, \d+ m of road are too little to come round"),
        (np.vstack([eight()[1:], eight() + np.array([0.4, 0.0])]), 4.0, "it folds, passages beside each other cannot be told apart"),
        (weave(12.0, 60.0), 4.0, "it folds, "),
    ],
)
def test_folds_are_refused_with_the_place(points: np.ndarray, half: float, words: str):
    road = Road.from_points("x", points, -half, half)
    with pytest.raises(RoadError, match=rf"a\.csv:\d+: the road crosses itself at \(.*\) m, where line \d+ passed.*{words}"):
        crossings_of(road, place)
    found = crossings_of(road, place, refuse=False)
    assert any("it folds" in finding.message for finding in found)
    assert len(found) <= 5


def test_a_tangle_is_no_road():
    road = Road.from_points("x", np.cumsum(np.random.default_rng(2).normal(size=(20_000, 2)), axis=0), -3.0, 3.0)
    with pytest.raises(RoadError, match="x: the line crosses itself more than 300 times"):
        crossings_of(road, place)
    [finding] = crossings_of(road, place, refuse=False)
    assert "more than 300 times" in finding.message


def test_heights_tell(tmp_path: Path):
    points, height = eight(), 2.0 * (1.0 - np.cos(2.0 * np.pi * np.arange(320) / 320))
    for scale, count in ((1.0, 0), (0.5, 1)):
        made = roads.read(track(tmp_path / "a.csv", points, 4.0, scale * height))
        assert len(made.findings) == count
    folded = loop(5.0)
    with pytest.raises(RoadError, match="it folds"):
        roads.read(track(tmp_path / "b.csv", folded, 3.0))


def test_a_level_without_crossing_has_no_finding():
    angle = np.linspace(0.0, 2.0 * np.pi, 100, endpoint=False)
    ring = Road.from_points("x", 50.0 * np.column_stack([np.cos(angle), np.sin(angle)]), -3.0, 3.0, closed=True)
    assert crossings_of(ring, place) == ()


def test_edges_and_path_tables_say_so_too(tmp_path: Path):
    points = eight()
    road = Road.from_points("x", points, -4.0, 4.0, closed=True)
    normal = road.reference.normal(road.s)
    rows = np.column_stack([points + 4.0 * normal, points - 4.0 * normal])
    text = "left_x_m,left_y_m,right_x_m,right_y_m\n" + "\n".join(",".join(f"{value:.5f}" for value in row) for row in rows)
    (tmp_path / "edges.csv").write_text(text)
    (tmp_path / "path.csv").write_text("x,y\n" + "\n".join(f"{x:.5f},{y:.5f}" for x, y in points))
    for name in ("edges", "path"):
        found = roads.read(tmp_path / f"{name}.csv").findings
        assert [finding.place for finding in found if "taken as a bridge" in finding.message] == [f"{tmp_path / name}.csv:321"]
