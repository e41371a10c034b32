"""The section of figures at the end of a run: by pytest in a process of its own, on a file of tests of its own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

CONFTEST = "from tests.figures import figure, pytest_terminal_summary\n"
MEASURED = """
import pytest

def test_share(figure):
    assert figure("share of the gain", 0.919, "{:.1%}", published="61.6 %") > 0.9

@pytest.mark.parametrize("road", ["commute", "rural"])
def test_saved(figure, road):
    figure(f"saved on {road}", (21.36, 160.0), "{:.1f} % in {:.0f} s", asked="20 %")
    assert road == "commute"
"""
SILENT = "def test_nothing(figure):\n    pass\n"


def run(folder: Path, tests: str, *arguments: str) -> list[str]:
    """Lines that pytest prints."""
    (folder / "conftest.py").write_text(CONFTEST)
    (folder / "pytest.ini").write_text("[pytest]\n")
    (folder / "test_it.py").write_text(tests)
    here = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])}
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *arguments]
    done = subprocess.run(command, cwd=folder, env=here, capture_output=True, text=True, check=False, timeout=120)
    return done.stdout.splitlines()


@pytest.mark.parametrize("arguments", [(), ("-q",), ("-n", "2")], ids=["plain", "quiet", "two processes"])
def test_figures_are_printed_in_columns_with_their_tests_even_of_those_that_fail(tmp_path: Path, arguments: tuple[str, ...]):
    if "-n" in arguments:
        pytest.importorskip("xdist")
    lines = run(tmp_path, MEASURED, *arguments)
    at = next(k for k, line in enumerate(lines) if line.strip("= ") == "figures")
    head, *found = (line.split("  ") for line in lines[at + 1 : at + 5])
    columns = [[cell.strip() for cell in line if cell.strip()] for line in (head, *sorted(found))]
    assert columns == [
        ["figure", "measured", "published or asked", "test"],
        ["saved on commute", "21.4 % in 160 s", "asked 20 %", "test_it.py::test_saved[commute]"],
        ["saved on rural", "21.4 % in 160 s", "asked 20 %", "test_it.py::test_saved[rural] FAILED"],
        ["share of the gain", "91.9%", "published 61.6 %", "test_it.py::test_share"],
    ]
    assert len({line.index("test_it.py::") for line in lines[at + 2 : at + 5]}) == 1


def test_a_run_without_figures_prints_no_section(tmp_path: Path):
    lines = run(tmp_path, SILENT)
    assert any("1 passed" in line for line in lines)
    assert not any(line.strip("= ") == "figures" for line in lines)
