"""A progress line for work that takes longer than a second."""

from __future__ import annotations

import sys
import time

#: Seconds between two messages: on a terminal, where they share one line, and in a log, where each takes a line.
_TERMINAL, _LOG = 0.0, 5.0


class ProgressLine:
    """Call it with a message. A terminal shows the latest after the first second, on one line; a log gets a line every five seconds."""

    def __init__(self) -> None:
        self._started = self._shown = time.monotonic()
        self._live = sys.stderr.isatty()
        self._open = False

    def __call__(self, message: str) -> None:
        """Show `message` if it is time to."""
        now = time.monotonic()
        if now - self._started < 1.0 or now - self._shown < (_TERMINAL if self._live else _LOG):
            return
        self._shown = now
        text = f"{now - self._started:z5.1f} s  {message}"
        if self._live:
            sys.stderr.write(f"\r\x1b[2K{text}")
            self._open = True
        else:
            sys.stderr.write(text + "\n")
        sys.stderr.flush()

    def close(self) -> None:
        """Clear the line."""
        if self._open:
            sys.stderr.write("\r\x1b[2K")
            sys.stderr.flush()
            self._open = False
