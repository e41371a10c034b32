"""Every format is read right: against the road that the samples were made from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import roads
from roads import Road, RoadError

from .. import samples

#: The samples hold 41 points of the bend, 4.5 m apart; a spline through them cuts the clothoids by this much, m.
SAMPLED = 5e-3


def compare(road: Road, edge: float = 3.5) -> None:
    true = samples.bend()
    for side in (1.0, -1.0):
        border = road.left if side > 0 else road.right
        points = road.reference.position(road.s) + border[:, None] * road.reference.normal(road.s)
        _, off = true.reference.locate(points)
        inner = slice(2, -2)
        assert np.max(np.abs(off[inner] - side * edge)) < SAMPLED


def moved(road: Road) -> float:
    """Farthest that the road's reference lies from the true one, m."""
    _, off = samples.bend().reference.locate(road.reference.position(np.linspace(0.0, road.length, 500)))
    return float(np.max(np.abs(off)))


def test_edges_csv(tmp_path: Path):
    road = roads.read(samples.edges(tmp_path))
    compare(road)
    assert road.name == "bend"
    assert road.height_at(50.0) == 500.0


def test_edges_may_be_named_the_other_way_round_and_banked(tmp_path: Path):
    text = "x_left_m;y_left_m;x_right_m;y_right_m;z_left_m;z_right_m\n" + "\n".join(f"{5 * k};2;{5 * k};-2;0.4;0" for k in range(10))
    (tmp_path / "a.csv").write_text(text)
    road = roads.read(tmp_path / "a.csv")
    assert np.allclose(road.left, 2.0)
    assert np.allclose(np.tan(road.bank), 0.1)
    (tmp_path / "b.csv").write_text(
        text.replace("x_left", "q")
        .replace("x_right", "x_left")
        .replace("q", "x_right")
        .replace(";2;", ";9;")
        .replace(";-2;", ";2;")
        .replace(";9;", ";-2;")
    )
    with pytest.raises(RoadError, match="left edge is not left of the right one"):
        roads.read(tmp_path / "b.csv")


@pytest.mark.parametrize(
    "names", [("s", "x", "y", "psi", "v", "kappa"), ("x", "y", "psi", "v"), ("s", "x", "y", "psi", "v"), ("t", "s", "x", "y", "psi", "v", "kappa")]
)
@pytest.mark.parametrize("header", [True, False])
def test_path_tables_by_name_and_by_order(tmp_path: Path, names: tuple[str, ...], header: bool):
    road = roads.read(samples.path_csv(tmp_path, names, header=header), lane=3.5, width=7.0)
    assert moved(road) < SAMPLED
    # the path is the middle of the right lane
    assert (road.right[0], road.left[0]) == (-1.75, 5.25)
    columns = samples.path_columns()
    assert np.allclose(road.columns["v"], columns["v"], atol=1e-6)
    assert np.allclose(road.columns["psi"], columns["psi"], atol=1e-6)
    if "t" in names:
        assert np.allclose(road.columns["t"], columns["t"], atol=1e-6)


def test_racing_line_of_f1tenth(tmp_path: Path):
    columns = samples.path_columns()
    head = "# s_m; x_m; y_m; psi_rad; kappa_radpm; vx_mps; ax_mps2\n"
    rows = np.column_stack([columns["s"], columns["x"], columns["y"], columns["psi"] - np.pi / 2, columns["kappa"], columns["v"], 0.1 * columns["v"]])
    (tmp_path / "line.csv").write_text("# 4a7c, made by hand\n" + head + "\n".join("; ".join(f"{v:.7f}" for v in row) for row in rows) + "\n")
    road = roads.read(tmp_path / "line.csv", lane=2.2, width=2.2)
    assert moved(road) < SAMPLED
    assert len(road.lanes) == 1
    assert np.allclose(road.columns["kappa"], columns["kappa"], atol=1e-6)


@pytest.mark.parametrize("kind", ["vectors", "matrix", "struct"])
def test_matlab_files(tmp_path: Path, kind: str):
    from scipy.io import loadmat

    path = samples.path_mat(tmp_path, kind)
    road = roads.read(path, lane=3.5, width=7.0)
    assert moved(road) < SAMPLED
    assert np.array_equal(road.columns["v"], samples.path_columns()["v"])
    # SciPy's reader finds the same variables
    from roads.formats.tables.matlab import read_variables

    assert set(read_variables(path)) == {key for key in loadmat(path) if not key.startswith("__")}


def test_matlab_files_packed_and_of_other_byte_order_and_types(tmp_path: Path):
    from scipy.io import savemat

    from roads.formats.tables.matlab import read_variables

    values = {"x": np.arange(5, dtype=np.int8)[:, None], "y": np.arange(5, dtype=np.float32), "word": "text", "z": np.array([1 + 2j])}
    savemat(tmp_path / "a.mat", values, do_compression=True)
    found = read_variables(tmp_path / "a.mat")
    assert list(found) == ["x", "y"]
    assert np.array_equal(np.ravel(found["x"]), np.arange(5.0))
    (tmp_path / "b.mat").write_bytes(b"\x89HDF\r\n" + bytes(500))
    with pytest.raises(RoadError, match="version 7.3 is HDF5"):
        read_variables(tmp_path / "b.mat")


@pytest.mark.parametrize("make", [samples.gpx, samples.geojson])
def test_lines_in_degrees(tmp_path: Path, make):
    road = roads.read(make(tmp_path), width=7.0)
    # degrees are given to 1e-9, a tenth of a millimetre
    assert moved(road) < SAMPLED + 1e-3
    assert road.origin == pytest.approx(samples.ORIGIN, abs=1e-8)
    assert len(road.lanes) == 2
    assert road.name == "bend"


def test_a_width_out_of_range_is_refused(tmp_path: Path):
    with pytest.raises(RoadError, match=r"width 0 m, expected 0.5 to 1000"):
        roads.read(samples.gpx(tmp_path), width=0)


@pytest.mark.parametrize("local", [True, False])
def test_lanelet2(tmp_path: Path, local: bool):
    network = roads.read_network(samples.lanelet2(tmp_path, local=local))
    assert list(network.links) == ["2001", "2002", "2003"]
    link = network.links["2001"]
    assert (link.successors, link.beside, link.against) == (["2002"], ("2001", "2003"), (False, True))
    assert link.limits == ((0.0, pytest.approx(50 / 3.6)),)
    road = network.route("2001", "2002")
    _, off = samples.bend().reference.locate(road.reference.position(np.linspace(0.0, road.length, 300)))
    # without local coordinates the map's first node, on the left edge, is the origin
    if local:
        assert np.allclose(off, -1.75, atol=SAMPLED)
        assert np.allclose(road.left[5:20], 5.25, atol=SAMPLED)
    assert np.allclose(road.right, -1.75, atol=SAMPLED)
    assert road.height_at(30.0) == 500.0


@pytest.mark.parametrize("version", ["2018b", "2020a"])
def test_commonroad(tmp_path: Path, version: str):
    network = roads.read_network(samples.commonroad(tmp_path, version))
    assert network.format == f"CommonRoad {version}"
    road = network.route("1", "2")
    assert road.speed_limit[0] == 13.5
    assert np.isinf(road.speed_limit[-1])
    assert [lane.direction for lane in road.lanes] == [1, -1, 1]
    _, off = samples.bend().reference.locate(road.reference.position(np.linspace(0.0, road.length, 300)))
    assert np.allclose(off, -1.75, atol=0.03)  # 21 points 9 m apart


def test_sumo(tmp_path: Path):
    network = roads.read_network(samples.sumo(tmp_path))
    assert list(network.links) == [":J_0_0", "a_0", "a_1", "b_0"]
    assert network.links["a_0"].left == "a_1"
    assert network.links["a_1"].right == "a_0"
    road = network.route("a_1", "b_0")
    # from the left lane of a over to the right one, which leads through the junction
    assert [step.link.id for group in network.steps("a_1", "b_0") for step in group] == ["a_1", "a_0", ":J_0_0", "b_0"]
    assert np.allclose(road.reference.position(0.0), [0.0, -1.6])
    assert np.allclose(road.reference.position(road.length), [112.8, 100.0])
    assert road.height_at(road.length) == pytest.approx(4.0)
    assert road.left[-1] == pytest.approx(1.75, abs=1e-3)
    # the long straight stays straight beside the short pieces of the junction
    after = road.reference.position(np.linspace(road.length - 80.0, road.length, 50))
    assert np.max(np.abs(after[:, 0] - 112.8)) < 0.01
    notes = [finding.message for finding in network.findings]
    assert any("passenger" in note for note in notes)


def test_unknown_files_are_named(tmp_path: Path):
    (tmp_path / "a.dwg").write_text("x")
    with pytest.raises(RoadError, match=r"a\.dwg: unknown road format '\.dwg', expected one of"):
        roads.read(tmp_path / "a.dwg")
    with pytest.raises(RoadError, match="unknown network format"):
        roads.read_network(samples.edges(tmp_path))
    with pytest.raises(RoadError, match="holds 3 roads, give the id of one or start and goal"):
        roads.read(samples.lanelet2(tmp_path))
    (tmp_path / "b.csv").mkdir()
    with pytest.raises(RoadError, match="is a folder"):
        roads.read(tmp_path / "b.csv")
    (tmp_path / "c.xodr").write_text("")
    with pytest.raises(RoadError, match="empty file"):
        roads.read(tmp_path / "c.xodr")
    with pytest.raises(RoadError, match=r"cannot write format '\.gpx'"):
        roads.write(samples.bend(), tmp_path / "a.gpx")
    with pytest.raises(RoadError, match="cannot be written"):
        roads.write(samples.bend(), tmp_path / "nowhere" / "a.csv")


BOMB = '<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "bbbbbbbbbb"><!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;">]><OpenDRIVE><road id="&c;"/></OpenDRIVE>'


@pytest.mark.parametrize("suffix", [".xodr", ".xml", ".net.xml", ".osm", ".gpx"])
def test_entities_and_deep_nesting_are_refused(tmp_path: Path, suffix: str):
    for text, words in (
        (BOMB, "document type or entities"),
        (BOMB.replace("<!ENTITY", "<!ELEMENT"), "document type or entities"),
        ("<a>" * 50_000, "not well-formed XML"),
        ("<a>" * 300 + "</a>" * 300, "not well-formed XML"),
        ('<?xml version="1.0" encoding="hex"?><a/>', "not well-formed XML"),
        ("\x00", "not well-formed XML"),
    ):
        path = tmp_path / f"bad{suffix}"
        path.write_text(text)
        with pytest.raises(RoadError, match=words) as caught:
            roads.read(path, width=7.0) if suffix == ".gpx" else roads.read_network(path)
        assert str(path) in str(caught.value)


def test_entities_in_other_encodings_are_refused_too(tmp_path: Path):
    (tmp_path / "a.xodr").write_bytes(BOMB.replace('"1.0"', '"1.0" encoding="UTF-16"').encode("utf-16"))
    with pytest.raises(RoadError, match=r"document type or entities|not well-formed"):
        roads.read_network(tmp_path / "a.xodr")


def test_messages_stay_short_and_printable(tmp_path: Path):
    (tmp_path / "a.csv").write_text("x_m,y_m,w_tr_right_m,w_tr_left_m,\x1b[31m" + "z" * 5000 + "\n1,2,3,4,5\n")
    with pytest.raises(RoadError) as caught:
        roads.read(tmp_path / "a.csv")
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) <= 1000
