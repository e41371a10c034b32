from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from energy_mgr import PlanningError, Trajectory
from energy_mgr.trajectory.files import save

from .test_trajectory_files import ramp

HEADER = list(Trajectory.COLUMNS)


def spoiled(row: int, label: str, word: str) -> str:
    rows = [[repr(value) for value in row] for row in ramp().table().tolist()]
    rows[row][HEADER.index(label)] = word
    return "\n".join([",".join(HEADER), *(",".join(row) for row in rows)]) + "\n"


@pytest.mark.parametrize(
    ("row", "label", "word", "words"),
    [
        (3, "v_mps", "fast", ":5: v_mps is 'fast', expected a finite number"),
        (3, "x_m", "nan", ":5: x_m is 'nan', expected a finite number"),
        (0, "power_w", "inf", ":2: power_w is 'inf', expected a finite number"),
        (4, "s_m", "6.0", ":6: s_m is 6, expected more than 6 m"),
        (4, "s_m", "5.5", ":6: s_m is 5.5, expected more than 6 m"),
        (7, "v_mps", "-0.5", ":9: v_mps is -0.5, expected 0 or more"),
        (7, "t_s", "1.5", ":9: t_s is 1.5, expected 1.2 s and the way since over the mean of both speeds"),
        (7, "a_mps2", "0.5", ":9: a_mps2 is 0.5, expected the change of v"),
        (7, "psi_rad", "2.0", ":9: psi_rad is 2, expected a heading in rad"),
        (7, "kappa_1pm", "2.0", ":9: kappa_1pm is 2, expected in 1/m"),
        (7, "x_m", "200", ":9: s_m is 14, expected to grow"),
    ],
)
def test_a_bad_value_is_named_with_line_and_column(row: int, label: str, word: str, words: str, tmp_path: Path):
    (tmp_path / "bad.csv").write_text(spoiled(row, label, word))
    with pytest.raises(PlanningError, match=r"bad\.csv" + words) as caught:
        Trajectory.load(tmp_path / "bad.csv")
    assert "\n" not in str(caught.value)


def test_standstill_at_neighbours_is_named_with_its_line(tmp_path: Path):
    lines = spoiled(6, "v_mps", "0").splitlines()
    lines[8] = spoiled(7, "v_mps", "0").splitlines()[8]
    (tmp_path / "bad.csv").write_text("\n".join(["# name: jam", *lines]))
    with pytest.raises(PlanningError, match=r"bad\.csv:10: v_mps is 0, expected a speed"):
        Trajectory.load(tmp_path / "bad.csv")


@pytest.mark.parametrize("label", Trajectory.COLUMNS)
@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_missing_column_is_named(label: str, suffix: str, tmp_path: Path):
    columns = {key: values for key, values in zip(HEADER, ramp().columns.values(), strict=True) if key != label}
    if suffix == ".csv":
        np.savetxt(tmp_path / "bad.csv", np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="")
    else:
        pq.write_table(pa.table(columns), tmp_path / "bad.parquet")
    with pytest.raises(PlanningError, match=rf"bad\{suffix}\S* no column {label} among .*, expected one each of s_m, "):
        Trajectory.load(tmp_path / f"bad{suffix}")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "empty file"),
        (",".join(HEADER) + "\n", "no data"),
        ("\n".join(spoiled(0, "t_s", "0").splitlines()[:2]), "csv: 1 rows, expected at least 2"),
        ("\n".join(spoiled(0, "t_s", "0").splitlines()[1:]), ":1: no line with the names of columns above the data"),
        (spoiled(0, "t_s", "0").replace("y_m", "x_m", 1), "no column y_m|2 columns x_m"),
        (spoiled(5, "t_s", "1,2"), ":7: 14 columns, expected 13"),
        ("# closed: maybe\n" + spoiled(0, "t_s", "0"), "closed is 'maybe', expected true or false"),
        ("# closed: true\n" + spoiled(0, "t_s", "0"), r":23: x_m is \S+, expected 0 as in the first row of a closed track"),
    ],
)
def test_files_that_are_no_table_are_refused(text: str, words: str, tmp_path: Path):
    (tmp_path / "bad.csv").write_text(text)
    with pytest.raises(PlanningError, match=words):
        Trajectory.load(tmp_path / "bad.csv")


def test_files_that_are_not_there_are_refused(tmp_path: Path):
    (tmp_path / "folder.parquet").mkdir()
    for name, words in {"none.csv": "no such file", "none.parquet": "no such file", "folder.parquet": "is a folder"}.items():
        with pytest.raises(PlanningError, match=words):
            Trajectory.load(tmp_path / name)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda columns: columns | {"v_mps": pa.array(["ten"] * 21)}, "v_mps is of type string, expected numbers"),
        (lambda columns: columns | {"v_mps": pa.array([10.0] * 4 + [None] * 17)}, "row 4: v_mps is null, expected a finite number"),
        (lambda columns: columns | {"v_mps": np.array([10.0] * 4 + [np.nan] * 17)}, "row 4: v_mps is nan, expected a finite number"),
        (lambda columns: {name: values[:1] for name, values in columns.items()}, "1 rows, expected at least 2"),
        (lambda columns: {name: values[:0] for name, values in columns.items()}, "0 rows, expected at least 2"),
        (lambda columns: columns | {"s_m": columns["s_m"][::-1]}, "row 1: s_m is 38, expected more than 40 m"),
    ],
)
def test_bad_values_in_parquet_are_named_with_row_and_column(change: Callable[[dict], dict], words: str, tmp_path: Path):
    pq.write_table(pa.table(change(dict(zip(HEADER, ramp().columns.values(), strict=True)))), tmp_path / "bad.parquet")
    with pytest.raises(PlanningError, match=r"bad\.parquet: " + words):
        Trajectory.load(tmp_path / "bad.parquet")


@pytest.mark.parametrize("about", [b"", b"[]", b"{}", b'{"closed": 1, "name": "x"}', b'{"closed": true}', b"\xff"])
def test_bad_metadata_of_ours_is_refused(about: bytes, tmp_path: Path):
    table = pa.table(dict(zip(HEADER, ramp().columns.values(), strict=True))).replace_schema_metadata({b"energy_mgr.trajectory": about})
    pq.write_table(table, tmp_path / "bad.parquet")
    with pytest.raises(PlanningError, match="expected an object with closed"):
        Trajectory.load(tmp_path / "bad.parquet")


@given(place=st.floats(0, 1), junk=st.binary(min_size=1, max_size=12), kind=st.sampled_from(["put", "replace", "cut"]))
@settings(max_examples=150, deadline=None)
def test_a_damaged_file_is_refused_in_one_line_or_still_a_trajectory(tmp_path_factory: pytest.TempPathFactory, place: float, junk: bytes, kind: str):
    folder = tmp_path_factory.getbasetemp()
    for suffix in (".csv", ".parquet"):
        file = folder / f"damaged{suffix}"
        save(ramp(), file)
        whole = file.read_bytes()
        at = int(place * len(whole))
        rest = {"put": whole[at:], "replace": whole[at + len(junk) :], "cut": b""}[kind]
        file.write_bytes(whole[:at] + junk + rest)
        try:
            found = Trajectory.load(file)
        except PlanningError as error:
            assert str(error).startswith(str(file))  # noqa: PT017
            assert "\n" not in str(error)  # noqa: PT017
        else:
            assert np.all(np.isfinite(found.at(np.linspace(found.s[0], found.s[-1], 50)).kappa))


def test_a_flipped_bit_in_parquet_is_refused_or_without_effect(tmp_path: Path):
    save(ramp(), tmp_path / "flipped.parquet")
    whole = (tmp_path / "flipped.parquet").read_bytes()
    refused = 0
    for at in range(0, len(whole), 11):
        (tmp_path / "flipped.parquet").write_bytes(whole[:at] + bytes([whole[at] ^ 4]) + whole[at + 1 :])
        try:
            assert np.array_equal(Trajectory.load(tmp_path / "flipped.parquet").table(), ramp().table())
        except PlanningError:
            refused += 1
    assert refused > 50


@given(row=st.integers(0, 20), label=st.sampled_from(HEADER), value=st.floats(allow_nan=True, allow_infinity=True))
@settings(max_examples=100, deadline=None)
def test_one_wrong_number_is_noticed_or_harmless(tmp_path_factory: pytest.TempPathFactory, row: int, label: str, value: float):
    file = tmp_path_factory.getbasetemp() / "wrong.csv"
    file.write_text(spoiled(row, label, repr(value)))
    try:
        found = Trajectory.load(file)
    except PlanningError as error:
        assert "wrong.csv:" in str(error)  # noqa: PT017
    else:
        # what the others do not say too may be anything finite; what they do must agree with them
        was = ramp().columns[{key: name for name, key in zip(ramp().columns, HEADER, strict=True)}[label]][row]
        free = {"z_m", "power_w", "jerk_mps3", "slope", "bank_rad"}
        # the last row's acceleration would hold until a next station, and there is none
        assert label in free or (label, row) == ("a_mps2", 20) or abs(value - was) < 1.0
        t = np.linspace(found.t[0], found.t[-1], 50)
        assert np.all(np.isfinite(found.at(found.at_time(t)).kappa))
