"""What `python -m tests.first_hour` reads out of documents and wheels, and that it does not pass what fails."""

from __future__ import annotations

import json
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tests.first_hour import run_blocks
from tests.first_hour.documents import blocks_of, commands
from tests.first_hour.first import alike
from tests.first_hour.left_out import lacking
from tests.first_hour.outcome import Report
from tests.first_hour.place import run, users_environment
from tests.first_hour.wheel import complaints

GUIDE = """# Guide
Say `energy-mgr plan rural --time 180`, not `--time`.
## One
```sh
make plan    # sets up
.venv/bin/energy-mgr plan x.csv --out out/x   # and `energy-mgr plan no` is no command
```
```python
a = 1
```
## Two
```python
print(a)
```
"""


def test_commands_are_found_in_order_without_their_comments(tmp_path: Path):
    (tmp_path / "guide.md").write_text(GUIDE)
    found = commands(tmp_path, "guide.md")
    assert [(command.line, command.name) for command in found] == [
        (2, "energy-mgr plan rural --time 180"),
        (5, "make plan"),
        (6, "energy-mgr plan x.csv --out out/x"),
    ]
    assert [command.written for command in found] == [[], [], ["out/x"]]


def test_blocks_know_their_line_and_section():
    found = [(block.line, block.section) for block in blocks_of(GUIDE, "guide.md") if block.language == "python"]
    assert found == [(9, "One"), (13, "Two")]


def test_an_open_fence_is_refused():
    with pytest.raises(ValueError, match="guide.md:1"):
        blocks_of("```sh\nmake plan\n", "guide.md")


def test_a_section_knows_what_stands_before_all_sections_and_nothing_of_the_others(tmp_path: Path):
    rows = [("", "a = 1"), ("One", "b = a"), ("One", "b"), ("Two", "a"), ("Two", "b"), ("Two", "import warnings; warnings.warn('old')")]
    todo = [{"document": "guide.md", "line": 10 * k + 1, "section": section, "text": text + "\n"} for k, (section, text) in enumerate(rows)]
    (tmp_path / "wanted.json").write_text(json.dumps(todo))
    subprocess.run([sys.executable, run_blocks.__file__, "wanted.json", "answers.json"], cwd=tmp_path, check=True)
    failures = [answer["failure"] for answer in json.loads((tmp_path / "answers.json").read_text())]
    assert failures[:4] == [""] * 4
    assert "NameError: name 'b'" in failures[4]
    assert 'File "guide.md", line 41' in failures[4]
    assert "UserWarning: old" in failures[5]


def test_figures_may_differ_in_their_last_digit_and_words_not_at_all():
    shown = "> path and speed               161.34      0.1710     0.0464    21.36"
    assert alike(shown, shown.replace("0.1710", "0.1711").replace("21.36", "21.38"))
    assert not alike(shown, shown.replace("0.1710", "0.1810"))
    assert not alike(shown, shown.replace("> path", "  path"))
    assert not alike(shown, shown.replace("    21.36", ""))


def test_a_wheel_with_tests_or_without_its_cars_is_found_out(tmp_path: Path):
    files = ["roads/__init__.py", "roads/py.typed", "powertrain/vehicles/romo.toml", "tests/__init__.py"]
    with zipfile.ZipFile(tmp_path / "x.whl", "w") as wheel:
        for name in ("roads/__init__.py", "roads/py.typed", "tests/__init__.py", "x-1.dist-info/METADATA"):
            wheel.writestr(name, "")
    told = complaints(tmp_path / "x.whl", files)
    assert "lacks powertrain/vehicles/romo.toml" in told
    assert "holds tests/__init__.py" in told
    assert "holds no powertrain/vehicles/*.toml" in told
    assert "py.typed" not in told


def test_one_failure_is_told_and_makes_the_exit_code(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    report = Report()
    for command in ("true", "echo why >&2; exit 3"):
        ran = run(command, tmp_path, users_environment())
        report.tell("guide.md:1", command, ran.seconds, ran.last_words if ran.code else "")
    assert report.close() == 1
    said = capsys.readouterr().out
    assert "    why" in said
    assert said.endswith("1 passed, 1 failed\n")


def test_what_needs_a_program_that_is_not_there_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    monkeypatch.setenv("PATH", str(tmp_path))
    assert lacking("machine.compile_c()") == "a C compiler"
    assert lacking("energy-mgr simulate commute --animate mp4") == "ffmpeg"
    assert lacking("energy-mgr simulate commute --animate gif") == ""


def test_a_users_environment_has_nothing_of_the_developers(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    (tmp_path / "pyvenv.cfg").touch()
    monkeypatch.setenv("PATH", f"{tmp_path / 'bin'}:/usr/bin")
    monkeypatch.setenv("PYTHONPATH", "here")
    monkeypatch.setenv("VIRTUAL_ENV", str(tmp_path))
    monkeypatch.setenv("PIP_NO_INPUT", "1")
    found = users_environment(tmp_path / "ahead")
    assert found["PATH"] == f"{tmp_path / 'ahead'}:/usr/bin"
    assert found["PIP_NO_INPUT"] == "1"
    assert not {"PYTHONPATH", "VIRTUAL_ENV"} & found.keys()
