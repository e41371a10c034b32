"""Cones of two colours as edges."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import energy_mgr
import roads
from roads import PlanarCurve, Road, RoadError

Floats = np.ndarray


def circuit() -> PlanarCurve:
    """A circuit with a hairpin whose legs are 12 m apart, left-hand round."""
    corners = [[0, 0], [60, 0], [80, 12], [70, 28], [45, 24], [24, 22], [20, 28], [24, 34], [45, 36], [70, 44], [60, 60], [0, 60], [-22, 30]]
    return PlanarCurve.through(np.array(corners, dtype=float), closed=True)


def cones_of(curve: PlanarCurve, spacing: float = 4.0, half: float = 1.5, end: float | None = None) -> tuple[Floats, Floats]:
    """Left and right cones beside a curve, each edge's own `spacing` apart."""
    s = np.linspace(0.0, end or curve.length, 4000, endpoint=not curve.closed)
    edges = []
    for side in (1.0, -1.0):
        line = curve.position(s) + side * half * curve.normal(s)
        way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
        edges.append(line[np.searchsorted(way, np.arange(0.0, way[-1] - 0.6 * spacing * curve.closed, spacing))])
    return edges[0], edges[1]


def written(
    path: Path, left: Floats, right: Floats, words: tuple[str, str] = ("blue", "yellow"), *, head: str = "x,y,color", seed: int | None = None
):
    rows = [(x, y, words[0]) for x, y in left.tolist()] + [(x, y, words[1]) for x, y in right.tolist()]
    if seed is not None:
        rows = [rows[k] for k in np.random.default_rng(seed).permutation(len(rows))]
    names = head.split(",")
    (label,) = set(names) - {"x", "y"}
    cells = [{"x": f"{x:.3f}", "y": f"{y:.3f}", label: word} for x, y, word in rows]
    path.write_text(head + "\n" + "\n".join(",".join(cell[name] for name in names) for cell in cells) + "\n")
    return path


def beside(road: Road, curve: PlanarCurve) -> tuple[Floats, Floats]:
    """Offsets of the road's edges from `curve`, station by station."""
    s = np.linspace(0.0, road.length, 500, endpoint=not road.closed)
    right, left = np.interp(s, road.s, road.right), np.interp(s, road.s, road.left)
    place, normal = road.reference.position(s), road.reference.normal(s)
    return curve.locate(place + right[:, None] * normal)[1], curve.locate(place + left[:, None] * normal)[1]


@pytest.mark.parametrize("seed", [None, 1, 2])
@pytest.mark.parametrize("spacing", [2.0, 4.0])
def test_edges_of_a_circuit_are_found_whatever_the_order_of_the_rows(tmp_path: Path, seed: int | None, spacing: float):
    curve = circuit()
    road = roads.read(written(tmp_path / "a.csv", *cones_of(curve, spacing), seed=seed))
    assert road.closed
    # the polygon through the cones is shorter than the curve inside bends
    assert road.length == pytest.approx(curve.length, rel=0.02)
    right, left = beside(road, curve)
    # the line between two cones lies spacing^2 / 8 R inside a border of radius R
    tightest = 1.0 / float(np.max(np.abs(curve.curvature(np.linspace(0.0, curve.length, 2000))))) - 1.5
    sag = spacing**2 / (8.0 * tightest) + 0.1
    assert sag < 1.0
    assert np.max(np.abs(right + 1.5)) < sag
    assert np.max(np.abs(left - 1.5)) < sag
    [note] = road.findings
    assert note.severity == "note"


def test_noise_and_missing_cones_do_no_harm(tmp_path: Path):
    curve = circuit()
    rng = np.random.default_rng(4)
    left, right = (edge + rng.normal(0.0, 0.1, edge.shape) for edge in cones_of(curve, 3.0))
    road = roads.read(written(tmp_path / "a.csv", np.delete(left, [5, 20, 33], axis=0), np.delete(right, [11, 40], axis=0), seed=3))
    edges = beside(road, curve)
    assert max(np.max(np.abs(edges[0] + 1.5)), np.max(np.abs(edges[1] - 1.5))) < 1.0
    # what is driven bends as the circuit does, not as the noise
    assert np.max(np.abs(road.lane_centre().curvature(np.linspace(0.0, road.length, 2000)))) < 0.5


def test_blue_is_left_and_the_road_starts_at_the_orange_cones(tmp_path: Path):
    curve = circuit()
    left, right = cones_of(curve)
    gate = curve.position(80.0) + np.array([[2.0], [-2.0]]) * curve.normal(80.0)
    path = written(tmp_path / "a.csv", left, right, seed=5)
    path.write_text(path.read_text() + "".join(f"{x:.3f},{y:.3f},orange\n" for x, y in gate))
    road = roads.read(path)
    assert np.hypot(*(road.reference.position(0.0) - curve.position(80.0))) < 3.0
    assert road.reference.tangent(0.0) @ curve.tangent(80.0) > 0.9
    assert "2 orange cones or marks of the start" in road.findings[0].message
    # with the colours exchanged it is driven the other way round
    turned = roads.read(written(tmp_path / "b.csv", left, right, ("yellow", "blue"), seed=5))
    s = turned.reference.locate([curve.position(80.0)])[0][0]
    assert turned.reference.tangent(s) @ curve.tangent(80.0) < -0.9


@pytest.mark.parametrize("words", [("0", "1"), ("red", "white"), ("1", "0")])
@pytest.mark.parametrize("backward", [False, True])
def test_other_words_are_told_apart_by_the_order_of_the_rows(tmp_path: Path, words: tuple[str, str], backward: bool):
    curve = circuit()
    left, right = cones_of(curve)
    road = roads.read(written(tmp_path / "a.csv", left[::-1], right[::-1], words) if backward else written(tmp_path / "a.csv", left, right, words))
    s = road.reference.locate([curve.position(80.0)])[0][0]
    assert (road.reference.tangent(s) @ curve.tangent(80.0)) * (-1.0 if backward else 1.0) > 0.9
    assert "the order of the rows does" in road.findings[0].message


@pytest.mark.parametrize("head", ["tag,x,y", "y,x,side", "class,y,x"])
def test_columns_stand_in_any_order(tmp_path: Path, head: str):
    words = ("left", "right") if "side" in head else ("blue", "yellow")
    road = roads.read(written(tmp_path / "a.csv", *cones_of(circuit()), words, head=head))
    assert road.length == pytest.approx(circuit().length, rel=0.02)
    text = (tmp_path / "a.csv").read_text()
    if head == "tag,x,y":
        (tmp_path / "b.csv").write_text(text.split("\n", 1)[1])
        assert roads.read(tmp_path / "b.csv").length == road.length


def test_an_open_road_ends_where_its_cones_do(tmp_path: Path):
    s = np.arange(0.0, 80.0, 2.0)
    curve = PlanarCurve.through(np.column_stack([s, 12.0 * np.sin(s / 25.0)]))
    road = roads.read(written(tmp_path / "a.csv", *cones_of(curve, 4.0, 2.0), seed=6))
    assert not road.closed
    assert road.length == pytest.approx(curve.length, abs=4.0)
    right, left = beside(road, curve)
    assert max(np.max(np.abs(right + 2.0)), np.max(np.abs(left - 2.0))) < 0.4
    assert road.reference.position(0.0)[0] < 4.0


def test_it_is_planned(tmp_path: Path):
    road = roads.read(written(tmp_path / "a.csv", *cones_of(circuit(), 4.0, 2.5), seed=7))
    path = energy_mgr.plan(road, "romo", corridor="road", margin=0.1).chosen.path
    assert path.report.certified
    roads.write(road, tmp_path / "copy.csv")
    assert roads.read(tmp_path / "copy.csv").length == pytest.approx(road.length, abs=0.05)


def test_bad_sets_are_refused_with_the_line(tmp_path: Path):
    left, right = cones_of(circuit())
    none = np.zeros((0, 2))
    with pytest.raises(RoadError, match=r"a\.csv: holds cones \d+ blue; expected two colours"):
        roads.read(written(tmp_path / "a.csv", left, none))
    with pytest.raises(RoadError, match=rf"a\.csv:{len(left) + 3}: one of 2 cones called 'yellow', expected at least 3"):
        roads.read(written(tmp_path / "a.csv", left, right[:2]))
    with pytest.raises(RoadError, match=r"a\.csv:\d+: \d+ of \d+ cones lie beside the longest way .* expected edges without gaps"):
        roads.read(written(tmp_path / "a.csv", left, right[: len(right) // 3]))
    far = np.array([[1.0 * k, 0.0] for k in range(6)])
    with pytest.raises(RoadError, match="the cones lie on one line"):
        roads.read(written(tmp_path / "a.csv", far, far + np.array([10.0, 0.0])))
    path = written(tmp_path / "a.csv", left, right)
    path.write_text(path.read_text().replace(f"{left[3, 0]:.3f},", "nan,", 1))
    with pytest.raises(RoadError, match=r"a\.csv:5: x is 'nan', expected a finite number"):
        roads.read(path)
    way = np.column_stack([np.arange(5001.0), np.zeros(5001)])
    with pytest.raises(RoadError, match=r"a\.csv: holds 10002 cones, expected at most 10000"):
        roads.read(written(tmp_path / "a.csv", way, way + np.array([0.0, 3.0])))
    with pytest.raises(RoadError, match="cones are the edges, leave width, lane"):
        roads.read(written(tmp_path / "a.csv", left, right), width=7.0)


def test_a_stray_cone_is_left_out_with_a_word(tmp_path: Path):
    left, right = cones_of(circuit())
    road = roads.read(written(tmp_path / "a.csv", np.vstack([left, [[200.0, 200.0]]]), right))
    [finding] = road.findings
    assert finding.severity == "warning"
    assert f"1 cones beside the way are left out (lines {len(left) + 2})" in finding.message
