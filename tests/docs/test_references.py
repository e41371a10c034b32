"""What the documents and the comments name is there: files, tests, headings, make targets, modules, command lines, names of the code."""

from __future__ import annotations

from pathlib import Path

import pytest

from .command_lines import command_lines
from .names import dotted, known
from .references import ROOTS, links, modules, paths, targets
from .spans import Span, of_markdown, of_source

ROOT = Path(__file__).resolve().parents[2]
DOCUMENTS = ["README.md", "CHANGELOG.md", *sorted(f"docs/{path.name}" for path in (ROOT / "docs").glob("*.md"))]
#: It tells of names that were.
HISTORY = "CHANGELOG.md"


def complaints(document: str, text: str) -> list[str]:
    """All complaints about a document, each with its line."""
    told = []
    for span in of_markdown(text):
        found = [*common(span), *links(ROOT, document, span)]
        if document != HISTORY:
            found += [*dotted(span), *known(ROOT, span)]
        told += [f"{document}:{span.line}: {complaint}" for complaint in found]
    return told


def common(span: Span) -> list[str]:
    return [*paths(ROOT, span), *targets(ROOT, span), *modules(ROOT, span), *command_lines(span)]


@pytest.mark.parametrize("document", DOCUMENTS)
def test_what_a_document_names_is_there(document: str):
    assert complaints(document, (ROOT / document).read_text(encoding="utf-8")) == []


@pytest.mark.parametrize("package", [root for root in ROOTS if root not in ("docs", "typings")])
def test_what_docstrings_and_comments_name_is_there(package: str):
    here = Path(__file__).parent  # this folder's own texts show what is not there
    told = [
        f"{path.relative_to(ROOT)}:{span.line}: {complaint}"
        for path in sorted((ROOT / package).rglob("*.py"))
        if here not in path.parents
        for span in of_source(path.read_text(encoding="utf-8"))
        for complaint in [*common(span), *dotted(span)]
    ]
    assert told == []


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("see `tests/energy_mgr/test_gone.py`", "no file tests/energy_mgr/test_gone.py"),
        ("see `energy_mgr/gone/`", "no file energy_mgr/gone/"),
        ("rooms: `gone_module.py`", "no file gone_module.py anywhere"),
        ("`tests/conftest.py::test_gone`", "no test test_gone in tests/conftest.py"),
        ("![a picture](gone.png)", "link to gone.png, where there is no file"),
        ("[theory](theory.md#gone)", "link to theory.md#gone, where there is no such heading"),
        ("`make gone`", "no target gone in the Makefile"),
        ("```sh\nmake gone  # once\n```", "no target gone in the Makefile"),
        ("`python -m benchmarks.gone`", "no module benchmarks.gone to run"),
        ("`python -m powertrain`", "no module powertrain to run"),
        ("```sh\npython -m gone_package\n```", "no module gone_package to run"),
        ("`energy-mgr fly commute`", "no command fly in `energy-mgr`"),
        ("`energy-mgr roads info|gone`", "no command gone in `energy-mgr roads`"),
        ("`vehicle gone`", "no command gone in `energy-mgr vehicle`"),
        ("```sh\n.venv/bin/energy-mgr plan rural --gone 3\n```", "`energy-mgr plan`: No such option"),
        ("`energy-mgr plan rural --corridor gone`", "`energy-mgr plan` --corridor: 'gone' is not one of"),
        ("`energy-mgr plan rural --time soon`", "`energy-mgr plan` --time: 'soon' is not a valid float"),
        ("`energy-mgr plan rural --time`", "`energy-mgr plan`: Option '--time' requires an argument"),
        ("`energy-mgr plan rural commute`", "`energy-mgr plan` takes no further commute"),
        ("`--gone 3`", "no command has an option --gone"),
        ("`--corridor gone`", "--corridor: 'gone' is not one of"),
        ("`energy_mgr.speed.comparison.nlp.gone_profile(limits)`", "no energy_mgr.speed.comparison.nlp.gone_profile in the code"),
        ("```python\nroads.gone('x.xodr')\n```", "no roads.gone in the code"),
        ("::: powertrain.gone\n`powertrain.gone`", "no powertrain.gone in the code"),
        ("`Plaanner.step`", "Plaanner (of `Plaanner.step`) is no word of the code"),
    ],
)
def test_a_stale_reference_is_found(text: str, says: str):
    told = complaints("docs/results.md", text)
    assert len(told) == 1
    assert says in told[0]


@pytest.mark.parametrize(
    "text",
    [
        "`tests/conftest.py`, `tests/*.csv`, `request.py`, https://example.org/docs/gone.md",
        "`tests/docs/test_references.py::test_a_stale_reference_is_found`",
        "[theory](theory.md#speed), [there](https://example.org), [below](#closed-loop)",
        "`make plan`, `python -m benchmarks`, `python -m pip wheel .`, `python -W error -m roads.gallery.archetypes`",
        "`energy-mgr roads check FILE`, `energy-mgr battery fit FILES... -o cell.toml`, `--road ID`",
        "`--path-method gradient|slsqp`, `vehicle map NAME`",
        "```sh\nenergy-mgr simulate commute --soc 0.5 # a drive\n```",
        "`energy_mgr.plan(road)`, `powertrain.Plant`, `roads.RoadBuilder.straight`, `Measurements.wheel_speeds`",
    ],
)
def test_a_good_reference_is_let_pass(text: str):
    assert complaints("docs/results.md", text) == []
