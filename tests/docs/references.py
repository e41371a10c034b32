"""Do files, tests, make targets and modules exist that a text names? Each function takes a part of a text and answers with complaints."""

from __future__ import annotations

import ast
import importlib.util
import re
from functools import cache
from pathlib import Path

from .spans import Span

ROOTS = ("tests", "benchmarks", "docs", "energy_mgr", "powertrain", "roads", "typings")
#: A path below one of the project's folders; `tests/*.csv` is the reader's own.
_PATH = re.compile(rf"(?<![\w./-])(?:\./)?((?:{'|'.join(ROOTS)})/[\w./*-]*)(?:::(\w+(?:::\w+)*))?")
#: A file of sources that a table names without its folder.
_BARE = re.compile(r"^\w+\.pyi?$")
_MAKE = re.compile(r"^make +([a-z][\w-]*)")
_MODULE = re.compile(r"\bpython3? +(?:-\w+ +(?!-m))*-m +([\w.]+)")
_TARGET = re.compile(r"^([a-z][\w-]*):(?!=)", re.MULTILINE)


def paths(root: Path, span: Span) -> list[str]:
    """Files and folders of the project, and tests in them (`tests/test_x.py::test_y`)."""
    if span.kind == "link":
        return []
    told = []
    for path, test in _PATH.findall(span.text):
        path = path.rstrip(".")
        if "*" in path:
            continue
        if not (root / path).exists():
            told.append(f"no file {path}")
        elif test and not _has_test(root / path, test):
            told.append(f"no test {test} in {path}")
    if span.kind == "ticked" and _BARE.match(span.text) and span.text not in _sources(root):
        told.append(f"no file {span.text} anywhere")
    return told


def links(root: Path, document: str, span: Span) -> list[str]:
    """Relative links lead to files, and what follows a # to a heading there."""
    if span.kind != "link" or re.match(r"[a-z]+:", span.text):
        return []
    place, _, heading = span.text.partition("#")
    target = (root / document).parent / place if place else root / document
    if not target.exists():
        return [f"link to {span.text}, where there is no file"]
    if heading and heading not in _headings(target):
        return [f"link to {span.text}, where there is no such heading"]
    return []


def targets(root: Path, span: Span) -> list[str]:
    """`make TARGET` is in the Makefile."""
    found = _MAKE.match(span.text) if span.kind in ("ticked", "sh") else None
    if not found or found[1] in _TARGET.findall((root / "Makefile").read_text(encoding="utf-8")):
        return []
    return [f"no target {found[1]} in the Makefile"]


def modules(root: Path, span: Span) -> list[str]:
    """`python -m MODULE` is a module, or a package that can be run."""
    return [f"no module {name} to run" for name in _MODULE.findall(span.text) if span.kind != "link" and not _runs(root, name)]


def _runs(root: Path, name: str) -> bool:
    first = name.split(".")[0]
    if first not in ROOTS:
        return importlib.util.find_spec(first) is not None
    place = root.joinpath(*name.split("."))
    return place.with_suffix(".py").is_file() or (place / "__main__.py").is_file()


@cache
def _sources(root: Path) -> frozenset[str]:
    return frozenset(path.name for first in ROOTS for path in (root / first).rglob("*.py*"))


@cache
def _headings(document: Path) -> frozenset[str]:
    """The headings' names in links: small letters, blanks as hyphens, other signs left out."""
    titles = re.findall(r"^#+ +(.+)$", document.read_text(encoding="utf-8"), re.MULTILINE)
    return frozenset(re.sub(r"\s+", "-", re.sub(r"[^\w\s-]", "", title.lower()).strip()) for title in titles)


@cache
def _has_test(path: Path, name: str) -> bool:
    """A function, or a class and a function in it (`TestX::test_y`)."""
    body: list[ast.stmt] = ast.parse(path.read_text(encoding="utf-8")).body
    for part in name.split("::"):
        inner = [node for node in body if isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name == part]
        if not inner:
            return False
        body = inner[0].body
    return True
