"""Fresh copies of the checkout, and programs run there as a user's shell would."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

#: What a shell of the developer may have set and a user's has not. PIP_* stays: it says where packages come from.
_NOT_A_USERS = ("VIRTUAL_ENV", "CONDA_PREFIX", "ENERGY_MGR_DATA", "MPLBACKEND", "MAKEFLAGS", "MAKELEVEL", "MFLAGS")
#: No command of the documents takes a tenth of this on a quiet machine, s.
PATIENCE = 600.0


@dataclass(frozen=True)
class Ran:
    """What came of a program: exit code, output, errors, seconds."""

    code: int
    out: str
    error: str
    seconds: float

    @property
    def last_words(self) -> str:
        """The last lines of the errors, or of the output where there were none."""
        lines = (self.error.strip() or self.out.strip()).splitlines()
        return "\n".join(lines[-12:])


def users_environment(*ahead: Path) -> dict[str, str]:
    """The environment without virtual environments and Python's own settings.

    Args:
        ahead: folders to put before all others on the PATH.
    """
    kept = {key: value for key, value in os.environ.items() if key not in _NOT_A_USERS and not key.startswith("PYTHON")}
    if "PYTHON" in os.environ:  # the Makefile's own variable: which Python to set up with
        kept["PYTHON"] = os.environ["PYTHON"]
    folders = [folder for folder in os.environ.get("PATH", "").split(os.pathsep) if folder and not (Path(folder).parent / "pyvenv.cfg").exists()]
    kept["PATH"] = os.pathsep.join([*map(str, ahead), *folders])
    return kept


def run(command: str | list[str], place: Path, environment: dict[str, str]) -> Ran:
    """Run a line of shell, or a program with arguments, in a folder; a program that does not end in time has exit code 124."""
    start = time.monotonic()
    program = subprocess.Popen(
        command,
        shell=isinstance(command, str),
        cwd=place,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        errors="replace",
        start_new_session=True,  # so that what the shell started ends with it
    )
    try:
        out, error = program.communicate(timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        os.killpg(program.pid, signal.SIGKILL)
        out, error = program.communicate()
        return Ran(124, out, f"{error}\nnot done after {PATIENCE:g} s", time.monotonic() - start)
    return Ran(program.returncode, out, error, time.monotonic() - start)


def tracked(checkout: Path) -> list[str]:
    """The files that git keeps and that are still there, relative to the checkout."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=checkout, capture_output=True, check=True).stdout.decode()
    return [name for name in listed.split("\0") if name and (checkout / name).is_file()]


def copy(checkout: Path, to: Path) -> Path:
    """The tracked files as they lie there, changes included: what a clone would have after the next commit."""
    for name in tracked(checkout):
        target = to / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(checkout / name, target)
    return to


def beside(fresh: Path, name: str) -> Path:
    """A second copy for another document, with the environment of the first one: two documents run at a time and do not share their files."""
    place = fresh.parent / name
    shutil.copytree(fresh, place, ignore=lambda folder, _: [".venv"] if Path(folder) == fresh else [])
    (place / ".venv").symlink_to(fresh / ".venv", target_is_directory=True)
    return place
