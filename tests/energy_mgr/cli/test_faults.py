"""What nobody foresaw ends in one line too."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from energy_mgr.cli.main import main

from ...roads import samples


@pytest.fixture
def broken(monkeypatch: pytest.MonkeyPatch):
    """A reader of GPX with a fault."""

    def set_up(error: BaseException) -> None:
        def fail(*_: object, **__: object) -> None:
            raise error

        monkeypatch.setattr("roads.formats.gpx.read", fail)

    return set_up


@pytest.mark.parametrize("command", [["roads", "check"], ["roads", "info"], ["plan", "--width=7"]])
def test_a_fault_ends_in_one_line_that_names_command_file_and_place(
    broken, command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.delenv("ENERGY_MGR_TRACEBACK", raising=False)
    monkeypatch.chdir(tmp_path)
    broken(IndexError("index 3\nis out of range\x1b[31m"))
    file = str(samples.gpx(tmp_path))
    assert main([*command, file]) == 70
    shown = capsys.readouterr()
    (line,) = shown.err.strip().splitlines()[-1:]
    assert line.isprintable()
    names = " ".join(word for word in command if not word.startswith("-"))
    assert line.startswith(f"energy-mgr: {names} {file}: IndexError at ")
    assert "in roads.formats.registry:" in line
    assert "index 3 is out of range" in line
    assert "please report" in line
    assert "Traceback" not in shown.err + shown.out
    assert [found.name for found in tmp_path.iterdir()] == ["bend.gpx"]


def test_the_traceback_is_there_for_who_asks(broken, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("ENERGY_MGR_TRACEBACK", "1")
    broken(RecursionError("too deep"))
    assert main(["roads", "check", str(samples.gpx(tmp_path))]) == 70
    err = capsys.readouterr().err
    assert "Traceback (most recent call last)" in err
    assert "RecursionError at" in err.splitlines()[-1]


def test_too_little_memory_is_no_fault_of_the_file(broken, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    broken(MemoryError())
    assert main(["roads", "info", str(samples.gpx(tmp_path))]) == 70
    assert "more memory is needed than there is" in capsys.readouterr().err.splitlines()[-1]


def test_an_interruption_is_none(broken, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    broken(KeyboardInterrupt())
    assert main(["roads", "info", str(samples.gpx(tmp_path))]) == 130
    assert "interrupted, nothing written" in capsys.readouterr().err


def test_a_reader_that_has_seen_enough_is_no_fault():
    # a pipe whose other end is closed before the first word
    code = "import sys; from energy_mgr.cli.main import run; sys.argv = ['energy-mgr', 'roads', 'info', 'commute']; input(); run()"
    process = subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout is not None
    assert process.stdin is not None
    assert process.stderr is not None
    process.stdout.close()
    process.stdin.write(b"\n")
    process.stdin.close()
    words = process.stderr.read()
    process.stderr.close()
    process.wait(60)
    assert words == b""
