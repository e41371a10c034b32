"""The elements that road designers draw with: straight, arc, clothoid and cubic, one after the other, seen from above."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from .clothoid import PANEL, clothoid, many

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

#: A spline through the sampled points stays this close to the elements, m.
TOLERANCE = 2e-5
#: Step of curvature that the ends of roads are prepared for, 1/m.
END_JUMP = 0.1
#: Longest distance of two samples, m.
LONGEST_STEP = 5.0
#: A cubic is measured in this many parts.
_PARTS = 16
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)


@dataclass(frozen=True)
class Clothoid:
    """Curvature runs linearly from `start` to `end` (1/m); a straight and an arc are its special cases.

    Attributes:
        x: m, where the element starts.
        y: m.
        heading: rad, at its start.
        length: m.
        start: curvature at the start, 1/m, positive left.
        end: curvature at the end, 1/m.
    """

    x: float
    y: float
    heading: float
    length: float
    start: float = 0.0
    end: float = 0.0

    def at(self, s: Floats) -> tuple[Floats, Floats]:
        """Points (n, 2) in m and headings (n,) in rad at arc lengths `s` (n,) from the element's start."""
        points, psi = clothoid(s, self.start, (self.end - self.start) / self.length)
        return _placed(self.x, self.y, self.heading, points), self.heading + psi

    def curvature(self, s: Floats) -> Floats:
        """Curvature (n,) in 1/m."""
        return self.start + (self.end - self.start) / self.length * s


@dataclass(frozen=True)
class Cubic:
    """A plane cubic `u(p), v(p)` in the frame of its start (OpenDRIVE's poly3 and paramPoly3).

    Attributes:
        x: m, where the frame is.
        y: m.
        heading: rad, of the frame's u axis.
        length: m, along the road.
        u: coefficients of p^0 to p^3, m.
        v: as `u`.
        end: the parameter at the end of the element.
        speed: how p runs with the road's station: `unit` p = s; `arc` so that equal parts of p's curve length are equal parts of the road.
    """

    x: float
    y: float
    heading: float
    length: float
    u: tuple[float, float, float, float]
    v: tuple[float, float, float, float]
    end: float
    speed: Literal["unit", "arc"]

    def at(self, s: Floats) -> tuple[Floats, Floats]:
        """Points (n, 2) in m and headings (n,) in rad at stations `s` (n,) from the element's start."""
        return _Cubics([self]).at(np.zeros(len(s), dtype=np.intp), s)

    def curvature(self, s: Floats) -> Floats:
        """Curvature (n,) in 1/m."""
        return _Cubics([self]).curvature(np.zeros(len(s), dtype=np.intp), s)

    def by_arc_length(self) -> Cubic:
        """The same curve with stations that count its own length."""
        return replace(self, length=self.true_length, speed="arc")

    @property
    def true_length(self) -> float:
        """Length of the cubic itself, m, whatever the road's stations say."""
        return float(_Cubics([self]).true_length[0])


class _Cubics:
    """Many cubics as columns."""

    def __init__(self, cubics: Sequence[Cubic]) -> None:
        frame = np.array([(c.x, c.y, c.heading, c.length, c.end, c.speed == "unit") for c in cubics]).reshape(-1, 6)
        self.x, self.y, self.heading, self.length, self.end, unit = frame.T
        self.unit = unit > 0.0
        # real part u, imaginary part v; one row per power of p
        self.rows = np.array([[complex(u, v) for u, v in zip(c.u, c.v, strict=True)] for c in cubics]).reshape(-1, 4).T
        self.true_length = self._way(np.arange(len(cubics)), self.end)

    def _rate(self, index: NDArray[np.intp], p: Floats) -> NDArray[np.complex128]:
        _, b, c, d = self.rows[:, index] if p.ndim == 1 else self.rows[:, index][..., None]
        return b + (2.0 * c + 3.0 * d * p) * p

    def _way(self, index: NDArray[np.intp], p: Floats) -> Floats:
        """Arc length from the start to the parameters `p`."""
        half = 0.5 * p
        return half * (np.abs(self._rate(index, half[:, None] * (1.0 + _NODES))) @ _WEIGHTS)

    def parameter(self, index: NDArray[np.intp], s: Floats) -> Floats:
        """The parameters p at stations `s`: s itself, or where as much of the cubic's length has passed as of the element's."""
        if np.all(self.unit[index]):
            return s
        p = s * (self.end / self.length)[index]
        wanted = s * (self.true_length / self.length)[index]
        for _ in range(8):
            move = (self._way(index, p) - wanted) / np.maximum(np.abs(self._rate(index, p)), 1e-9)
            p = np.clip(p - move, 0.0, self.end[index])
            if np.max(np.abs(move), initial=0.0) < 1e-13:
                break
        return np.where(self.unit[index], s, p)

    def at(self, index: NDArray[np.intp], s: Floats) -> tuple[Floats, Floats]:
        """Points (n, 2) and headings (n,) on the cubics `index` (n,) at stations `s` (n,) along each."""
        p = self.parameter(index, s)
        a, b, c, d = self.rows[:, index]
        heading = self.heading[index]
        place = np.exp(1j * heading) * (a + (b + (c + d * p) * p) * p)
        rate = b + (2.0 * c + 3.0 * d * p) * p
        return np.column_stack([self.x[index] + place.real, self.y[index] + place.imag]), heading + np.angle(rate)

    def curvature(self, index: NDArray[np.intp], s: Floats) -> Floats:
        """Curvature (n,) in 1/m."""
        p = self.parameter(index, s)
        _, _, c, d = self.rows[:, index]
        rate, bend = self._rate(index, p), 2.0 * c + 6.0 * d * p
        return (rate.conj() * bend).imag / np.maximum(np.abs(rate), 1e-12) ** 3


Element = Clothoid | Cubic


class PlanView:
    """Many elements, of one road or of many, as columns: evaluated and sampled together, which is what makes large networks quick.

    Args:
        elements: in order.
        follows: whether each element goes on from the one before it (the first of a road does not).
    """

    def __init__(self, elements: Sequence[Element], follows: NDArray[np.bool_]) -> None:
        self.elements = elements
        self.follows = follows
        frame = np.array([(e.x, e.y, e.heading, e.length) for e in elements])
        self.x, self.y, self.heading, self.length = frame.T
        self.cubics = np.array([k for k, element in enumerate(elements) if isinstance(element, Cubic)], dtype=np.intp)
        ends = np.array([(0.0, 0.0) if isinstance(e, Cubic) else (e.start, e.end) for e in elements])
        self.start, self.end = ends[:, 0].copy(), ends[:, 1].copy()
        self.rate = (self.end - self.start) / self.length  # cubics have theirs evaluated apart
        self.bend = np.maximum(np.abs(self.start), np.abs(self.end))
        self.change = np.abs(self.end - self.start)
        if len(self.cubics):
            self._cubic = _Cubics([element for element in elements if isinstance(element, Cubic)])
            count = 2 * _PARTS + 1
            which = np.repeat(np.arange(len(self.cubics)), count)
            looks = (self.length[self.cubics][:, None] * np.linspace(0.0, 1.0, count)).ravel()
            kappa = self._cubic.curvature(which, looks).reshape(-1, count)
            self.start[self.cubics], self.end[self.cubics] = kappa[:, 0], kappa[:, -1]
            self.bend[self.cubics] = np.max(np.abs(kappa), axis=1)
            self.change[self.cubics] = np.max(np.abs(np.diff(kappa)), axis=1) * (count - 1)

    def at(self, index: NDArray[np.intp], s: Floats) -> tuple[Floats, Floats]:
        """Points (n, 2) in m and headings (n,) in rad, at arc length `s` (n,) along the elements `index` (n,), which must be sorted."""
        kappa, rate = self.start[index], self.rate[index]
        turn = (kappa + 0.5 * rate * s) * s
        local = s.astype(np.complex128)
        arc = (rate == 0.0) & (kappa != 0.0)
        half = 0.5 * turn[arc]
        local[arc] = s[arc] * np.sinc(half / np.pi) * np.exp(1j * half)
        bent = rate != 0.0
        short = bent & ((np.abs(kappa) + np.abs(rate * s)) * s < PANEL)
        local[short] = many(s[short], kappa[short], rate[short])
        points, psi = np.empty((len(s), 2)), self.heading[index] + turn
        heading = self.heading[index]
        placed = np.exp(1j * heading) * local
        points[:, 0], points[:, 1] = self.x[index] + placed.real, self.y[index] + placed.imag
        for k in np.unique(index[bent & ~short]).tolist():
            part = slice(*np.searchsorted(index, [k, k + 1]))
            points[part], psi[part] = self.elements[k].at(s[part])
        if len(self.cubics):
            which = np.searchsorted(self.cubics, index)
            mine = np.flatnonzero(self.cubics[np.minimum(which, len(self.cubics) - 1)] == index)
            points[mine], psi[mine] = self._cubic.at(which[mine], s[mine])
        return points, psi

    def steps(self) -> Floats:
        """(n,) longest distance of samples on each element for which a spline through them keeps `TOLERANCE`.

        A cubic spline through points h apart misses an arc by (5/384) kappa^3 h^4, and a clothoid by as much of kappa kappa'.
        """
        bend = np.maximum(self.bend, 1e-6)
        arc = (77.0 * TOLERANCE / bend**3) ** 0.25
        spiral = (77.0 * TOLERANCE * self.length / np.maximum(self.change * bend, 1e-12)) ** (1.0 / 3.0)
        return np.minimum(np.minimum(arc, spiral), LONGEST_STEP)

    def samples(self) -> tuple[NDArray[np.intp], Floats]:
        """Element and arc length along it of every sample, sorted; ends of elements included.

        A step of curvature by dk costs a spline about dk h^2 / 50; towards such steps the samples grade down. At the ends of a road they do
        so too: what goes on there may begin with any curvature.
        """
        count = np.maximum(np.ceil(self.length / self.steps()), 2).astype(np.intp)
        index = np.repeat(np.arange(len(count)), count + 1)
        within = np.arange(len(index)) - np.repeat(np.cumsum(count + 1) - count - 1, count + 1)
        s = within * (self.length / count)[index]
        s[within == count[index]] = self.length[index[within == count[index]]]
        more_index, more_s = [index], [s]
        step = self.length / count
        jump = np.where(self.follows, np.abs(self.start - np.roll(self.end, 1)), END_JUMP)
        next_jump = np.roll(jump, -1)
        for size, from_end in ((jump, False), (next_jump, True)):
            first = np.sqrt(50.0 * TOLERANCE / np.maximum(size, 1e-9))
            reach = np.zeros_like(first)
            grow = first.copy()
            while True:
                reach = reach + grow
                grow = 1.6 * grow
                fine = np.flatnonzero((first < step) & (grow < step) & (reach < 0.5 * self.length))
                if not len(fine):
                    break
                more_index.append(fine)
                more_s.append(self.length[fine] - reach[fine] if from_end else reach[fine])
        index, s = np.concatenate(more_index), np.concatenate(more_s)
        order = np.lexsort((s, index))
        return index[order], s[order]


def _placed(x: float, y: float, heading: float, points: Floats) -> Floats:
    cosine, sine = np.cos(heading), np.sin(heading)
    return np.stack([x + cosine * points[..., 0] - sine * points[..., 1], y + sine * points[..., 0] + cosine * points[..., 1]], axis=-1)
