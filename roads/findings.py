"""What a check of a road file finds, with place and severity."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from .errors import RoadError

Severity = Literal["error", "warning", "note"]


@dataclass(frozen=True)
class Finding:
    """One finding.

    Attributes:
        severity: `error`: this part cannot be used; `warning`: used, but look at it; `note`: something in the file is not read.
        place: file, line and element.
        message: what was found and what was expected.
    """

    severity: Severity
    place: str
    message: str

    def __str__(self) -> str:
        """As one line."""
        return f"{self.severity}: {self.place}: {self.message}"


@dataclass
class Findings:
    """Collects findings while a file is read; the same note is kept once per kind, with a count."""

    items: list[Finding] = field(default_factory=list)
    _notes: dict[str, tuple[str, int]] = field(default_factory=dict)

    def warn(self, place: str, message: str) -> None:
        """Something that is used as it is, but deserves a look."""
        self.items.append(Finding("warning", place, message))

    def error(self, error: RoadError) -> None:
        """A part that cannot be used; `error` carries place and message."""
        place, _, message = str(error).partition(": ")
        self.items.append(Finding("error", place, message))

    def note(self, place: str, message: str, times: int = 1) -> None:
        """A kind of content that is not read; the first place is kept, further ones are counted."""
        first, count = self._notes.get(message, (place, 0))
        self._notes[message] = first, count + times

    def all(self) -> list[Finding]:
        """Errors first, then warnings, then notes."""
        notes = [Finding("note", place, message + (f" ({count} times)" if count > 1 else "")) for message, (place, count) in self._notes.items()]
        rank = {"error": 0, "warning": 1, "note": 2}
        return sorted([*self.items, *notes], key=lambda finding: rank[finding.severity])

    def errors(self) -> list[Finding]:
        """Errors only."""
        return [finding for finding in self.items if finding.severity == "error"]
