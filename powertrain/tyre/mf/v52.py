"""MF-Tyre 5.2: the equations of the MF-Tyre 5.2 manual, which Adams' PAC2002 shares, in their own signs (ISO W).

It differs from 6.1 in the lateral force and the aligning moment: angles enter plainly, camber shifts through PHY3 and PVY3, the trail works on the
whole lateral force without its kappa-induced part, and relaxation lengths have coefficients of their own. `R_0` and the nominal load are the file's.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .coefficients import Coefficients
from .curve import Factors, cosine, length, sine
from .shared import State, kappa_induced, lateral_weight, longitudinal_factors, longitudinal_weight


def cornering_slope(p: Coefficients, s: State) -> Any:
    """Cornering stiffness K_y in the manual's sign, negative for a real tyre."""
    nominal = p.LFZO * p.FNOMIN
    upright = p.PKY1 * nominal * np.sin(2.0 * np.arctan(s.load / (p.PKY2 * nominal))) * p.LKY
    return upright * (1.0 - p.PKY3 * abs(s.camber * p.LGAY))


def lateral_factors(p: Coefficients, s: State) -> Factors:
    """Factors of the pure lateral force."""
    dfz, camber, friction = s.dfz(p), s.camber * p.LGAY, p.LMUY * s.friction
    slope = cornering_slope(p, s)
    c = p.PCY1 * p.LCY
    mu = (p.PDY1 + p.PDY2 * dfz) * (1.0 - p.PDY3 * camber**2) * friction
    d = mu * s.load
    leaning = camber * p.LKYG * p.LKYC  # Adams' name and 6.1's name of the same factor; a file has one of them
    horizontal = (p.PHY1 + p.PHY2 * dfz) * p.LHY + p.PHY3 * leaning
    vertical = s.load * ((p.PVY1 + p.PVY2 * dfz) * p.LVY + (p.PVY3 + p.PVY4 * dfz) * leaning) * friction
    side = np.sign(s.alpha + horizontal)
    e = (p.PEY1 + p.PEY2 * dfz) * (1.0 - (p.PEY3 + p.PEY4 * camber) * side) * p.LEY
    return Factors(slope / (c * d), c, d, np.minimum(e, 1.0), horizontal, vertical, slope, mu)


def trail_factors(p: Coefficients, s: State) -> Factors:
    """Factors of the pneumatic trail."""
    dfz, camber, nominal = s.dfz(p), s.camber * p.LGAZ, p.LFZO * p.FNOMIN
    shift = p.QHZ1 + p.QHZ2 * dfz + (p.QHZ3 + p.QHZ4 * dfz) * camber
    b = (p.QBZ1 + p.QBZ2 * dfz + p.QBZ3 * dfz**2) * (1.0 + p.QBZ4 * camber + p.QBZ5 * abs(camber)) * p.LKY / (p.LMUY * s.friction)
    d = s.load * p.UNLOADED_RADIUS / nominal * (p.QDZ1 + p.QDZ2 * dfz) * (1.0 + p.QDZ3 * camber + p.QDZ4 * camber**2) * p.LTR
    turned = (p.QEZ4 + p.QEZ5 * camber) * (2.0 / np.pi) * np.arctan(b * p.QCZ1 * (s.alpha + shift))
    e = (p.QEZ1 + p.QEZ2 * dfz + p.QEZ3 * dfz**2) * (1.0 + turned)
    return Factors(b, p.QCZ1, d, np.minimum(e, 1.0), shift)


def residual_factors(p: Coefficients, s: State, y: Factors) -> Factors:
    """Factors of the residual moment."""
    dfz, camber, friction = s.dfz(p), s.camber * p.LGAZ, p.LMUY * s.friction
    d = (p.QDZ6 + p.QDZ7 * dfz) * p.LRES + (p.QDZ8 + p.QDZ9 * dfz) * camber * p.LKZC
    d = d * s.load * p.UNLOADED_RADIUS * friction * np.cos(s.alpha)
    return Factors(p.QBZ9 * p.LKY / friction + p.QBZ10 * y.b * y.c, 1.0, d, 0.0, y.horizontal + y.vertical / y.slope)


def equivalent(angle: Any, other: Any) -> Any:
    """Side slip angle with as much effect as `angle` and the normalised longitudinal slip `other` together; its sign is without effect."""
    return np.arctan(length(np.tan(angle), other))


def forces(p: Coefficients, s: State) -> tuple[Any, Any, Any]:
    """Longitudinal and lateral force and aligning moment at combined slip."""
    x, y = longitudinal_factors(p, s), lateral_factors(p, s)
    longitudinal = longitudinal_weight(p, s) * (sine(x, s.kappa + x.horizontal) + x.vertical)
    steering = lateral_weight(p, s) * (sine(y, s.alpha + y.horizontal) + y.vertical)
    lateral = steering + kappa_induced(p, s, y.friction)
    trail, residual = trail_factors(p, s), residual_factors(p, s, y)
    other = x.slope / y.slope * s.kappa
    arm = p.SSZ1 + p.SSZ2 * lateral / (p.LFZO * p.FNOMIN) + (p.SSZ3 + p.SSZ4 * s.dfz(p)) * s.camber
    lever = cosine(trail, equivalent(s.alpha + trail.horizontal, other)) * np.cos(s.alpha)
    remains = cosine(residual, equivalent(s.alpha + residual.horizontal, other))
    return longitudinal, lateral, remains - lever * steering + p.UNLOADED_RADIUS * arm * p.LS * longitudinal
