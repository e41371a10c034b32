"""Elements of a plan view that lead from one pose to another: lines, arcs, spirals, cubics."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

#: No reference line bends tighter than this, m, so that lanes inside of it have 4 m, which a car can steer; what would is left out of the town.
TIGHTEST = 6.0


@dataclass(frozen=True)
class Pose:
    x: float
    y: float
    hdg: float

    def moved(self, ahead: float, aside: float = 0.0) -> Pose:
        c, s = np.cos(self.hdg), np.sin(self.hdg)
        return Pose(float(self.x + ahead * c - aside * s), float(self.y + ahead * s + aside * c), self.hdg)

    def turned(self, angle: float = np.pi) -> Pose:
        return replace(self, hdg=float(wrapped(self.hdg + angle)))

    def seen_from(self, other: Pose) -> tuple[float, float, float]:
        """Ahead, aside and turn in the frame of `other`."""
        dx, dy = self.x - other.x, self.y - other.y
        c, s = np.cos(other.hdg), np.sin(other.hdg)
        return float(dx * c + dy * s), float(dy * c - dx * s), float(wrapped(self.hdg - other.hdg))


@dataclass(frozen=True)
class Element:
    """One geometry: where it starts, how long it is, its kind with numbers (arc: k; spiral: k0, k1; poly3: a-d; param: aU-dU, aV-dV, by length?)."""

    start: Pose
    length: float
    kind: str
    numbers: tuple[float, ...] = ()

    def sampled(self, count: int = 65) -> tuple[np.ndarray, np.ndarray]:
        """Curvature at `count` places, and the way to them; good enough to judge by."""
        s = np.linspace(0.0, self.length, count)
        if self.kind == "line":
            return np.zeros(count), s
        if self.kind in ("arc", "spiral"):
            return np.interp(s, [0.0, self.length], [self.numbers[0], self.numbers[-1]]), s
        if self.kind == "poly3":
            _, b, c, d = self.numbers
            return (2 * c + 6 * d * s) / (1 + (b + 2 * c * s + 3 * d * s**2) ** 2) ** 1.5, s
        _, bu, cu, du, _, bv, cv, dv, by_length = self.numbers
        p = np.linspace(0.0, self.length if by_length else 1.0, count)
        du1, dv1 = bu + 2 * cu * p + 3 * du * p**2, bv + 2 * cv * p + 3 * dv * p**2
        return (du1 * (2 * cv + 6 * dv * p) - dv1 * (2 * cu + 6 * du * p)) / np.maximum(np.hypot(du1, dv1), 1e-9) ** 3, s


def wrapped(angle: float) -> float:
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)


def joined(a: Pose, b: Pose, kind: str) -> list[Element] | None:
    """From pose to pose by elements of that kind, else by two arcs; None where it would bend too tightly."""
    ahead, aside, turn = b.seen_from(a)
    if abs(aside) < 1e-9 and abs(turn) < 1e-12 and ahead > 0.0:
        return [Element(a, ahead, "line")]
    makers = {"spiral": _spirals, "param": _param, "param length": _param_by_length, "poly3": _poly3, "arc": _biarc}
    for make in (makers[kind], _biarc, _param):
        made = make(a, b)
        if made is not None and all(np.max(np.abs(element.sampled()[0])) < 1.0 / TIGHTEST for element in made) and _is_short(a, b, made):
            return made
    return None


def _is_short(a: Pose, b: Pose, made: list[Element]) -> bool:
    return sum(element.length for element in made) < 2.5 * np.hypot(b.x - a.x, b.y - a.y)


def _arc(a: Pose, b: Pose) -> Element | None:
    """The circle from `a` that ends at the place of `b`."""
    ahead, aside, _ = b.seen_from(a)
    chord = float(np.hypot(ahead, aside))
    half = float(np.arctan2(aside, ahead))
    if chord < 0.05 or abs(half) > 2.4:
        return None
    if abs(half) < 1e-12:
        return Element(a, chord, "line")
    return Element(a, chord * half / np.sin(half), "arc", (2.0 * np.sin(half) / chord,))


def _biarc(a: Pose, b: Pose) -> list[Element] | None:
    """Two arcs that meet where both their tangents are equally long."""
    v = np.array([b.x - a.x, b.y - a.y])
    ta, tb = (np.array([np.cos(p.hdg), np.sin(p.hdg)]) for p in (a, b))
    t = ta + tb
    below = 2.0 * (1.0 - ta @ tb)
    if below < 1e-12:
        if v @ tb <= 0.0:
            return None
        d = float(v @ v / (4.0 * (v @ tb)))
    else:
        d = float((-(v @ t) + np.sqrt((v @ t) ** 2 + below * (v @ v))) / below)
    middle = (np.array([a.x, a.y]) + np.array([b.x, b.y]) + d * (ta - tb)) / 2.0
    heading = 2.0 * np.arctan2(middle[1] - a.y, middle[0] - a.x) - a.hdg
    join = Pose(float(middle[0]), float(middle[1]), wrapped(heading))
    made = [_arc(a, join), _arc(join, b)]
    return None if None in made else made  # type: ignore[return-value]


def _spirals(a: Pose, b: Pose) -> list[Element] | None:
    """Two spirals, curvature from 0 to a peak and back to 0, found by Newton's method."""
    from scipy.optimize import fsolve

    ahead, aside, turn = b.seen_from(a)
    reach = float(np.hypot(ahead, aside))
    if abs(turn) < 0.2:
        return None
    u, w = np.polynomial.legendre.leggauss(24)
    u, w = 0.5 * (u + 1.0), 0.5 * w

    def miss(lengths: np.ndarray) -> list[float]:
        first, last = lengths
        peak = 2.0 * turn / (first + last)
        heading = [0.5 * peak * first * u**2, 0.5 * peak * first + peak * last * (u - 0.5 * u**2)]
        x = first * (w @ np.cos(heading[0])) + last * (w @ np.cos(heading[1]))
        y = first * (w @ np.sin(heading[0])) + last * (w @ np.sin(heading[1]))
        return [float(x - ahead), float(y - aside)]

    (first, last), _, found, _ = fsolve(miss, [0.55 * reach, 0.55 * reach], full_output=True, xtol=1e-13)
    if found != 1 or min(first, last) < 0.5 or np.hypot(*miss(np.array([first, last]))) > 1e-7:
        return None
    peak = 2.0 * turn / (first + last)
    heading = 0.5 * peak * first * u**2
    x, y = first * (w @ np.cos(heading)), first * (w @ np.sin(heading))
    join = a.moved(float(x), float(y)).turned(0.5 * peak * first)
    return [Element(a, float(first), "spiral", (0.0, float(peak))), Element(join, float(last), "spiral", (float(peak), 0.0))]


def _hermite(a: Pose, b: Pose) -> tuple[np.ndarray, np.ndarray, float]:
    """Cubics u(p), v(p) for p from 0 to 1, and the length."""
    ahead, aside, turn = b.seen_from(a)
    pull = 1.2 * float(np.hypot(ahead, aside))
    end = pull * np.array([np.cos(turn), np.sin(turn)])
    sides = []
    for goal, at_start, at_end in ((ahead, pull, end[0]), (aside, 0.0, end[1])):
        sides.append(np.array([0.0, at_start, 3 * goal - 2 * at_start - at_end, at_start + at_end - 2 * goal]))
    p = np.linspace(0.0, 1.0, 4001)
    speed = np.hypot(*[row[1] + 2 * row[2] * p + 3 * row[3] * p**2 for row in sides])
    return sides[0], sides[1], float(np.trapezoid(speed, p))


def _param(a: Pose, b: Pose) -> list[Element] | None:
    u, v, length = _hermite(a, b)
    return [Element(a, length, "param", (*u.tolist(), *v.tolist(), 0.0))]


def _param_by_length(a: Pose, b: Pose) -> list[Element] | None:
    """As writers do it: the parameter runs to the length, though it is not quite the way."""
    u, v, length = _hermite(a, b)
    scale = length ** -np.arange(4.0)
    return [Element(a, length, "param", (*(u * scale).tolist(), *(v * scale).tolist(), 1.0))]


def _poly3(a: Pose, b: Pose) -> list[Element] | None:
    ahead, aside, turn = b.seen_from(a)
    if ahead < 1.0 or abs(turn) > 0.8 or abs(aside) > 0.6 * ahead:
        return None
    slope = np.tan(turn)
    c, d = (3 * aside - slope * ahead) / ahead**2, (slope * ahead - 2 * aside) / ahead**3
    u = np.linspace(0.0, ahead, 4001)
    length = float(np.trapezoid(np.hypot(1.0, 2 * c * u + 3 * d * u**2), u))
    return [Element(a, length, "poly3", (0.0, 0.0, float(c), float(d)))]
