"""Runs the Python blocks of one document, in the fresh environment: `python run_blocks.py blocks.json results.json`.

What stands before a document's first section is known in all sections; each section goes on from there and knows nothing of the others, as a
reader does who opens the document at one recipe. Within a section later blocks know the earlier ones. Warnings are errors: a document does not
show what a library complains of.
"""

from __future__ import annotations

import json
import linecache
import sys
import time
import traceback
import warnings
from pathlib import Path
from typing import Any


def main(wanted: str, answered: str) -> None:
    """Run the blocks that the first file lists and write what became of them to the second, after each block."""
    sys.path[0] = ""  # as in a shell of the reader's; a script has its own folder there
    warnings.simplefilter("error")
    # binary packages made by SWIG before 4.4 warn of themselves on Python 3.12 and newer when they are loaded
    warnings.filterwarnings("ignore", message="builtin type (swig|Swig)", category=DeprecationWarning)
    common: dict[str, Any] = {"__name__": "__main__"}
    sections: dict[str, dict[str, Any]] = {}
    results = []
    for block in json.loads(Path(wanted).read_text(encoding="utf-8")):
        names = sections.setdefault(block["section"], dict(common)) if block["section"] else common
        start = time.monotonic()
        failure = _run(block, names)
        results.append({"seconds": time.monotonic() - start, "failure": failure})
        Path(answered).write_text(json.dumps(results), encoding="utf-8")


def _run(block: dict[str, Any], names: dict[str, Any]) -> str:
    """Run a block; what went wrong, told with the document's own lines, or nothing."""
    source = "\n" * (block["line"] - 1) + block["text"]
    place = block["document"]
    linecache.cache[place] = (len(source), None, source.splitlines(keepends=True), place)
    try:
        exec(compile(source, place, "exec"), names)
    except BaseException:  # SystemExit too: a document's block does not end its reader's session
        kept = traceback.format_exc().splitlines()
        return "\n".join(line for line in kept if "run_blocks.py" not in line and "exec(compile" not in line)
    return ""


if __name__ == "__main__":
    main(*sys.argv[1:])
