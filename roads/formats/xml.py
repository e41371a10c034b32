"""XML from strangers: parsed without entities, DTDs or network, within limits, with line numbers in every message."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from lxml import etree

from ..errors import RoadError
from .text import read_bytes

if TYPE_CHECKING:
    from pathlib import Path

    from ..findings import Findings

#: The parser's elements; lxml ships no types.
Node = Any
#: No coordinate, length or coefficient of a road is larger, in SI units.
LARGEST = 1e9


def parse(path: Path, root: str | None = None) -> Node:
    """The root element of the XML file at `path`, namespaces taken off.

    Args:
        path: the file.
        root: the expected name of the root element; None accepts any.

    Raises:
        RoadError: unreadable, not well-formed, nested deeper than 250, with entities or a document type, or with another root.
    """
    data = read_bytes(path)
    if b"<!ENTITY" in data or b"<!DOCTYPE" in data:
        raise RoadError(f"{path}: holds a document type or entities, which road files do not need and this reader refuses")
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False, remove_comments=True, remove_pis=True)
    try:
        found: Node = etree.fromstring(data, parser)
    except (etree.XMLSyntaxError, ValueError, LookupError) as error:
        line = getattr(error, "lineno", None)
        words = str(error).splitlines()[0] if str(error) else "empty file"
        raise RoadError(f"{path}:{line or 1}: not well-formed XML: {words}") from None
    document = found.getroottree().docinfo
    if document.doctype or document.internalDTD is not None:
        raise RoadError(f"{path}: holds a document type or entities, which road files do not need and this reader refuses")
    if "}" in found.tag or found.nsmap:
        for node in found.iter(etree.Element):
            node.tag = etree.QName(node).localname
    if root is not None and found.tag != root:
        raise RoadError(f"{path}:1: root element is <{found.tag}>, expected <{root}>")
    return found


def children(node: Node | None) -> dict[str, list[Node]]:
    """The children of `node` by tag; a pass over them costs less than one search for a path."""
    found: dict[str, list[Node]] = {}
    if node is not None:
        for child in node:
            found.setdefault(child.tag, []).append(child)
    return found


def only(found: dict[str, list[Node]], tag: str) -> Node | None:
    """The first child of that tag, None where there is none."""
    nodes = found.get(tag)
    return nodes[0] if nodes else None


class Place:
    """Reads attributes of one file's nodes and words its errors: `file:line: <tag> what`."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._name = str(path)

    def at(self, node: Node) -> str:
        """`file:line`."""
        return f"{self._name}:{node.sourceline}"

    def error(self, node: Node, message: str) -> RoadError:
        """The error to raise about `node`."""
        return RoadError(f"{self.at(node)}: <{node.tag}> {message}")

    def number(self, node: Node, key: str, default: float | None = None) -> float:
        """Attribute `key` as a finite float; missing attributes take `default`, and are an error where there is none."""
        word = node.get(key)
        if word is None:
            if default is None:
                raise self.error(node, f"has no {key}")
            return default
        return self.float(node, key, word)

    def numbers(self, node: Node, keys: tuple[str, ...]) -> list[float]:
        """Attributes `keys`, all of them needed, as finite floats: `number` in bulk."""
        get = node.get
        try:
            values = [float(get(key)) for key in keys]
        except (TypeError, ValueError):
            values = []
        # the sum of a NaN is no number, and one that is too large makes the sum so
        if values and sum(map(abs, values)) < LARGEST:
            return values
        return [self.number(node, key) for key in keys]

    def float(self, node: Node, key: str, word: str | None) -> float:
        """`word`, which node calls `key`, as a finite float."""
        try:
            value = float(word or "")
        except ValueError:
            value = float("nan")
        if not abs(value) < LARGEST:
            raise self.error(node, f"{key} is {_shown(word)}, expected a finite number below {LARGEST:g}")
        return value

    def optional(self, node: Node, key: str, default: float | None, findings: Findings) -> float | None:
        """Attribute `key` as a finite float, `default` where there is none; one that is no number is a finding, and None."""
        word = node.get(key)
        if word is None and default is not None:
            return default
        try:
            return self.float(node, key, word)
        except RoadError as error:
            message = str(error).removeprefix(f"{self.at(node)}: ")
            findings.warn(self.at(node), f"{message}; what it says is left out")
            return None

    def word(self, node: Node, key: str) -> str:
        """Attribute `key`, not empty."""
        word = (node.get(key) or "").strip()
        if not word:
            raise self.error(node, f"has no {key}")
        return word


def _shown(word: str | None) -> str:
    word = word or ""
    return repr(word if len(word) <= 40 else word[:37] + "...")
