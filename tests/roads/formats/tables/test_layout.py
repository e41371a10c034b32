"""Decimal commas: one decision for the whole file."""

from pathlib import Path

import numpy as np
import pytest

import roads
from roads import RoadError
from roads.formats.tables.table import read_table

ROWS = np.column_stack([5.0 * np.arange(12.0), 0.125 * np.arange(12.0) ** 2, np.full((12, 2), 3.5)])


def text_of(between: str, comma: bool, form: str = "{:.4f}") -> str:
    rows = "\n".join(between.join(form.format(value) for value in row) for row in ROWS) + "\n"
    return rows.replace(".", ",") if comma else rows


@pytest.mark.parametrize("between", [";", "; ", "\t", " ", "  "])
@pytest.mark.parametrize("header", [False, True])
@pytest.mark.parametrize("form", ["{:.4f}", "{:g}", "{:.3e}", "{:+.2f}"])
def test_decimal_commas_mean_decimal_points(tmp_path: Path, between: str, header: bool, form: str):
    head = between.join(["x_m", "y_m", "w_tr_right_m", "w_tr_left_m"]) + "\n" if header else ""
    (tmp_path / "a.csv").write_text(head + text_of(between, comma=True, form=form))
    (tmp_path / "b.csv").write_text(head + text_of(between, comma=False, form=form))
    found, plain = read_table(tmp_path / "a.csv"), read_table(tmp_path / "b.csv")
    assert np.array_equal(found.rows, plain.rows)
    assert found.names == plain.names
    assert roads.read(tmp_path / "a.csv").length == roads.read(tmp_path / "b.csv").length


@pytest.mark.parametrize("between", [",", ", ", ",\t"])
def test_commas_between_columns_are_none(tmp_path: Path, between: str):
    for form in ("{:.4f}", "{:.0f}"):
        (tmp_path / "a.csv").write_text(text_of(between, comma=False, form=form))
        rows = read_table(tmp_path / "a.csv").rows
        assert rows.shape == ROWS.shape
        assert np.allclose(rows, ROWS, atol=0.51 if form == "{:.0f}" else 1e-4)


def test_a_first_row_of_whole_numbers_decides_nothing(tmp_path: Path):
    (tmp_path / "a.csv").write_text("0;0;3;3\n5;0,5;3;3\n10;1;3;3\n")
    assert read_table(tmp_path / "a.csv").rows[1, 1] == 0.5


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("0,0;0,0;3;3\n5,0;1.5;3;3\n", r"a\.csv:2: '1\.5' beside '0,0' in line 1, expected decimal points or decimal commas, not both"),
        ("0.0;0;3;3\n5;1,5;3;3\n", r"a\.csv:2: '1,5' beside '0\.0' in line 1, expected decimal points"),
        ("0,5;0;3;3\n1.234,5;0;3;3\n", r"a\.csv:2: column 1 is '1\.234,5', expected a finite number"),
        ("0,5;0;3;3\n1,234,5;0;3;3\n", r"a\.csv:2: column 1 is '1,234,5', expected a finite number"),
    ],
)
def test_mixed_files_are_one_clear_error(tmp_path: Path, text: str, words: str):
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(RoadError, match=words):
        roads.read(tmp_path / "a.csv")


def test_a_driving_cycle_may_have_them_too(tmp_path: Path):
    from roads.cycles import load

    (tmp_path / "c.csv").write_text("t_s;v_kmh\n" + "\n".join(f"{k},0;{0.5 * k}".replace(".", ",") for k in range(9)))
    cycle = load(tmp_path / "c.csv")
    assert np.allclose(3.6 * cycle.v, 0.5 * np.arange(9))
