"""Rows of path tables whose station, time or place contradicts those beside them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import roads
from roads import RoadError
from roads.formats.tables.order import in_order

from ... import samples

HEAD = "s,x,y,psi,v,kappa"


def loop(length: float = 150.0, count: int = 150) -> np.ndarray:
    """Rows `s x y psi v kappa` of a circle that starts in (0, 0), its end repeating its start."""
    s = np.linspace(0.0, length, count + 1)
    radius = length / (2.0 * np.pi)
    psi = s / radius
    return np.column_stack([s, radius * np.sin(psi), radius * (1.0 - np.cos(psi)), psi, 0.0 * s + 10.0, 0.0 * s + 1.0 / radius])


def written(path: Path, rows: np.ndarray, head: str | None = HEAD) -> Path:
    lines = [",".join(f"{value:.6f}" for value in row) for row in rows]
    path.write_text("\n".join(([] if head is None else [head]) + lines) + "\n")
    return path


def warnings(made: roads.Road) -> list[str]:
    return [str(finding) for finding in made.findings if finding.severity == "warning"]


@pytest.mark.parametrize("head", [HEAD, None])
def test_a_row_after_the_end_of_a_loop_is_left_out_with_a_word(tmp_path: Path, head: str | None):
    rows = np.vstack([loop(), [4999.0, 1.0, 0.0, 0.0, 0.0, 0.0]])
    made = roads.read(written(tmp_path / "a.csv", rows, head), lane=3.5, width=7.0)
    assert made.closed
    assert made.length == pytest.approx(150.0, abs=0.02)
    line = len(rows) + (head is not None)
    [words] = warnings(made)
    assert words.startswith(f"warning: {tmp_path / 'a.csv'}:{line}: its station 4999 is 4849 from that of the row beside it, its place 1 m: ")
    assert len(made.columns["v"]) == 150


@pytest.mark.parametrize("kind", ["matrix", "vectors", "struct"])
def test_the_same_in_matlab_names_the_row(tmp_path: Path, kind: str):
    from scipy.io import savemat

    rows = np.vstack([loop(), [4999.0, 1.0, 0.0, 0.0, 0.0, 0.0]])
    vectors = dict(zip(HEAD.split(","), rows.T, strict=True))
    values = {"matrix": {"path": rows}, "vectors": vectors, "struct": {"path": vectors}}[kind]
    savemat(tmp_path / "a.mat", values)
    made = roads.read(tmp_path / "a.mat")
    assert (made.closed, len(made.s)) == (True, 150)
    assert warnings(made)[0].startswith(f"warning: {tmp_path / 'a.mat'}: row 152: its station 4999")


@pytest.mark.parametrize("at", [0, 40, 149])
@pytest.mark.parametrize("run", [1, 2, 3])
def test_rows_from_elsewhere_are_left_out_wherever_they_stand(tmp_path: Path, at: int, run: int):
    straight = np.array([[k, 1.0 * k, 0.02 * k, 0.0, 10.0, 0.0] for k in range(150)])
    wrong = np.array([[-50.0 - 7 * k, 400.0 + 90 * k, 0.0, 0.0, 0.0, 0.0] for k in range(run)])
    rows = np.insert(straight, at, wrong, axis=0) if at < 149 else np.vstack([straight, wrong])
    made = roads.read(written(tmp_path / "a.csv", rows))
    assert len(made.s) == 150
    assert np.max(np.abs(made.reference.curvature(made.s))) < 1e-4
    assert len(warnings(made)) == run
    first = (at if at < 149 else 150) + 2
    assert f"a.csv:{first}: " in warnings(made)[0]


def test_a_wrong_station_beside_a_good_place_leaves_the_place(tmp_path: Path):
    rows = loop()
    rows[70, 0] = 0.0
    made = roads.read(written(tmp_path / "a.csv", rows))
    assert len(made.s) == 150
    [words] = warnings(made)
    assert "a.csv:72: its station 0 is 69 from that of the row beside it, its place 1 m: the place is used" in words


def test_a_row_that_repeats_the_first_one_is_no_fault(tmp_path: Path):
    rows = np.vstack([loop()[:-1], loop()[0]])
    made = roads.read(written(tmp_path / "a.csv", rows))
    assert (made.closed, len(made.s), warnings(made)) == (True, 150, [])
    assert any("a.csv:152: " in str(finding) and "repeats the first row" in str(finding) for finding in made.findings)


@pytest.mark.parametrize(
    ("count", "words"),
    [
        (lambda s: s, None),
        (lambda s: s + 731.5, None),
        (lambda s: np.round(s), None),
        (lambda s: s / 1000.0, "counts 0.001 for each metre"),
        (lambda s: 150.0 - s, "decreases along the rows"),
        (lambda s: s**2, "do not count the way"),
        (lambda s: 0.0 * s, "do not count the way"),
        (lambda s: np.random.default_rng(3).uniform(0.0, 150.0, len(s)), "do not count the way"),
        (lambda s: np.mod(s, 50.5), "the station jumps by -49.5 where the place moves by 1 m"),
    ],
)
def test_stations_of_another_kind_cost_no_row(tmp_path: Path, count, words: str | None):
    rows = loop()
    rows[:, 0] = count(rows[:, 0])
    made = roads.read(written(tmp_path / "a.csv", rows[:-1]), lane=3.5)
    assert len(made.s) == 150
    found = [str(finding) for finding in made.findings]
    assert (found == []) if words is None else any(words in one and "a.csv" in one for one in found)
    assert len(found) <= 5


def test_times_that_go_back_and_places_far_off(tmp_path: Path):
    rows = np.array([[0.1 * k, 1.0 * k, 0.01 * k * k] for k in range(60)])
    rows[20, 1:] += [0.0, 300.0]
    made = roads.read(written(tmp_path / "a.csv", np.vstack([rows, [0.0, 0.0, 0.0]]), "t,x,y"))
    assert len(made.s) == 59
    found = warnings(made)
    assert any("a.csv:62: its time 0 s breaks the order" in words and "left out" in words for words in found)
    assert any("a.csv:22: its place lies" in words and "left out" in words for words in found)


def test_jumps_at_an_end_are_named_and_used(tmp_path: Path):
    rows = np.array([[1.0 * k, 0.01 * k * k, 0.0, 9.0] for k in range(40)] + [[1.0, -30.0, 0.0, 0.0]])
    made = roads.read(written(tmp_path / "a.csv", rows, "x,y,psi,v"))
    assert len(made.s) == 41
    assert any("a.csv:42: its place lies" in words and "is the row part of the road?" in words for words in warnings(made))


@settings(deadline=None, max_examples=60)
@given(seed=st.integers(0, 2**32 - 1), scale=st.sampled_from([1.0, -1.0, 0.001, 3.28]), bad=st.integers(0, 3))
def test_good_rows_are_never_left_out(seed: int, scale: float, bad: int):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(30, 200))
    heading = np.cumsum(rng.normal(0.0, 0.1, count))
    step = rng.uniform(0.5, 1.5, count)[:, None]
    points = np.cumsum(step * np.column_stack([np.cos(heading), np.sin(heading)]), axis=0)
    stations = scale * np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    wrong = rng.choice(np.arange(5, count - 5, 8), bad, replace=False)
    stations[wrong] += scale * rng.choice([-1, 1], bad) * rng.uniform(30.0, 3000.0, bad)
    points[wrong] += rng.choice([-1, 1], (bad, 2)) * rng.uniform(30.0, 3000.0, (bad, 2))
    found = in_order(points, stations, None, str)
    assert sorted(np.flatnonzero(~found.keep).tolist()) == sorted(wrong.tolist())


def test_two_columns_are_a_line(tmp_path: Path):
    for head in (None, "x,y", "x_m,y_m", "X;Y"):
        text = written(tmp_path / "a.csv", loop()[:60, 1:3], head and head.replace(";", ",")).read_text()
        (tmp_path / "a.csv").write_text(text.replace(",", ";") if head and ";" in head else text)
        assert roads.read(tmp_path / "a.csv").length == pytest.approx(59.0, abs=0.02)


def test_one_lane_where_nothing_is_said(tmp_path: Path):
    path = samples.path_csv(tmp_path)
    made = roads.read(path)
    assert [lane.direction for lane in made.lanes] == [1]
    assert (made.right[0], made.left[0]) == (-1.75, 1.75)
    [note] = made.findings
    assert note.severity == "note"
    assert "one lane 3.5 m wide about it is assumed" in note.message


@pytest.mark.parametrize(
    ("lane", "width", "edges", "lanes", "assumed"),
    [
        (3.0, None, (-1.5, 1.5), 1, False),
        (None, 4.0, (-2.0, 2.0), 1, True),
        (None, 6.0, (-1.5, 4.5), 2, True),
        (None, 9.0, (-1.75, 7.25), 2, True),
        (3.0, 7.0, (-1.5, 5.5), 2, False),
    ],
)
def test_lane_or_width_alone(tmp_path: Path, lane: float | None, width: float | None, edges: tuple[float, float], lanes: int, assumed: bool):
    made = roads.read(samples.path_csv(tmp_path), lane=lane, width=width)
    assert (made.right[0], made.left[0], len(made.lanes)) == (*edges, lanes)
    assert bool(made.findings) == assumed


def test_widths_that_are_none_are_refused(tmp_path: Path):
    for bad in ({"lane": 0.2}, {"width": -1.0}, {"lane": 5.0, "width": 4.0}, {"lane": float("nan")}):
        with pytest.raises(RoadError, match="expected 0.5 <= lane <= width <= 1000"):
            roads.read(samples.path_csv(tmp_path), **bad)
