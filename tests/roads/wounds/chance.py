"""Nodes and values by chance."""

from __future__ import annotations

import copy
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

Node = ET.Element

NUMBERS = [
    "nan",
    "inf",
    "-inf",
    "1e300",
    "-1e300",
    "1e-300",
    "1e9",
    "-1e6",
    "1e5",
    "1000",
    "100",
    "20",
    "7",
    "3",
    "1",
    "0.5",
    "0.02",
    "1e-4",
    "1e-7",
    "1e-9",
    "0",
    "-0.0",
    "-1e-7",
    "-1",
    "-3",
    "-50",
]
WORDS = ["", "abc", "0x10", "1,5", "no limit", "undefined", "٣", "9" * 400, "-", "none", "True"]


def one_of(rng: np.random.Generator, found: list[Any]) -> Any:
    return found[int(rng.integers(len(found)))] if found else None


def any_of(root: Node, rng: np.random.Generator, *paths: str) -> Node:
    """A node on one of `paths`; where there is none, one that belongs to no file."""
    node = one_of(rng, [node for path in paths for node in root.iterfind(path)])
    return ET.Element("nothing") if node is None else node


def value(rng: np.random.Generator, now: str = "") -> str:
    kind = rng.random()
    if kind < 0.35:
        try:
            factor = float(one_of(rng, [-1.0, 0.0, 0.5, 0.99, 1.0 + 1e-9, 1.02, 2.0, 10.0, 1e3, 1e-3]))
            return repr(float(now) * factor + float(one_of(rng, [0.0, 0.0, 1e-7, -1e-7, 0.01, -1.0, 3.0])))
        except ValueError:
            pass
    return str(one_of(rng, NUMBERS if kind < 0.93 else WORDS))


def spoil(node: Node, rng: np.random.Generator, *keys: str) -> None:
    key = one_of(rng, list(keys))
    if rng.random() < 0.08:
        node.attrib.pop(key, None)
    else:
        node.set(key, value(rng, node.get(key, "")))


def shuffle(parent: Node, tag: str, rng: np.random.Generator) -> None:
    """One child of that tag is repeated, dropped, or changes places with another."""
    found = [child for child in parent if child.tag == tag]
    if not found:
        return
    child, other = one_of(rng, found), one_of(rng, found)
    kind = int(rng.integers(3))
    if kind == 0:
        parent.insert(list(parent).index(other), copy.deepcopy(child))
    elif kind == 1:
        parent.remove(child)
    else:
        a, b = list(parent).index(child), list(parent).index(other)
        parent[a], parent[b] = parent[b], parent[a]
