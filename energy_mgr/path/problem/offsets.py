"""Offsets from the reference: where a curve beside it runs, and borders drawn in."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from roads import PlanarCurve

    Floats = NDArray[np.float64]


def beside(curve: PlanarCurve, reference: PlanarCurve, q: Floats) -> Floats:
    """(k,) offset of `curve` from the reference at stations `q`: where it crosses the reference's normals, m."""
    points, normal = reference.position(q), reference.normal(q)
    tangent = np.column_stack([normal[:, 1], -normal[:, 0]])
    s, _ = curve.project(points, q * curve.length / reference.length)
    for _ in range(20):
        gap = curve.position(s) - points
        # along the normal the crossing has no component along the tangent
        step = np.sum(gap * tangent, axis=1) / np.maximum(np.sum(curve.tangent(s) * tangent, axis=1), 0.2)
        s = s - step
        if np.max(np.abs(step), initial=0.0) < 1e-9:
            break
    return np.sum((curve.position(s) - points) * normal, axis=1)


def drawn_in(right: Floats, left: Floats, tighter: Floats | float) -> tuple[Floats, Floats]:
    """Borders (right, left) moved towards each other by `tighter`, but by no more than a quarter of what is between them."""
    least = np.minimum(tighter, 0.25 * np.maximum(left - right, 0.0))
    return right + least, left - least
