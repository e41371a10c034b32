"""Damaged copies of a good file, for fuzzing: seeded, mostly still well-formed, so that the inside of a reader is reached."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy as np

NUMBER = re.compile(rb"(?<![\w.])-?\d+\.?\d*(?:[eE][-+]?\d+)?(?![\w.])")
ATTRIBUTE = re.compile(rb'\s[\w:]+="[^"]*"')
ELEMENT = re.compile(rb"<(\w+)\b[^<>]*/>|<(\w+)\b[^<>]*>[^<>]*</\2>")
NASTY = [
    *b"nan inf -inf 1e308 -1e308 1e-308 0 -0 -1 1 2 0.5 1e5 1e9 1e18 99999999999999999999 abc 0x10 1,5 1_0 true null".split(),
    b"",
    b"1" * 5000,
    "٣".encode(),
    b"\x00",
]
FACTORS = (-1.0, 1e3, 1e-6, 10.0, 0.1, 1.0 + 1e-9, 0.0)
BOMB = b'<!DOCTYPE a [<!ENTITY b "bbbbbbbbbb"><!ENTITY c "&b;&b;&b;&b;&b;&b;"><!ENTITY f SYSTEM "file:///etc/hostname">]>'


def mutants(seed: bytes, count: int, rng: np.random.Generator) -> Iterator[bytes]:
    """Yield `count` damaged copies of `seed`, each with one to three wounds."""
    for _ in range(count):
        made = seed
        for _ in range(int(rng.integers(1, 4))):
            made = _tame(made, rng) if rng.random() < 0.8 else _wild(made, rng)
        yield made


def _tame(data: bytes, rng: np.random.Generator) -> bytes:
    """A number, an attribute, an element or a line is changed; what is well-formed mostly stays so."""
    kind = int(rng.integers(0, 8))
    if kind < 4:
        found = list(NUMBER.finditer(data))
        if not found:
            return data
        match = found[int(rng.integers(len(found)))]
        scaled = repr(float(match[0]) * FACTORS[int(rng.integers(len(FACTORS)))]).encode()
        word = NASTY[int(rng.integers(len(NASTY)))] if kind < 2 else scaled
        return data[: match.start()] + word + data[match.end() :]
    pattern = ATTRIBUTE if kind == 4 else ELEMENT if kind < 7 else None
    spans = [match.span() for match in pattern.finditer(data)] if pattern else []
    if not spans:
        lines = data.splitlines(keepends=True)
        start = int(rng.integers(len(lines))) if lines else 0
        spans = [(sum(map(len, lines[:start])), sum(map(len, lines[: start + 1])))]
    a, b = spans[int(rng.integers(len(spans)))]
    if kind == 4 or rng.random() < 0.5:
        return data[:a] + data[b:]
    to = spans[int(rng.integers(len(spans)))][0]
    return data[:to] + data[a:b] + data[to:]


def _wild(data: bytes, rng: np.random.Generator) -> bytes:
    """Bytes are changed, whatever they mean."""
    kind = int(rng.integers(0, 7))
    a, b = sorted(rng.integers(0, len(data) + 1, 2).tolist())
    b = min(b, a + 200)
    if kind == 0:
        at = int(rng.integers(max(len(data), 1)))
        return data[:at] + bytes([int(rng.integers(256))]) + data[at + 1 :]
    if kind == 1:
        return data[:a] + data[b:]
    if kind == 2:
        return data[:b] + data[a:b] * int(rng.integers(1, 50)) + data[b:]
    if kind == 3:
        return data[: max(b, len(data) // 2)]
    if kind == 4:
        return data[:a] + rng.bytes(int(rng.integers(1, 30))) + data[a:]
    if kind == 5:
        return data.replace(b"?>", b"?>" + BOMB, 1) if rng.random() < 0.5 else BOMB + data
    deep = int(rng.integers(10, 20_000))
    return data[:a] + (b"<a>" if data[:1] == b"<" else b"[") * deep + data[a:]
