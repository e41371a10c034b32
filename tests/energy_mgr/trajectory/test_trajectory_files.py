import csv
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from energy_mgr import PlanningError, Trajectory
from energy_mgr.trajectory.files import save, write_csv, write_path_table
from roads import open_road

from .test_trajectory import circle, on_clothoid, straight

KINDS = pytest.mark.parametrize("suffix", [".csv", ".parquet", ".CSV"])


def ramp() -> Trajectory:
    s = np.linspace(0.0, 40.0, 21)
    return on_clothoid(s, z=0.02 * s, bank=0.001 * s, power=np.linspace(-5e3, 2e4, 20), name="ramp 7: east")


def same(one: Trajectory, other: Trajectory) -> bool:
    return np.array_equal(one.table(), other.table()) and (one.closed, one.name) == (other.closed, other.name)


# -- there and back ------------------------------------------------------------------------------------------------------------------


@KINDS
@pytest.mark.parametrize("make", [ramp, circle, lambda: straight(np.array([0.0, 3.0, 0.0]), name='Straße # 1, \n"x"')])
def test_files_hold_every_bit(make: Callable[[], Trajectory], suffix: str, tmp_path: Path):
    trajectory = make()
    trajectory.save(tmp_path / f"file{suffix}")
    assert same(Trajectory.load(tmp_path / f"file{suffix}"), trajectory)
    assert [file.name for file in tmp_path.iterdir()] == [f"file{suffix}"]


@given(
    v=st.lists(st.floats(0.01, 90.0), min_size=2, max_size=6),
    step=st.floats(0.1, 100.0),
    z=st.floats(-400, 9000),
    name=st.text(max_size=20),
    power=st.floats(-1e6, 1e6),
)
@settings(max_examples=40, deadline=None)
def test_files_hold_any_trajectory(tmp_path_factory: pytest.TempPathFactory, v: list[float], step: float, z: float, name: str, power: float):
    trajectory = straight(np.array(v), step, z=z, name=name, power=power)
    folder = tmp_path_factory.getbasetemp()
    for suffix in (".csv", ".parquet"):
        save(trajectory, folder / f"any{suffix}")
        assert same(Trajectory.load(folder / f"any{suffix}"), trajectory)


def test_csv_begins_with_name_and_flag_or_with_the_header(tmp_path: Path):
    write_csv(circle(), tmp_path / "a.csv")
    write_csv(circle(), tmp_path / "b.csv", remarks=False)
    with_remarks, plain = ((tmp_path / name).read_text().splitlines() for name in ("a.csv", "b.csv"))
    assert with_remarks[:2] == ["# name: ring", "# closed: true"]
    assert with_remarks[2:] == plain
    assert plain[0] == ",".join(Trajectory.COLUMNS)
    with (tmp_path / "b.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["psi_rad"]) for row in rows] == circle().psi.tolist()


def test_closed_follows_from_the_ends_where_the_file_does_not_say(tmp_path: Path):
    ring = circle()
    write_csv(ring, tmp_path / "ring.csv", remarks=False)
    assert same(Trajectory.load(tmp_path / "ring.csv"), ring)
    write_csv(ramp(), tmp_path / "ramp.csv", remarks=False)
    assert not Trajectory.load(tmp_path / "ramp.csv").closed
    # one that starts and ends at rest at one place is a drive from and to the garage
    speed = np.minimum(10.0, np.linspace(0.0, 60.0, len(ring.s)))
    speed[-1] = 0.0
    home = Trajectory.along(ring.s, ring.x, ring.y, ring.psi, ring.kappa, speed)
    write_csv(home, tmp_path / "home.csv", remarks=False)
    assert not Trajectory.load(tmp_path / "home.csv").closed


def test_parquet_of_another_program_is_read_by_its_columns(tmp_path: Path):
    table = pa.table({"note": ["x"] * 21} | dict(zip(reversed(Trajectory.COLUMNS), reversed(list(ramp().columns.values())), strict=True)))
    pq.write_table(table, tmp_path / "other.parquet")
    found = Trajectory.load(tmp_path / "other.parquet")
    assert np.array_equal(found.table(), ramp().table())
    assert (found.name, found.closed) == ("other", False)


def test_parquet_in_a_folder_with_an_equals_sign_is_read(tmp_path: Path):
    save(ramp(), tmp_path / "slope=3" / "ramp.parquet")
    assert same(Trajectory.load(tmp_path / "slope=3" / "ramp.parquet"), ramp())


@pytest.mark.parametrize("digits", [6, 9])
def test_files_with_rounded_numbers_are_taken_and_stay_continuous_in_time(digits: int, tmp_path: Path):
    header = ",".join(Trajectory.COLUMNS)
    np.savetxt(tmp_path / "short.csv", ramp().table(), fmt=f"%.{digits}g", delimiter=",", header=header, comments="")
    found = Trajectory.load(tmp_path / "short.csv")
    assert np.allclose(found.table(), ramp().table(), rtol=1e-5, atol=1e-5)
    assert found.at(found.s[1:] - 1e-9).t == pytest.approx(found.t[1:], abs=1e-9)
    t = np.linspace(0.0, found.journey_time, 101)
    assert found.at(found.at_time(t)).t == pytest.approx(t, abs=1e-12)


@pytest.mark.parametrize("make", [ramp, circle])
def test_path_table_comes_back_as_the_road_about_the_line(make: Callable[[], Trajectory], tmp_path: Path):
    trajectory = make()
    write_path_table(trajectory, tmp_path / "line.csv", height=True)
    assert (tmp_path / "line.csv").read_text().splitlines()[2] == "s_m,x_m,y_m,psi_rad,v_mps,kappa_radpm,z_m"
    road = open_road(tmp_path / "line.csv", lane=3.5, width=7.0)
    rows = slice(0, -1) if trajectory.closed else slice(None)
    assert (road.name, road.closed) == (trajectory.name, trajectory.closed)
    for name in ("s", "psi", "v", "kappa"):
        assert np.array_equal(road.columns[name], trajectory.columns[name][rows])
    assert np.array_equal(road.height, trajectory.z[rows])
    # a cubic spline through points 2 or 3 m apart
    s = np.linspace(0.0, min(road.length, trajectory.length), 300)
    place, found = road.reference.position(s), trajectory.at(s)
    assert np.max(np.hypot(place[:, 0] - found.x, place[:, 1] - found.y)) < 2e-3
    assert road.reference.heading(s[5:-5]) == pytest.approx(found.psi[5:-5], abs=5e-3)


def test_path_table_has_the_six_columns_of_the_layout_and_no_other_suffix(tmp_path: Path):
    write_path_table(ramp(), tmp_path / "line.csv")
    assert (tmp_path / "line.csv").read_text().splitlines()[2] == "s_m,x_m,y_m,psi_rad,v_mps,kappa_radpm"
    with pytest.raises(PlanningError, match=r"expected \.csv"):
        write_path_table(ramp(), tmp_path / "line.mat")


def test_an_open_line_whose_ends_meet_stays_an_open_road(tmp_path: Path):
    ring = circle()
    home = Trajectory.along(ring.s, ring.x, ring.y, ring.psi, ring.kappa, ring.v)
    write_path_table(home, tmp_path / "home.csv")
    assert not open_road(tmp_path / "home.csv", lane=3.0, width=3.0).closed


@pytest.mark.parametrize("remarks", [True, False])
def test_trajectory_csv_is_a_path_table_too(remarks: bool, tmp_path: Path):
    write_csv(ramp(), tmp_path / "plan.csv", remarks=remarks)
    road = open_road(tmp_path / "plan.csv", lane=3.5, width=7.0)
    assert np.array_equal(road.columns["v"], ramp().v)
    assert np.array_equal(road.height, ramp().z)


# -- whole or not at all -------------------------------------------------------------------------------------------------------------


@KINDS
def test_a_failure_while_writing_leaves_the_old_file(suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    out = tmp_path / f"file{suffix}"
    save(ramp(), out)
    before = out.read_bytes()

    def full(*_args: object, **_more: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(PlanningError, match="cannot be written: No space left on device"):
        save(circle(), out)
    assert out.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == [out.name]


def test_places_that_cannot_be_written_to_are_refused(tmp_path: Path):
    (tmp_path / "file").write_text("")
    (tmp_path / "folder.csv").mkdir()
    for out in (tmp_path / "file" / "a.csv", tmp_path / "folder.csv"):
        with pytest.raises(PlanningError, match="cannot be written"):
            save(ramp(), out)
    save(ramp(), tmp_path / "new" / "deep" / "a.csv")
    assert os.listdir(tmp_path / "new" / "deep") == ["a.csv"]  # noqa: PTH208


@pytest.mark.parametrize("what", [lambda path: save(ramp(), path), Trajectory.load])
def test_other_suffixes_are_refused(what: Callable[[Path], object], tmp_path: Path):
    with pytest.raises(PlanningError, match=r"unknown kind of trajectory file '\.xlsx', expected one of \.csv, \.parquet"):
        what(tmp_path / "a.xlsx")
