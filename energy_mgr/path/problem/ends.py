"""What holds where an open path begins and ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...errors import PlanningError
from .spline import PER_KNOT, ReducedSpline

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from roads import PlanarCurve

    Floats = NDArray[np.float64]


#: No lane leads across its road by more than this, rad.
_ASLANT = 0.5


@dataclass(frozen=True)
class End:
    """What is prescribed at an end; what is None the optimisation chooses.

    Attributes:
        offset: place, m left of the reference.
        heading: direction of the path against that of the reference, rad, positive left.
        curvature: curvature of the path, 1/m; needs offset and heading, with which it is linear in the variables.
        speed: metres of path per metre of station; changes the parameter, not the shape. None: as along a curve beside the reference.
    """

    offset: float | None = None
    heading: float | None = None
    curvature: float | None = None
    speed: float | None = None

    def __post_init__(self) -> None:
        given = [value for value in (self.offset, self.heading, self.curvature, self.speed) if value is not None]
        if not np.all(np.isfinite(given)):
            raise PlanningError(f"end of a path: {self}, expected finite numbers")
        if self.speed is not None and not self.speed > 0.0:
            raise PlanningError(f"end of a path: {self.speed} m of path per m of station, expected more than 0")
        if self.heading is not None and abs(self.heading) >= 1.2:
            raise PlanningError(f"end of a path: heading {self.heading:.2f} rad against the road, expected less than 1.2 rad")
        if (self.curvature is not None or self.speed is not None) and (self.offset is None or self.heading is None):
            raise PlanningError("end of a path: a prescribed curvature or speed needs a prescribed offset and heading")


def both_ends(found: Iterable[End | None]) -> tuple[End | None, End | None]:
    """What is prescribed at the start and at the end, as a tuple.

    Raises:
        PlanningError: not two of them.
    """
    ends = tuple(found)
    if len(ends) != 2:
        raise PlanningError(f"ends {ends!r}, expected two, of the start and of the end, each an End or None")
    return ends


def along(curve: PlanarCurve, reference: PlanarCurve, q: float, offset: float) -> End:
    """The end at reference station `q` on `curve`, along it; along the reference where the curve runs aslant, as beside a step of width."""
    place = reference.position(np.array([q])) + offset * reference.normal(np.array([q]))
    near, _ = curve.project(place, np.array([q * curve.length / reference.length]))
    turn = float(curve.heading(near)[0] - reference.heading(np.array([q]))[0])
    turn = float(np.arctan2(np.sin(turn), np.cos(turn)))
    return End(offset, turn if abs(turn) < _ASLANT else 0.0)


def held(
    ends: tuple[End | None, End | None], curve: PlanarCurve, spline: ReducedSpline, offset: Floats, curvature_max: float, name: str
) -> tuple[End, End]:
    """The ends of an open path; those that are not given lie along `curve`, at the `offset` (n,) that the knots begin with.

    Raises:
        PlanningError: a given curvature is above `curvature_max`, 1/m.
    """
    first, last = (
        along(curve, spline.reference, float(spline.q[k]), float(offset[k])) if end is None else end for k, end in ((0, ends[0]), (-1, ends[1]))
    )
    for end in (first, last):
        if end.curvature is not None and abs(end.curvature) > curvature_max:
            raise PlanningError(f"{name}: curvature {end.curvature:.4g} 1/m at an end, expected at most {curvature_max:.4g} 1/m")
    return first, last


def conditions(spline: ReducedSpline, end: End, *, last: bool) -> tuple[list[int], Floats, Floats]:
    """Segments, rows (k, 6) over the variables of the segment, and right-hand sides of an end.

    The first row fixes how fast the parameter runs, which leaves all shapes open: by default as along a curve beside the reference, `o' t = 1 -
    kappa e`.
    """
    knot, segment = (len(spline.q) - 1, len(spline.h) - 1) if last else (0, 0)
    tangent, normal = spline.frame[0][knot], spline.frame[1][knot]
    own = PER_KNOT if last else 0
    matrix, constant = spline.slope_at(last=last)
    size = float(spline.h[segment])  # makes the rows of the size of offsets
    along, across = (size * (direction @ matrix) for direction in (tangent, normal))
    rhs_along, rhs_across = (-size * float(direction @ constant) for direction in (tangent, normal))
    rows, rhs = [along], [rhs_along]
    if end.speed is None or end.heading is None or end.offset is None:
        kappa, slope = float(spline.kappa[knot]), float(np.tan(end.heading or 0.0))
        along[own + 2] += size * kappa / spline.unit
        rhs[0] += size / spline.unit
        across[own + 2] += size * slope * kappa / spline.unit
        rhs_across += size * slope / spline.unit
        speed = (1.0 - kappa * (end.offset or 0.0)) / np.cos(end.heading or 0.0)
    else:
        speed = end.speed
        rhs[0] += size * speed * float(np.cos(end.heading)) / spline.unit
        rhs_across += size * speed * float(np.sin(end.heading)) / spline.unit
    if end.heading is not None:
        rows.append(across)
        rhs.append(rhs_across)
    if end.offset is not None:
        rows.append(np.eye(6)[own + 2])
        rhs.append(end.offset)
    if end.curvature is not None and end.heading is not None:
        row = np.zeros(6)
        row[own], row[own + 1] = -np.sin(end.heading), np.cos(end.heading)
        rows.append(row)
        rhs.append(0.5 * end.curvature * (speed / spline.unit) ** 2 * float(spline.b_scale[knot]))
    return [segment] * len(rows), np.array(rows), np.array(rhs)
