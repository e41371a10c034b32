"""What is not run, each by name and with its reason. A name that no document has any more is a failure: the list does not outlive its reasons."""

from __future__ import annotations

#: Run before all others, in the fresh copy.
FIRST = "make plan"

LEFT_OUT = {
    "make test": "CI runs it itself, in a clean clone",
    "make docs": "serves until it is stopped; `make test` builds the pages",
    "make bench": "minutes of measuring, which need a quiet machine",
    "energy-mgr plan": "the name of the command, not a call",
}
