"""Processor time of a piece of work; tests that compare two of them bear the marker `timing` and run alone, in `make experiments`."""

from __future__ import annotations

import time
from collections.abc import Callable


def least_time(work: Callable[[], object], *, rounds: int = 5) -> float:
    """The least processor time of this process over some rounds, s: what the code takes where nothing else gets in its way."""
    times = []
    for _ in range(rounds):
        started = time.process_time()
        work()
        times.append(time.process_time() - started)
    return min(times)


def slowness() -> float:
    """By how much this machine takes longer for a plain loop than the one on which hang guards were chosen; at least 1."""
    return max(1.0, least_time(lambda: sum(range(1_000_000)), rounds=3) / 0.015)
