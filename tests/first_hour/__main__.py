"""`python -m tests.first_hour`: all of it, in temporary folders that are removed at the end; `--keep FOLDER` leaves them in a folder that is new."""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from .documents import Block, Command, blocks, commands
from .first import set_up
from .left_out import FIRST, LEFT_OUT, lacking
from .outcome import Report
from .place import beside, run, users_environment
from .wheel import try_wheel

CHECKOUT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent
DOCUMENTS = ("README.md", "docs/tutorial.md", "docs/how-to.md")
#: The documents' own blocks that the reader saves under a name: document, language, which of them, name.
SAVED = (("docs/tutorial.md", "", 0, "road.csv"), ("docs/tutorial.md", "", 1, "my_road.csv"), ("docs/how-to.md", "toml", 0, "stuck.toml"))
#: Documents tried at a time: the longest one keeps one core busy, the others and the wheel another.
AT_A_TIME = 2


def main(arguments: list[str] | None = None) -> int:
    """Run everything; exit code 1 if anything failed."""
    parser = argparse.ArgumentParser(prog="python -m tests.first_hour", description="Try what a user meets in the first hour.")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="where to work, to look at afterwards; must not exist")
    keep = parser.parse_args(arguments).keep
    if keep is not None:
        keep.mkdir(parents=True)
        return _all(keep.resolve())
    with tempfile.TemporaryDirectory(prefix="first-hour-") as folder:
        return _all(Path(folder).resolve())


def _all(work: Path) -> int:
    report = Report()
    fresh = work / "fresh"
    if set_up(CHECKOUT, fresh, report):
        _own_files(fresh, report)
        todo = _commands(fresh, report)
        with ThreadPoolExecutor(AT_A_TIME) as pool:
            jobs = [pool.submit(_document, beside(fresh, Path(name).stem), name, todo[name], report) for name in reversed(DOCUMENTS)]
            jobs.append(pool.submit(try_wheel, CHECKOUT, fresh, fresh, report))
        for job in jobs:
            job.result()
    return report.close()


def _own_files(fresh: Path, report: Report) -> None:
    """Make the files that stand for the reader's own, in the fresh copy."""
    ran = run([".venv/bin/python", str(HERE / "own_files.py"), "."], fresh, users_environment())
    report.tell("tests/first_hour", "python own_files.py", ran.seconds, ran.last_words if ran.code else "")
    for document, language, which, name in SAVED:
        text = [block.text for block in blocks(fresh, document) if block.language == language][which]
        (fresh / name).write_text(text, encoding="utf-8")


def _commands(fresh: Path, report: Report) -> dict[str, list[Command]]:
    """What to run for each document: each command once, where it stands first; what is not run is told."""
    seen = {FIRST: "before all others"}
    used = set()
    todo: dict[str, list[Command]] = {}
    for document in DOCUMENTS:
        todo[document] = []
        for command in commands(fresh, document):
            where = f"{document}:{command.line}"
            if command.name in LEFT_OUT:
                used.add(command.name)
                report.note(where, command.text, LEFT_OUT[command.name])
            elif need := lacking(command.text):
                report.note(where, command.text, f"needs {need}")
            elif command.name in seen:
                report.note(where, command.text, f"was run, {seen[command.name]}")
            else:
                seen[command.name] = f"from {where}"
                todo[document].append(command)
    for name in LEFT_OUT.keys() - used:
        report.tell("left_out.py", name, 0.0, "no document has this command any more, take it off the list")
    return todo


def _document(place: Path, document: str, todo: list[Command], report: Report) -> None:
    """Run a document's commands in order, then its Python blocks in order."""
    environment = users_environment(place / ".venv/bin")
    for command in todo:
        ran = run(command.text, place, environment)
        lost = [f"not written: {name}" for name in command.written if not (place / name).exists()]
        report.tell(f"{document}:{command.line}", command.text, ran.seconds, ran.last_words if ran.code else "\n".join(lost))
    shown = [block for block in blocks(place, document) if block.language == "python"]
    for block in shown:
        if need := lacking(block.text):
            report.note(f"{document}:{block.line}", "python", f"needs {need}")
    _python(place, [block for block in shown if not lacking(block.text)], environment, report)


def _python(place: Path, todo: list[Block], environment: dict[str, str], report: Report) -> None:
    """Run Python blocks in one process of the fresh environment."""
    wanted, answered = place / "blocks.json", place / "answers.json"
    wanted.write_text(json.dumps([vars(block) for block in todo]), encoding="utf-8")
    ran = run([str(place / ".venv/bin/python"), str(HERE / "run_blocks.py"), wanted.name, answered.name], place, environment)
    answers = json.loads(answered.read_text(encoding="utf-8")) if answered.exists() else []
    for k, block in enumerate(todo):
        answer = (
            answers[k]
            if k < len(answers)
            else {"seconds": 0.0, "failure": f"not reached: the process ended with exit code {ran.code}\n{ran.last_words}"}
        )
        words = "\n".join(answer["failure"].splitlines()[-12:])
        first = next(line for line in block.text.splitlines() if line.strip())
        report.tell(f"{block.document}:{block.line}", f"python: {first}", answer["seconds"], words)


if __name__ == "__main__":
    if shutil.which("make") is None or shutil.which("git") is None:
        sys.exit("needs make and git")
    sys.exit(main())
