"""README's first command in a fresh copy: does it do what README shows?"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from .documents import blocks
from .left_out import FIRST
from .place import copy, run, users_environment

if TYPE_CHECKING:
    from pathlib import Path

    from .outcome import Report

WRITTEN = ("trajectory.csv", "plan.json", "plan.png")
_NUMBER = re.compile(r"-?\d+\.\d+")
#: README's figures may be off by this share or by this much, whichever is more: solvers round differently on other machines.
_SHARE, _LEAST = 0.005, 0.0002


def set_up(checkout: Path, fresh: Path, report: Report) -> bool:
    """Copy the checkout and run the first command there; whether there now is something to go on with."""
    copy(checkout, fresh)
    ran = run(FIRST, fresh, users_environment())
    failure = ran.last_words if ran.code else _missing(checkout, fresh, ran.out)
    report.tell("README.md", FIRST, ran.seconds, failure)
    return (fresh / ".venv/bin/energy-mgr").exists()


def _missing(checkout: Path, fresh: Path, printed: str) -> str:
    """What the first command should have printed or written and has not."""
    shown = [block.text for block in blocks(checkout, "README.md") if "saved kWh" in block.text]
    told = [] if shown else ["README shows no table"]
    told += [f"not printed: {line}" for line in "".join(shown).splitlines() if not any(alike(line, other) for other in printed.splitlines())]
    told += [f"not written: out/plan/{name}" for name in WRITTEN if not _filled(fresh / "out/plan" / name)]
    return "\n".join(told)


def alike(line: str, other: str) -> bool:
    """The same words in two lines, and nearly the same numbers."""
    if _NUMBER.sub("#", line).split() != _NUMBER.sub("#", other).split():
        return False
    pairs = zip(map(float, _NUMBER.findall(line)), map(float, _NUMBER.findall(other)), strict=True)
    return all(abs(a - b) <= max(_SHARE * abs(a), _LEAST) for a, b in pairs)


def _filled(path: Path) -> bool:
    return path.is_file() and path.stat().st_size > 0
