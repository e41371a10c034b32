"""Reference lines of OpenDRIVE by plain quadrature: an oracle for tests, slow and short."""

from __future__ import annotations

from xml.etree import ElementTree as ET

import numpy as np

GAUSS = np.polynomial.legendre.leggauss(8)


def cubic(nodes: list[ET.Element], key: str, shift: float, s: np.ndarray) -> np.ndarray:
    """Piecewise cubics of the station; zero before the first."""
    value = np.zeros(len(s))
    for node in nodes:
        a, b, c, d = (float(node.get(name, "nan")) for name in "abcd")
        t = s - (float(node.get(key, "nan")) + shift)
        value = np.where(t >= -1e-12, a + b * t + c * t**2 + d * t**3, value)
    return value


class Line:
    """A plan view; `at` gives places (n, 2) and headings (n,)."""

    def __init__(self, nodes: list[ET.Element]) -> None:
        self.pieces = [_Piece(node) for node in nodes]
        self.starts = np.append(0.0, np.cumsum([piece.length for piece in self.pieces]))
        self.length = float(self.starts[-1])

    def at(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        place, heading = np.empty((len(s), 2)), np.empty(len(s))
        which = np.clip(np.searchsorted(self.starts, s, side="right") - 1, 0, len(self.pieces) - 1)
        for k in np.unique(which):
            here = which == k
            piece = self.pieces[k]
            place[here], heading[here] = piece.at(np.clip(s[here] - self.starts[k], 0.0, piece.length))
        return place, heading


class _Piece:
    def __init__(self, node: ET.Element) -> None:
        self.x, self.y, self.hdg, self.length = (float(node.get(key, "nan")) for key in ("x", "y", "hdg", "length"))
        shape = next(iter(node))
        self.kind = shape.tag
        number = {key: float(value) for key, value in shape.attrib.items() if key != "pRange"}
        if self.kind in ("line", "arc", "spiral"):
            first = number.get("curvature", number.get("curvStart", 0.0))
            self.curvature = first, number.get("curvature", number.get("curvEnd", 0.0))
            return
        if self.kind == "poly3":
            self.u, self.v = (0.0, 1.0, 0.0, 0.0), tuple(number[key] for key in "abcd")
        else:
            self.u, self.v = (tuple(number[f"{key}{axis}"] for key in "abcd") for axis in "UV")
        end = self.length if self.kind == "poly3" or shape.get("pRange") == "arcLength" else 1.0
        self.p = np.linspace(0.0, end, 4001)
        way = np.append(0.0, np.cumsum(np.hypot(*(np.diff(_value(row, self.p)) for row in (self.u, self.v)))))
        # a poly3 ends where it is as long as it says, parameters by length are the length, others go with the way
        self.way = way if self.kind == "poly3" else self.p if end != 1.0 else way * self.length / way[-1]

    def at(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        if self.kind in ("line", "arc", "spiral"):
            u, v, turn = self._clothoid(s)
        else:
            p = np.interp(s, self.way, self.p)
            u, v = _value(self.u, p), _value(self.v, p)
            turn = np.arctan2(*(row[1] + 2 * row[2] * p + 3 * row[3] * p**2 for row in (self.v, self.u)))
        c, sn = np.cos(self.hdg), np.sin(self.hdg)
        return np.column_stack([self.x + c * u - sn * v, self.y + sn * u + c * v]), self.hdg + turn

    def _clothoid(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        first, rate = self.curvature[0], (self.curvature[1] - self.curvature[0]) / self.length
        # twenty panels of eight points each: exact to rounding for turns of a few radians
        edges = np.linspace(0.0, 1.0, 21)
        nodes, weights = (0.5 * (GAUSS[0] + 1.0)), 0.5 * GAUSS[1]
        share = (edges[:-1, None] + nodes * 0.05).ravel()
        w = np.tile(weights * 0.05, 20)
        at = s[:, None] * share
        turn = first * at + 0.5 * rate * at**2
        return s * (np.cos(turn) @ w), s * (np.sin(turn) @ w), first * s + 0.5 * rate * s**2


def _value(row: tuple[float, ...], p: np.ndarray) -> np.ndarray:
    return row[0] + row[1] * p + row[2] * p**2 + row[3] * p**3
