"""Numeric variables of MATLAB's .mat files, version 5 (what MATLAB saves by default up to -v7).

SciPy has a reader for all of the format, but a damaged file can bring it down together with the process. This one takes real
matrices and structs of them, checks every size before it uses it, and leaves everything else aside. Format: MAT-File Format, The MathWorks.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...errors import RoadError
from ..text import read_bytes

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Values = dict[str, "Floats | Values"]

#: All packed variables together may unpack to so much, bytes.
LARGEST_UNPACKED = 256 * 1024 * 1024
#: Data types of the format, and classes of arrays that hold numbers.
_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_MATRIX, _PACKED = 14, 15
_STRUCT, _NUMERIC = 2, range(6, 16)
_COMPLEX = 0x0800


@dataclass
class _Bytes:
    """A stretch of the file being read; `order` is `<` or `>`."""

    path: Path
    data: bytes
    order: str
    at: int = 0

    def damaged(self, what: str) -> RoadError:
        return RoadError(f"{self.path}: damaged near byte {self.at}: {what}")

    def element(self) -> tuple[int, bytes]:
        """Type and content of the next element; small ones hold up to four bytes within their tag."""
        tag = self.data[self.at : self.at + 8]
        if len(tag) < 8:
            raise self.damaged("it ends within a tag")
        first, size = np.frombuffer(tag, self.order + "u4").tolist()
        if first >> 16:
            kind, size, start = first & 0xFFFF, first >> 16, self.at + 4
            after = self.at + 8
            if size > 4:
                raise self.damaged(f"a small element of {size} bytes")
        else:
            kind, start = first, self.at + 8
            after = start + size + (-size % 8 if kind != _PACKED else 0)
        if start + size > len(self.data):
            raise self.damaged(f"an element of {size} bytes, {max(len(self.data) - start, 0)} are left")
        self.at = min(after, len(self.data))
        return kind, self.data[start : start + size]

    def numbers(self) -> NDArray[np.generic]:
        """The next element as numbers."""
        kind, content = self.element()
        if kind not in _TYPES:
            raise self.damaged(f"type {kind} where numbers are expected")
        form = np.dtype(self.order + _TYPES[kind])
        if len(content) % form.itemsize:
            raise self.damaged(f"{len(content)} bytes are no whole number of {form.name}")
        return np.frombuffer(content, form)

    def whole_numbers(self) -> list[int]:
        """The next element as whole numbers."""
        found = self.numbers()
        if found.dtype.kind not in "iu":
            raise self.damaged("fractions where whole numbers are expected")
        return found.tolist()


def read_variables(path: Path) -> Values:
    """Names and values of the real numeric arrays, and of the structs of them, in the order of the file.

    Raises:
        RoadError: no MATLAB 5 file, a damaged one, or one that unpacks to more than 256 MiB.
    """
    data = read_bytes(path)
    if len(data) < 128 or data[126:128] not in (b"IM", b"MI") or data[:4] == b"\x00\x00\x00\x00":
        raise RoadError(f"{path}: not a MATLAB 5 file (save with -v7 or -v6; version 7.3 is HDF5 and not read)")
    order = "<" if data[126:128] == b"IM" else ">"
    top = _Bytes(path, data, order, 128)
    found: Values = {}
    left = LARGEST_UNPACKED
    while top.at < len(data):
        kind, content = top.element()
        if kind == _PACKED:
            content = _unpacked(path, content, left)
            left -= len(content)
            kind, content = _Bytes(path, content, order).element()
        if kind == _MATRIX:
            name, value = _array(_Bytes(path, content, order), depth=0)
            if value is not None:
                found[name] = value
    return found


def _unpacked(path: Path, content: bytes, left: int) -> bytes:
    try:
        made = zlib.decompressobj().decompress(content, left)
    except zlib.error:
        raise RoadError(f"{path}: packed data are damaged") from None
    if len(made) >= left:
        raise RoadError(f"{path}: unpacks to more than {LARGEST_UNPACKED // 2**20} MiB, expected a path")
    return made


def _array(source: _Bytes, depth: int) -> tuple[str, Floats | Values | None]:
    """Name and value of one array; None where it is of a kind that is left aside (text, cells, objects, complex, sparse)."""
    flags = source.whole_numbers()
    if not flags:
        raise source.damaged("an array without flags")
    flag = flags[0]
    shape = source.whole_numbers()
    name = source.element()[1].decode("ascii", "replace")
    kind = flag & 0xFF
    if kind == _STRUCT and depth == 0:
        return name, _struct(source, shape)
    if kind not in _NUMERIC or flag & _COMPLEX:
        return name, None
    values = source.numbers()
    if len(shape) < 2 or min(shape) < 0 or int(np.prod(np.array(shape, dtype=object))) != len(values):
        raise source.damaged(f"{len(values)} values for shape {'x'.join(map(str, shape[:6]))}")
    return name, values.astype(np.float64).reshape(shape, order="F")


def _struct(source: _Bytes, shape: list[int]) -> Values | None:
    """Fields of a single struct; arrays of structs are left aside."""
    if any(length != 1 for length in shape):
        return None
    (width, *_) = source.whole_numbers() or [0]
    text = source.element()[1]
    if not 0 < width <= 64 or len(text) % width:
        raise source.damaged(f"field names of {width} letters in {len(text)} bytes")
    names = [text[k : k + width].split(b"\0")[0].decode("ascii", "replace") for k in range(0, len(text), width)]
    made: Values = {}
    for name in names:
        kind, content = source.element()
        if kind != _MATRIX:
            raise source.damaged(f"type {kind} where a field is expected")
        if content:
            value = _array(_Bytes(source.path, content, source.order), depth=1)[1]
            if value is not None:
                made[name] = value
    return made
