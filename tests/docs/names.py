"""Do the names exist that a text gives to things of the code?"""

from __future__ import annotations

import importlib
import re
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from .references import ROOTS

if TYPE_CHECKING:
    from .spans import Span

_DOTTED = re.compile(r"(?<![\w./-])((?:energy_mgr|powertrain|roads)(?:\.[A-Za-z_]\w*)+)")
#: `PathPlanner`, `clear_faults`, `EnergyManager.step`, `roads.join([a, b])`: a name, or a call of one.
_NAME = re.compile(r"^([A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*)(?:\(.*\))?$")
#: A file of the reader's, or one that `references.paths` looks for.
_FILE = re.compile(r"\.(py|pyi|csv|json|toml|png|gif|md|tir|mat|xml|xodr|gpx|parquet)$")
_WORD = re.compile(r"[A-Za-z_]\w*")


def dotted(span: Span) -> list[str]:
    """`roads.read`, `energy_mgr.speed.comparison.nlp.nlp_profile`: modules, and what is in them."""
    if span.kind in ("link", "sh"):
        return []
    return [f"no {name} in the code" for name in _DOTTED.findall(span.text) if not name.endswith(".py") and not _resolves(name)]


def known(root: Path, span: Span) -> list[str]:
    """A ticked name is a word of the sources; names that are gone occur there no more."""
    found = _NAME.match(span.text) if span.kind == "ticked" else None
    if not found or _DOTTED.match(span.text) or _FILE.search(span.text):
        return []
    return [f"{word} (of `{span.text}`) is no word of the code" for word in _WORD.findall(found[1]) if word not in _words(root)]


@cache
def _resolves(name: str) -> bool:
    parts = name.split(".")
    thing: object = importlib.import_module(parts[0])
    for k, part in enumerate(parts[1:], start=2):
        if not hasattr(thing, part):
            if not isinstance(thing, ModuleType):
                return part in getattr(thing, "__annotations__", {})  # an attribute of a dataclass without a default
            try:
                importlib.import_module(".".join(parts[:k]))
            except ModuleNotFoundError:
                return False
        thing = getattr(thing, part)
    return True


@cache
def _words(root: Path) -> frozenset[str]:
    """Every word of the sources, and the names of files and folders."""
    words: set[str] = set()
    for first in ROOTS:
        for path in (root / first).rglob("*"):
            if path.suffix in (".py", ".pyi", ".toml") and "docs" not in path.relative_to(root).parts:
                words.update(_WORD.findall(path.read_text(encoding="utf-8")), path.name.split("."), path.parent.parts)
            elif path.suffix in (".csv", ".xodr"):
                words.add(path.stem)
    for name in ("Makefile", "pyproject.toml"):
        words.update(_WORD.findall((root / name).read_text(encoding="utf-8")))
    return frozenset(words)
