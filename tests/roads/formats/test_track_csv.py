from pathlib import Path

import numpy as np
import pytest

import roads
from roads import RoadError

HEAD = "# x_m,y_m,w_tr_right_m,w_tr_left_m"


def write(path: Path, rows: list[tuple[object, ...]], head: str = HEAD) -> Path:
    path.write_text("\n".join([head, *(",".join(map(str, row)) for row in rows)]) + "\n")
    return path


def test_plain_tum_file_reads(tmp_path: Path, straight_rows: list[tuple[float, ...]]):
    road = roads.read(write(tmp_path / "plain.csv", straight_rows))
    assert (road.name, road.closed, road.length) == ("plain", False, pytest.approx(295.0))
    assert np.all(road.right == -3.5)
    assert np.all(road.left == 3.5)
    assert len(road.lanes) == 1


@pytest.mark.parametrize("repeat_first", [False, True])
def test_circuits_are_recognised_with_or_without_the_first_point_repeated(tmp_path: Path, repeat_first: bool):
    angle = np.linspace(0, 2 * np.pi, 100, endpoint=False)
    rows = [(50 * np.cos(a), 50 * np.sin(a), 4, 4) for a in angle]
    road = roads.read(write(tmp_path / "ring.csv", rows + rows[:1] * repeat_first))
    assert road.closed
    assert len(road.s) == 100
    assert road.length == pytest.approx(2 * np.pi * 50, rel=1e-6)
    assert not roads.read(tmp_path / "ring.csv", closed=False).closed


def test_open_u_turn_whose_ends_come_close_stays_open(tmp_path: Path):
    legs = [(4.0 * k, 0.0) for k in range(16)]
    turn = [(60 + 4 * np.sin(a), 4 - 4 * np.cos(a)) for a in np.linspace(0, np.pi, 6)[1:]]
    back = [(60 - 4.0 * k, 8.0) for k in range(1, 16)]
    rows = [(x, y, 2.0, 2.0) for x, y in legs + turn + back]
    assert not roads.read(write(tmp_path / "u.csv", rows)).closed
    assert roads.read(write(tmp_path / "u.csv", rows), closed=True).closed


def test_file_without_header_and_with_semicolons(tmp_path: Path, straight_rows: list[tuple[float, ...]]):
    (tmp_path / "a.csv").write_text("\n".join(";".join(map(str, row)) for row in straight_rows))
    assert roads.read(tmp_path / "a.csv").length == pytest.approx(295.0)


def test_road_over_itself_on_a_bridge_is_allowed(tmp_path: Path):
    angle = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    flat = [(100 * np.sin(a), 100 * np.sin(a) * np.cos(a), 4, 4) for a in angle]
    road = roads.read(write(tmp_path / "eight.csv", flat))
    [finding] = road.findings
    assert finding.severity == "warning"
    assert finding.place == f"{tmp_path / 'eight.csv'}:101"
    assert finding.message.startswith("the road crosses itself at (0.0, 0.0) m, where line 2 passed on the same level, s = ")
    assert "taken as a bridge" in finding.message
    assert "column z_m" in finding.message
    bridge = [(*row, 3 * (1 + np.cos(a))) for row, a in zip(flat, angle, strict=True)]
    made = roads.read(write(tmp_path / "bridge.csv", bridge, HEAD + ",z_m"))
    assert made.closed
    assert made.findings == ()


@pytest.mark.parametrize("name", roads.shipped())
def test_write_and_read_give_the_same_road(tmp_path: Path, name: str):
    road = roads.open_road(name)
    roads.write(road, tmp_path / "copy.csv")
    copy = roads.read(tmp_path / "copy.csv")
    s = np.linspace(0, road.length, 500)
    assert np.max(np.abs(copy.reference.position(s) - road.reference.position(s))) < 1e-3
    assert np.max(np.abs(copy.height_at(s) - road.height_at(s))) < 1e-3
    assert copy.lanes[0].direction == 1
    assert copy.name == name
    assert [file.name for file in tmp_path.iterdir()] == ["copy.csv"]


CASES: dict[str, tuple[list[tuple[object, ...]], str, str]] = {
    "no data": ([], HEAD, r"bad\.csv: no data"),
    "three columns": ([(0, 0, 3)], HEAD, r"bad\.csv:2: 3 columns, expected 4"),
    "nan": ([(0, 0, 3, 3), (1, "nan", 3, 3)], HEAD, r"bad\.csv:3: y_m is 'nan', expected a finite number"),
    "text": ([(0, 0, 3, 3), (1, "abc", 3, 3)], HEAD, r"bad\.csv:3: y_m is 'abc'"),
    "infinite": ([(0, 0, 3, 3), (1, "1e999", 3, 3)], HEAD, r"bad\.csv:3: y_m is '1e999'"),
    "repeated": ([(0, 0, 3, 3), (5, 0, 3, 3), (5, 0, 3, 3)], HEAD, r"bad\.csv:4: repeats the point of line 3"),
    "one point": ([(0, 0, 3, 3)], HEAD, "1 points, expected at least 2"),
    "crossing borders": ([(0, 0, 3, 3), (5, 0, -4, 3)], HEAD, r"bad\.csv:3: the borders cross"),
    "unknown column": ([(0, 0, 3, 3, 1)], HEAD + ",wind", r"bad\.csv:1: columns .*wind, expected"),
    "missing column": ([(0, 0, 3)], "# x_m,y_m,w_tr_right_m", r"bad\.csv:1: columns"),
    "zero limit": ([(0, 0, 3, 3, 0), (5, 0, 3, 3, 1)], HEAD + ",speed_limit_mps", r"bad\.csv:2: speed_limit_mps is 0"),
    "absurd number": ([(0, 0, 3, 3), (1e300, 0, 3, 3)], HEAD, r"bad\.csv:3: x_m is '1e\+300', expected a finite number below"),
    "lane beside the road": (
        [(0, 0, 3, 3), (5, 0, 3, 3)],
        "# lanes: forward -9 -5\n" + HEAD,
        "bad.csv: bad: lane from -9 to -5 m .* within the road",
    ),
    "closed neither way": ([(0, 0, 3, 3), (5, 0, 3, 3)], "# closed: maybe\n" + HEAD, "closed is 'maybe', expected true or false"),
    "lane": ([(0, 0, 3, 3), (5, 0, 3, 3)], "# lanes: forward 1 0\n" + HEAD, "lane 'forward 1 0', expected"),
    "no lane this way": ([(0, 0, 3, 3), (5, 0, 3, 3)], "# lanes: backward 0 1\n" + HEAD, "at least one forward lane"),
}


@pytest.mark.parametrize("case", CASES)
def test_bad_files_are_refused_with_place_and_expectation(tmp_path: Path, case: str):
    rows, head, words = CASES[case]
    with pytest.raises(RoadError, match=words) as caught:
        roads.read(write(tmp_path / "bad.csv", rows, head))
    assert "\n" not in str(caught.value)


def test_files_that_are_none_are_refused(tmp_path: Path):
    with pytest.raises(RoadError, match="no such file"):
        roads.read(tmp_path / "none.csv")
    with pytest.raises(RoadError, match="unknown road format '.png'"):
        roads.read(tmp_path / "none.png")
    (tmp_path / "bytes.csv").write_bytes(bytes(range(256)))
    with pytest.raises(RoadError, match="not a text file"):
        roads.read(tmp_path / "bytes.csv")
    with pytest.raises(RoadError, match="no shipped road, expected a road file or one of commute, descent, handling"):
        roads.open_road("nowhere")


def test_a_point_far_off_the_line_is_left_out_with_a_word(tmp_path: Path, straight_rows: list[tuple[float, ...]]):
    rows = [*straight_rows[:20], (97.0, 800.0, 3.5, 3.5), *straight_rows[20:]]
    road = roads.read(write(tmp_path / "far.csv", rows))
    assert road.length == pytest.approx(295.0)
    [finding] = road.findings
    assert finding.severity == "warning"
    assert finding.place == f"{tmp_path / 'far.csv'}:22"
    assert "800.0 m off the rows beside it" in finding.message
