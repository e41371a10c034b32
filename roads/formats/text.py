"""Reading and writing whole files, with errors that a person can act on."""

from __future__ import annotations

import gc
import os
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import RoadError

if TYPE_CHECKING:
    from collections.abc import Iterator

#: Larger files are refused unread, bytes.
LARGEST_FILE = 512 * 1024 * 1024


def read_bytes(path: Path) -> bytes:
    """The content of `path`.

    Raises:
        RoadError: missing, a folder, unreadable, empty, or larger than 512 MiB.
    """
    try:
        if path.is_dir():
            raise RoadError(f"{path}: is a folder, expected a file")
        size = path.stat().st_size
        if size > LARGEST_FILE:
            raise RoadError(f"{path}: {size / 2**20:.0f} MiB, expected at most {LARGEST_FILE // 2**20}")
        data = path.read_bytes()
    except FileNotFoundError:
        raise RoadError(f"{path}: no such file") from None
    except (OSError, ValueError) as error:
        raise RoadError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if not data:
        raise RoadError(f"{path}: empty file")
    return data


@contextmanager
def garbage_later() -> Iterator[None]:
    """No collection of garbage meanwhile: a reader makes many objects and no cycles, and looking for them costs it a fifth of its time."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


def read_text(path: Path) -> str:
    """The content of `path` as UTF-8 text, with or without byte order mark.

    Raises:
        RoadError: as `read_bytes`, or not UTF-8.
    """
    try:
        return read_bytes(path).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise RoadError(f"{path}: not a text file (byte {error.start} is not UTF-8)") from None


def write_whole(path: Path, content: str | bytes) -> None:
    """Write `content` to `path` through a temporary file beside it: whole or not at all.

    Raises:
        RoadError: the folder is missing or cannot be written to.
    """
    try:
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    except OSError as error:
        raise RoadError(f"{path}: cannot be written: {error.strerror}") from None
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content.encode("utf-8") if isinstance(content, str) else content)
        Path(temporary).chmod(0o644)
        Path(temporary).replace(path)
    except OSError as error:
        Path(temporary).unlink(missing_ok=True)
        raise RoadError(f"{path}: cannot be written: {error.strerror}") from None
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
