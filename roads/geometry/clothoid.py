"""Points of a clothoid: the integral of `exp(i psi(s))` with heading `psi = kappa s + rate s^2 / 2`.

Fresnel's integrals give it in closed form, but two of their values are subtracted there and the phase `kappa^2 / (2 rate)` taken out of them,
which costs digits where the curvature changes little. There, Gauss-Legendre panels of at most four radians are exact to rounding: twelve nodes
miss the integral of `exp(i psi)` over a turn of `T` rad by about 1e-38 `T`^24.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import RoadError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)

#: Fresnel arguments between which the closed form keeps 1e-12 of the length: the least difference and the largest value.
_LEAST_CHANGE, _LARGEST_ARGUMENT = 0.2, 20.0
#: Largest turn that one panel of the quadrature integrates to rounding, rad.
PANEL = 4.0
#: A line that turns by more is none, rad: 16,000 times round.
MOST_TURN = 1e5
#: Panels that are integrated anew for each station.
_FEW = 4


def clothoid(s: ArrayLike, kappa: float, rate: float) -> tuple[Floats, Floats]:
    """Points and headings of a clothoid that starts at the origin along +x.

    Args:
        s: (n,) arc lengths from the start, m.
        kappa: curvature at the start, 1/m, positive left.
        rate: change of curvature over arc length, 1/m^2.

    Returns:
        Points (n, 2) in m and headings (n,) in rad.
    """
    s = np.asarray(s, dtype=np.float64)
    psi = (kappa + 0.5 * rate * s) * s
    longest = float(np.max(np.abs(s), initial=0.0))
    if kappa == 0.0 and rate == 0.0:
        return np.stack([s, np.zeros_like(s)], axis=-1), psi
    scale = np.sqrt(abs(rate) / np.pi)
    largest = scale * (longest + abs(kappa / rate)) if rate else np.inf
    places = _fresnel(s, kappa, rate) if scale * longest > _LEAST_CHANGE and largest < _LARGEST_ARGUMENT else _panels(s, kappa, rate)
    return np.stack([places.real, places.imag], axis=-1), psi


def _fresnel(s: Floats, kappa: float, rate: float) -> NDArray[np.complex128]:
    from scipy.special import fresnel  # slow to import, and roads without spirals never need it

    sign = np.sign(rate)
    start = kappa / rate
    scale = np.sqrt(abs(rate) / np.pi)
    sine, cosine = fresnel(scale * np.append(s + start, start))
    integral = (cosine[:-1] - cosine[-1] + 1j * sign * (sine[:-1] - sine[-1])) / scale
    return np.asarray(np.exp(-0.5j * kappa * start) * integral, dtype=np.complex128)


def _panels(s: Floats, kappa: float, rate: float) -> NDArray[np.complex128]:
    """Composite quadrature; every panel turns by at most `PANEL`. Each station from the start where these are few, else from station to station.

    Raises:
        RoadError: more turns than any line on Earth makes.
    """
    turn = float(np.max((np.abs(kappa) + np.abs(rate * s)) * np.abs(s), initial=0.0))
    if turn <= _FEW * PANEL:
        few = int(np.ceil(turn / PANEL)) or 1
        inner = (np.linspace(0.0, 1.0, few + 1)[:-1, None] + 0.5 / few * (1.0 + _NODES)).ravel()
        at = s[..., None] * inner
        return np.asarray(s * (np.exp(1j * (kappa + 0.5 * rate * at) * at) @ np.tile(0.5 / few * _WEIGHTS, few)), dtype=np.complex128)
    return _step_by_step(s, kappa, rate)


def _step_by_step(s: Floats, kappa: float, rate: float) -> NDArray[np.complex128]:
    knots = np.unique(np.append(s.ravel(), 0.0))
    length = np.diff(knots)
    turn = np.maximum(np.abs(kappa + rate * knots[:-1]), np.abs(kappa + rate * knots[1:])) * length
    if not float(np.sum(turn)) < MOST_TURN:
        raise RoadError(f"a spiral turns by {float(np.sum(turn)):.3g} rad, expected less than {MOST_TURN:g}")
    count = np.maximum(np.ceil(turn / PANEL), 1.0).astype(np.intp)
    ends = np.cumsum(count)
    step = np.repeat(length / count, count)
    start = np.repeat(knots[:-1], count) + step * (np.arange(len(step)) - np.repeat(ends - count, count))
    at = start[:, None] + 0.5 * step[:, None] * (1.0 + _NODES)
    pieces = 0.5 * step * (np.exp(1j * (kappa + 0.5 * rate * at) * at) @ _WEIGHTS)
    way = np.concatenate([[0.0], np.cumsum(pieces)[ends - 1]])
    return np.asarray((way - way[np.searchsorted(knots, 0.0)])[np.searchsorted(knots, s)], dtype=np.complex128)


def many(s: Floats, kappa: Floats, rate: Floats) -> NDArray[np.complex128]:
    """End points x + iy of many clothoids at once, each (n,) with its own length, curvature and rate; none may turn by more than `PANEL`."""
    at = (0.5 * s)[:, None] * (1.0 + _NODES)
    return np.asarray((0.5 * s) * (np.exp(1j * (kappa[:, None] + 0.5 * rate[:, None] * at) * at) @ _WEIGHTS), dtype=np.complex128)
