"""The wheel: what it holds, and the first commands of a user who installs it and has no checkout."""

from __future__ import annotations

import shutil
import time
import zipfile
from fnmatch import fnmatch
from typing import TYPE_CHECKING

from .place import copy, run, tracked, users_environment

if TYPE_CHECKING:
    from pathlib import Path

    from .outcome import Report

PACKAGES = ("energy_mgr", "powertrain", "roads")
#: What a package needs beside its modules: types, cars, cells, roads, cycles.
DATA = ("*/py.typed", "*/*.pyi", "powertrain/vehicles/*.toml", "powertrain/battery/cells/*.toml", "roads/gallery/*.xodr", "roads/cycles/*.csv")
COMMANDS = (
    "energy-mgr --version",
    "energy-mgr plan commute",
    "energy-mgr plan tour.gpx --width 6.5",
    "energy-mgr simulate roundabout --from west/0/1 --to east",
    "energy-mgr vehicle cycle wltc_3b --vehicle compact --until-empty",
    """python -W error -c "import roads; assert 1400 < roads.read('tour.gpx', width=6.5).length < 1700" """,
)
WHERE = "wheel"


def try_wheel(checkout: Path, fresh: Path, own: Path, report: Report) -> None:
    """Build the wheel, look into it, install it into an environment of its own and use it in a folder that holds nothing else.

    Args:
        checkout: whose tracked files are built.
        fresh: copy with the environment whose pip builds.
        own: where the reader's own files lie.
        report: is told.
    """
    place = fresh.parent / "wheel"
    source = copy(checkout, place / "source")
    python = str(fresh / ".venv/bin/python")
    done = run([python, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", "dist", "./source"], place, users_environment())
    wheels = list((place / "dist").glob("energy_mgr-*.whl"))
    report.tell(WHERE, "pip wheel --no-deps .", done.seconds, done.last_words if done.code or not wheels else "")
    if not wheels:
        return
    shutil.rmtree(source)  # so that nothing of it can be found by chance
    start = time.monotonic()
    report.tell(WHERE, f"what {wheels[0].name} holds", time.monotonic() - start, complaints(wheels[0], tracked(checkout)))
    _use(wheels[0], python, own, report)


def complaints(wheel: Path, files: list[str]) -> str:
    """What the wheel lacks of a checkout's files, and what it holds besides its three packages (tests, say), a line each."""
    with zipfile.ZipFile(wheel) as archive:
        held = {name for name in archive.namelist() if not name.split("/")[0].endswith(".dist-info")}
    wanted = {name for name in files if name.split("/")[0] in PACKAGES}
    told = [f"lacks {name}" for name in sorted(wanted - held)] + [f"holds {name}, which is no file of the packages" for name in sorted(held - wanted)]
    return "\n".join(told + [f"holds no {pattern}" for pattern in DATA if not any(fnmatch(name, pattern) for name in held)])


def _use(wheel: Path, python: str, own: Path, report: Report) -> None:
    place = wheel.parents[1] / "user"
    place.mkdir()
    shutil.copy2(own / "tour.gpx", place)
    binaries = place / ".venv/bin"
    made = run([python, "-m", "venv", ".venv"], place, users_environment())
    done = run([str(binaries / "python"), "-m", "pip", "install", "--quiet", str(wheel)], place, users_environment()) if made.code == 0 else made
    report.tell(WHERE, f"pip install {wheel.name}", made.seconds + done.seconds, done.last_words if done.code else "")
    if done.code:
        return
    for command in COMMANDS:
        ran = run(command, place, users_environment(binaries))
        report.tell(WHERE, command.strip(), ran.seconds, ran.last_words if ran.code else "")
