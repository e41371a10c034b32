"""Figures that tests measure, printed after a run, so that the test that holds a documented figure is also the command that prints it.

    .venv/bin/pytest tests/acceptance/test_paths.py -k t32

`tests/conftest.py` takes both names below over. What is measured travels as a property of the test's report, so that it comes through pytest-xdist
and is printed whether the test passed or not.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, TypeVar

import pytest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from _pytest.terminal import TerminalReporter

Value = TypeVar("Value")

#: Name of the property of a report that carries a figure.
PROPERTY = "figure"
#: Widest column that others are aligned to.
WIDEST = 90
#: Headings of the columns that every figure has: name, measured, and what was published or asked for.
COLUMNS = ("figure", "measured", "published or asked", "test")


class Recorder(Protocol):
    """What the fixture `figure` gives."""

    def __call__(self, name: str, measured: Value, form: str = ..., *, published: str = ..., asked: str = ...) -> Value: ...


@pytest.fixture
def figure(record_property: Callable[[str, object], None]) -> Recorder:
    """Record a figure under a name, and give it back: `assert figure("gap", gap, "{:.1e}", asked="1 %") < 0.01`.

    `form` prints it; of a tuple each part is one field. Record before asserting, so that a figure that is wrong is printed, too.
    """

    def record(name: str, measured, form: str = "{:.4g}", *, published: str = "", asked: str = ""):
        text = form.format(*measured) if isinstance(measured, tuple) else form.format(measured)
        beside = [f"published {published}"] * bool(published) + [f"asked {asked}"] * bool(asked)
        # plain words, which every transport between processes can carry
        record_property(PROPERTY, [name, text, ", ".join(beside)])
        return measured

    return record


def recorded(reporter: TerminalReporter) -> Iterator[tuple[str, str, str, str]]:
    """All figures of a run, those of a test and of a file together, since tests that run side by side end in any order."""
    reports = [report for outcome in reporter.stats.values() for report in outcome if getattr(report, "when", None) == "call"]
    for report in sorted(reports, key=lambda one: one.nodeid.split("::")[0]):
        for name, value in report.user_properties:
            if name == PROPERTY:
                label, measured, beside = value
                yield label, measured, beside, report.nodeid + (" FAILED" if report.failed else "")


def pytest_terminal_summary(terminalreporter: TerminalReporter) -> None:
    """One line per figure, in columns."""
    lines = list(recorded(terminalreporter))
    if not lines:
        return
    # a row of a table as one figure is wider than all others, which need not stand so far apart for it
    widths = [min(max(len(line[column]) for line in (COLUMNS, *lines)), WIDEST) for column in range(3)]
    terminalreporter.section("figures")
    for line in (COLUMNS, *lines):
        terminalreporter.line("  ".join([*(cell.ljust(width) for cell, width in zip(line, widths, strict=False)), line[3]]))
