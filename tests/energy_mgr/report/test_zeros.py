"""Nothing that a person reads says `-0.00`."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import numpy as np
import pytest

import energy_mgr
from energy_mgr.report import comparison_table, road_table
from roads import Road

ROOT = Path(__file__).parents[3]
#: What is made for people, by place; `z` in a format turns what rounds to -0 into 0 (PEP 682).
FOR_PEOPLE = [*ROOT.glob("energy_mgr/report/**/*.py"), *ROOT.glob("energy_mgr/cli/*.py"), ROOT / "roads/check.py", ROOT / "roads/crossings.py"]


def fixed(source: str) -> list[tuple[int, str]]:
    """Line and format of every number with fixed decimals in the f-strings of `source`."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FormattedValue) and isinstance(node.format_spec, ast.JoinedStr):
            spec = "".join(str(part.value) if isinstance(part, ast.Constant) else "0" for part in node.format_spec.values)
            if re.search(r"\.\d+f$", spec):
                found.append((node.lineno, spec))
    return found


def test_formats_are_seen():
    assert fixed("f'{a:.2f} {b:>9.1f} {c:z+.3f} {d:g} {e:.{n}f}'") == [(1, ".2f"), (1, ">9.1f"), (1, "z+.3f"), (1, ".0f")]


@pytest.mark.parametrize("file", FOR_PEOPLE, ids=lambda file: str(file.relative_to(ROOT)))
def test_every_number_with_fixed_decimals_is_written_without_minus_zero(file: Path):
    assert [(line, spec) for line, spec in fixed(file.read_text(encoding="utf-8")) if "z" not in spec] == []


def minus_zeros(text: str) -> list[str]:
    return re.findall(r"-0(?:\.0+)?(?![\d.])", text)


def test_tables_of_roads_and_plans_show_none():
    assert minus_zeros("a -0.00 b -0 c -0.01 d 1-0.5") == ["-0.00", "-0"]
    s = np.arange(0.0, 101.0, 5.0)
    road = Road.from_points("x", np.column_stack([s, 0.0 * s]), -3.0, 3.0, height=-0.0 * s - 1e-4 * (s > 50.0), bank=-1e-7)
    assert minus_zeros(road_table(road)) == []
    plan = energy_mgr.plan(road, "romo")
    assert minus_zeros(comparison_table(plan)) == []
