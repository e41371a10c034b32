"""What passed and what failed, told as it happens."""

from __future__ import annotations

import threading

_LINE = 110


class Report:
    """Prints a line per thing tried and counts; may be told from several threads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._passed = 0
        self._failed: list[str] = []

    def tell(self, where: str, what: str, seconds: float, failure: str = "") -> None:
        """Something was tried.

        Args:
            where: document and line.
            what: command, or first line of a block.
            seconds: it took.
            failure: what went wrong, in lines; empty if nothing did.
        """
        shown = what if len(what) <= _LINE else what[: _LINE - 3] + "..."
        with self._lock:
            print(f"{'FAILED' if failure else 'passed'} {seconds:6.1f} s  {where:22} {shown}", flush=True)
            if failure:
                print("\n".join("    " + line for line in failure.splitlines()), flush=True)
                self._failed.append(f"{where}  {what}")
            else:
                self._passed += 1

    def note(self, where: str, what: str, reason: str) -> None:
        """Something was not tried, and why."""
        with self._lock:
            print(f"   not run   {where:22} {what}: {reason}", flush=True)

    def close(self) -> int:
        """Print once more what failed, and the sums; the exit code."""
        if self._failed:
            print("\nFailed:\n" + "\n".join(self._failed))
        print(f"{self._passed} passed, {len(self._failed)} failed")
        return 1 if self._failed else 0
